"""Time integration of the line: generalised-alpha (Chung & Hulbert 1993), second order, unconditionally stable in the
linear case.

The equations hold at the point between t_n and t_{n+1} where x, v are blended by alpha_f and a by alpha_m. Newton
starts from a constant acceleration and stops when a correction strains no segment by more than the tolerance; what is
left then is its square.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cable_sim_node.compiled import inner_kernel, kernel
from cable_sim_node.line_arrays import LineArrays
from cable_sim_node.line_assembly import add_compensator, assemble_nodes, assemble_segments, solve_blocks
from cable_sim_node.line_bending import add_bending, solve_with_bending
from cable_sim_node.line_feed import feed, set_top_segment
from cable_sim_node.line_flow import set_flow
from cable_sim_node.line_layout import (
    ACCELERATION,
    ALPHA_F,
    ALPHA_M,
    BENDING_ON,
    BETA,
    DONE,
    GAMMA,
    HALVINGS,
    ITERATIONS,
    LENGTH,
    MERGE_AT,
    NOT_CONVERGED,
    RATE,
    SEGMENTS,
    SOLVES,
    SPRING_ON,
    STATE_COLUMNS,
    STEP,
    SUBSTEPS,
    TIME,
    TOLERANCE,
    TOO_SHORT,
    TOTAL,
)

Array = NDArray[np.float64]
Counters = NDArray[np.int64]

_SMALLEST_SHARE = 2.0**-16
"""A step is halved at most so far before the advance is given up."""
_LONGEST_SLACK_STEP = 0.0125
"""Steps with a slack segment are halved down to this [s]."""
_FAILED, _TAUT, _SLACK, _SLACK_REFUSED = range(4)
"""How a step ended."""


@kernel
def hermite(
    share: float, duration: float, start: float, start_rate: float, end: float, end_rate: float
) -> tuple[float, float, float]:
    """Return value, rate and acceleration at `share` of `duration` of the cubic through both ends."""
    s = share
    delta = end - start
    bend = delta - duration * start_rate
    turn = duration * (start_rate + end_rate) - 2.0 * delta
    value = start + s * (duration * start_rate + s * (bend + turn * (s - 1.0)))
    rate = start_rate + (2.0 * s * bend + turn * s * (3.0 * s - 2.0)) / duration
    acceleration = (2.0 * bend + turn * (6.0 * s - 2.0)) / (duration * duration)
    return value, rate, acceleration


@kernel
def largest_relative_correction(count: int, seg: Array, correction: Array) -> float:
    """Return the largest difference of neighbours' corrections per length of their segment (NaN stays NaN)."""
    largest = 0.0
    for i in range(count):
        d0 = correction[i + 1, 0] - correction[i, 0]
        d1 = correction[i + 1, 1] - correction[i, 1]
        d2 = correction[i + 1, 2] - correction[i, 2]
        size = (d0 * d0 + d1 * d1 + d2 * d2) / (seg[i, LENGTH] * seg[i, LENGTH])
        if not size <= largest:
            largest = size
    return math.sqrt(largest)


@inner_kernel
def assemble(line: LineArrays, n: int, c_mass: float, c_velocity: float) -> tuple[float, bool]:
    """Assemble everything at the middle of the step or, where `c_mass` is 0, at its end.

    A flag for that would be a literal, and this long function compiled twice.
    Return the least strain and whether the seabed is touched.
    """
    x, v, a, moving, tip = line.x, line.v, line.a, line.moving, line.tip
    at_middle = c_mass > 0.0
    if at_middle:
        x, v, a, moving, tip = line.x_middle, line.v_middle, line.a_middle, line.middle, line.middle_tip
    least = assemble_segments(
        n,
        x,
        v,
        a,
        line.seg,
        line.flow,
        line.flow_acceleration,
        moving,
        line.settings,
        c_mass,
        c_velocity,
        line.diagonal,
        line.upper,
        line.residual,
        line.tensions,
    )
    touching = assemble_nodes(
        n,
        x,
        v,
        a,
        line.seg,
        line.lump,
        line.unit,
        line.flow,
        line.flow_acceleration,
        line.settings,
        c_mass,
        c_velocity,
        line.diagonal,
        line.residual,
    )
    if line.settings[BENDING_ON] > 0.0:
        add_bending(n, x, line.seg, line.residual, line.band, line.hinge)
    if at_middle:
        touching |= add_compensator(n, x, v, a, tip, line.settings, c_mass, c_velocity, line.diagonal, line.residual)
    return least, touching


@inner_kernel
def predict(line: LineArrays, n: int, count: int, h: float) -> None:
    """Set the middle state for constant acceleration of nodes 0..count-1; length and boom tip go to `end` and
    `end_tip`.
    """
    end_length, end_tip = line.end, line.end_tip
    af, am = line.settings[ALPHA_F], line.settings[ALPHA_M]
    for k in range(STATE_COLUMNS):
        line.middle[k] = af * line.moving[k] + (1.0 - af) * end_length[k]
    line.middle[ACCELERATION] = am * line.moving[ACCELERATION] + (1.0 - am) * end_length[ACCELERATION]
    share = (1.0 - af) * h
    for i in range(count):
        for k in range(3):
            a = line.a[i, k]
            line.x_middle[i, k] = line.x[i, k] + share * (line.v[i, k] + 0.5 * h * a)
            line.v_middle[i, k] = line.v[i, k] + share * a
            line.a_middle[i, k] = a
    for k in range(3):
        line.middle_tip[0, k] = af * line.tip[0, k] + (1.0 - af) * end_tip[0, k]
        line.middle_tip[1, k] = af * line.tip[1, k] + (1.0 - af) * end_tip[1, k]
        line.middle_tip[2, k] = am * line.tip[2, k] + (1.0 - am) * end_tip[2, k]
    # with a compensator the sheave keeps its own z, but follows the boom tip sideways
    for k in range(3 if count == n else 2):
        line.x_middle[n, k] = line.middle_tip[0, k]
        line.v_middle[n, k] = line.middle_tip[1, k]
        line.a_middle[n, k] = line.middle_tip[2, k]
    set_top_segment(n, line.middle[TOTAL], line.grid, line.grid_s, line.grid_lump, line.seg, line.lump)
    set_flow(
        n, line.x_middle, line.middle, line.settings, line.current, line.schedule, line.flow, line.flow_acceleration
    )


@inner_kernel
def finish(line: LineArrays, n: int, count: int, h: float) -> None:
    """Carry the middle state to the end of the step."""
    end_tip = line.end_tip
    am, beta, gamma = line.settings[ALPHA_M], line.settings[BETA], line.settings[GAMMA]
    for i in range(count):
        for k in range(3):
            a, v = line.a[i, k], line.v[i, k]
            new = (line.a_middle[i, k] - am * a) / (1.0 - am)
            line.x[i, k] += h * (v + h * ((0.5 - beta) * a + beta * new))
            line.v[i, k] = v + h * ((1.0 - gamma) * a + gamma * new)
            line.a[i, k] = new
    take_ends(line)
    for k in range(3 if count == n else 2):
        line.x[n, k], line.v[n, k], line.a[n, k] = end_tip[0, k], end_tip[1, k], end_tip[2, k]
    set_top_segment(n, line.moving[TOTAL], line.grid, line.grid_s, line.grid_lump, line.seg, line.lump)


@inner_kernel
def take_ends(line: LineArrays) -> None:
    """Make the end of the step the present: time, length and boom tip."""
    for k in range(STATE_COLUMNS):
        line.moving[k] = line.end[k]
    for k in range(3):
        line.tip[0, k], line.tip[1, k], line.tip[2, k] = line.end_tip[0, k], line.end_tip[1, k], line.end_tip[2, k]


@inner_kernel
def step(line: LineArrays, n: int, h: float) -> int:
    """Make one step of `h` seconds to `end` and `end_tip`; return whether the line was taut or slack in it.

    _FAILED: Newton finds no solution; _SLACK_REFUSED: a segment is slack, which wants short steps of the dissipative
    scheme. The state is then as it was.
    """
    settings = line.settings
    af, am, beta, gamma = settings[ALPHA_F], settings[ALPHA_M], settings[BETA], settings[GAMMA]
    c_velocity = gamma / (beta * h)
    c_mass = (1.0 - am) / ((1.0 - af) * beta * h * h)
    count = n if settings[SPRING_ON] == 0.0 else n + 1
    predict(line, n, count, h)
    bending = settings[BENDING_ON] > 0.0
    tolerance = settings[TOLERANCE]
    correction = line.correction
    for k in range(3):
        correction[n, k] = 0.0
    last, part = 1e300, 1.0
    for _ in range(int(settings[ITERATIONS])):
        least, touching = assemble(line, n, c_mass, c_velocity)
        line.counters[SOLVES] += 1
        if bending:
            solve_with_bending(count, line.diagonal, line.upper, line.residual, line.band, correction)
        else:
            solve_blocks(count, line.diagonal, line.upper, line.residual, line.sweep, correction)
        size = largest_relative_correction(n, line.seg, correction)
        if not size < 10.0:
            return _FAILED
        # a correction that does not shrink jumps to and fro over a kink (a segment that comes taut): go part of the way
        part = 0.5 * part if size > 0.5 * last else min(2.0 * part, 1.0)
        last = size
        for i in range(count):
            for k in range(3):
                c = part * correction[i, k]
                line.x_middle[i, k] += c
                line.v_middle[i, k] += c_velocity * c
                line.a_middle[i, k] += c_mass * c
        # where a segment is or may become slack, or the seabed is touched, the equations have a kink: ask for much more
        smooth = least > 4.0 * size and not touching
        if size < (tolerance if smooth else min(tolerance, 1e-2 * tolerance)):
            # the margin is for rounding: a step that was shortened for slack is never refused again for its length
            if least <= 0.0 and (h > 1.001 * _LONGEST_SLACK_STEP or af > 0.0):
                return _SLACK_REFUSED
            finish(line, n, count, h)
            return _SLACK if least <= 0.0 else _TAUT
    return _FAILED


@kernel
def set_scheme(settings: Array, alpha_m: float, alpha_f: float) -> None:
    """Set the parameters of the generalised-alpha scheme; (-1, 0) removes the fastest oscillations at once.

    A scheme that keeps them feeds energy into light nodes that snap taut: it must not be used while a segment is
    slack.
    """
    settings[ALPHA_M], settings[ALPHA_F] = alpha_m, alpha_f
    settings[GAMMA] = 0.5 - alpha_m + alpha_f
    settings[BETA] = 0.25 * (1.0 - alpha_m + alpha_f) ** 2


@kernel
def advance(line: LineArrays, duration: float, ends: Array, lengths: Array) -> int:
    """Integrate over `duration` [s]; return the outcome (DONE, NOT_CONVERGED, TOO_SHORT).

    `ends` rows: boom tip position and velocity at the start, position and velocity at the end. `lengths`: unstretched
    length and rate at the start, length and rate at the end. Both run as cubics in between. The state is that of the
    last good step where it fails.
    """
    n = line.counters[SEGMENTS]
    moving = line.moving
    start_time = moving[TIME]
    shares = max(math.ceil(duration / line.settings[STEP] - 1e-9), 1)
    nominal = 1.0 / shares
    end_tip = line.end_tip
    load_ends(0.0, duration, start_time, ends, lengths, line.end, end_tip)
    take_ends(line)
    free = 3 if line.settings[SPRING_ON] == 0.0 else 2
    for k in range(free):
        line.x[n, k], line.v[n, k], line.a[n, k] = end_tip[0, k], end_tip[1, k], end_tip[2, k]
    outcome = DONE
    alpha_m, alpha_f = line.settings[ALPHA_M], line.settings[ALPHA_F]
    for j in range(shares):
        done, size = j * nominal, nominal
        goal = 1.0 if j == shares - 1 else (j + 1) * nominal
        while done < goal:
            at = goal if done + size > goal - 1e-12 else done + size
            load_ends(at, duration, start_time, ends, lengths, line.end, end_tip)
            if line.end[TOTAL] < MERGE_AT * line.grid_s[1]:
                outcome = TOO_SHORT
                break
            ended = step(line, n, (at - done) * duration)
            if ended in (_TAUT, _SLACK):
                done = at
                size = min(2.0 * size, nominal)
                line.counters[SUBSTEPS] += 1
                n = feed(line, n)
                if ended == _TAUT:
                    set_scheme(line.settings, alpha_m, alpha_f)
            elif ended == _SLACK_REFUSED:
                set_scheme(line.settings, -1.0, 0.0)
                while size * duration > _LONGEST_SLACK_STEP:
                    size *= 0.5
            else:
                size *= 0.5
                line.counters[HALVINGS] += 1
                if size < nominal * _SMALLEST_SHARE:
                    outcome = NOT_CONVERGED
                    break
        if outcome != DONE:
            break
    set_scheme(line.settings, alpha_m, alpha_f)
    line.counters[SEGMENTS] = n
    set_top_segment(n, moving[TOTAL], line.grid, line.grid_s, line.grid_lump, line.seg, line.lump)
    return outcome


@kernel
def load_ends(
    share: float, duration: float, start_time: float, ends: Array, lengths: Array, end_length: Array, end_tip: Array
) -> None:
    """Write time, length and boom tip at `share` of the interval."""
    end_length[TIME] = start_time + share * duration
    value, rate, acceleration = hermite(share, duration, lengths[0], lengths[1], lengths[2], lengths[3])
    end_length[TOTAL], end_length[RATE], end_length[ACCELERATION] = value, rate, acceleration
    for k in range(3):
        value, rate, acceleration = hermite(share, duration, ends[0, k], ends[1, k], ends[2, k], ends[3, k])
        end_tip[0, k], end_tip[1, k], end_tip[2, k] = value, rate, acceleration


@kernel
def evaluate(line: LineArrays) -> float:
    """Fill `tensions` and `residual` at the present state; return the least strain.

    Row n of the residual is then the force [N] that holds the line's top end: the top segment's tension with half its
    weight, drag and inertia.
    """
    n = line.counters[SEGMENTS]
    set_flow(n, line.x, line.moving, line.settings, line.current, line.schedule, line.flow, line.flow_acceleration)
    least, _ = assemble(line, n, 0.0, 0.0)
    return least
