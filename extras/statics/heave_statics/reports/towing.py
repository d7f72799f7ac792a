"""A ship that steams with unit and cable in the water: depth and layback of the unit, tension of the cable."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from cable_sim_node.errors import StaticsError
from cable_sim_node.line.rest.hanging import refuse_floating
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.current import current_of
from cable_sim_node.physics.seabed import clearance_of
from heave_node.sheet import Column, Sheet
from numpy.typing import ArrayLike

from heave_statics.problems import towing_cable
from heave_statics.reports.cases import CasesReport, Sides, SideView, draw_curves, unit_vector
from heave_statics.shape import StaticShape
from heave_statics.suspended import shape_at_rest


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


def towing_report(
    parameters: CableSimParameters, speeds: Sequence[float], *, course: float = 0.0, boom_tip: ArrayLike = (0, 0, 0)
) -> CasesReport:
    """Return the steady tow of a plant's unit and cable at every speed of the ship; rows are `TowedUnit`.

    Parameters
    ----------
    parameters : of the plant; its current flows on top of the ship's motion
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
    tip, along, current = np.asarray(boom_tip, dtype=np.float64), unit_vector(course), current_of(parameters)
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

    shapes = [(f"{tow.speed:g} m/s", tow.shape.curve()) for tow in tows]
    views = [SideView(name, (curve[:, :2] - tip[:2]) @ along, curve[:, 2]) for name, curve in shapes]
    words = {"xlabel": "speed of the ship [m/s]", "ylabel": "[m]", "title": "depth and layback"}
    return CasesReport(
        *(TOWS, "tows", tuple(tows), {"course_deg": math.degrees(course)}),
        largest_tension=max(tow.shape.top_tension for tow in tows),
        side=Sides(views, "ship", "along the course from the boom tip [m]").draw,
        other=partial(draw_curves, tows, "speed", {"depth of the unit": "depth", "layback": "layback"}, words, 1.0),
        unit_load=max(float(np.linalg.norm(tow.shape.lower[0])) for tow in tows),
    )
