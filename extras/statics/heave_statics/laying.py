"""Steady laying of a cable from a moving ship: where it touches the bottom, and how long it hangs (Pinto; Zajac).

Seen from the ship the cable is stationary while its material runs down along it at the payout speed, and the water
comes at the current less the ship's velocity. A cable that lands with tension lies along the ship's track there, since
the bottom cannot pull it down. One that lands without any, the usual aim, comes down in the direction in which weight
and drag leave no force across it. Followed upwards from the touchdown the shape is direct. The centrifugal force of
the running cable only adds mass * speed^2 to the tension and does not change the shape.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from cable_sim_node.errors import NoEquilibriumError, StaticsError
from cable_sim_node.physics.current import Current
from cable_sim_node.physics.drag import segment_drag
from heave_node.numerics.arrays import Array
from numpy.typing import ArrayLike

from heave_statics.problems import STILL_WATER
from heave_statics.shape import Crossing, StaticShape, cut_at_height, shape_from
from heave_statics.system import StaticSection, static_cable

DIRECTION_ITERATIONS = 2000


@dataclass(frozen=True)
class Laying:
    """A steady lay."""

    touchdown: Array  # from the ship, x, y [m]
    suspended_length: float  # unstretched length between ship and bottom [m]
    tension: float  # at the ship [N]
    departure_angle: float  # of the cable at the ship from the horizontal [rad]
    strain: float  # largest of the cable that hangs [-]
    shape: Array  # positions from the touchdown at (0, 0, -depth) up to the ship, shape (k, 3) [m]


def critical_angle(section: StaticSection, speed: float) -> float:
    """Return the angle from the horizontal [rad] at which a cable that is towed or laid sinks as a straight line.

    Weight across the cable equals normal drag: w cos a = D sin^2 a (Pinto's Eq. 21 for small angles, Zajac).

    Parameters
    ----------
    section : the cable; its length and tangential drag have no part in it
    speed : of the ship [m/s]

    Raises
    ------
    StaticsError
        for a speed, weight or normal drag that is not positive.
    """
    if not speed > 0.0 or section.weight <= 0.0 or section.normal_drag <= 0.0:
        raise StaticsError("a critical angle needs a cable that sinks, normal drag and a positive speed")
    ratio = section.weight / (section.normal_drag * speed**2)
    return math.acos(0.5 * (-ratio + math.sqrt(ratio**2 + 4.0)))


def covering_payout(angle: float, rise: float, speed: float) -> float:
    """Return the payout speed [m/s] that covers a sloping bottom, neither hanging free of it nor lying slack.

    The cable is a straight line in still water that moves along with the ship. It touches down where it meets the
    bottom, which runs ahead at V sin a/sin(a - b); that and the change of the length that hangs give
    V cos((a + b)/2)/cos((a - b)/2): less than V uphill, more downhill (Zajac 1957; Pinto's fig. 1).

    Parameters
    ----------
    angle : of the cable from the horizontal [rad]: `critical_angle`
    rise : angle of the bottom from the horizontal [rad], positive where it rises ahead of the ship
    speed : of the ship [m/s]

    Raises
    ------
    StaticsError
        for a bottom that rises as steeply as the cable hangs, or more: no payout covers it, only a slower ship does.
    """
    if not -0.5 * math.pi < rise < angle:
        raise StaticsError(
            f"the bottom rises by {math.degrees(rise):.1f} deg and the cable hangs at {math.degrees(angle):.1f} deg at "
            f"{speed:g} m/s: it would span the foot of the slope; lay more slowly"
        )
    return speed * math.cos(0.5 * (angle + rise)) / math.cos(0.5 * (angle - rise))


def lay(
    section: StaticSection,
    depth: float,
    ship_velocity: ArrayLike,
    current: Current = STILL_WATER,
    *,
    payout_speed: float | None = None,
    bottom_tension: float = 0.0,
    sheave_height: float = 0.0,
    segments: int = 200,
) -> Laying:
    """Return the steady shape of a cable laid on a flat bottom.

    Parameters
    ----------
    section : the cable; its length is not used
    depth : of the bottom below z = 0 [m]
    ship_velocity : x, y [m/s]
    current : over depth
    payout_speed : [m/s]; the ship's speed if None (no slack on the bottom)
    bottom_tension : tension at the touchdown [N]; above 0 the cable touches down along the ship's track
    sheave_height : z of the ship's sheave [m]
    segments : over the suspended length, about

    Raises
    ------
    StaticsError
        for a cable that does not sink, a depth that is not positive, or a bottom tension behind a ship at rest.
    NoEquilibriumError
        if the cable does not come up to the ship within 200 depths.
    """
    velocity = np.asarray(ship_velocity, dtype=np.float64)
    speed = float(np.linalg.norm(velocity))
    if not (section.weight > 0.0 and min(depth, depth + sheave_height) > 0.0 and bottom_tension >= 0.0):
        raise StaticsError("laying needs a cable that sinks, a positive depth and a bottom tension of 0 or more")
    if not math.isfinite(speed):
        raise StaticsError(f"the ship's velocity must be finite; got {velocity.tolist()}")
    feed = speed if payout_speed is None else payout_speed
    water = current.shifted(velocity)
    direction, drag = _landing_direction(section, water.at(depth), feed)
    length = 1.5 * (depth + sheave_height) / max(direction[2], 1e-2)
    tension = max(bottom_tension, 1e-6 * section.weight * depth)
    if bottom_tension > 0.0:
        if speed == 0.0:
            raise StaticsError("a bottom tension needs a ship that moves")
        direction = np.array([*(velocity / speed), 0.0])
    origin = np.array([0.0, 0.0, -depth])
    for _ in range(8):
        cable = static_cable([StaticSection(length, *_properties(section))], segments=segments, feed=feed)
        shape = shape_from(cable, water, origin, tension * direction, drag_guess=_first_row(drag, len(cable.segments)))
        crossing = None if shape is None else cut_at_height(shape, sheave_height)
        if shape is not None and crossing is not None:
            if crossing.label < 0.8 * length:  # use the segments on the cable that hangs
                length = 1.05 * crossing.label
                continue
            return _laying_of(shape, crossing)
        length *= 2.0
    raise NoEquilibriumError("the cable does not reach up to the ship: it is laid too fast for its weight")


def _laying_of(shape: StaticShape, crossing: Crossing) -> Laying:
    """Return the laying of a cable of this `shape`, which meets the ship's sheave at the `crossing`."""
    below = shape.cable.labels < crossing.label
    return Laying(
        touchdown=-crossing.position[:2],
        suspended_length=crossing.label,
        tension=float(np.linalg.norm(crossing.tension)),
        departure_angle=math.atan2(crossing.tension[2], float(np.hypot(*crossing.tension[:2]))),
        strain=crossing.strain,
        shape=np.vstack((shape.positions[below], crossing.position)),
    )


def _first_row(drag: Array, count: int) -> Array:
    guess = np.full((count, 3), np.nan)
    guess[0] = drag
    return guess


def _properties(section: StaticSection) -> tuple[float, float, float, float]:
    return section.axial_stiffness, section.weight, section.normal_drag, section.tangential_drag


def _landing_direction(section: StaticSection, water: Array, feed: float) -> tuple[Array, Array]:
    """Return the direction (upwards along the cable) without load across it, and the drag there [N/m]."""
    direction = np.array([0.0, 0.0, 1.0])
    flow, scratch = (float(water[0]), float(water[1]), float(water[2])), (np.empty((3, 3)), np.empty((3, 3)))
    for _ in range(DIRECTION_ITERATIONS):
        drag = np.array(segment_drag(direction, flow, feed, section.normal_drag, section.tangential_drag, *scratch))
        load = drag - np.array([0.0, 0.0, section.weight])
        across = load - (load @ direction) * direction
        size = float(np.linalg.norm(across)) / section.weight
        if size < 1e-13:
            break
        stiff = section.normal_drag * float(water @ water) / section.weight
        direction = direction - across / section.weight / (2.0 + 2.0 * stiff)
        direction /= np.linalg.norm(direction)
    return direction, drag
