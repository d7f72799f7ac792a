"""A whole lift in one compiled loop: the line's integrator, the servo, a stationary filter and a linear law.

Line and servo are the plant's own kernels, and the plant with the winch locked runs beside it. Filter and law are
matrices: x = A x + B u, then x += K (y - H x), and u = -G x.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.step import advance
from cable_sim_node.winch.drive import speed_step
from heave_bringup.closed_loop import COLUMNS
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import kernel

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

DONE, LOST = 0, 1
"""How a lift ended: at its end, or where the line could not be followed."""


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
    """What comes from outside, for t_1 to t_{k+1}."""

    tips: Array  # position of the boom tip [m], shape (k + 1, 3)
    velocities: Array  # [m/s], shape (k + 1, 3)
    readings: Array  # heave [m] and its rate [m/s] that the MRU delivers, NaN where it does not, shape (k + 1, 2)
    depth_noise: Array  # of the depth measured at each tick [m], shape (k + 1,)
    # what the filter assumes over what it was designed for, as a logarithm: the noise of each of NOISY, the height of
    # the sea; shape (k + 1, 4)
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


@kernel
def _move_on(line: LineArrays, course: Course, k: int, timing: Timing, begin: Array, end: Array) -> int:
    """Take a `line` from t_{k+1} to t_{k+2}; `begin` and `end` are payout and rate [m], [m/s]. Return the outcome."""
    lengths = (timing.tick_period, timing.length + begin[0], begin[1], timing.length + end[0], end[1])
    tips, velocities = course.tips, course.velocities
    return advance(
        line.tiles, line.numbers, line.water, line.band, tips[k], velocities[k], tips[k + 1], velocities[k + 1], lengths
    )


@kernel
def _filter(
    control: Control, phase: int, command: float, readings: Array, levels: Array, x: Array, moved: Array
) -> None:
    """Predict x and take the `readings` that are numbers, at `levels` and a `phase` of the pattern."""
    n = x.size
    for i in range(n):
        moved[i] = control.command[i] * command
    for j in range(n):
        share = x[j]
        for i in range(n):
            moved[i] += control.transition[j, i] * share
    for i in range(n):
        x[i] = moved[i]
    for m in range(readings.size):
        predicted = 0.0
        for i in range(n):
            predicted += control.rows[m, i] * moved[i]
        left = readings[m] - predicted
        if math.isfinite(left):
            for i in range(n):
                x[i] += control.gains[phase, m, i] * left
            for level in range(levels.size):
                share = levels[level] * left
                for i in range(n):
                    x[i] += control.by_level[level, phase, m, i] * share


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


@kernel
def _command_of(control: Control, x: Array, authority: float, heave: float, rate: float) -> float:
    """Return u at an `authority`; the locked unit moves by `heave` and `rate` (core: `shift_state`)."""
    command = 0.0
    for i in range(x.size):
        command -= control.law[i] * x[i] * (authority if control.of_sea[i] > 0.0 else 1.0)
    off: float = control.law[control.unit[0]] * heave + control.law[control.unit[1]] * rate
    return command + (1.0 - authority) * off


@kernel
def _write(row: Array, plant: LineArrays, locked: LineArrays, drum: Array, authority: float) -> None:
    """Write the state of a tick to a row of the record."""
    own, other = plant.numbers, locked.numbers
    row[UNIT], row[UNIT_RATE] = plant.tiles[0, at.Z], plant.tiles[0, at.VZ]
    row[OFF] = locked.tiles[0, at.Z]
    row[TENSION], row[PEAK] = own[at.SEEN_TENSION], own[at.SEEN_LARGEST]
    row[OFF_TENSION], row[OFF_PEAK] = other[at.SEEN_TENSION], other[at.SEEN_LARGEST]
    row[UNIT_TENSION], row[SLACK] = plant.tiles[0, at.TENSION], own[at.SEEN_SLACK]
    row[TOUCHDOWN], row[SET_POINT], row[AUTHORITY] = own[at.SEEN_BED], 0.0, authority
    row[PAYOUT], row[RATE], row[ACCELERATION], row[LIMITS] = drum[0], drum[1], drum[2], drum[3]


@kernel
def fly(
    plant: LineArrays, locked: LineArrays, control: Control, course: Course, timing: Timing, servo: Array, record: Array
) -> tuple[int, float]:
    """Run a lift; return how it ended, and the largest strain of the cable [-].

    Parameters
    ----------
    plant, locked : lines at rest at t_1
    control, course, timing : of the lift
    servo : `cable_sim_node.winch.drive.as_array` of the winch's settings
    record : out, a row for each tick t_1 to t_k, columns COLUMNS
    """
    ticks, n, pattern = len(record), control.law.size, len(control.gains)
    x, moved, readings = np.zeros(n), np.zeros(n), np.full(4, np.nan)
    drum, before, rest = np.zeros(4), np.zeros(4), np.zeros(4)
    commands, heave, begun = np.zeros(ticks), np.zeros(ticks), np.zeros(2)
    decay = math.exp(-timing.tick_period / servo[0].time_constant)
    zero, moves, strain = plant.tiles[0, at.Z], timing.start <= ticks, plant.numbers[at.SEEN_STRAIN]
    first = -course.depth_noise[timing.depth_period - 1]  # the depth counts from where its first reading was
    for k in range(ticks):
        authority = min(max((k + 1 - timing.start) * timing.fade_in, 0.0), 1.0)
        _write(record[k], plant, locked, drum, authority)
        record[k, TIME], record[k, BOOM_TIP] = (k + 1) * timing.tick_period, course.tips[k, 2] - timing.height
        if moves:
            heave[k] = plant.tiles[0, at.Z] - zero
            measured = k - timing.depth_age
            is_due = measured >= 0 and (measured + 1) % timing.depth_period == 0
            readings[DEPTH] = heave[measured] - course.depth_noise[measured] - first if is_due else np.nan
            readings[MRU_HEAVE], readings[MRU_RATE] = course.readings[k, 0], course.readings[k, 1]
            step = timing.resolution
            if k > 0:
                readings[ENCODER] = step * np.rint(drum[0] / step) if step > 0.0 else drum[0]
            _filter(control, (k + 1) % pattern, commands[k - 1] if k > 0 else 0.0, readings, course.levels[k], x, moved)
            if k + 1 >= timing.start:
                off, off_rate = locked.tiles[0, at.Z] - zero, locked.tiles[0, at.VZ]
                if k + 1 == timing.start:  # the controller's own locked unit begins where its estimate is
                    begun[0], begun[1] = x[control.unit[0]] - off, x[control.unit[1]] - off_rate
                commands[k] = _command_of(control, x, authority, off + begun[0], off_rate + begun[1])
            sent = commands[k - timing.delay] if k >= timing.delay else 0.0
            before[:] = drum
            power_speed = timing.power_limit / max(plant.numbers[at.SEEN_TENSION], 1.0)
            drum[0], drum[1], limits = speed_step(
                before[0], before[1], sent, power_speed, servo[0], decay, timing.tick_period
            )
            drum[2], drum[3] = (sent - drum[1]) / servo[0].time_constant, limits
        outcome = _move_on(plant, course, k, timing, before, drum)
        if moves and outcome == at.DONE:
            outcome = _move_on(locked, course, k, timing, rest, rest)
        strain = max(strain, plant.numbers[at.SEEN_STRAIN])
        if outcome != at.DONE:
            return LOST, strain
    return DONE, strain
