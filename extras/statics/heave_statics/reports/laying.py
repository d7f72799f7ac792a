"""A cable that is laid from a steaming ship: where it touches the bottom, how much of it hangs, and what it pulls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from cable_sim_node.errors import StaticsError
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.current import current_of
from heave_node.numerics.arrays import Array
from heave_node.sheet import Column, Sheet

from heave_statics.laying import Laying, covering_payout, critical_angle, lay
from heave_statics.reports.cases import CasesReport, Sides, SideView, unit_vector
from heave_statics.suspended import refuse_unbearable, static_sections

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class LaidCable:
    """The lay at one speed of the ship."""

    speed: float  # of the ship [m/s]
    behind: float  # where the cable touches the bottom, from the ship along its course, positive astern [m]
    sideways: float  # the same across its course, positive to port [m]
    critical_angle: float  # from the horizontal, of a straight line in still water without tangential drag [rad]
    payout: float  # speed of the cable [m/s]
    laying: Laying  # the steady shape

    def way(self, along: Array) -> Array:
        """Return the cable from touchdown to ship, seen from above: `along` a course and to port of it, (n, 2) [m]."""
        return (self.laying.shape[:, :2] + self.laying.touchdown) @ np.column_stack((along, (-along[1], along[0])))


LAYS = Sheet(
    Column("speed m/s", "speed", "speed_mps", ".2f"),
    Column("touchdown astern m", "behind", "touchdown_behind_m", ".2f"),
    Column("to port m", "sideways", "touchdown_sideways_m", ".2f"),
    Column("suspended m", "laying.suspended_length", "suspended_length_m", ".2f"),
    Column("tension kN", "laying.tension", "tension_n", ".3f", 1e-3),
    Column("angle at ship deg", lambda one: math.degrees(one.laying.departure_angle), "departure_angle_deg", ".2f"),
    Column("critical angle deg", lambda one: math.degrees(one.critical_angle), "critical_angle_deg", ".2f"),
    Column("payout m/s", "payout", "payout_mps", ".3f"),
)
"""Columns of a lay at each speed."""

ALONG = "along the course from the ship [m]"
"""Label of an axis."""


def laying_report(
    parameters: CableSimParameters,
    depth: float,
    speeds: Sequence[float],
    *,
    course: float = 0.0,
    rise: float = 0.0,
    payout_speed: float | None = None,
    bottom_tension: float = 0.0,
    boom_tip_height: float = 0.0,
) -> CasesReport:
    """Return the lay of a plant's main cable at every speed of the ship; rows are `LaidCable`.

    Parameters
    ----------
    parameters : of the plant; unit, sections and bodies have no part in it
    depth : of the bottom below still water, at the touchdown [m]
    speeds : of the ship over ground [m/s]
    course : direction in which it steams, from x towards y [rad]
    rise : of the bottom ahead, per metre along the course
    payout_speed : of the cable [m/s]; if None what covers the bottom in still water: the ship's speed where it is flat
    bottom_tension : with which the cable lands [N]
    boom_tip_height : z of the sheave [m]

    Raises
    ------
    StaticsError
        for a cable that does not sink, speeds that are not positive, a bottom that rises more steeply than the
        cable hangs, or a cable strained by more than LARGEST_STRAIN.
    NoEquilibriumError
        if the cable does not come up to the ship.
    """
    section, current = static_sections(parameters)[-1], current_of(parameters)
    along = unit_vector(course)
    lays = []
    for speed in speeds:
        if not (math.isfinite(speed) and speed > 0.0):
            raise StaticsError(f"the laying speed must be finite and above 0; got {speed:g}")
        angle = critical_angle(section, speed)
        payout = covering_payout(angle, math.atan(rise), speed) if payout_speed is None else payout_speed
        laying = lay(
            *(section, depth, speed * along, current),
            payout_speed=payout,
            bottom_tension=bottom_tension,
            sheave_height=boom_tip_height,
        )
        refuse_unbearable(parameters, laying.strain)
        x, y = laying.touchdown
        sideways = float(y * along[0] - x * along[1])
        lays.append(LaidCable(speed, -float(laying.touchdown @ along), sideways, angle, payout, laying))
    ways = [laid.way(along) for laid in lays]
    sides = [(f"{laid.speed:g} m/s", laid.laying.shape[:, 2]) for laid in lays]
    views = [SideView(name, way[:, 0], height) for way, (name, height) in zip(ways, sides, strict=True)]
    return CasesReport(
        *(LAYS, "lays", tuple(lays), {"depth_m": depth, "course_deg": math.degrees(course)}),
        largest_tension=max(laid.laying.tension for laid in lays),
        side=Sides(views, "ship", ALONG, depth).draw,
        other=partial(_draw_from_above, ways, 0.1 * max(laid.behind for laid in lays)),
    )


def _draw_from_above(ways: Sequence[Array], extent: float, axis: Axes) -> None:
    """Draw the `ways` of the cables from touchdown to ship, on at least an `extent` [m] to both sides."""
    for way in ways:
        (line,) = axis.plot(*way.T)
        axis.plot(*way[0], "o", color=line.get_color())
    axis.plot(0.0, 0.0, "r^", markersize=8.0, label="ship")
    axis.set(xlabel=ALONG, ylabel="to port of the course [m]", title="touchdown from above")
    axis.legend(loc="best", fontsize="small")
    low, high = axis.get_ylim()
    axis.set_ylim(min(low, -extent), max(high, extent))
