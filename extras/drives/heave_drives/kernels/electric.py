"""Equations of the electric drive, compiled; `electric` says what they are.

Arguments: `x` the state, shape (SIZE,), rows as numbered here and in `mechanics`; `work` room for the steps, shape
(STAGES, SIZE); `plant` and `spool` the drive in numbers; all others as in `mechanics`.
"""

from __future__ import annotations

from typing import NamedTuple

from cable_sim_node.winch import drive
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from heave_drives.kernels.mechanics import (
    LIMIT_TORQUE,
    LOST,
    OWN,
    PAYOUT,
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
from heave_drives.kernels.spool import Spool, arm_at

REFERENCE, INTEGRAL, TORQUE = OWN, OWN + 1, OWN + 2
"""Speed that the loop follows [m/s], integral part of its force [N], motor torque [N m]."""
SIZE = OWN + 3


class ElectricPlant(NamedTuple):
    """The electric drive in numbers."""

    inertia: float  # about the drum's axis, of the drum and of what turns with it, motor included [kg m^2]
    load_mass: float  # rigidly on the rope [kg]
    gear_ratio: float  # turns of the motor for one of the drum [-]
    torque_limit: float  # of the motor [N m]
    motoring_limit: float  # largest power that the motor gives to the shaft [W]
    regeneration_limit: float  # largest power that it takes from the shaft [W]
    torque_time: float  # lag of the torque [s]
    copper_loss: float  # at torque_limit [W]; it goes with the torque squared
    acceleration_limit: float  # of the reference, at the rope [m/s^2]
    reference_time: float  # lag of the reference behind the set-point [s]
    bandwidth: float  # of the speed loop [1/s]
    integral_time: float  # of the speed loop [s]
    feed_forward: float  # share of the tension that is fed forward [-]


@inner_kernel
def rope_mass(plant: ElectricPlant, spool: Spool, payout: float) -> tuple[float, float, float]:
    """Return the mass [kg] that the rope feels at `payout` [m], its change [kg/m], and the motor's turn [rad/m]."""
    arm, arm_slope = arm_at(spool, payout)
    mass = plant.inertia / arm**2 + plant.load_mass
    return mass, -2.0 * plant.inertia * arm_slope / arm**3, plant.gear_ratio / arm


@inner_kernel
def _torque_range(plant: ElectricPlant, speed: float) -> tuple[float, float]:
    """Return the least and the largest torque at a motor speed [rad/s]: constant torque, then constant power."""
    largest = plant.torque_limit
    if speed == 0.0:
        return -largest, largest
    motoring = min(largest, plant.motoring_limit / abs(speed))
    regenerating = min(largest, plant.regeneration_limit / abs(speed))
    return (-regenerating, motoring) if speed > 0.0 else (-motoring, regenerating)


@inner_kernel
def _slope(
    slope: Array,
    x: Array,
    plant: ElectricPlant,
    spool: Spool,
    friction: Friction,
    bounds: Bounds,
    order: Order,
    tension: float,
    braking: float,
) -> int:
    """Set the slope of the state `x`; return the limits that act."""
    v = x[RATE]
    mass, mass_slope, ratio = rope_mass(plant, spool, x[PAYOUT])
    demand, limits = rate_demand(x, order, bounds, 1.0)
    speed = ratio * v
    least, most = _torque_range(plant, speed)
    if order.brake:  # the motor carries the load under the brake, and is ready when it opens
        slope[REFERENCE] = -x[REFERENCE] / plant.reference_time
        asked = -tension / ratio
        wanted = min(max(asked, least), most)
        slope[INTEGRAL] = (-(1.0 - plant.feed_forward) * tension - x[INTEGRAL]) / plant.integral_time
    else:
        pull = (demand - x[REFERENCE]) / plant.reference_time
        slope[REFERENCE] = clip(pull, plant.acceleration_limit)
        if slope[REFERENCE] != pull:
            limits |= drive.LIMIT_ACCELERATION
        push = plant.bandwidth * mass * (x[REFERENCE] - v)
        force = mass * slope[REFERENCE] + push + x[INTEGRAL] - plant.feed_forward * tension
        asked = force / ratio
        wanted = min(max(asked, least), most)
        slope[INTEGRAL] = (push + (wanted - asked) * ratio) / plant.integral_time
    if wanted != asked:
        limits |= LIMIT_TORQUE if abs(wanted) == plant.torque_limit else drive.LIMIT_POWER
    torque = min(max(x[TORQUE], least), most)
    slope[TORQUE] = (wanted - x[TORQUE]) / plant.torque_time
    copper = plant.copper_loss * (torque / plant.torque_limit) ** 2
    slope[SUPPLIED] = torque * speed + copper
    slope[LOST] = copper
    set_motion(slope, x, torque * ratio, tension, mass, mass_slope, friction, order.brake, braking)
    return limits


@kernel
def advance_electric(
    x: Array,
    work: Array,
    plant: ElectricPlant,
    spool: Spool,
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
        limits |= _slope(work[0], x, plant, spool, friction, bounds, order, tension, braking)
        shift(at, x, work[0], 0.5 * h)
        _slope(work[1], at, plant, spool, friction, bounds, order, tension, braking)
        shift(at, x, work[1], 0.5 * h)
        _slope(work[2], at, plant, spool, friction, bounds, order, tension, braking)
        shift(at, x, work[2], h)
        _slope(work[3], at, plant, spool, friction, bounds, order, tension, braking)
        add_slopes(x, work, h)
        mass, _, _ = rope_mass(plant, spool, x[PAYOUT])
        limits |= keep_in_bounds(x, mass, rate, h, order.brake, bounds)
        acceleration = (x[RATE] - rate) / h
    return acceleration, limits


@kernel
def kinetic_energy(x: Array, plant: ElectricPlant, spool: Spool) -> float:
    """Return M v^2/2 [J]."""
    mass, _, _ = rope_mass(plant, spool, x[PAYOUT])
    return 0.5 * mass * x[RATE] ** 2


@kernel
def motor(x: Array, plant: ElectricPlant, spool: Spool) -> tuple[float, float]:
    """Return the motor's radians per metre of payout and its torque [N m]."""
    _, _, ratio = rope_mass(plant, spool, x[PAYOUT])
    least, most = _torque_range(plant, ratio * x[RATE])
    return ratio, min(max(x[TORQUE], least), most)
