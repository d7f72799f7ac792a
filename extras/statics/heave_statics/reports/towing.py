"""A ship that steams with unit and cable in the water: depth and layback of the unit, tension of the cable."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from cable_sim_node.errors import StaticsError
from cable_sim_node.line.rest.hanging import refuse_floating
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.current import current_of
from cable_sim_node.physics.seabed import clearance_of
from cable_sim_node.reports.report import columns
from heave_node.numerics.arrays import Array
from heave_node.sheet import Column, Sheet
from numpy.typing import ArrayLike

from heave_statics.problems import towing_cable
from heave_statics.shape import StaticShape
from heave_statics.suspended import shape_at_rest

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class TowedUnit:
    """The tow at one speed of the ship."""

    speed: float  # of the ship [m/s]
    depth: float  # of the unit below still water [m]
    layback: float  # how far the unit is behind the boom tip, along the course [m]
    sideways: float  # how far it is beside the course, positive to port [m]
    shape: StaticShape  # of the cable, s = 0 at the unit


TOWS = Sheet(
    Column("speed m/s", "speed", "speed_mps", ".2f"),
    Column("unit depth m", "depth", "unit_depth_m", ".2f"),
    Column("layback m", "layback", "layback_m", ".2f"),
    Column("to port m", "sideways", "sideways_m", ".2f"),
    Column("top tension kN", "shape.top_tension", "top_tension_n", ".3f", 1e-3),
    Column("top angle deg", lambda tow: math.degrees(tow.shape.top_angle), "top_angle_deg", ".2f"),
    Column("smallest tension kN", lambda tow: float(tow.shape.tension.min()), "least_tension_n", ".3f", 1e-3),
)
"""Columns of a tow at each speed."""


@dataclass(frozen=True)
class TowingReport:
    """The tow at several speeds."""

    course: float  # direction in which the ship steams, from x towards y [rad]
    boom_tip: Array  # [m]
    tows: tuple[TowedUnit, ...]  # one for each speed

    @property
    def largest_tension(self) -> float:
        """Largest tension at the boom tip at any of the speeds [N]."""
        return max(tow.shape.top_tension for tow in self.tows)

    @property
    def unit_load(self) -> float:
        """Largest force of the cable on the unit at any of the speeds [N]."""
        return max(float(np.linalg.norm(tow.shape.lower[0])) for tow in self.tows)

    def values(self) -> dict[str, object]:
        """Return the numbers with units in their names, for a machine."""
        return {"course_deg": math.degrees(self.course), "tows": TOWS.records(self.tows)}

    def table(self) -> str:
        """Return the report as text for a person."""
        return columns(TOWS.headings, TOWS.cells(self.tows))

    def draw(self, figure: Figure) -> None:
        """Draw the cable from the side at every speed, and depth and layback over the speed, into `figure`."""
        side, curves = figure.subplots(1, 2)
        along = np.array([math.cos(self.course), math.sin(self.course)])
        for tow in self.tows:
            curve = tow.shape.curve()
            behind = (self.boom_tip[:2] - curve[:, :2]) @ along
            (line,) = side.plot(-behind, curve[:, 2], label=f"{tow.speed:g} m/s")
            side.plot(-behind[0], curve[0, 2], "s", color=line.get_color())
        side.axhline(0.0, color="tab:blue", linewidth=0.8, alpha=0.5)
        side.set(xlabel="along the course from the boom tip [m]", ylabel="z [m]", title="cable and unit from the side")
        side.legend(title="ship", fontsize="small")
        speeds = [tow.speed for tow in self.tows]
        curves.plot(speeds, [tow.depth for tow in self.tows], "o-", label="depth of the unit")
        curves.plot(speeds, [tow.layback for tow in self.tows], "s-", label="layback")
        curves.set(xlabel="speed of the ship [m/s]", ylabel="[m]", title="depth and layback")
        curves.legend(fontsize="small")
        for axis in (side, curves):
            axis.grid(alpha=0.3)


def towing_report(
    parameters: CableSimParameters, speeds: Sequence[float], *, course: float = 0.0, boom_tip: ArrayLike = (0, 0, 0)
) -> TowingReport:
    """Return the steady tow of a plant's unit and cable at every speed of the ship.

    Parameters
    ----------
    parameters : of the plant; its current flows on top of the ship's motion, as it is at the start of a run
    speeds : of the ship over ground [m/s]
    course : direction in which it steams, from x towards y [rad]
    boom_tip : position [m], z up

    Raises
    ------
    StaticsError
        for a speed that is not a finite number of 0 or more, sections or bodies that do not fit on the cable, or a unit
        below the seabed.
    NoEquilibriumError
        if the tow's shape cannot be reached, or the unit would float above the boom tip.
    """
    tip = np.asarray(boom_tip, dtype=np.float64)
    along = np.array([math.cos(course), math.sin(course)])
    current = current_of(parameters)
    tows = []
    for speed in speeds:
        if not (math.isfinite(speed) and speed >= 0.0):
            raise StaticsError(f"the towing speed must be finite and not negative; got {speed:g}")
        solve = partial(towing_cable, end=tip, current=current.shifted(speed * along))
        shape = shape_at_rest(parameters, solve)
        refuse_floating(float(shape.positions[0, 2]), float(tip[2]))
        clearance_of(parameters, shape.positions[0])
        offset = shape.positions[0] - tip
        sideways = float(offset[1] * along[0] - offset[0] * along[1])
        tows.append(TowedUnit(speed, -float(shape.positions[0, 2]), -float(offset[:2] @ along), sideways, shape))
    return TowingReport(course, tip, tuple(tows))
