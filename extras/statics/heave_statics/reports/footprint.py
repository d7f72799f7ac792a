"""How far a unit with thrusters gets on its cable: the footprint below the boom tip (thesis 2.2.4, problem 4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.current import current_of
from cable_sim_node.reports.report import columns, labelled_rows
from heave_node.numerics.arrays import Array

from heave_statics.footprint import Footprint, FootprintLimits, footprint
from heave_statics.suspended import refuse_unbearable, suspended_cable, unit_load

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEADINGS = 24


@dataclass(frozen=True)
class FootprintReport:
    """The area that the unit can reach."""

    depth: float  # of the unit below still water [m]
    limits: FootprintLimits  # of thrust, tension and vertical pull
    area: Footprint  # boundary of the area, about the point below the boom tip
    flow: Array  # current at that depth [m/s], shape (3,)

    @property
    def largest_tension(self) -> float:
        """Largest tension at the boom tip on the boundary [N]."""
        return max(point.tension for point in self.area.points)

    @property
    def unit_load(self) -> float:
        """NaN: the shape of the cable at the unit is not part of the report."""
        return math.nan

    def values(self) -> dict[str, object]:
        """Return the numbers with units in their names, for a machine."""
        return {
            "depth_m": self.depth,
            "thrust_n": self.limits.thrust,
            "tension_limit_n": self.limits.tension,
            "vertical_pull_limit_n": self.limits.vertical_pull,
            "headings": [
                {"heading_deg": math.degrees(heading), "reach_m": float(reach), "is_reachable": bool(reachable)}
                for heading, reach, reachable in zip(
                    self.area.headings, self.area.radius, self.area.is_reachable, strict=True
                )
            ],
            "boundary": [
                {
                    "offset_m": point.offset.tolist(),
                    "length_m": point.length,
                    "top_tension_n": point.tension,
                    "vertical_pull_n": point.vertical_pull,
                }
                for point in self.area.points
            ],
        }

    def table(self) -> str:
        """Return the report as text for a person."""
        points = self.area.points
        rows = [
            ("depth of the unit [m]", f"{self.depth:10.2f}"),
            ("thrust of the unit [kN]", f"{self.limits.thrust / 1e3:10.3f}"),
            ("vertical pull that lifts the unit [kN]", f"{self.limits.vertical_pull / 1e3:10.3f}"),
            ("cable out on the boundary, largest [m]", f"{max(point.length for point in points):10.2f}"),
            ("top tension on the boundary, largest [kN]", f"{self.largest_tension / 1e3:10.3f}"),
        ]
        reach = [
            (f"{math.degrees(heading):.0f}", f"{radius:.2f}" if reachable else "out of reach")
            for heading, radius, reachable in zip(
                self.area.headings, self.area.radius, self.area.is_reachable, strict=True
            )
        ]
        return f"{labelled_rows(rows)}\n\n{columns(('heading deg', 'reach m'), reach)}"

    def draw(self, figure: Figure) -> None:
        """Draw the area from above into `figure`."""
        axis = figure.subplots()
        corners = np.array([point.offset for point in self.area.points])
        axis.fill(*corners.T, alpha=0.2)
        axis.plot(*np.vstack((corners, corners[:1])).T, label=f"reach with {self.limits.thrust:g} N of thrust")
        axis.plot(0.0, 0.0, "r^", markersize=8.0, label="below the boom tip")
        speed = float(np.hypot(*self.flow[:2]))
        if speed > 0.0:
            tip = 0.4 * np.abs(corners).max() * self.flow[:2] / speed
            axis.annotate("", tip, (0.0, 0.0), arrowprops={"arrowstyle": "->", "color": "tab:blue"})
            axis.text(tip[0], tip[1], f" current {speed:.2f} m/s", color="tab:blue")
        axis.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title=f"reach of the unit {self.depth:g} m down")
        axis.grid(alpha=0.3)
        axis.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), fontsize="small")


def footprint_report(
    parameters: CableSimParameters,
    depth: float,
    thrust: float,
    *,
    tension_limit: float = math.inf,
    vertical_pull: float | None = None,
    boom_tip_height: float = 0.0,
) -> FootprintReport:
    """Return how far a plant's unit gets from below the boom tip, with all of its cable at hand.

    Parameters
    ----------
    parameters : of the plant; `length` is the most cable that may be out
    depth : of the unit below still water [m]
    thrust : largest horizontal force of its thrusters [N]
    tension_limit : largest tension at the boom tip [N]
    vertical_pull : of the cable on the unit that its weight and thrusters bear [N]; its weight in water if None
    boom_tip_height : z of the boom tip [m]

    The tension law is taken as linear.

    Raises
    ------
    StaticsError
        for limits that are not positive, sections or bodies that do not fit on the cable, or one strained by more than
        LARGEST_STRAIN.
    NoEquilibriumError
        if no place can be reached within the limits.
    """
    if vertical_pull is None:
        vertical_pull = parameters.unit.weight_in_fluid(parameters.water_density, parameters.gravity)
    limits = FootprintLimits(thrust, tension_limit, vertical_pull)
    current = current_of(parameters)
    cable = suspended_cable(parameters, unit_load(parameters, is_carried=True))
    area = footprint(cable, (0.0, 0.0, boom_tip_height), -depth, limits, current, headings=HEADINGS)
    refuse_unbearable(parameters, area.largest_strain)
    return FootprintReport(depth, limits, area, current.at(depth))
