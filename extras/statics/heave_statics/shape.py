"""The answer of statics: where the cable lies and what it pulls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from cable_sim_node.physics.current import Current
from heave_node.numerics.arrays import Array

from heave_statics.march import march
from heave_statics.segment import segment_span
from heave_statics.system import StaticCable
from heave_statics.tables import LENGTH, STIFFNESS, CableTables, allocate_shape


@dataclass(frozen=True)
class StaticShape:
    """An equilibrium; frame z up, vectors in newtons and metres, one row per node from s = 0."""

    cable: StaticCable  # what was solved
    positions: Array  # shape (n + 1, 3) [m]
    lower: Array  # shape (n, 3), tension vector at the lower end of each segment, pointing along increasing s [N]
    upper: Array  # the same at the upper end [N]
    drag: Array  # shape (n, 3), drag on each segment per unstretched metre [N/m]
    start_force: Array  # force that holds the cable at s = 0, point loads there not included [N]
    end_force: Array  # the same at s = L [N]
    partials: Array  # shape (6, 6): (position at s = L, end_force) by (position at s = 0, minus start_force)
    energy: float  # complementary energy [N m]

    @property
    def tension(self) -> Array:
        """Tension at each node, the larger of both sides where a load makes it jump, shape (n + 1,) [N]."""
        above = np.linalg.norm(np.vstack((self.lower, self.upper[-1:])), axis=1)
        below = np.linalg.norm(np.vstack((self.lower[:1], self.upper)), axis=1)
        return np.asarray(np.maximum(above, below))

    @property
    def largest_strain(self) -> float:
        """Largest strain of the cable [-]."""
        return self.largest_strain_below(np.inf)

    def largest_strain_below(self, label: float) -> float:
        """Return the largest strain [-] of the segments that begin before the unstretched length `label` [m]."""
        below = self.cable.labels[:-1] < label
        ends = np.maximum(np.linalg.norm(self.lower, axis=1), np.linalg.norm(self.upper, axis=1))
        return float(np.max(ends[below] / self.cable.segments[below, STIFFNESS]))

    @property
    def top_tension(self) -> float:
        """Tension in the cable at s = L [N]."""
        return float(np.linalg.norm(self.upper[-1]))

    @property
    def top_angle(self) -> float:
        """Angle between the cable at s = L and the vertical [rad]; 0 hangs straight down."""
        pull = self.upper[-1]
        return float(np.arctan2(np.hypot(pull[0], pull[1]), pull[2]))

    @property
    def stretched_length(self) -> float:
        """Length under load [m]."""
        mean = 0.0
        for index, row in enumerate(self.cable.segments):
            load = (self.lower[index] - self.upper[index]) / row[LENGTH]
            scratch = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
            integral = segment_span(self.lower[index], load, row[LENGTH], row[STIFFNESS], *scratch)
            mean += row[LENGTH] + integral / row[STIFFNESS]
        return float(mean)

    def curve(self, per_segment: int = 4) -> Array:
        """Return points along the exact curve, `per_segment` to a segment, shape (n * per_segment + 1, 3) [m]."""
        points = [self.positions[0]]
        scratch = np.empty((3, 3)), np.empty((3, 3))
        for index, row in enumerate(self.cable.segments):
            load = (self.lower[index] - self.upper[index]) / row[LENGTH]
            for part in range(1, per_segment + 1):
                span = np.empty(3)
                segment_span(self.lower[index], load, row[LENGTH] * part / per_segment, row[STIFFNESS], span, *scratch)
                points.append(self.positions[index] + span)
        return np.array(points)


@dataclass(frozen=True)
class Crossing:
    """Where a shape, followed from s = 0, first reaches a height."""

    label: float  # unstretched length from s = 0 [m]
    position: Array  # [m]
    tension: Array  # tension vector there [N]
    strain: float  # largest from s = 0 up to there, its whole segment taken in [-]


def cut_at_height(shape: StaticShape, height: float) -> Crossing | None:
    """Return where the cable of `shape`, from s = 0 on, first comes up to z = `height` [m]; None if it does not."""
    above = np.nonzero(shape.positions[1:, 2] >= height)[0]
    if len(above) == 0 or shape.positions[0, 2] >= height:
        return None
    index = int(above[0])
    row = shape.cable.segments[index]
    load = (shape.lower[index] - shape.upper[index]) / row[LENGTH]
    span, scratch = np.empty(3), (np.empty((3, 3)), np.empty((3, 3)))

    def miss(part: float) -> float:
        if part == 0.0:
            return float(shape.positions[index, 2] - height)
        segment_span(shape.lower[index], load, part, row[STIFFNESS], span, *scratch)
        return float(shape.positions[index, 2] + span[2] - height)

    size = float(row[LENGTH])
    part = size if miss(size) <= 0.0 else float(scipy.optimize.brentq(miss, 0.0, size, xtol=1e-13 * size))
    if part > 0.0:
        miss(part)
    else:
        span[:] = 0.0
    return Crossing(
        float(shape.cable.labels[index]) + part,
        shape.positions[index] + span,
        shape.lower[index] - load * part,
        shape.largest_strain_below(float(shape.cable.labels[index + 1])),
    )


def shape_from(
    cable: StaticCable,
    current: Current,
    origin: Array,
    start: Array,
    *,
    factor: float = 1.0,
    frozen_drag: Array | None = None,
    drag_guess: Array | None = None,
) -> StaticShape | None:
    """March from s = 0; return None where a segment has no solution.

    Parameters
    ----------
    cable, current : what is marched
    origin : position of s = 0 [m]
    start : tension vector there, below node 0 [N]
    factor : multiplies the current
    frozen_drag : dead loads in place of the segments' drag, shape (n, 3) [N/m]
    drag_guess : where the search for each segment's drag begins, shape (n, 3) [N/m]; needed where tension is so small
        that drag decides its direction
    """
    shape = allocate_shape(len(cable.segments))
    for given in (drag_guess, frozen_drag):
        if given is not None:
            shape.drag[:] = given
    tables = CableTables(
        cable.segments, cable.nodes, current.profile, factor, cable.feed, frozen=frozen_drag is not None
    )
    energy = march(tables, origin, start, shape)
    if not np.isfinite(energy) or not np.all(np.isfinite(shape.partials)):
        return None
    return StaticShape(
        cable=cable,
        positions=shape.positions,
        lower=shape.lower,
        upper=shape.upper,
        drag=shape.drag,
        start_force=-start,
        end_force=shape.end,
        partials=shape.partials,
        energy=energy,
    )
