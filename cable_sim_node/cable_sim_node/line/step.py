"""Time integration of the line by generalised-alpha (Chung & Hulbert 1993), of second order.

It is unconditionally stable in the linear case. The equations hold at the point between t_n and t_{n+1} where x, v are
blended by alpha_f and a by alpha_m. Newton starts from a constant acceleration and stops when a correction strains no
segment by more than the tolerance; what is left then is its square. Arguments as in `motion`.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel, kernel

from cable_sim_node.errors import LARGEST_JUMP
from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.assembly import assemble
from cable_sim_node.line.elimination import solve_blocks
from cable_sim_node.line.feed import feed, follow_length, start_of
from cable_sim_node.line.forces.bending import add_bending, solve_with_bending
from cable_sim_node.line.forces.compensator import add_compensator
from cable_sim_node.line.motion import finish, hold_top, load_end, move, predict, take_end
from cable_sim_node.line.observation import note_tension, observe
from cable_sim_node.line.tiles import copy_borders, larger, largest_of, sum_of

_SMALLEST_SHARE = 2.0**-16
"""A step is halved at most so far before the advance is given up."""
_STEPS_PER_PERIOD = 180.0
"""Steps in a heave period of the unit on its cable, at least, while a segment is slack: peak tensions of snaps are then
good to 1 to 3 %."""
_SHORTEST_SLACK_STEP, _LONGEST_SLACK_STEP = 0.001, 0.0125
"""Bounds of a step while a segment is slack [s]: what snaps faster is a cable of a few metres; waves run along soft
ones in between."""
_SNAPS_LAST = 0.5
"""Share of the heave period for which steps stay as short after a segment was slack."""
_PATIENCE = 4
"""Steps that must succeed after a refused one before a longer one is tried."""
_OVERSHOOT = 0.5
"""Share of the residual along a correction, turned to the other sign, above which the correction is shortened."""
_SMALLEST_PART = 1e-3
"""Smallest part of a correction that is taken."""
_FAILED, _TAUT, _SLACK, _SLACK_REFUSED = range(4)
"""Result of a step, by number."""
Motion = tuple[float, float, float, float]
"""Value and rate at the start of an interval, value and rate at its end."""
Interval = tuple[float, float, float, float, float]
"""Duration of an interval [s], and the motion of a value in it."""


@inlined_kernel
def largest_relative_correction(tiles: Array, n: int) -> float:
    """Return the largest difference of neighbours' corrections per length of their segment; NaN where one is."""
    largest = 0.0
    for t in range(((n - 1) >> at.SHIFT) + 1):
        tile, count = tiles[t], min(at.TILE, n - (t << at.SHIFT))
        for j in range(count):
            dx, dy, dz = (
                tile[at.CX + j + 1] - tile[at.CX + j],
                tile[at.CY + j + 1] - tile[at.CY + j],
                tile[at.CZ + j + 1] - tile[at.CZ + j],
            )
            tile[at.SCRATCH + j] = (dx * dx + dy * dy + dz * dz) * (tile[at.PER_LENGTH + j] * tile[at.PER_LENGTH + j])
        largest = larger(largest, largest_of(tile, count))
    return math.sqrt(largest)


@inner_kernel
def along_correction(tiles: Array, count: int) -> float:
    """Return the residual's part along the corrections of nodes 0..count-1: their scalar product."""
    total = 0.0
    for t in range(((count - 1) >> at.SHIFT) + 1):
        tile, nodes = tiles[t], min(at.TILE, count - (t << at.SHIFT))
        for j in range(nodes):
            along = tile[at.RX + j] * tile[at.CX + j] + tile[at.RY + j] * tile[at.CY + j]
            tile[at.SCRATCH + j] = along + tile[at.RZ + j] * tile[at.CZ + j]
        total += sum_of(tile, nodes)
    return total


@inlined_kernel
def equations_of(line: LineArrays, n: int, c_mass: float, c_velocity: float) -> tuple[float, bool]:
    """Assemble all equations; return least strain and whether they may have a kink, as in `assemble` or near a stop."""
    least, near_kink = assemble(line, n, c_mass, c_velocity)
    if line.numbers[at.BENDING_ON] > 0.0:
        add_bending(line, n)
    if line.numbers[at.SPRING_ON] > 0.0:
        near_kink |= add_compensator(line.tiles[n >> at.SHIFT], n & at.LANES, line.numbers, c_mass, c_velocity)
    return least, near_kink


@inlined_kernel
def solve(line: LineArrays, n: int, count: int) -> float:
    """Set the corrections of all nodes; return what `solve_blocks` does."""
    tile, j = line.tiles[n >> at.SHIFT], n & at.LANES
    tile[at.CX + j] = tile[at.CY + j] = tile[at.CZ + j] = 0.0
    is_stiff = line.numbers[at.BENDING_ON] > 0.0
    decrease = solve_with_bending(line, count) if is_stiff else solve_blocks(line.tiles, count)
    copy_borders(line.tiles, n, at.CX, 3)
    return decrease


@inner_kernel
def heave_period(line: LineArrays, n: int) -> float:
    """Return the heave period [s] of the unit on its cable.

    Rayleigh's estimate: a third of the cable's mass moves with the unit.
    """
    mass, compliance = 0.0, 0.0
    for i in range(n):
        tile, j = line.tiles[i >> at.SHIFT], i & at.LANES
        mass += (tile[at.MASS + j] * tile[at.LENGTH + j] + tile[at.LUMP_MASS + j]) / 3.0
        compliance += tile[at.LENGTH + j] / tile[at.STIFFNESS + j]
    return 2.0 * math.pi * math.sqrt((line.numbers[at.UNIT_INERTIA + 2] + mass) * compliance)


@inner_kernel
def slack_step(line: LineArrays, n: int) -> float:
    """Return the longest step [s] while a segment is slack, with a margin for rounding."""
    longest = heave_period(line, n) / _STEPS_PER_PERIOD
    return 1.001 * min(max(longest, _SHORTEST_SLACK_STEP), _LONGEST_SLACK_STEP)


@inlined_kernel
def next_step(line: LineArrays, n: int, h: float, longest: float, ended: int, patience: int) -> float:
    """Return the step [s] to try after one of `h` that `ended` well; at most `longest`.

    It is doubled, but stays short for half a heave period of the unit after a segment was slack: that is how long the
    snap lasts in which the line takes up the unit's fall, and in it tension peaks. It also stays as it is while
    `patience`, the number of steps that must still succeed after a refused one, is positive.
    """
    numbers = line.numbers
    if ended == _SLACK:
        numbers[at.HELD_SHORT] = _SNAPS_LAST * heave_period(line, n)
    elif numbers[at.HELD_SHORT] > 0.0:
        numbers[at.HELD_SHORT] = max(numbers[at.HELD_SHORT] - h, 0.0)
    twice = min(2.0 * h, longest)
    if patience > 0 or (numbers[at.HELD_SHORT] > 0.0 and twice > slack_step(line, n)):
        return h
    return twice


@inlined_kernel
def step(line: LineArrays, n: int, h: float) -> int:
    """Make one step of `h` [s] to the end that `load_end` set; return whether the line was taut or slack in it.

    _FAILED: Newton finds no solution; _SLACK_REFUSED: a segment is slack, which requires steps of at most
    `slack_step` in the dissipative scheme. The state is then as it was.
    """
    numbers, tiles = line.numbers, line.tiles
    af, am, beta, gamma = numbers[at.ALPHA_F], numbers[at.ALPHA_M], numbers[at.BETA], numbers[at.GAMMA]
    c_velocity = gamma / (beta * h)
    c_mass = (1.0 - am) / ((1.0 - af) * beta * h * h)
    count = n if numbers[at.SPRING_ON] == 0.0 else n + 1
    predict(line, n, count, h)
    tolerance = numbers[at.TOLERANCE]
    part, decrease = 1.0, 0.0
    for iteration in range(int(numbers[at.ITERATIONS])):
        numbers[at.NEWTON] += 1
        least, near_kink = equations_of(line, n, c_mass, c_velocity)
        overshoot = along_correction(tiles, count) if iteration > 0 else 0.0
        if overshoot > _OVERSHOOT * decrease and part > _SMALLEST_PART:
            # beyond a kink (a segment that comes taut) the residual works against the correction: go back on it
            shorter = part * max(decrease / (decrease + overshoot), 0.1)
            move(tiles, n, shorter - part, c_velocity, c_mass)
            part = shorter
            continue
        decrease = solve(line, n, count)
        size = largest_relative_correction(tiles, n)
        if not size < 10.0:
            return _FAILED
        part = 1.0
        move(tiles, n, part, c_velocity, c_mass)
        # where a segment is or may become slack, or the seabed is touched, the equations have a kink: be stricter
        smooth = least > 4.0 * size and not near_kink
        if size < (tolerance if smooth else min(tolerance, 1e-2 * tolerance)):
            if least <= 0.0 and (af > 0.0 or h > slack_step(line, n)):
                return _SLACK_REFUSED
            finish(line, n, count, h)
            return _SLACK if least <= 0.0 else _TAUT
    return _FAILED


@inner_kernel
def set_scheme(numbers: Array, alpha_m: float, alpha_f: float) -> None:
    """Set alpha_m and alpha_f of the scheme in `numbers`; (-1, 0) removes the fastest oscillations at once.

    A scheme that keeps them feeds energy into light nodes that snap taut: it must not be used while a segment is slack.
    """
    numbers[at.ALPHA_M], numbers[at.ALPHA_F] = alpha_m, alpha_f
    numbers[at.GAMMA] = 0.5 - alpha_m + alpha_f
    numbers[at.BETA] = 0.25 * (1.0 - alpha_m + alpha_f) ** 2


@inner_kernel
def halved_to(size: float, limit: float) -> float:
    """Return `size`, halved until it is not above `limit`."""
    while size > limit:
        size *= 0.5
    return size


@inlined_kernel
def take_motion(
    numbers: Array,
    duration: float,
    start: Array,
    start_velocity: Array,
    end: Array,
    end_velocity: Array,
    lengths: Motion,
) -> int:
    """Take what boom tip and length do in an interval of `duration` [s]; return DONE where it can be done.

    `start`, `start_velocity`, `end`, `end_velocity` and `lengths` as in `advance`, and what is returned otherwise.
    """
    total, total_rate, end_total, end_rate = lengths
    check = total + total_rate + end_total + end_rate + duration
    for k in range(3):
        check += start[k] + start_velocity[k] + end[k] + end_velocity[k]
    if not (duration > 0.0 and math.isfinite(check)) or abs(total - numbers[at.NOW + at.TOTAL]) > LARGEST_JUMP:
        return at.BAD_MOTION
    if max(total, end_total) + duration * max(abs(total_rate), abs(end_rate)) > numbers[at.GRID_END]:
        return at.GRID_TOO_SHORT
    for k in range(3):
        numbers[at.ENDS + k], numbers[at.ENDS + 4 + k] = start[k], start_velocity[k]
        numbers[at.ENDS + 8 + k], numbers[at.ENDS + 12 + k] = end[k], end_velocity[k]
    numbers[at.ENDS + 3], numbers[at.ENDS + 7] = total, total_rate
    numbers[at.ENDS + 11], numbers[at.ENDS + 15] = end_total, end_rate
    return at.DONE


@inlined_kernel
def start_interval(line: LineArrays, n: int, duration: float) -> None:
    """Put boom tip, sheave and length where an interval of `duration` [s] begins."""
    numbers = line.numbers
    load_end(0.0, duration, numbers[at.NOW + at.TIME], numbers)
    take_end(numbers)
    hold_top(line.tiles, n, at.X, numbers, at.NOW, numbers[at.SPRING_ON] > 0.0)


@inlined_kernel
def integrate(line: LineArrays, duration: float) -> int:
    """Integrate over an interval of `duration` [s] whose motion `take_motion` has taken; return the outcome."""
    numbers, tiles, n, outcome = line.numbers, line.tiles, int(line.numbers[at.SEGMENTS]), at.DONE
    start_time, alpha_m, alpha_f = numbers[at.NOW + at.TIME], numbers[at.ALPHA_M], numbers[at.ALPHA_F]
    start_interval(line, n, duration)
    numbers[at.SEEN_LARGEST] = 0.0
    # all as shares of the interval: the largest step, the next one, what is done
    shares = max(math.ceil(duration / numbers[at.STEP] - 1e-9), 1)
    nominal, patience = 1.0 / shares, 0
    resumed = numbers[at.RESUMED_STEP] / duration
    size, done = nominal if resumed == 0.0 else min(nominal, resumed), 0.0
    while done < 1.0:
        goal = min((math.floor(done * shares + 1e-9) + 1.0) / shares, 1.0)
        reached = goal if done + size > goal - 1e-12 else done + size
        load_end(reached, duration, start_time, numbers)
        if numbers[at.END + at.TOTAL] < at.MERGE_AT * start_of(1, tiles):
            outcome = at.TOO_SHORT
            break
        ended = step(line, n, (reached - done) * duration)
        if ended in (_TAUT, _SLACK):
            done = reached
            n = feed(line, n)
            numbers[at.STEPS] += 1
            patience -= 1
            size = next_step(line, n, size * duration, nominal * duration, ended, patience) / duration
            if ended == _TAUT:
                set_scheme(numbers, alpha_m, alpha_f)
            if done < 1.0:
                numbers[at.SEGMENTS] = n
                note_tension(line, n)
            continue
        set_scheme(numbers, -1.0, 0.0)
        if ended == _SLACK_REFUSED:
            size = halved_to(size, slack_step(line, n) / duration)
        else:
            numbers[at.REFUSED] += 1
            patience, size = _PATIENCE, 0.5 * size
            if size < nominal * _SMALLEST_SHARE:
                outcome = at.NOT_CONVERGED
                break
    set_scheme(numbers, alpha_m, alpha_f)
    numbers[at.RESUMED_STEP] = 0.0 if size >= nominal else size * duration
    numbers[at.SEGMENTS] = n
    follow_length(n, numbers[at.NOW + at.TOTAL], tiles)
    return outcome


@kernel
def advance(
    tiles: Array,
    numbers: Array,
    water: Array,
    band: Array,
    start: Array,
    start_velocity: Array,
    end: Array,
    end_velocity: Array,
    interval: Interval,
) -> int:
    """Integrate a line over an interval, and `observe` it; return the outcome.

    Boom tip and length run as cubics through the values and rates at both ends. BAD_MOTION for a number that is not
    finite, a duration that is not positive and a length that jumps, GRID_TOO_SHORT where the length may exceed
    the grid: nothing is changed then. TOO_SHORT, NOT_CONVERGED: the state is that of the last good step.

    Parameters
    ----------
    tiles, numbers, water, band : the line's arrays, one by one: a tuple of them takes Python twice as long
    start, start_velocity, end, end_velocity : of the boom tip at both ends [m], [m/s], shape (3,)
    interval : duration [s]; unstretched length and its rate at the start, the same at the end [m], [m/s]
    """
    duration, lengths = interval[0], interval[1:]
    outcome = take_motion(numbers, duration, start, start_velocity, end, end_velocity, lengths)
    if outcome == at.DONE:
        line = LineArrays(tiles, numbers, water, band)
        outcome = integrate(line, duration)
        if outcome == at.DONE:
            observe(line)
    return outcome
