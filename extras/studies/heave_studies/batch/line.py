"""Lines of many lifts side by side: the plant's equations of a line that hangs straight down in still water.

They are those of `cable_sim_node.line`, whose node names, scheme and tolerance hold, for vertical motion alone: three
equations a node become one, and LANES lifts take a vector instruction together. A lift in which a segment comes slack,
or a node is born or dies, leaves its lane: its numbers mean nothing from then on.

Arguments have the same names everywhere: `lanes` the lines, of which `cells`, `parts` and `scheme` are fields, with `n`
segments; `h` a step [s], and `share` the part of it up to where the equations hold; an acceleration moves by `c_mass`
[1/s^2] and a velocity by `c_velocity` [1/s] times as much as a position; `held` what `blend_top` puts out, `tip` what
`take_material` keeps; `size` the largest change of strain and `least` the least strain of each lift, `gone` why it has
left its lane, `tolerance` Newton's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.forces.segment import tension_of
from cable_sim_node.line.motion import hermite
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel

LANES = 8
"""Lifts side by side."""

# A node: height [m], velocity [m/s], acceleration [m/s^2], and the same where the equations hold; diagonal and right
# side of its equation, coupling to the node above; of the segment above it: length [m], tension [N], strain. Columns
# begin a constant apart, by which the compiler sees that they do not overlap.
COLUMNS = 12
Z, V, A, MID_Z, MID_V, MID_A, DIAGONAL, RIGHT, UPPER, LENGTH, TENSION, STRAIN = range(0, COLUMNS * LANES, LANES)
ROW = COLUMNS * LANES

# A part: stiffness EA [N], its law, internal damping [N s]; per unstretched metre mass [kg], tangential drag
# [N s2/m2], weight in water [N], and what that lacks of the weight in air [N].
PARTS = (at.STIFFNESS, at.QUADRATIC, at.CUBIC, at.DAMPING, at.MASS, at.TANGENTIAL_DRAG, at.WEIGHT, at.DISPLACED)
STIFFNESS, QUADRATIC, CUBIC, DAMPING, MASS, DRAG, WEIGHT, BUOYANCY = range(len(PARTS))

OF_NO_LANE = {
    "bending": at.BENDING_ON,
    "friction between wires": at.FRICTION_ON,
    "a compensator": at.SPRING_ON,
    "waves along the cable": at.WAVES,
    "moving water": at.FLOW_VARIES,
    "a unit that varies": at.UNIT_VARIES,
    "bodies on the cable": at.LUMPS_ON,
    "a bottom below the boom tip": at.BED_FOLLOWS,
    "a bottom with a profile": at.PROFILE_ROWS,
}
"""Settings of a line that lanes do not have, in words."""


class Lanes(NamedTuple):
    """The lines of LANES lifts, which differ in their motion alone."""

    cells: Array  # nodes from the unit to the boom tip, a row of COLUMNS for each, flat
    parts: Array  # of each segment, shape (n, len(PARTS))
    unit: Array  # inertia [kg], drag over speed squared [kg/m], steady force [N], all vertical
    scheme: Array  # alpha_f, alpha_m, beta, gamma, tolerance of Newton, most iterations
    # label of the node below the boom tip, least and largest length of the line, least height of the unit [m]
    ends: Array
    seen: Array  # top tension [N], largest strain so far, why the lift has left its lane; shape (3, LANES)


SEEN_TENSION, SEEN_STRAIN, SEEN_GONE = range(3)
SLACK, OTHER_NODES, ON_BOTTOM = 1.0, 2.0, 3.0
WHY_GONE = ("", "a slack cable", "a cable that is divided anew", "the unit on the seabed")
"""Why a lift has left its lane, by number; 0: it has not."""
NEAR_BOTTOM = 1.0
"""Height of the unit above the bottom below which a lift leaves its lane [m]."""


def why_no_lanes(line: LineArrays, duration: float) -> str:
    """Return what lanes do not have of a `line`, integrated over intervals of a `duration` [s]; "" where they do."""
    numbers, n = line.numbers, line.segments
    found = [words for words, setting in OF_NO_LANE.items() if numbers[setting] > 0.0]
    found += ["water without a surface"] if numbers[at.SURFACE_ON] == 0.0 else []
    found += ["a current"] if line.read(at.FLOW_X, 6, n).any() else []
    found += ["another section below the boom tip"] if _changes_above(line) else []
    slopes = numbers[[at.BED_SLOPE_X, at.BED_SLOPE_Y]]
    found += ["a bottom that slopes"] if numbers[at.BED_ON] > 0.0 and slopes.any() else []
    found += ["steps shorter than a tick"] if numbers[at.STEP] < duration * (1.0 - 1e-9) else []
    return found[0] if found else ""


def _changes_above(line: LineArrays) -> bool:
    """Return whether the top segment has other parts on the grid points beside it, so that payout changes it."""
    beside = line.read(at.GRID + at.PART, at.PART_COLUMNS, line.segments + 1)[-3:, 2:]
    return bool(np.any(beside != beside[0])) or line.segments < 3


def lanes_of(line: LineArrays) -> Lanes:
    """Return LANES times a `line` at rest."""
    n, numbers = line.segments, line.numbers
    cells = np.zeros((n + 1, COLUMNS, LANES))
    for column, known in ((Z, at.Z), (V, at.VZ), (A, at.AZ)):
        cells[:, column // LANES] = line.column(known, n + 1)[:, None]
    cells[:n, LENGTH // LANES] = line.column(at.LENGTH, n)[:, None]
    parts = np.column_stack([line.column(part, n) for part in PARTS])
    parts[:, BUOYANCY] *= numbers[at.GRAVITY]
    drag = numbers[at.UNIT_DRAG + 2] + numbers[at.UNIT_BODY_DRAG]
    unit = np.array([numbers[at.UNIT_INERTIA + 2], drag, numbers[at.UNIT_FORCE + 2]])
    points, size = line.grid_points, line.column(at.GRID + at.LENGTH, n + 1)
    bottom = NEAR_BOTTOM - numbers[at.BED_DEPTH] if numbers[at.BED_ON] > 0.0 else -np.inf
    shortest, longest = points[n - 1] + at.MERGE_AT * size[n - 1], points[n] + at.SPLIT_AT * size[n]
    ends = np.array([points[n - 1], shortest, longest, bottom])
    scheme = numbers[[at.ALPHA_F, at.ALPHA_M, at.BETA, at.GAMMA, at.TOLERANCE, at.ITERATIONS]]
    lanes = Lanes(cells.ravel(), parts, unit, scheme.copy(), ends, np.zeros((3, LANES)))
    lanes.seen[SEEN_TENSION], lanes.seen[SEEN_STRAIN] = numbers[at.SEEN_TENSION], numbers[at.SEEN_STRAIN]
    lanes.cells.reshape(n + 1, COLUMNS, LANES)[0, TENSION // LANES] = line.column(at.TENSION, 1)[0]
    return lanes


@inlined_kernel
def assemble(cells: Array, parts: Array, unit: Array, first: int, end: int, c_mass: float, c_velocity: float) -> None:
    """Set what the unit and the segments `first` to `end` - 1 give to the equations of the nodes, where these hold.

    Those of a node are M a + drag + weight = tension above - tension below.
    """
    for k in range(LANES):
        v = cells[MID_V + k]
        drag = unit[1] * abs(v)
        cells[RIGHT + k] = unit[2] - unit[0] * cells[MID_A + k] - drag * v
        cells[DIAGONAL + k] = c_mass * unit[0] + 2.0 * c_velocity * drag
    for j in range(first, end):
        low, high, part = j * ROW, (j + 1) * ROW, parts[j]
        stiffness, quadratic, cubic, damping = part[STIFFNESS], part[QUADRATIC], part[CUBIC], part[DAMPING]
        for k in range(LANES):
            length, bottom, top = cells[low + LENGTH + k], cells[low + MID_Z + k], cells[high + MID_Z + k]
            v, w = cells[low + MID_V + k], cells[high + MID_V + k]
            per_length = 1.0 / length
            strain = (top - bottom) * per_length - 1.0
            tension, by_strain, by_rate = tension_of(stiffness, quadratic, cubic, damping, strain, (w - v) * per_length)
            dry = min(max(top / (top - bottom), 0.0), 1.0)  # share of it above still water
            slip, half = 0.5 * (v + w), 0.5 * length
            drag = half * part[DRAG] * (1.0 - dry) * abs(slip)
            load, mass = drag * slip + half * (part[WEIGHT] + dry * part[BUOYANCY]), half * part[MASS]
            stretching, braking = (by_strain + c_velocity * by_rate) * per_length, c_velocity * drag
            both = braking + stretching + c_mass * mass
            cells[low + RIGHT + k] += tension - load - mass * cells[low + MID_A + k]
            cells[high + RIGHT + k] = -tension - load - mass * cells[high + MID_A + k]
            cells[low + DIAGONAL + k] += both
            cells[high + DIAGONAL + k] = both
            cells[low + UPPER + k] = braking - stretching
            cells[low + TENSION + k], cells[low + STRAIN + k] = tension, strain


@inlined_kernel
def solve(cells: Array, n: int) -> None:
    """Leave the corrections of nodes 0..n-1 in their right sides; the boom tip, node n, is held (Thomas)."""
    for i in range(1, n):
        below, row = (i - 1) * ROW, i * ROW
        for k in range(LANES):
            factor = cells[below + UPPER + k] / cells[below + DIAGONAL + k]
            cells[row + DIAGONAL + k] -= factor * cells[below + UPPER + k]
            cells[row + RIGHT + k] -= factor * cells[below + RIGHT + k]
    for k in range(LANES):
        cells[n * ROW + RIGHT + k] = 0.0
    for i in range(n - 1, -1, -1):
        row, above = i * ROW, (i + 1) * ROW
        for k in range(LANES):
            rest = cells[row + RIGHT + k] - cells[row + UPPER + k] * cells[above + RIGHT + k]
            cells[row + RIGHT + k] = rest / cells[row + DIAGONAL + k]


@inlined_kernel
def move(cells: Array, n: int, c_mass: float, c_velocity: float, size: Array, least: Array) -> None:
    """Correct where the equations hold; set the largest change of strain and the least strain of each lift."""
    size[:], least[:] = 0.0, 1.0
    for i in range(n):
        row, above = i * ROW, (i + 1) * ROW
        for k in range(LANES):
            c = cells[row + RIGHT + k]
            cells[row + MID_Z + k] += c
            cells[row + MID_V + k] += c_velocity * c
            cells[row + MID_A + k] += c_mass * c
            size[k] = max(size[k], abs(cells[above + RIGHT + k] - c) / cells[row + LENGTH + k])
            least[k] = min(least[k], cells[row + STRAIN + k])


@inlined_kernel
def blend_top(lanes: Lanes, h: float, tips: Array, lengths: Array, held: Array) -> None:
    """Put the boom tip where the equations hold, the material there, and set the length of the top segment.

    Parameters
    ----------
    h : step [s]
    tips, lengths : height and its rate at the start and at the end [m], [m/s]; the same of the lengths; (4, LANES)
    held : out, height, velocity and acceleration of the boom tip at the end, and rate and acceleration of the length
        at the end and midway; (7, LANES)
    """
    cells, n, af, am = lanes.cells, len(lanes.parts), lanes.scheme[0], lanes.scheme[1]
    node, below = n * ROW, (n - 1) * ROW
    for k in range(LANES):
        _, _, begun = hermite(0.0, h, tips[0, k], tips[1, k], tips[2, k], tips[3, k])
        held[0, k], held[1, k], held[2, k] = hermite(1.0, h, tips[0, k], tips[1, k], tips[2, k], tips[3, k])
        _, _, feed = hermite(0.0, h, lengths[0, k], lengths[1, k], lengths[2, k], lengths[3, k])
        total, held[3, k], held[4, k] = hermite(1.0, h, lengths[0, k], lengths[1, k], lengths[2, k], lengths[3, k])
        cells[node + MID_Z + k] = af * tips[0, k] + (1.0 - af) * held[0, k]
        cells[node + MID_V + k] = af * tips[1, k] + (1.0 - af) * held[1, k]
        cells[node + MID_A + k] = am * begun + (1.0 - am) * held[2, k]
        held[5, k] = af * lengths[1, k] + (1.0 - af) * held[3, k]
        held[6, k] = am * feed + (1.0 - am) * held[4, k]
        cells[below + LENGTH + k] = af * lengths[0, k] + (1.0 - af) * total - lanes.ends[0]


@inlined_kernel
def take_material(cells: Array, n: int, rate: Array, acceleration: Array, tip: Array) -> None:
    """Put the motion of the material at the sheave where that of the boom tip is, which is kept in `tip` (2, LANES).

    `rate` and `acceleration` are those of the length.
    """
    node, below = n * ROW, (n - 1) * ROW
    for k in range(LANES):
        tip[0, k], tip[1, k] = cells[node + MID_V + k], cells[node + MID_A + k]
        per_length = 1.0 / cells[below + LENGTH + k]
        q = (cells[node + MID_Z + k] - cells[below + MID_Z + k]) * per_length
        material = tip[0, k] - rate[k] * q
        turned = 2.0 * rate[k] * (material - cells[below + MID_V + k]) * per_length
        cells[node + MID_V + k] = material
        cells[node + MID_A + k] -= acceleration[k] * q + turned


@inlined_kernel
def give_back(cells: Array, n: int, tip: Array) -> None:
    """Undo `take_material`."""
    for k in range(LANES):
        cells[n * ROW + MID_V + k], cells[n * ROW + MID_A + k] = tip[0, k], tip[1, k]


@inlined_kernel
def predict(cells: Array, n: int, h: float, share: float) -> None:
    """Set where the equations hold for constant acceleration."""
    for i in range(n):
        row = i * ROW
        for k in range(LANES):
            v, a = cells[row + V + k], cells[row + A + k]
            cells[row + MID_Z + k] = cells[row + Z + k] + share * (v + 0.5 * h * a)
            cells[row + MID_V + k] = v + share * a
            cells[row + MID_A + k] = a


@inlined_kernel
def finish(cells: Array, n: int, h: float, scheme: Array) -> None:
    """Carry nodes 0..n-1 to the end of a step of `h` [s]."""
    am, beta, gamma = scheme[1], scheme[2], scheme[3]
    for i in range(n):
        row = i * ROW
        for k in range(LANES):
            a, v = cells[row + A + k], cells[row + V + k]
            new = (cells[row + MID_A + k] - am * a) / (1.0 - am)
            cells[row + Z + k] += h * (v + h * ((0.5 - beta) * a + beta * new))
            cells[row + V + k] = v + h * ((1.0 - gamma) * a + gamma * new)
            cells[row + A + k] = new


@inlined_kernel
def leave(lanes: Lanes, k: int, why: float) -> None:
    """Note why lift `k` leaves its lane, unless it has left it before."""
    if lanes.seen[SEEN_GONE, k] == 0.0:
        lanes.seen[SEEN_GONE, k] = why


@inlined_kernel
def observe(lanes: Lanes, held: Array, tip: Array) -> None:
    """Note the top tension, the unit's tension, the largest strain, and which lift has left its lane."""
    cells, parts, n = lanes.cells, lanes.parts, len(lanes.parts)
    for k in range(LANES):
        cells[n * ROW + Z + k], cells[n * ROW + V + k], cells[n * ROW + A + k] = held[0, k], held[1, k], held[2, k]
    for i in (0, 1, n - 1, n):
        for place in range(i * ROW, i * ROW + 3 * LANES):
            cells[place + MID_Z] = cells[place]
    take_material(cells, n, held[3], held[4], tip)
    assemble(cells, parts, lanes.unit, 0, 1, 0.0, 0.0)
    assemble(cells, parts, lanes.unit, n - 1, n, 0.0, 0.0)
    give_back(cells, n, tip)
    for k in range(LANES):
        lanes.seen[SEEN_TENSION, k] = max(-cells[n * ROW + RIGHT + k], 0.0)
        length = cells[(n - 1) * ROW + LENGTH + k] + lanes.ends[0]
        if not lanes.ends[1] < length < lanes.ends[2]:
            leave(lanes, k, OTHER_NODES)
        if not cells[Z + k] > lanes.ends[3]:
            leave(lanes, k, ON_BOTTOM)
    most, least = tip[0], tip[1]
    most[:], least[:] = 0.0, 1.0
    for i in range(n):
        row, above = i * ROW, (i + 1) * ROW
        for k in range(LANES):
            strain = (cells[above + Z + k] - cells[row + Z + k]) / cells[row + LENGTH + k] - 1.0
            most[k], least[k] = max(most[k], strain), min(least[k], strain)
    for k in range(LANES):
        lanes.seen[SEEN_STRAIN, k] = max(lanes.seen[SEEN_STRAIN, k], most[k])
        if not least[k] > 0.0:
            leave(lanes, k, SLACK)


@inlined_kernel
def is_settled(size: Array, least: Array, gone: Array, tolerance: float) -> bool:
    """Return whether Newton may stop, as in `line.step`; lifts that have left their lane do not count."""
    for k in range(LANES):
        strict = tolerance if least[k] > 4.0 * size[k] else 1e-2 * tolerance
        if gone[k] == 0.0 and not size[k] < strict:
            return False
    return True


@inner_kernel
def advance(lanes: Lanes, h: float, tips: Array, lengths: Array, work: Array) -> None:
    """Make one step of `h` [s], and `observe` the line; a lift without a solution leaves its lane.

    `tips` and `lengths` as in `blend_top`; `work` of shape (11, LANES).
    """
    cells, n, scheme = lanes.cells, len(lanes.parts), lanes.scheme
    af, am, beta, gamma = scheme[0], scheme[1], scheme[2], scheme[3]
    c_velocity, c_mass = gamma / (beta * h), (1.0 - am) / ((1.0 - af) * beta * h * h)
    held, tip, size, least, gone = work[:7], work[7:9], work[9], work[10], lanes.seen[SEEN_GONE]
    predict(cells, n, h, (1.0 - af) * h)
    blend_top(lanes, h, tips, lengths, held)
    for _ in range(int(scheme[5])):
        take_material(cells, n, held[5], held[6], tip)
        assemble(cells, lanes.parts, lanes.unit, 0, n, c_mass, c_velocity)
        give_back(cells, n, tip)
        solve(cells, n)
        move(cells, n, c_mass, c_velocity, size, least)
        if is_settled(size, least, gone, scheme[4]):
            break
    for k in range(LANES):
        if not (math.isfinite(size[k]) and least[k] > 0.0):
            leave(lanes, k, SLACK)
    finish(cells, n, h, scheme)
    for k in range(LANES):
        cells[(n - 1) * ROW + LENGTH + k] = lengths[2, k] - lanes.ends[0]
    observe(lanes, held, tip)
