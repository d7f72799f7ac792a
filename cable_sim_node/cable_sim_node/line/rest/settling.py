"""A line at rest on the seabed: the unit landed, cable along the bottom, a lift that has only begun.

There is no march from the unit upwards, since the bottom carries a share that is not known. The line is laid out (from
below the boom tip straight up, what is longer along the bottom, down the current) and let go in the dynamic equations.
Its kinetic energy is taken away at each of its peaks (dynamic relaxation: Day 1965), and Newton's method removes what
is left. Friction holds as it does in a run, so that nothing moves when the run begins.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import kernel

from cable_sim_node.errors import NoEquilibriumError
from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.elimination import solve_blocks
from cable_sim_node.line.forces.bending import solve_with_bending
from cable_sim_node.line.grid import settings_of
from cable_sim_node.line.observation import evaluate
from cable_sim_node.line.rest.hanging import add_drag_turning
from cable_sim_node.line.step import advance
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.seabed import Seabed

_INTERVAL = 0.25
"""Time between two looks at the kinetic energy, and longest inner step [s]."""
_LONGEST = 4000.0
"""Time after which a line that has not come to rest is given up [s]."""
_QUIET = 0.03
"""Largest unbalanced force, over the weight of line and unit, from which Newton's method is tried; a tenth of it after
each failure."""
_AT_REST = 1e-9
"""Largest unbalanced force, over the weight of line and unit, of a line at rest."""
_CORRECTIONS = 60
"""Newton's method gets so many."""


@kernel
def correct(line: LineArrays, n: int) -> None:
    """Move nodes 0..n-1 of `line`, whose equations are assembled, by one correction of Newton's method."""
    if line.numbers[at.BENDING_ON] > 0.0:
        add_drag_turning(line, n)
        solve_with_bending(line, n)
    else:
        solve_blocks(line.tiles, n)
    for i in range(n):
        tile, j = line.tiles[i >> at.SHIFT], i & at.LANES
        for k in range(0, 3 * at.STRIDE, at.STRIDE):
            tile[at.X + k + j] += tile[at.CX + k + j]


def settle(line: LineArrays, parameters: CableSimParameters, boom_tip: Array) -> None:
    """Put a line that the seabed carries a part of at rest, in the current of the present time; waves are still.

    Parameters
    ----------
    line : arrays, with its length, segments and time set
    parameters : of the plant
    boom_tip : position [m], shape (3,)

    Raises
    ------
    NoEquilibriumError
        where it does not come to rest.
    """
    n, numbers = line.segments, line.numbers
    settings = numbers[at.SETTINGS :].copy()
    solver = dataclasses.replace(parameters.solver, spectral_radius=0.0, time_step=_INTERVAL)
    numbers[at.SETTINGS :] = settings_of(dataclasses.replace(parameters, solver=solver))
    numbers[at.SPRING_ON] = numbers[at.FRICTION_ON] = 0.0
    evaluate(line)  # sets the flow, by which it is laid out
    _lay_out(line, n, boom_tip, Seabed(parameters.seabed))
    hold_here(line)
    rests = _let_go(line, n, boom_tip)
    numbers[at.SETTINGS :] = settings
    numbers[[at.NEWTON, at.STEPS, at.REFUSED, at.HEAVE_PATH, at.HEAVE_SQUARE, at.HEAVE_WEIGHT]] = 0.0
    if not rests:
        raise NoEquilibriumError(
            f"the line does not come to rest on the seabed within {_LONGEST:g} s: give it more friction or less current"
        )


def hold_here(line: LineArrays) -> None:
    """Let all nodes of the line hold to where they are."""
    line.write(at.HOLD_X, line.read(at.X, 3, line.segments + 1))


def hold_strains(line: LineArrays) -> None:
    """Let the wires of all segments of the `line` be held where they are, without friction."""
    n = line.segments
    chords = np.linalg.norm(np.diff(line.read(at.X, 3, n + 1), axis=0), axis=1)
    line.write(at.HELD, (chords * line.column(at.PER_LENGTH, n) - 1.0)[:, None])


def _lay_out(line: LineArrays, n: int, boom_tip: Array, seabed: Seabed) -> None:
    """Place the nodes from below the boom tip straight up, what is longer along the seabed, down the current."""
    foot = np.append(boom_tip[:2], seabed.height(boom_tip, boom_tip[2]))
    current = line.tiles[0, [at.FLOW_X, at.FLOW_Y]]
    speed = float(np.hypot(*current))
    along = np.append(current / speed if speed > 0.0 else np.array([1.0, 0.0]), 0.0)
    label = np.append(0.0, np.cumsum(line.column(at.LENGTH, n)))
    height = boom_tip[2] - foot[2]
    on_bed = max(label[-1] - height, 0.0)
    stretch = height / (label[-1] - on_bed)
    point, reached = foot, 0.0
    positions = np.zeros((n + 1, 3))
    for i in range(n, -1, -1):
        step = max(on_bed - label[i], 0.0) - reached
        rise = seabed.height(point + step * along, boom_tip[2]) - point[2]
        point = point + along * step * step / max(float(np.hypot(step, rise)), 1e-12)
        point[2] = seabed.height(point, boom_tip[2])
        reached += step
        positions[i] = point
    positions[:, 2] += np.maximum(label - on_bed, 0.0) * stretch
    positions[n] = boom_tip
    line.write(at.X, positions)


def _let_go(line: LineArrays, n: int, boom_tip: Array) -> bool:
    """Let the line move until it is at rest; return whether it got there."""
    numbers = line.numbers
    start_time, total = float(numbers[at.NOW + at.TIME]), float(numbers[at.NOW + at.TOTAL])
    still, ends = np.zeros(3), (total, 0.0, total, 0.0)
    lengths = line.column(at.LENGTH, n)
    weight = float(np.abs(line.column(at.WEIGHT, n)) @ lengths) + abs(float(numbers[at.UNIT_FORCE + 2]))
    mass = line.column(at.MASS, n) * lengths
    mass[0] += numbers[at.UNIT_INERTIA]
    energy, quiet = 0.0, _QUIET
    for _ in range(round(_LONGEST / _INTERVAL)):
        outcome = advance(*line, boom_tip, still, boom_tip, still, (_INTERVAL, *ends))
        if outcome != at.DONE:
            return False
        numbers[at.NOW + at.TIME] = start_time
        now = float(mass @ np.sum(line.read(at.VX, 3, n) ** 2, axis=1))
        if now >= energy:
            energy = now
            continue
        line.write(at.VX, np.zeros((n + 1, 6)))
        energy = 0.0
        if _unbalanced(line, n) < quiet * weight:
            if _balance(line, n, _AT_REST * weight):
                return True
            quiet *= 0.1
    return False


def _unbalanced(line: LineArrays, n: int) -> float:
    """Return the largest component of force [N] on a node of the line, which does not move."""
    evaluate(line)
    return float(np.max(np.abs(line.read(at.RX, 3, n))))


def _balance(line: LineArrays, n: int, tolerance: float) -> bool:
    """Move the nodes to where forces balance to the tolerance [N]; return whether it succeeds, else change nothing."""
    before = line.read(at.X, 3, n)
    left = _unbalanced(line, n)
    for _ in range(_CORRECTIONS):
        if left < tolerance:
            return True
        correct(line, n)
        last, left = left, _unbalanced(line, n)
        if not left < 10.0 * last:
            break
    line.write(at.X, before)
    return False
