"""Equations of the pump-controlled hydraulic drive, compiled; `pump_controlled` says what they are.

Arguments: `x` the state, shape (SIZE,), rows as numbered here and in `mechanics`; `work` room for the steps, shape
(STAGES, SIZE); `plant` the drive in numbers; all others as in `mechanics`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cable_sim_node.winch import drive
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from heave_drives.kernels.mechanics import (
    BOOST_TIME,
    LIMIT_FLOW,
    LIMIT_PRESSURE,
    LOST,
    OWN,
    RATE,
    SUPPLIED,
    Bounds,
    Friction,
    Order,
    add_slopes,
    braking_of,
    clip,
    keep_in_bounds,
    rate_demand,
    set_motion,
    shift,
)

SWASH, PRESSURE, MOTOR, INTEGRAL = OWN, OWN + 1, OWN + 2, OWN + 3
"""Pump swash over full [-], pressure that hoists [Pa], motor displacement over full [-], integral part of the loop."""
SIZE = OWN + 4


class PumpPlant(NamedTuple):
    """The pump-controlled drive in numbers."""

    mass: float  # that the rope feels [kg]
    flow: float  # of the pump at full swash [m^3/s]
    area: float  # flow of the motors per rope speed at full displacement [m^2]
    stiffness: float  # of the fluid, pressure per volume [Pa/m^3]
    swash_time: float  # lag of the swash plate [s]
    swash_input_limit: float  # largest input of the swash's servo, over full swash [-]
    leakage: float  # of pump and motors [m^3/s/Pa]
    efficiency: float  # of motors and gear, mechanical [-]
    is_passive: bool  # what efficiency takes is friction; false: it is a constant factor
    relief_pressure: float  # at which the relief valves open, in both directions [Pa]
    power_limit: float  # of the pump, hydraulic [W]
    motor_minimum: float  # smallest displacement of the motors over full [-]; 1 is a fixed motor
    motor_time: float  # lag of the motors' displacement [s]
    overdrive: float  # times the speed limit that a set-point may demand [-]
    gain: float  # of the speed loop, from speed error over full speed to swash [-]
    integral_time: float  # of the speed loop [s]


@inner_kernel
def _controls(slope: Array, x: Array, plant: PumpPlant, demand: float, speed_limit: float, brake: bool) -> int:
    """Set the slopes of swash, motor displacement and integral; return the limits that act."""
    full_speed = plant.flow / plant.area
    share = demand / full_speed
    slope[MOTOR] = 0.0
    if plant.motor_minimum < 1.0:
        needed = full_speed / max(abs(clip(demand, speed_limit)), full_speed)
        slope[MOTOR] = (max(needed, plant.motor_minimum) - x[MOTOR]) / plant.motor_time
    if brake:
        slope[SWASH] = -x[SWASH] / plant.swash_time
        slope[INTEGRAL] = -x[INTEGRAL] / plant.integral_time
        return 0
    push = plant.gain * (share - x[RATE] / full_speed)
    asked = share * x[MOTOR] + push + x[INTEGRAL]
    given = clip(asked, plant.swash_input_limit)
    pull = (given - x[SWASH]) / plant.swash_time
    stopped = (x[SWASH] >= 1.0 and pull > 0.0) or (x[SWASH] <= -1.0 and pull < 0.0)
    slope[SWASH] = 0.0 if stopped else pull
    spill = clip(asked, 1.0) - asked
    slope[INTEGRAL] = (push + spill) / plant.integral_time if plant.gain > 0.0 else 0.0
    return LIMIT_FLOW if stopped else 0


@inner_kernel
def _slope(
    slope: Array,
    x: Array,
    plant: PumpPlant,
    friction: Friction,
    bounds: Bounds,
    order: Order,
    tension: float,
    braking: float,
) -> int:
    """Set the slope of the state `x`; return the limits that act."""
    v, pressure = x[RATE], x[PRESSURE]
    demand, limits = rate_demand(x, order, bounds, plant.overdrive)
    limits |= _controls(slope, x, plant, demand, bounds.speed, order.brake)
    area = plant.area * x[MOTOR]
    flow = clip(x[SWASH], 1.0) * plant.flow
    if abs(pressure * flow) > plant.power_limit:
        flow = math.copysign(plant.power_limit / abs(pressure), flow)
        limits |= drive.LIMIT_POWER
    leaked = plant.leakage * pressure
    if order.brake:
        held = tension / (area if plant.is_passive else area * plant.efficiency)
        slope[PRESSURE] = (clip(held, plant.relief_pressure) - pressure) / BOOST_TIME
        flow = area * v - leaked - slope[PRESSURE] / plant.stiffness
    else:
        slope[PRESSURE] = plant.stiffness * (area * v - leaked - flow)
    slope[SUPPLIED] = -pressure * flow
    force = -area * pressure * plant.efficiency
    if plant.is_passive:
        force = -area * pressure - (1.0 - plant.efficiency) * area * abs(pressure) * math.tanh(v / friction.slip_speed)
    slope[LOST] = pressure * leaked - area * pressure * v - force * v
    set_motion(slope, x, force, tension, plant.mass, 0.0, friction, order.brake, braking)
    return limits


@inner_kernel
def _relieve(x: Array, plant: PumpPlant) -> int:
    """Let the relief valves open: what the fluid held above their pressure is lost in them."""
    pressure = clip(x[PRESSURE], plant.relief_pressure)
    if pressure == x[PRESSURE]:
        return 0
    x[LOST] += (x[PRESSURE] ** 2 - pressure**2) / (2.0 * plant.stiffness)
    x[PRESSURE] = pressure
    return LIMIT_PRESSURE


@kernel
def advance_pump(
    x: Array,
    work: Array,
    plant: PumpPlant,
    friction: Friction,
    bounds: Bounds,
    order: Order,
    tension: float,
    substeps: int,
    h: float,
) -> tuple[float, int]:
    """Advance the state by `substeps` of `h` [s]; return the last acceleration [m/s^2] and the limits that acted."""
    limits, acceleration = 0, 0.0
    at = work[4]
    for _ in range(substeps):
        rate = x[RATE]
        braking = braking_of(rate, h, bounds)
        limits |= _slope(work[0], x, plant, friction, bounds, order, tension, braking)
        shift(at, x, work[0], 0.5 * h)
        _slope(work[1], at, plant, friction, bounds, order, tension, braking)
        shift(at, x, work[1], 0.5 * h)
        _slope(work[2], at, plant, friction, bounds, order, tension, braking)
        shift(at, x, work[2], h)
        _slope(work[3], at, plant, friction, bounds, order, tension, braking)
        add_slopes(x, work, h)
        x[SWASH] = clip(x[SWASH], 1.0)
        limits |= _relieve(x, plant) | keep_in_bounds(x, plant.mass, rate, h, order.brake, bounds)
        acceleration = (x[RATE] - rate) / h
    return acceleration, limits
