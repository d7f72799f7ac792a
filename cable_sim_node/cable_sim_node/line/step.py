"""Time integration of the line by generalised-alpha (Chung & Hulbert 1993), of second order.

It is unconditionally stable in the linear case. The equations hold at the point between t_n and t_{n+1} where x, v are
blended by alpha_f and a by alpha_m. Newton starts from a constant acceleration and stops when a correction strains no
segment by more than the tolerance; what is left then is its square. Arguments: `line` the arrays, `n` segments in use,
`count` nodes that move freely, `h` the step [s]; the others as in `assembly`.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.assembly import add_compensator, assemble_nodes, assemble_segments, solve_blocks
from cable_sim_node.line.bending import add_bending, solve_with_bending
from cable_sim_node.line.contact import carry_holds
from cable_sim_node.line.direction import direction_of
from cable_sim_node.line.feed import feed, set_top_segment
from cable_sim_node.line.flow import set_flow
from cable_sim_node.line.layout import (
    ACCELERATION,
    ADDED_MASS,
    ALPHA_F,
    ALPHA_M,
    AX,
    AY,
    AZ,
    BENDING_ON,
    BETA,
    CX,
    CY,
    CZ,
    DONE,
    END,
    GAMMA,
    HOLD_X,
    ITERATIONS,
    LENGTH,
    LUMP_MASS,
    MASS,
    MERGE_AT,
    MIDDLE,
    NEWTON,
    NOT_CONVERGED,
    NOW,
    RATE,
    REFUSED,
    RESUMED_STEP,
    RX,
    RY,
    RZ,
    SEEN_AX,
    SEEN_AZ,
    SEEN_SLACK,
    SEEN_STRAIN,
    SEEN_TENSION,
    SEGMENTS,
    SPRING_ON,
    START,
    STEP,
    STEPS,
    STIFFNESS,
    TENSION,
    TIME,
    TOLERANCE,
    TOO_SHORT,
    TOP_COLUMNS,
    TOTAL,
    UNIT_INERTIA,
    VX,
    VY,
    VZ,
    X,
    Y,
    Z,
)

_SMALLEST_SHARE = 2.0**-16
"""A step is halved at most so far before the advance is given up."""
_STEPS_PER_PERIOD = 180.0
"""While a segment is slack, steps are at most the heave period of the unit on its cable by this: peak tensions of snaps
are then good to 1 to 3 %..."""
_SHORTEST_SLACK_STEP, _LONGEST_SLACK_STEP = 0.001, 0.0125
"""...but within these [s]: what snaps faster is a cable of a few metres; waves run along soft ones in between."""
_PATIENCE = 4
"""Steps that must succeed after a refused one before a longer one is tried."""
_OVERSHOOT = 0.5
"""A correction is shortened where the residual along it, which was to vanish, turns to more than this share..."""
_SMALLEST_PART = 1e-3
"""...but not below this part of it."""
_FAILED, _TAUT, _SLACK, _SLACK_REFUSED = range(4)
"""How a step ended."""


@inner_kernel
def hermite(
    share: float, duration: float, start: float, start_rate: float, end: float, end_rate: float
) -> tuple[float, float, float]:
    """Return value, rate and acceleration at `share` of `duration` [s] of the cubic through both ends.

    `start` and `end` are its values there, `start_rate` and `end_rate` its rates.
    """
    s = share
    delta = end - start
    bend = delta - duration * start_rate
    turn = duration * (start_rate + end_rate) - 2.0 * delta
    value = start + s * (duration * start_rate + s * (bend + turn * (s - 1.0)))
    rate = start_rate + (2.0 * s * bend + turn * s * (3.0 * s - 2.0)) / duration
    acceleration = (2.0 * bend + turn * (6.0 * s - 2.0)) / (duration * duration)
    return value, rate, acceleration


@inner_kernel
def largest_relative_correction(n: int, parts: Array, equations: Array) -> float:
    """Return the largest difference of neighbours' corrections per length of their segment (NaN stays NaN)."""
    largest = 0.0
    for i in range(n):
        low, high = equations[i], equations[i + 1]
        d0, d1, d2 = high[CX] - low[CX], high[CY] - low[CY], high[CZ] - low[CZ]
        size = (d0 * d0 + d1 * d1 + d2 * d2) / (parts[i, LENGTH] * parts[i, LENGTH])
        if not size <= largest:
            largest = size
    return math.sqrt(largest)


@inner_kernel
def assemble(line: LineArrays, n: int, c_mass: float, c_velocity: float) -> tuple[float, bool]:
    """Assemble everything at the middle of the step or, where `c_mass` is 0, at its end.

    A flag for that would be a literal, and this long function compiled twice. Returns the least strain, and whether the
    seabed is touched or a stop of the compensator is near.
    """
    nodes, top, settings, equations = line.now, line.top[NOW], line.settings, line.equations
    at_middle = c_mass > 0.0
    if at_middle:
        nodes, top = line.middle, line.top[MIDDLE]
    least = assemble_segments(n, nodes, top, line.parts, line.flow, settings, c_mass, c_velocity, equations)
    near_kink = assemble_nodes(n, nodes, line.parts, line.unit, line.flow, settings, c_mass, c_velocity, equations)
    if settings[BENDING_ON] > 0.0:
        add_bending(n, nodes, line.parts, equations, line.band)
    if at_middle and settings[SPRING_ON] > 0.0:
        near_kink |= add_compensator(nodes[n], top, settings, c_mass, c_velocity, equations[n])
    return least, near_kink


@inner_kernel
def hold_top(node: Array, top: Array, compensated: bool) -> None:
    """Put the sheave `node` where the boom tip `top` is; on a compensator (`compensated`) it keeps its own z."""
    node[X], node[VX], node[AX] = top[X], top[VX], top[AX]
    node[Y], node[VY], node[AY] = top[Y], top[VY], top[AY]
    if not compensated:
        node[Z], node[VZ], node[AZ] = top[Z], top[VZ], top[AZ]


@inner_kernel
def predict(line: LineArrays, n: int, count: int, h: float) -> None:
    """Set the middle state of nodes 0..count-1 for constant acceleration, and blend length and boom tip."""
    af, am = line.settings[ALPHA_F], line.settings[ALPHA_M]
    now, middle, end = line.top[NOW], line.top[MIDDLE], line.top[END]
    for c in range(TOP_COLUMNS):
        weight = am if c == ACCELERATION or AX <= c <= AZ else af
        middle[c] = weight * now[c] + (1.0 - weight) * end[c]
    share = (1.0 - af) * h
    for i in range(count):
        start, goal = line.now[i], line.middle[i]
        for k in range(3):
            a = start[AX + k]
            goal[X + k] = start[X + k] + share * (start[VX + k] + 0.5 * h * a)
            goal[VX + k] = start[VX + k] + share * a
            goal[AX + k] = a
            goal[HOLD_X + k] = start[HOLD_X + k]
    hold_top(line.middle[n], middle, count > n)
    set_top_segment(n, middle[TOTAL], line.grid, line.parts)
    set_flow(n, middle[TIME], line.middle, line.settings, line.current, line.schedule, line.flow)


@inner_kernel
def finish(line: LineArrays, n: int, count: int, h: float) -> None:
    """Carry the middle state of nodes 0..count-1 to the end of the step of `h` seconds."""
    am, beta, gamma = line.settings[ALPHA_M], line.settings[BETA], line.settings[GAMMA]
    for i in range(count):
        node = line.now[i]
        for k in range(3):
            a, v = node[AX + k], node[VX + k]
            new = (line.middle[i, AX + k] - am * a) / (1.0 - am)
            node[X + k] += h * (v + h * ((0.5 - beta) * a + beta * new))
            node[VX + k] = v + h * ((1.0 - gamma) * a + gamma * new)
            node[AX + k] = new
    take_end(line.top)
    hold_top(line.now[n], line.top[NOW], count > n)
    set_top_segment(n, line.top[NOW, TOTAL], line.grid, line.parts)
    carry_holds(line, n)


@inner_kernel
def take_end(top: Array) -> None:
    """Make the end of the step the present in `top`: time, length and boom tip."""
    for c in range(TOP_COLUMNS):
        top[NOW, c] = top[END, c]


@inner_kernel
def clear_corrections(n: int, equations: Array) -> None:
    """Set the corrections of nodes 0..n to zero."""
    for i in range(n + 1):
        equations[i, CX] = equations[i, CY] = equations[i, CZ] = 0.0


@inner_kernel
def along_correction(count: int, equations: Array) -> float:
    """Return the residual's part along the corrections of nodes 0..count-1: their scalar product."""
    total = 0.0
    for i in range(count):
        row = equations[i]
        total += row[RX] * row[CX] + row[RY] * row[CY] + row[RZ] * row[CZ]
    return total


@inner_kernel
def move(nodes: Array, count: int, equations: Array, part: float, c_velocity: float, c_mass: float) -> None:
    """Add `part` of the corrections to nodes 0..count-1, in position, velocity and acceleration."""
    for i in range(count):
        node = nodes[i]
        for k in range(3):
            c = part * equations[i, CX + k]
            node[X + k] += c
            node[VX + k] += c_velocity * c
            node[AX + k] += c_mass * c


@inner_kernel
def slack_step(line: LineArrays, n: int) -> float:
    """Return the longest step [s] while a segment is slack, from the heave period of the unit on its cable.

    Rayleigh's estimate: a third of the cable's mass moves with the unit.
    """
    mass, compliance = 0.0, 0.0
    for i in range(n):
        part = line.parts[i]
        mass += (part[MASS] * part[LENGTH] + part[LUMP_MASS]) / 3.0
        compliance += part[LENGTH] / part[STIFFNESS]
    period = 2.0 * math.pi * math.sqrt((line.unit[UNIT_INERTIA + 2] + mass) * compliance)
    return min(max(period / _STEPS_PER_PERIOD, _SHORTEST_SLACK_STEP), _LONGEST_SLACK_STEP)


@inner_kernel
def step(line: LineArrays, n: int, h: float, longest_slack: float) -> int:
    """Make one step of `h` [s] to row END of `top`; return whether the line was taut or slack in it.

    _FAILED: Newton finds no solution; _SLACK_REFUSED: a segment is slack, which requires steps of at most
    `longest_slack` [s] in the dissipative scheme. The state is then as it was.
    """
    settings, equations = line.settings, line.equations
    af, am, beta, gamma = settings[ALPHA_F], settings[ALPHA_M], settings[BETA], settings[GAMMA]
    c_velocity = gamma / (beta * h)
    c_mass = (1.0 - am) / ((1.0 - af) * beta * h * h)
    count = n if settings[SPRING_ON] == 0.0 else n + 1
    predict(line, n, count, h)
    tolerance = settings[TOLERANCE]
    clear_corrections(n, equations)
    part, decrease = 1.0, 0.0
    for _ in range(int(settings[ITERATIONS])):
        line.counters[NEWTON] += 1
        least, near_kink = assemble(line, n, c_mass, c_velocity)
        overshoot = along_correction(count, equations)
        if overshoot > _OVERSHOOT * decrease and part > _SMALLEST_PART:
            # beyond a kink (a segment that comes taut) the residual works against the correction: go back on it
            shorter = part * max(decrease / (decrease + overshoot), 0.1)
            move(line.middle, count, equations, shorter - part, c_velocity, c_mass)
            part = shorter
            continue
        if settings[BENDING_ON] > 0.0:
            decrease = solve_with_bending(count, equations, line.band)
        else:
            decrease = solve_blocks(count, equations)
        size = largest_relative_correction(n, line.parts, equations)
        if not size < 10.0:
            return _FAILED
        part = 1.0
        move(line.middle, count, equations, part, c_velocity, c_mass)
        # where a segment is or may become slack, or the seabed is touched, the equations have a kink: be stricter
        smooth = least > 4.0 * size and not near_kink
        if size < (tolerance if smooth else min(tolerance, 1e-2 * tolerance)):
            # the margin is for rounding: a step that was shortened because of slack is not refused again for its length
            if least <= 0.0 and (h > 1.001 * longest_slack or af > 0.0):
                return _SLACK_REFUSED
            finish(line, n, count, h)
            return _SLACK if least <= 0.0 else _TAUT
    return _FAILED


@inner_kernel
def set_scheme(settings: Array, alpha_m: float, alpha_f: float) -> None:
    """Set alpha_m and alpha_f of the scheme in `settings`; (-1, 0) removes the fastest oscillations at once.

    A scheme that keeps them feeds energy into light nodes that snap taut: it must not be used while a segment is slack.
    """
    settings[ALPHA_M], settings[ALPHA_F] = alpha_m, alpha_f
    settings[GAMMA] = 0.5 - alpha_m + alpha_f
    settings[BETA] = 0.25 * (1.0 - alpha_m + alpha_f) ** 2


@kernel
def advance(line: LineArrays, duration: float, ends: Array) -> int:
    """Integrate `line` over `duration` [s]; return the outcome (DONE, NOT_CONVERGED, TOO_SHORT).

    `ends` rows: value and rate at the start, value and rate at the end; columns: boom tip x, y, z, unstretched length.
    They run as cubics in between. The state is that of the last good step where it fails.
    """
    n = line.counters[SEGMENTS]
    now, end = line.top[NOW], line.top[END]
    start_time = now[TIME]
    shares = max(math.ceil(duration / line.settings[STEP] - 1e-9), 1)
    nominal = 1.0 / shares
    load_end(0.0, duration, start_time, ends, end)
    take_end(line.top)
    hold_top(line.now[n], now, line.settings[SPRING_ON] > 0.0)
    outcome, patience = DONE, 0
    longest_slack = slack_step(line, n)
    resumed = line.settings[RESUMED_STEP] / duration
    size = nominal if resumed == 0.0 else min(nominal, resumed)
    alpha_m, alpha_f = line.settings[ALPHA_M], line.settings[ALPHA_F]
    for j in range(shares):
        done = j * nominal
        goal = 1.0 if j == shares - 1 else (j + 1) * nominal
        while done < goal:
            at = goal if done + size > goal - 1e-12 else done + size
            load_end(at, duration, start_time, ends, end)
            if end[TOTAL] < MERGE_AT * line.grid[1, START]:
                outcome = TOO_SHORT
                break
            ended = step(line, n, (at - done) * duration, longest_slack)
            if ended in (_TAUT, _SLACK):
                done = at
                patience -= 1
                if patience <= 0:
                    size = min(2.0 * size, nominal)
                n = feed(line, n)
                line.counters[STEPS] += 1
                if ended == _TAUT:
                    set_scheme(line.settings, alpha_m, alpha_f)
            elif ended == _SLACK_REFUSED:
                set_scheme(line.settings, -1.0, 0.0)
                while size * duration > 1.001 * longest_slack:
                    size *= 0.5
            else:
                line.counters[REFUSED] += 1
                set_scheme(line.settings, -1.0, 0.0)
                patience = _PATIENCE
                size *= 0.5
                if size < nominal * _SMALLEST_SHARE:
                    outcome = NOT_CONVERGED
                    break
        if outcome != DONE:
            break
    set_scheme(line.settings, alpha_m, alpha_f)
    line.settings[RESUMED_STEP] = 0.0 if size == nominal else size * duration
    line.counters[SEGMENTS] = n
    set_top_segment(n, now[TOTAL], line.grid, line.parts)
    return outcome


@inner_kernel
def load_end(share: float, duration: float, start_time: float, ends: Array, end: Array) -> None:
    """Write time, length and boom tip at `share` of the interval of `advance` to the row `end`.

    The interval begins at `start_time` and lasts `duration` [s]; `ends` as in `advance`.
    """
    end[TIME] = start_time + share * duration
    for k in range(3):
        end[X + k], end[VX + k], end[AX + k] = hermite(share, duration, ends[0, k], ends[1, k], ends[2, k], ends[3, k])
    end[TOTAL], end[RATE], end[ACCELERATION] = hermite(share, duration, ends[0, 3], ends[1, 3], ends[2, 3], ends[3, 3])


@kernel
def evaluate(line: LineArrays) -> float:
    """Fill tensions and residual of the present state of `line`; return the least strain.

    Row n of the residual is then the force [N] that holds the line's top end: the top segment's tension with half its
    weight, drag and inertia.
    """
    n = line.counters[SEGMENTS]
    set_flow(n, line.top[NOW, TIME], line.now, line.settings, line.current, line.schedule, line.flow)
    least, _ = assemble(line, n, 0.0, 0.0)
    return least


@kernel
def observe(line: LineArrays, seen: Array) -> None:
    """Evaluate the present state of `line`, and set `seen` to what is looked at, see `layout`."""
    evaluate(line)
    unit_acceleration(line, seen[SEEN_AX : SEEN_AZ + 1])
    n, largest, slack = line.counters[SEGMENTS], -1.0, 0
    for i in range(n):
        low, high = line.now[i], line.now[i + 1]
        dx, dy, dz = high[X] - low[X], high[Y] - low[Y], high[Z] - low[Z]
        strain = math.sqrt(dx * dx + dy * dy + dz * dz) / line.parts[i, LENGTH] - 1.0
        if not strain <= largest:
            largest = strain
        if line.equations[i, TENSION] <= 0.0:
            slack += 1
    seen[SEEN_STRAIN], seen[SEEN_SLACK], seen[SEEN_TENSION] = largest, slack, top_tension(line, n)


@inner_kernel
def top_tension(line: LineArrays, n: int) -> float:
    """Return the size [N] of the force of `line` on its top end, node `n`, after `evaluate`; 0 where it would push."""
    row, below, end = line.equations[n], line.now[n - 1], line.now[n]
    fx, fy, fz = -row[RX], -row[RX + 1], -row[RX + 2]
    pull = fx * (below[X] - end[X]) + fy * (below[Y] - end[Y]) + fz * (below[Z] - end[Z])
    return math.sqrt(fx * fx + fy * fy + fz * fz) if pull > 0.0 else 0.0


@kernel
def advance_and_observe(line: LineArrays, duration: float, ends: Array, seen: Array) -> int:
    """Do `advance`, and `observe` where it ended well; return the outcome of `advance`.

    One call for all of it: to take the arrays apart costs as much as to evaluate a short line.

    Parameters
    ----------
    line, duration, ends : see `advance`
    seen : see `observe`
    """
    outcome = advance(line, duration, ends)
    if outcome == DONE:
        observe(line, seen)
    return outcome


@inner_kernel
def unit_acceleration(line: LineArrays, out: Array) -> None:
    """Set `out` to the acceleration [m/s^2] that the forces on the unit give it now, after `evaluate`.

    The integrator's own acceleration a leaves the residual R = M a - F there. M = D - A e e', with A the added mass of
    half of the lowest segment, is inverted by the formula of Sherman and Morrison.
    """
    low, high, part, row = line.now[0], line.now[1], line.parts[0], line.equations[0]
    length = part[LENGTH]
    dx, dy, dz = (high[X] - low[X]) / length, (high[Y] - low[Y]) / length, (high[Z] - low[Z]) / length
    factor = direction_of(math.sqrt(dx * dx + dy * dy + dz * dz) + 1e-300)[0]
    e = (factor * dx, factor * dy, factor * dz)
    added = 0.5 * part[ADDED_MASS] * length
    by_e, e_by_e = 0.0, 0.0
    for k in range(3):
        inertia = line.unit[UNIT_INERTIA + k] + 0.5 * part[MASS] * length + added
        out[k] = row[RX + k] / inertia
        by_e += e[k] * out[k]
        e_by_e += e[k] * e[k] / inertia
    by_e *= added / (1.0 - added * e_by_e)
    for k in range(3):
        inertia = line.unit[UNIT_INERTIA + k] + 0.5 * part[MASS] * length + added
        out[k] = low[AX + k] - out[k] - by_e * e[k] / inertia
