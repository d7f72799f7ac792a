"""Equations of the valve-controlled hydraulic drive, compiled; `valve_controlled` says what they are.

Arguments: `x` the state, shape (SIZE,), rows as numbered here and in `mechanics`; `work` room for the steps, shape
(STAGES, SIZE); `plant` and `fluid` the drive in numbers; `oil` in the accumulator [m^3], negative below empty; all
others as in `mechanics`. Pressures are above atmospheric, as gauges read them; the laws of gas hold for absolute ones.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from heave_drives.kernels.mechanics import (
    BOOST_TIME,
    LIMIT_FLOW,
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

SPOOL, SPOOL_RATE, PRESSURE_A, PRESSURE_B, INTEGRAL, PUMP, OIL = (OWN + i for i in range(7))
"""Spool over full and its rate [1/s], pressures in the two lines of the motors [Pa], integral part of the loop, flow of
the pump [m^3/s], oil in the accumulator [m^3]."""
SIZE = OWN + 7

ATMOSPHERE = 101_325.0
GAS_EXPONENT = 1.4
DRY_SHARE = 0.01
"""Lines and block of an empty accumulator give its precharge away over this share of its volume."""


class Fluid(NamedTuple):
    """Oil with trapped air."""

    bulk_modulus: float  # of the oil alone [Pa]
    air: float  # share of air in the volume, at atmospheric pressure [-]


class ValvePlant(NamedTuple):
    """The valve-controlled drive in numbers."""

    mass: float  # that the rope feels [kg]
    area: float  # flow of the motors per rope speed [m^2]
    line_volume: float  # of each of the two lines [m^3]
    leakage: float  # of the motors [m^3/s/Pa]
    valve_gain: float  # flow of an edge over the root of the pressure drop, fully open [m^3/s/Pa^0.5]
    valve_frequency: float  # natural frequency of the spool [rad/s]
    valve_damping: float  # damping ratio of the spool [-]
    spool_input_limit: float  # largest spool set-point over full [-]
    laminar_pressure: float  # drop below which an edge's flow turns linear [Pa]
    gain: float  # spool over full per speed error [s/m]
    feed_forward: float  # spool over full per speed set-point [s/m]
    integral_time: float  # of the speed loop [s]
    supply_pressure: float  # set pressure of the supply [Pa]
    pump_flow: float  # largest flow of the pump [m^3/s]
    pump_rate: float  # reciprocal of the lag of the pump's flow [1/s]
    droop: float  # so far below its set pressure the pump gives all it can [Pa]
    accumulator_volume: float  # of the gas at precharge [m^3]; 0: the supply's pressure is constant
    precharge: float  # pressure of the gas in the empty accumulator, above atmospheric [Pa]
    fullest: float  # oil in the accumulator at which the supply's relief valve opens [m^3]


@inner_kernel
def bulk_modulus(pressure: float, fluid: Fluid) -> float:
    """Return the bulk modulus of oil with trapped air [Pa], at a `pressure` above atmospheric [Pa]."""
    absolute = max(pressure + ATMOSPHERE, 0.01 * ATMOSPHERE)
    air = fluid.air * (ATMOSPHERE / absolute) ** (1.0 / GAS_EXPONENT)
    return (1.0 + air) / (1.0 / fluid.bulk_modulus + air / (GAS_EXPONENT * absolute))


@inner_kernel
def supply_pressure(oil: float, plant: ValvePlant) -> float:
    """Return the pressure of the supply [Pa]: constant, or that of the accumulator's gas.

    (s + p_a) (V - oil)^n = (s_0 + p_a) V^n with the precharge s_0 and the atmosphere p_a.
    """
    volume = plant.accumulator_volume
    if volume == 0.0:
        return plant.supply_pressure
    if oil >= 0.0:
        return (plant.precharge + ATMOSPHERE) * (volume / (volume - oil)) ** GAS_EXPONENT - ATMOSPHERE
    return plant.precharge * max(0.0, 1.0 + oil / (DRY_SHARE * volume))


@inner_kernel
def gas_energy(oil: float, plant: ValvePlant) -> float:
    """Return the energy of the accumulator's gas, the integral of its pressure over the oil taken in [J]."""
    volume = plant.accumulator_volume
    if volume == 0.0:
        return 0.0
    if oil < 0.0:
        oil = max(oil, -DRY_SHARE * volume)
        return plant.precharge * oil * (1.0 + 0.5 * oil / (DRY_SHARE * volume))
    n = GAS_EXPONENT - 1.0
    gas = (plant.precharge + ATMOSPHERE) * volume / n * (math.pow(volume / (volume - oil), n) - 1.0)
    return gas - ATMOSPHERE * oil


@inner_kernel
def _orifice(opening: float, pressure: float, plant: ValvePlant) -> float:
    """Return the flow through an edge [m^3/s], smooth where the pressure difference changes sign."""
    return plant.valve_gain * opening * pressure / (pressure**2 + plant.laminar_pressure**2) ** 0.25


@inner_kernel
def _edges(x: Array, plant: ValvePlant, supply: float) -> tuple[float, float, float, float]:
    """Return the flows into lines A and B, out of the supply [m^3/s], and the power lost in the valve [W]."""
    a, b = x[PRESSURE_A], x[PRESSURE_B]
    opening = clip(x[SPOOL], 1.0)
    if opening >= 0.0:
        into_a, out_of_b = _orifice(opening, supply - a, plant), _orifice(opening, b, plant)
        return into_a, -out_of_b, into_a, (supply - a) * into_a + b * out_of_b
    into_b, out_of_a = _orifice(-opening, supply - b, plant), _orifice(-opening, a, plant)
    return -out_of_a, into_b, into_b, (supply - b) * into_b + a * out_of_a


@inner_kernel
def _spool(slope: Array, x: Array, plant: ValvePlant, demand: float, brake: bool) -> int:
    """Set the slopes of spool and integral; return the limits that act."""
    asked = 0.0
    if brake:
        slope[INTEGRAL] = -x[INTEGRAL] / plant.integral_time
    else:
        push = plant.gain * (demand - x[RATE])
        asked = plant.feed_forward * demand + push + x[INTEGRAL]
        slope[INTEGRAL] = (push + clip(asked, 1.0) - asked) / plant.integral_time
    w = plant.valve_frequency
    slope[SPOOL] = x[SPOOL_RATE]
    slope[SPOOL_RATE] = w * w * (clip(asked, plant.spool_input_limit) - x[SPOOL])
    slope[SPOOL_RATE] -= 2.0 * plant.valve_damping * w * x[SPOOL_RATE]
    return LIMIT_FLOW if abs(asked) > 1.0 else 0


@inner_kernel
def _slope(
    slope: Array,
    x: Array,
    plant: ValvePlant,
    fluid: Fluid,
    friction: Friction,
    bounds: Bounds,
    order: Order,
    tension: float,
    braking: float,
) -> int:
    """Set the slope of the state `x`; return the limits that act."""
    v, a, b = x[RATE], x[PRESSURE_A], x[PRESSURE_B]
    demand, limits = rate_demand(x, order, bounds, 1.0)
    limits |= _spool(slope, x, plant, demand, order.brake)
    supply = supply_pressure(x[OIL], plant)
    leaked = plant.leakage * (a - b)
    compliance_a = plant.line_volume / bulk_modulus(a, fluid)
    compliance_b = plant.line_volume / bulk_modulus(b, fluid)
    slope[LOST] = leaked * (a - b)
    if order.brake:  # shut-off valves close, a boost pump keeps the lines ready
        slope[PRESSURE_A] = (0.5 * (supply - tension / plant.area) - a) / BOOST_TIME
        slope[PRESSURE_B] = (0.5 * (supply + tension / plant.area) - b) / BOOST_TIME
        into_a = compliance_a * slope[PRESSURE_A] + plant.area * v + leaked
        into_b = compliance_b * slope[PRESSURE_B] - plant.area * v - leaked
        drawn = 0.0
        slope[SUPPLIED] = a * into_a + b * into_b
    else:
        into_a, into_b, drawn, throttled = _edges(x, plant, supply)
        slope[PRESSURE_A] = (into_a - plant.area * v - leaked) / compliance_a
        slope[PRESSURE_B] = (into_b + plant.area * v + leaked) / compliance_b
        slope[LOST] += throttled
        slope[SUPPLIED] = 0.0
    if plant.accumulator_volume == 0.0:
        slope[SUPPLIED] += supply * drawn
        slope[PUMP] = slope[OIL] = 0.0
    else:
        called = plant.pump_flow * min(max((plant.supply_pressure - supply) / plant.droop, 0.0), 1.0)
        slope[PUMP] = plant.pump_rate * (called - x[PUMP])
        slope[OIL] = x[PUMP] - drawn
        slope[SUPPLIED] += supply * x[PUMP]
    force = plant.area * (a - b)
    set_motion(slope, x, force, tension, plant.mass, 0.0, friction, order.brake, braking)
    return limits


@kernel
def advance_valve(
    x: Array,
    work: Array,
    plant: ValvePlant,
    fluid: Fluid,
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
        limits |= _slope(work[0], x, plant, fluid, friction, bounds, order, tension, braking)
        shift(at, x, work[0], 0.5 * h)
        _slope(work[1], at, plant, fluid, friction, bounds, order, tension, braking)
        shift(at, x, work[1], 0.5 * h)
        _slope(work[2], at, plant, fluid, friction, bounds, order, tension, braking)
        shift(at, x, work[2], h)
        _slope(work[3], at, plant, fluid, friction, bounds, order, tension, braking)
        add_slopes(x, work, h)
        if x[OIL] > plant.fullest:  # what the pump gives while it swings back goes over the relief valve
            x[LOST] += gas_energy(x[OIL], plant) - gas_energy(plant.fullest, plant)
            x[OIL] = plant.fullest
        limits |= keep_in_bounds(x, plant.mass, rate, h, order.brake, bounds)
        acceleration = (x[RATE] - rate) / h
    return acceleration, limits


@kernel
def drawn_flow(x: Array, plant: ValvePlant) -> float:
    """Return the flow that the valve draws from the supply [m^3/s]."""
    return _edges(x, plant, supply_pressure(x[OIL], plant))[2]


@kernel
def pressure_of_supply(x: Array, plant: ValvePlant) -> float:
    """Return the pressure of the supply [Pa]."""
    return supply_pressure(x[OIL], plant)


@kernel
def fluid_energy(pressure: float, volume: float, fluid: Fluid) -> float:
    """Return the energy of a line's fluid at `pressure` [Pa], the integral of V p/E(p) dp from 0 [J] (Simpson's rule).

    `volume` is V [m^3].
    """
    panels = 2000
    h = pressure / panels
    total = pressure / bulk_modulus(pressure, fluid)
    for i in range(1, panels):
        p = i * h
        total += (4.0 if i % 2 else 2.0) * p / bulk_modulus(p, fluid)
    return volume * total * h / 3.0


@kernel
def accumulator_energy(x: Array, plant: ValvePlant) -> float:
    """Return the energy of the accumulator [J]."""
    return gas_energy(x[OIL], plant)
