"""A cable whose lower end is held at the bottom while the ship drifts off: what it pulls, by the offset of the ship."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.current import current_of
from heave_node.numerics.arrays import Array
from heave_node.sheet import Column, Sheet

from heave_statics.problems import mooring_cable, submerged_cable
from heave_statics.reports.cases import CasesReport, Sides, SideView, draw_curves, unit_vector
from heave_statics.shape import StaticShape
from heave_statics.suspended import shape_at_rest
from heave_statics.system import PointLoad

LIES_BELOW = 1e-3
"""A cable that comes further below its lower end than this [m] would lie on the bottom."""


@dataclass(frozen=True)
class MooredCable:
    """The cable at one place of the ship."""

    offset: float  # of the boom tip from above the lower end, in the direction of the ship's drift [m]
    pull: float  # horizontal force on the cable in that direction at the boom tip [N]
    anchor_tension: float  # of the cable at its lower end [N]
    anchor_angle: float  # of the cable at its lower end, from the vertical [rad]
    below: float  # how far the cable sags below its lower end [m]
    shape: StaticShape  # s = 0 at the lower end


CABLES = Sheet(
    Column("offset m", "offset", "offset_m", ".2f"),
    Column("pull kN", "pull", "horizontal_pull_n", ".3f", 1e-3),
    Column("top tension kN", "shape.top_tension", "top_tension_n", ".3f", 1e-3),
    Column("top angle deg", lambda cable: math.degrees(cable.shape.top_angle), "top_angle_deg", ".2f"),
    Column("bottom tension kN", "anchor_tension", "anchor_tension_n", ".3f", 1e-3),
    Column("bottom angle deg", lambda cable: math.degrees(cable.anchor_angle), "anchor_angle_deg", ".2f"),
    Column("", "below", "below_anchor_m"),
)
"""Columns of a moored cable at each place of the ship."""

FORCES = {"horizontal pull": "pull", "top tension": "shape.top_tension", "bottom tension": "anchor_tension"}
"""Forces that are drawn."""


def mooring_report(
    parameters: CableSimParameters,
    depth: float,
    *,
    offsets: Sequence[float] = (),
    pulls: Sequence[float] = (),
    direction: float = 0.0,
    boom_tip_height: float = 0.0,
) -> CasesReport:
    """Return the equilibria of a cable whose lower end is held at the bottom; rows are `MooredCable`.

    Parameters
    ----------
    parameters : of the plant; the unit has no part in it, for it is what is held
    depth : of the lower end below still water [m]
    offsets : of the boom tip from above the lower end [m]
    pulls : horizontal forces by which the ship pulls the boom tip away [N]
    direction : of offsets and pulls, from x towards y [rad]
    boom_tip_height : z of the boom tip [m]

    Raises
    ------
    StaticsError
        for values that are not finite, or sections or bodies that do not fit on the cable.
    NoEquilibriumError
        where there is no such equilibrium.
    """
    along = unit_vector(direction)
    at: dict[str, Any] = {"start": np.array([0.0, 0.0, -depth]), "current": current_of(parameters)}
    tips = [np.array([*(offset * along), boom_tip_height]) for offset in offsets]
    solvers = [partial(submerged_cable, end=tip, **at) for tip in tips]
    solvers += [partial(mooring_cable, height=boom_tip_height, horizontal_force=pull * along, **at) for pull in pulls]
    cables = tuple(_moored(shape_at_rest(parameters, solve, PointLoad(0.0)), along) for solve in solvers)
    drawn = [(f"{cable.offset:.1f} m", cable.shape.curve()) for cable in cables]
    views = [SideView(name, curve[:, :2] @ along, curve[:, 2]) for name, curve in drawn]
    words = {"xlabel": "offset of the boom tip [m]", "ylabel": "[kN]", "title": "forces of the cable"}
    return CasesReport(
        *(CABLES, "cables", cables, {"depth_m": depth, "direction_deg": math.degrees(direction)}),
        largest_tension=max(cable.shape.top_tension for cable in cables),
        side=Sides(views, "offset", "from the lower end [m]", depth).draw,
        other=partial(draw_curves, cables, "offset", FORCES, words, 1e-3),
        notes=tuple(
            f"offset {cable.offset:.2f} m: the cable sags {cable.below:.2f} m below its lower end; the seabed it "
            "would lie on is not modelled"
            for cable in cables
            if cable.below > LIES_BELOW
        ),
    )


def _moored(shape: StaticShape, along: Array) -> MooredCable:
    bottom = shape.lower[0]
    return MooredCable(
        offset=float((shape.positions[-1, :2] - shape.positions[0, :2]) @ along),
        pull=float(shape.end_force[:2] @ along),
        anchor_tension=float(np.linalg.norm(bottom)),
        anchor_angle=math.atan2(float(np.hypot(bottom[0], bottom[1])), float(bottom[2])),
        below=float(shape.positions[0, 2] - shape.curve()[:, 2].min()),
        shape=shape,
    )
