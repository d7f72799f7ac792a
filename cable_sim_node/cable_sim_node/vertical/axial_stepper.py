"""The axial cable from end to end of intervals: over a whole record, or tick by tick in a closed loop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from cable_sim_node.errors import PlantError
from cable_sim_node.vertical import axial_layout as at
from cable_sim_node.vertical.axial_kernel import begin_step, solve_step, start_steadily, write_answer
from cable_sim_node.vertical.axial_line import AxialLine

INPUT = [at.TOP, at.TOP_VELOCITY, at.LENGTH, at.LENGTH_RATE]
STATE = [at.UNIT_ELEVATION, at.UNIT_VELOCITY, at.TOP_TENSION, at.LEAST_TENSION]
"""Columns of the kernels in the order of AxialInput, its payout as a length, and of AxialState."""


class AxialError(PlantError, ValueError):
    """An axial run that cannot be done or did not converge; the message says what and when."""


class AxialInput(NamedTuple):
    """Motion of the cable's top end at one time."""

    heave: float  # of the boom tip, positive up [m]
    heave_rate: float  # of the boom tip, positive up [m/s]
    payout: float  # cable let out beyond the length at payout 0, positive lowers [m]
    payout_rate: float  # cable let out beyond the length at payout 0, positive lowers [m/s]


class AxialState(NamedTuple):
    """State of unit and cable at one time."""

    unit_heave: float  # elevation of the unit above its rest at payout 0 with the boom tip at 0, positive up [m]
    unit_velocity: float  # positive up [m/s]
    top_tension: float  # force on the top end [N]
    least_tension: float  # the smallest along the cable [N]


class AxialStepper:
    """Cable and unit in vertical motion, advanced from tick to tick.

    Boom tip and payout run as cubics through their values and rates at both ends of an interval. The method is that of
    `axial_kernel`: slack, quadratic drag and a changing length are in.

    Parameters
    ----------
    line : cable and unit
    length : unstretched length out at payout 0 [m]
    start : motion of the top end at the start; cable and unit move steadily with it
    segments : elements along the cable
    duration : of an interval [s]
    substeps : steps in an interval
    allow_slack : False lets the cable carry compression (a linear material, for comparison with linear theory)

    Raises AxialError where the cable is hauled in to nothing, or a step has no solution.
    """

    def __init__(
        self,
        line: AxialLine,
        length: float,
        start: AxialInput,
        *,
        segments: int,
        duration: float,
        substeps: int,
        allow_slack: bool = True,
    ) -> None:
        self._arrays = _arrays(line, segments, allow_slack=allow_slack)
        self._time = 0.0
        self._length, self._duration, self._substeps = length, duration, substeps
        self._rest = -length - line.static_stretch(length)
        (self._end,), self._answer = self._rows(np.array([start])), np.zeros(at.ANSWER_COLUMNS)
        _start(self._arrays, self._end, duration / substeps, self._answer)

    def advance(self, end: AxialInput) -> AxialState:
        """Integrate to the `end` of the next interval and return the state there."""
        self._go_on(self._rows(np.array([end])))
        return self.state

    def follow(self, ends: Array) -> Array:
        """Integrate from end to end of intervals, `ends` (n, 4) as AxialInput; return the AxialState at each (n, 4)."""
        states = self._go_on(self._rows(ends))[:, STATE]
        states[:, 0] -= self._rest
        return states

    @property
    def state(self) -> AxialState:
        """State of now."""
        heave, velocity, top, least = self._answer[STATE].tolist()
        return AxialState(heave - self._rest, velocity, top, least)

    def _go_on(self, ends: Array) -> Array:
        """Integrate over intervals that end with these rows, and return the answers there."""
        rows, answers = np.vstack((self._end, ends)), np.empty((len(ends), at.ANSWER_COLUMNS))
        solved = advance(self._arrays, rows, self._duration, self._substeps, answers)
        self._time += solved * self._duration
        if solved < len(ends):
            raise AxialError(
                f"the axial cable has no solution after {self._time:.3f} s: check the motion there or use shorter steps"
            )
        self._end, self._answer = rows[-1], answers[-1] if len(answers) else self._answer
        return answers

    def _rows(self, tops: Array) -> Array:
        rows = np.zeros((len(tops), 4))
        rows[:, INPUT] = tops
        rows[:, at.LENGTH] += self._length
        for row in rows[~(np.isfinite(rows).all(axis=1) & (rows[:, at.LENGTH] > 0.0))]:
            raise AxialError(f"the cable cannot have a length of {row[at.LENGTH]:g} m under a top at {row[at.TOP]:g} m")
        return rows


def _arrays(line: AxialLine, segments: int, *, allow_slack: bool) -> at.AxialArrays:
    """Return a `line` of so many `segments` as the kernels take it; without `allow_slack` as a linear material."""
    nodes, elements = at.allocate_nodes(segments)
    return at.AxialArrays(
        sections=line.section_table(),
        bodies=np.array([(b.label, b.inertia, b.weight, b.drag) for b in line.clumps]).reshape(-1, 4),
        unit=np.array([line.unit.inertia, line.unit.weight, line.unit.drag]),
        nodes=nodes,
        elements=elements,
        is_linear=not allow_slack,
    )


@kernel
def _start(line: at.AxialArrays, motion: Array, h: float, answer: Array) -> None:
    """Set the steady state and write it to `answer`."""
    start_steadily(line, motion, h)
    write_answer(line, motion, h, True, answer)


@inner_kernel
def _between(begin: Array, end: Array, duration: float, share: float, motion: Array) -> None:
    """Write the top's motion at a `share` of the interval to `motion`: cubic Hermite, and its slope."""
    s, t = share, 1.0 - share
    for value, rate in ((at.TOP, at.TOP_VELOCITY), (at.LENGTH, at.LENGTH_RATE)):
        a, b, va, vb = begin[value], end[value], begin[rate] * duration, end[rate] * duration
        motion[value] = a * t * t * (1.0 + 2.0 * s) + b * s * s * (3.0 - 2.0 * s) + va * s * t * t - vb * s * s * t
        slope = 6.0 * s * t * (b - a) + va * t * (1.0 - 3.0 * s) + vb * s * (3.0 * s - 2.0)
        motion[rate] = slope / duration


@kernel
def advance(line: at.AxialArrays, rows: Array, duration: float, substeps: int, answers: Array) -> int:
    """Integrate from row to row, and write the answer at each but the first; return how many intervals were solved.

    Parameters
    ----------
    line : cable, unit and bodies
    rows : motion of the top at the ends of the intervals, columns TOP to LENGTH_RATE
    duration : of an interval [s]
    substeps : steps in an interval
    answers : out, a row for every interval
    """
    motion, h = np.zeros(4), duration / substeps
    for end in range(1, len(rows)):
        for step in range(1, substeps + 1):
            _between(rows[end - 1], rows[end], duration, step / substeps, motion)
            begin_step(line, motion)
            if not solve_step(line, motion, h):
                return end - 1
        write_answer(line, motion, h, False, answers[end - 1])
    return len(rows) - 1
