"""What all drives share: the moving mass, friction, brake and end stops, and the energy books, as compiled functions.

The state is referred to the rope: payout u and rate v. With the mass M(u) that the rope feels (it changes with u where
the drum has layers), M v' + M' v^2/2 = F + T - R(v), F the drive's force on the rope in the direction of paying out, T
the tension, R friction. Kinetic energy is M v^2/2, so that its rate is (F + T - R) v.

Under the brake the drum decelerates at a set rate whatever the load, with the drive's help where the load alone would
stop it harder, and is held at rest.

Arguments have the same names everywhere: `state` and its `slope`, shape (n,), rows as numbered below; `mass` M [kg] and
`mass_slope` M' [kg/m]; `force` of the drive and `tension` [N]; `friction`, `bounds` and `order` as described with their
types; `brake` whether it is on, and the acceleration of `braking` by it [m/s^2]; `substeps` how many steps of `h` [s].
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cable_sim_node.winch import drive
from heave_node.interface.codes import WinchLimit
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from heave_drives.parameters import FrictionParameters, MotionParameters

PAYOUT, RATE, SUPPLIED, FROM_LOAD, LOST = 0, 1, 2, 3, 4
OWN = 5
"""First row of the state that is the drive's own."""

NO_LIMIT = math.inf

LIMIT_TORQUE, LIMIT_PRESSURE, LIMIT_FLOW = (int(x) for x in (WinchLimit.TORQUE, WinchLimit.PRESSURE, WinchLimit.FLOW))
"""Limits beyond those of the speed servo."""

BOOST_TIME = 0.1
"""Under the brake a hydraulic drive comes to the load's pressure within this time constant [s]."""


class Bounds(NamedTuple):
    """What the rope's motion is kept within."""

    speed: float  # that set-points are kept to, in both directions [m/s]
    overspeed: float  # at which the brake catches the drum, in both directions [m/s]
    payout_minimum: float  # end stop [m]
    payout_maximum: float  # end stop [m]
    deceleration: float  # of the brake, and of the approach to an end stop [m/s^2]


class Friction(NamedTuple):
    """R = (coulomb + load |T|) tanh(v/slip_speed) + viscous v: [N], [-], [m/s], [N s/m]."""

    coulomb: float
    load: float
    slip_speed: float
    viscous: float


def bounds_of(parameters: MotionParameters) -> Bounds:
    """Return the bounds that `parameters` stand for."""
    p = parameters
    overspeed = p.overspeed * p.speed_limit if p.overspeed > 0.0 else NO_LIMIT
    return Bounds(p.speed_limit, overspeed, p.payout_minimum, p.payout_maximum, p.stop_deceleration)


def friction_of(parameters: FrictionParameters) -> Friction:
    """Return the friction that `parameters` stand for."""
    return Friction(parameters.coulomb, parameters.load, parameters.slip_speed, parameters.viscous)


class Order(NamedTuple):
    """A command in numbers."""

    payout_rate: float  # set-point, positive pays out [m/s]
    payout: float  # set-point, positive pays out [m]
    position_gain: float  # from payout error to speed [1/s]; 0: the payout set-point has no effect
    brake: bool  # is to be on


@inner_kernel
def clip(value: float, largest: float) -> float:
    """Return `value`, or the nearest one not larger in size than `largest`."""
    return min(max(value, -largest), largest)


@inner_kernel
def rate_demand(state: Array, order: Order, bounds: Bounds, overdrive: float) -> tuple[float, int]:
    """Return the speed that the loop shall follow [m/s], and the limits that act on it.

    Near the ends of the range it is the speed from which the deceleration still stops in time. `overdrive` times the
    speed limit may be demanded, where a set-point beyond it only drives a lag harder.
    """
    wanted = order.payout_rate + order.position_gain * (order.payout - state[PAYOUT])
    limits = 0
    demand = clip(wanted, overdrive * bounds.speed)
    if demand != wanted:
        limits |= drive.LIMIT_SPEED
    fastest = math.sqrt(2.0 * bounds.deceleration * max(bounds.payout_maximum - state[PAYOUT], 0.0))
    if demand > fastest and fastest < bounds.speed:
        demand = fastest
        limits |= drive.LIMIT_PAYOUT
    fastest = math.sqrt(2.0 * bounds.deceleration * max(state[PAYOUT] - bounds.payout_minimum, 0.0))
    if demand < -fastest and fastest < bounds.speed:
        demand = -fastest
        limits |= drive.LIMIT_PAYOUT
    return demand, limits


@inner_kernel
def braking_of(rate: float, h: float, bounds: Bounds) -> float:
    """Return the acceleration that the brake gives a drum of a `rate` [m/s] for a substep of `h` [s], to rest at most.

    It is constant in the substep, so that the books are exact in the one in which the drum comes to rest.
    """
    return -math.copysign(min(bounds.deceleration, abs(rate) / h), rate)


@inner_kernel
def set_motion(
    slope: Array,
    state: Array,
    force: float,
    tension: float,
    mass: float,
    mass_slope: float,
    friction: Friction,
    brake: bool,
    braking: float,
) -> None:
    """Set the slopes of payout, rate and of the books that the motion moves; `slope[LOST]` and
    `slope[SUPPLIED]` are added to.
    """
    v = state[RATE]
    resistance = (friction.coulomb + friction.load * abs(tension)) * math.tanh(v / friction.slip_speed)
    resistance += friction.viscous * v
    free = force + tension - resistance - 0.5 * mass_slope * v * v
    slope[PAYOUT] = v
    slope[RATE] = free / mass
    slope[FROM_LOAD] = tension * v
    slope[LOST] += resistance * v
    if brake:
        slope[RATE] = braking
        braked = (free - mass * slope[RATE]) * v
        if braked > 0.0:
            slope[LOST] += braked
        else:  # load and drive alone would stop the drum harder: the drive holds against them
            slope[SUPPLIED] -= braked


@inner_kernel
def keep_in_bounds(state: Array, mass: float, rate_before: float, h: float, brake: bool, bounds: Bounds) -> int:
    """After a substep of `h` [s], bring the braked drum to rest and no further, catch an overspeed, and end the motion
    at the end stops; return the limits that acted.

    `rate_before` is the rate before the substep [m/s]. What kinetic energy this takes is lost in the brake.
    """
    v, limits = state[RATE], 0
    if brake:
        v = rate_before - math.copysign(min(bounds.deceleration * h, abs(rate_before)), rate_before)
    if abs(v) > bounds.overspeed:
        v = clip(v, bounds.overspeed)
        limits |= drive.LIMIT_SPEED
    if state[PAYOUT] > bounds.payout_maximum or state[PAYOUT] < bounds.payout_minimum:
        outwards = v > 0.0 if state[PAYOUT] > bounds.payout_maximum else v < 0.0
        state[PAYOUT] = min(max(state[PAYOUT], bounds.payout_minimum), bounds.payout_maximum)
        v = 0.0 if outwards else v
        limits |= drive.LIMIT_PAYOUT
    state[LOST] += 0.5 * mass * (state[RATE] ** 2 - v * v)
    state[RATE] = v
    return limits


STAGES = 5
"""Rows of the work array: four slopes, and the state at which the next one is taken."""


@inner_kernel
def shift(at: Array, state: Array, slope: Array, h: float) -> None:
    """Set `at` to state + h slope."""
    for i in range(state.size):
        at[i] = state[i] + h * slope[i]


@inner_kernel
def add_slopes(state: Array, work: Array, h: float) -> None:
    """Advance the state by `h` with the four slopes in `work`."""
    for i in range(state.size):
        state[i] += h / 6.0 * (work[0, i] + 2.0 * work[1, i] + 2.0 * work[2, i] + work[3, i])
