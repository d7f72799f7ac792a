"""Whole lifts in one compiled loop: line, servo, a stationary filter and a linear law, lifts innermost.

The servo is the plant's own kernel, and the line with the winch locked has run before. Filter and law are matrices:
x = A x + B u, then x += K (y - H x), and u = -G x.

Arguments have the same names everywhere: `lanes` the lines of the lifts, `course` and `timing` of the lifts, `lane` the
place of one of them, `locked` what is kept of lines with the winch locked.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from cable_sim_node.line import layout as at
from cable_sim_node.line import step
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.winch.drive import speed_step
from heave_bringup.closed_loop import COLUMNS
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, kernel

from heave_studies.batch.line import (
    LANES,
    SEEN_TENSION,
    Lanes,
    V,
    Z,
    advance,
)
from heave_studies.batch.line import (
    TENSION as SEGMENT_TENSION,
)

_COLUMN = {name: index for index, name in enumerate(COLUMNS)}
TIME, BOOM_TIP, UNIT, OFF = (_COLUMN[name] for name in ("time", "boom_tip", "unit", "uncompensated"))
PAYOUT, RATE, ACCELERATION = (_COLUMN[name] for name in ("payout", "payout_rate", "payout_acceleration"))
TENSION, PEAK, UNIT_TENSION = (_COLUMN[name] for name in ("top_tension", "largest_top_tension", "unit_tension"))
OFF_TENSION, OFF_PEAK = (_COLUMN[name] for name in ("uncompensated_tension", "uncompensated_largest_tension"))
AUTHORITY, UNIT_RATE, SLACK = (_COLUMN[name] for name in ("authority", "unit_rate", "slack_segments"))
TOUCHDOWN, LIMITS, SET_POINT = (_COLUMN[name] for name in ("touchdown_force", "limits_hit", "depth_set_point"))

MRU_HEAVE, MRU_RATE, DEPTH, ENCODER = range(4)
"""Readings that the filter takes, in the order of its rows."""

NOISY = (MRU_HEAVE, MRU_RATE, DEPTH)
"""Readings of which the filter follows the noise."""

OFF_HEAVE, OFF_RATE, OFF_TOP, OFF_LARGEST = range(4)
"""What is kept of the locked line at each tick: height [m] and velocity [m/s] of the unit, tension [N], its largest."""


class Control(NamedTuple):
    """Filter and law, with n states and a pattern of p ticks."""

    transition: Array  # A', shape (n, n)
    command: Array  # B, shape (n,)
    rows: Array  # H, shape (4, n)
    gains: Array  # K', shape (p, 4, n); 0 where no reading is due
    by_level: Array  # change of K' by each of the levels that the filter follows, shape (4, p, 4, n)
    law: Array  # G, shape (n,)
    of_sea: Array  # 1 for the states of waves and vessel, shape (n,)
    unit: tuple[int, int]  # states of the unit's heave and of its rate


class Course(NamedTuple):
    """What comes from outside to each lift, for t_1 to t_{k+1}."""

    tips: Array  # height of the boom tip [m] and its rate [m/s], shape (k + 1, 2, LANES)
    # heave [m] and its rate [m/s] that the MRU delivers, NaN where it does not, shape (k + 1, 2, LANES)
    readings: Array
    depth_noise: Array  # of the depth measured at each tick [m], shape (k + 1, LANES)
    # what the filter assumes over what it was designed for, as a logarithm: the noise of each of NOISY, the height of
    # the sea; shape (k + 1, 4, LANES)
    levels: Array


class Timing(NamedTuple):
    """Times and sizes of a lift."""

    tick_period: float  # [s]
    length: float  # of the cable at payout 0 [m]
    height: float  # mean one of the boom tip [m]
    start: int  # tick at which compensation begins; beyond the end: the winch stays locked
    fade_in: float  # authority that a tick adds [-]
    delay: int  # of the command [ticks]
    depth_period: int  # [ticks]
    depth_age: int  # of a depth when it arrives [ticks]
    resolution: float  # of the encoder [m]
    power_limit: float  # [W], infinite where there is none


@inlined_kernel
def _move_on(lanes: Lanes, course: Course, k: int, timing: Timing, drums: Array, ends: Array, work: Array) -> None:
    """Take the lines from t_{k+1} to t_{k+2}.

    Parameters
    ----------
    lanes, course, timing : of the lifts
    k : tick
    drums : payout and its rate at the start, the same at the end [m], [m/s], shape (4, LANES)
    ends, work : scratch, shapes (8, LANES), (11, LANES)
    """
    tips, lengths = ends[:4], ends[4:]
    for column in range(2):
        for lane in range(LANES):
            tips[column, lane], tips[2 + column, lane] = course.tips[k, column, lane], course.tips[k + 1, column, lane]
            offset = timing.length if column == 0 else 0.0
            lengths[column, lane] = offset + drums[column, lane]
            lengths[2 + column, lane] = offset + drums[2 + column, lane]
    advance(lanes, timing.tick_period, tips, lengths, work)


@kernel
def hang(lanes: Lanes, course: Course, timing: Timing, locked: Array) -> None:
    """Run lines of which the winch is `locked`: fill what is kept of them, shape (k, 4, LANES)."""
    drums, ends, work = np.zeros((4, LANES)), np.zeros((8, LANES)), np.zeros((11, LANES))
    for k in range(len(locked)):
        for lane in range(LANES):
            locked[k, OFF_HEAVE, lane], locked[k, OFF_RATE, lane] = lanes.cells[Z + lane], lanes.cells[V + lane]
            locked[k, OFF_TOP, lane] = locked[k, OFF_LARGEST, lane] = lanes.seen[SEEN_TENSION, lane]
        _move_on(lanes, course, k, timing, drums, ends, work)


@kernel
def hang_alone(line: LineArrays, course: Course, timing: Timing, lane: int, locked: Array) -> bool:
    """Do `hang` for one lift by the plant's own `line`, which may be slack; return whether it could be followed."""
    start, end, speed, end_speed = np.zeros((4, 3))
    lengths = (timing.tick_period, timing.length, 0.0, timing.length, 0.0)
    for k in range(len(locked)):
        locked[k, OFF_HEAVE, lane], locked[k, OFF_RATE, lane] = line.tiles[0, at.Z], line.tiles[0, at.VZ]
        locked[k, OFF_TOP, lane] = line.numbers[at.SEEN_TENSION]
        locked[k, OFF_LARGEST, lane] = line.numbers[at.SEEN_LARGEST]
        start[2], speed[2] = course.tips[k, 0, lane], course.tips[k, 1, lane]
        end[2], end_speed[2] = course.tips[k + 1, 0, lane], course.tips[k + 1, 1, lane]
        outcome = step.advance(line.tiles, line.numbers, line.water, line.band, start, speed, end, end_speed, lengths)
        if outcome != at.DONE:
            return False
    return True


@inlined_kernel
def _correct(control: Control, phase: int, m: int, left: Array, levels: Array, x: Array, moved: Array) -> None:
    """Take reading `m`, from which what is predicted is taken off in `left`; arguments as in `_filter`."""
    n = len(x)
    for i in range(n):
        share = control.rows[m, i]
        if share != 0.0:
            for lane in range(LANES):
                left[lane] -= share * moved[i, lane]
    for i in range(n):
        gain, slopes = control.gains[phase, m, i], control.by_level[:, phase, m, i]
        for lane in range(LANES):
            change = slopes[0] * levels[0, lane] + slopes[1] * levels[1, lane]
            change += slopes[2] * levels[2, lane] + slopes[3] * levels[3, lane]
            x[i, lane] += (gain + change) * left[lane]


@inlined_kernel
def _filter(
    control: Control, phase: int, command: Array, readings: Array, is_due: Array, levels: Array, x: Array, moved: Array
) -> None:
    """Predict x and take the `readings` that are due, at `levels` and a `phase` of the pattern.

    Arrays have a column for each lift: `x` and `moved` (n, LANES), `command` (LANES,), `readings` (4, LANES).
    """
    n = len(x)
    for i in range(n):
        for lane in range(LANES):
            moved[i, lane] = control.command[i] * command[lane]
    for j in range(n):
        for i in range(n):
            share = control.transition[j, i]
            if share != 0.0:
                for lane in range(LANES):
                    moved[i, lane] += share * x[j, lane]
    x[:] = moved
    for m in range(len(readings)):
        if is_due[m]:
            _correct(control, phase, m, readings[m], levels, x, moved)


@kernel
def heights_seen(
    heave: Array, tick_period: float, sigma: float, tracker: tuple[float, float, float, float, float]
) -> Array:
    """Return the height of the sea that the filter assumes at each tick over that of its design (core: `sea.cpp`).

    Parameters
    ----------
    heave : of the boom tip, shape (k,) [m]
    tick_period : [s]
    sigma : standard deviation of that heave in the sea of the design [m]
    tracker : memory, memory of a group, patience [s], share of a group [-], step [-], of `design.seas`
    """
    memory, group_memory, patience, group_share, step = tracker
    variance, group, applied, found = 0.0, 0.0, 1.0, np.ones(heave.size)
    for k in range(heave.size):
        seen = (k + 1) * tick_period
        variance += tick_period / min(seen, memory) * (heave[k] ** 2 - variance)
        group += tick_period / min(seen, group_memory) * (heave[k] ** 2 - group)
        settled = math.sqrt(variance) / sigma if seen >= patience else 1.0
        ratio = max(settled, group_share * math.sqrt(group) / sigma)
        if abs(ratio / applied - 1.0) >= step:
            applied = ratio
        found[k] = applied
    return found


@inlined_kernel
def _take_commands(control: Control, x: Array, authority: float, off: Array, commands: Array) -> None:
    """Set u of each lift at an `authority`; the locked units move by `off`, (2, LANES) (core: `shift_state`)."""
    heave, rate = control.law[control.unit[0]], control.law[control.unit[1]]
    for lane in range(LANES):
        commands[lane] = (1.0 - authority) * (heave * off[0, lane] + rate * off[1, lane])
    for i in range(len(x)):
        share = -control.law[i] * (authority if control.of_sea[i] > 0.0 else 1.0)
        for lane in range(LANES):
            commands[lane] += share * x[i, lane]


@inlined_kernel
def _write(record: Array, k: int, lanes: Lanes, locked: Array, drums: Array, authority: float) -> None:
    """Write the state of tick `k` to the record of each lift."""
    for lane in range(LANES):
        row = record[lane, k]
        row[UNIT], row[UNIT_RATE] = lanes.cells[Z + lane], lanes.cells[V + lane]
        row[OFF], row[OFF_TENSION], row[OFF_PEAK] = locked[0, lane], locked[2, lane], locked[3, lane]
        row[TENSION] = row[PEAK] = lanes.seen[SEEN_TENSION, lane]
        row[UNIT_TENSION], row[AUTHORITY] = lanes.cells[SEGMENT_TENSION + lane], authority
        row[PAYOUT], row[RATE] = drums[0, lane], drums[1, lane]
        row[ACCELERATION], row[LIMITS] = drums[2, lane], drums[3, lane]


@inlined_kernel
def _read(
    k: int, timing: Timing, course: Course, heave: Array, first: Array, drums: Array, readings: Array, is_due: Array
) -> None:
    """Set the readings of tick `k`, and which of them are due.

    `heave` is that of each unit until now (k, LANES), `first` what its depth counts from (LANES,).
    """
    measured = k - timing.depth_age
    is_due[DEPTH] = measured >= 0 and (measured + 1) % timing.depth_period == 0
    is_due[ENCODER] = k > 0
    for m in (MRU_HEAVE, MRU_RATE):
        is_due[m] = math.isfinite(course.readings[k, m, 0])
        readings[m] = course.readings[k, m]
    if is_due[DEPTH]:
        readings[DEPTH] = heave[measured] - course.depth_noise[measured] - first
    step_size = timing.resolution
    for lane in range(LANES):
        payout = drums[0, lane]
        readings[ENCODER, lane] = step_size * np.rint(payout / step_size) if step_size > 0.0 else payout


@inlined_kernel
def _turn(timing: Timing, servo: Array, decay: float, sent: Array, tension: Array, drums: Array) -> None:
    """Let the drums follow what was `sent` [m/s] over a tick: payout, rate, acceleration, limits that acted."""
    for lane in range(LANES):
        power_speed = timing.power_limit / max(tension[lane], 1.0)
        drums[0, lane], drums[1, lane], drums[3, lane] = speed_step(
            drums[0, lane], drums[1, lane], sent[lane], power_speed, servo[0], decay, timing.tick_period
        )
        drums[2, lane] = (sent[lane] - drums[1, lane]) / servo[0].time_constant


@kernel
def fly(
    lanes: Lanes, locked: Array, control: Control, course: Course, timing: Timing, servo: Array, record: Array
) -> None:
    """Run lifts side by side.

    Parameters
    ----------
    lanes : lines at rest at t_1
    locked : what is kept of the same lines with the winch locked, shape (k, 4, LANES)
    control, course, timing : of the lifts
    servo : `cable_sim_node.winch.drive.as_array` of the winch's settings
    record : out, for each lift a row for each tick t_1 to t_k, columns COLUMNS; shape (LANES, k, len(COLUMNS))
    """
    ticks, n, pattern = record.shape[1], len(control.law), len(control.gains)
    x, moved, readings, is_due = np.zeros((n, LANES)), np.zeros((n, LANES)), np.zeros((4, LANES)), np.zeros(4, np.bool_)
    drums, both, off, begun = np.zeros((4, LANES)), np.zeros((4, LANES)), np.zeros((2, LANES)), np.zeros((2, LANES))
    commands, heave, none = np.zeros((ticks, LANES)), np.zeros((ticks, LANES)), np.zeros(LANES)
    ends, work = np.zeros((8, LANES)), np.zeros((11, LANES))
    decay = math.exp(-timing.tick_period / servo[0].time_constant)
    zero = lanes.cells[Z]
    first = -course.depth_noise[timing.depth_period - 1]  # the depth counts from where its first reading was
    for k in range(ticks):
        authority = min(max((k + 1 - timing.start) * timing.fade_in, 0.0), 1.0)
        _write(record, k, lanes, locked[k], drums, authority)
        for lane in range(LANES):
            record[lane, k, TIME] = (k + 1) * timing.tick_period
            record[lane, k, BOOM_TIP] = course.tips[k, 0, lane] - timing.height
            heave[k, lane] = lanes.cells[Z + lane] - zero
        _read(k, timing, course, heave, first, drums, readings, is_due)
        command = commands[k - 1] if k > 0 else none
        _filter(control, (k + 1) % pattern, command, readings, is_due, course.levels[k], x, moved)
        if k + 1 >= timing.start:
            for lane in range(LANES):
                off[0, lane], off[1, lane] = locked[k, OFF_HEAVE, lane] - zero, locked[k, OFF_RATE, lane]
                if k + 1 == timing.start:  # the controller's own locked unit begins where its estimate is
                    begun[0, lane] = x[control.unit[0], lane] - off[0, lane]
                    begun[1, lane] = x[control.unit[1], lane] - off[1, lane]
            off += begun
            _take_commands(control, x, authority, off, commands[k])
        both[:2] = drums[:2]
        sent = commands[k - timing.delay] if k >= timing.delay else none
        _turn(timing, servo, decay, sent, lanes.seen[SEEN_TENSION], drums)
        both[2:] = drums[:2]
        _move_on(lanes, course, k, timing, both, ends, work)
