"""Columns of the plain arrays that the line's compiled kernels share. Lengths and forces in SI units, frame `world`.

Nodes and segments stand in tiles of TILE, a row of `tiles` each. A column is TILE numbers of one kind, one after the
other, so that a loop over them is done by vector instructions; columns begin STRIDE numbers apart, a constant by which
the compiler sees that they do not overlap. Names are those beginnings: with

    tile, j = tiles[i >> SHIFT], i & LANES

z of node i is tile[Z + j], its y is tile[Z - STRIDE + j]. Place TILE of a node's column repeats the first one of the
next tile, so that the upper end of segment j is always at j + 1 (`borders.copy_borders`).
"""

from __future__ import annotations

import numpy as np

TILE = 64
SHIFT, LANES = 6, TILE - 1
STRIDE = 72
"""Length of a row: above TILE for the border; no power of two, for which columns would share the sets of a cache."""


NONE, ONE = np.int64(0), np.int64(1)
"""Numbers for kernels: with a literal one the compiler makes the called kernel once more."""


def _columns(first: int, count: int) -> range:
    return range(first * STRIDE, (first + count) * STRIDE, STRIDE)


# A node: position [m], velocity [m/s], acceleration [m/s^2]; the place on the seabed that it holds to [m].
NODE_COLUMNS, MOTION_COLUMNS = 12, 9
X, Y, Z, VX, VY, VZ, AX, AY, AZ, HOLD_X, HOLD_Y, HOLD_Z = _columns(0, NODE_COLUMNS)

# The motion of a node where the equations hold: MIDDLE + X to MIDDLE + AZ.
MIDDLE = NODE_COLUMNS * STRIDE

# The parts of the line. First a segment: unstretched length [m], 1 over it, EA [N], tension law, internal damping
# [N s]; the rest per unstretched metre. Then the lump on the node at its lower end: mass and added mass [kg], weight in
# fluid [N], (1/2) rho C_D A [kg/m], displaced mass [kg].
SEGMENT_COLUMNS, PART_COLUMNS = 13, 18
(
    LENGTH,
    PER_LENGTH,
    STIFFNESS,
    QUADRATIC,
    CUBIC,
    DAMPING,
    MASS,
    ADDED_MASS,
    WEIGHT,
    NORMAL_DRAG,
    TANGENTIAL_DRAG,
    DISPLACED,
    BENDING,
    LUMP_MASS,
    LUMP_ADDED_MASS,
    LUMP_WEIGHT,
    LUMP_DRAG,
    LUMP_DISPLACED,
) = _columns(21, PART_COLUMNS)
PART = LENGTH
"""The first of them."""

# The grid of material points: GRID + a part's column is the part there, whatever is in use; the unstretched length [m]
# from the unit to the point.
GRID = PART_COLUMNS * STRIDE
START = 57 * STRIDE

# The water: velocity [m/s], acceleration [m/s^2]; place 0 of the first tile at the unit, j + 1 at the middle of segment
# j.
FLOW_X, FLOW_Y, FLOW_Z, FLOW_AX, FLOW_AY, FLOW_AZ = _columns(58, 6)

# The equations of a node: symmetric blocks on the diagonal and above it, residual [N], correction [m] of its position.
DXX, DXY, DXZ, DYY, DYZ, DZZ, UXX, UXY, UXZ, UYY, UYZ, UZZ, RX, RY, RZ, CX, CY, CZ = _columns(64, 18)

# What a segment gives to its upper end, at that end's place: diagonal block and residual. Later in the same columns:
# the elimination's W = adj(S) U of each node, row by row; 1/det S is in SCALE.
END_XX, END_XY, END_XZ, END_YY, END_YZ, END_ZZ, END_RX, END_RY, END_RZ = _columns(82, 9)
WXX, WXY, WXZ, WYX, WYY, WYZ, WZX, WZY, WZZ = _columns(82, 9)

# Tension of a segment [N]; numbers of which the largest or the sum is wanted.
TENSION, SCRATCH, SCALE = _columns(91, 3)

# What water does to a segment, ADDED_MASS to DISPLACED, kept while the segment has what it has in air.
KEPT, FLUID_COLUMNS = 94 * STRIDE, 5

# The strain at which the friction between the wires of a segment is zero.
HELD = 99 * STRIDE
TILE_COLUMNS = 100

# The numbers of the whole line stand in one row. First the unit, three each: inertia along each axis [kg],
# (1/2) rho C_D S [kg/m], steady force [N], displaced and added mass [kg]; then (1/2) rho C_D S of an isotropic unit.
UNIT_INERTIA, UNIT_DRAG, UNIT_FORCE, UNIT_FLUID, UNIT_BODY_DRAG = 0, 3, 6, 9, 12
# From DEEP on the same numbers of the unit as its parameters give them, far from surface and bottom; its mass [kg].
DEEP, UNIT_MASS = 13, 26
UNIT_NUMBERS = 27

GRID_END = UNIT_NUMBERS
"""Longest line that leaves grid points to look ahead at [m]."""

# The boom tip now, where the equations hold, and at the end of the step: its motion in the order of a node's, time [s],
# unstretched length of the line [m], its rate and acceleration.
TIP_NUMBERS = 13
NOW, MIDWAY, END = range(GRID_END + 1, GRID_END + 1 + 3 * TIP_NUMBERS, TIP_NUMBERS)
TIP_X, TIP_Z, TIP_VX, TIP_VZ, TIP_AX, TIP_AZ = 0, 2, 3, 5, 6, 8
TIME, TOTAL, RATE, ACCELERATION = range(9, 13)

# Boom tip x, y, z and length at the start of an interval, their rates there, the same at its end.
ENDS = END + TIP_NUMBERS
ENDS_NUMBERS = 16

# Segments in use; Newton iterations, steps taken and steps refused since the start.
SEGMENTS, NEWTON, STEPS, REFUSED = range(ENDS + ENDS_NUMBERS, ENDS + ENDS_NUMBERS + 4)

# What is seen of the line: acceleration of the unit [m/s^2], force of the line on its top end [N], size of that or 0
# where the line would push, largest strain of a segment [-], number of segments without tension, vertical force of the
# seabed on the unit [N], largest size of the force on the top end in the last interval [N].
SEEN_AX, SEEN_FX, SEEN_TENSION, SEEN_STRAIN, SEEN_SLACK, SEEN_BED, SEEN_LARGEST = (
    REFUSED + k for k in (1, 4, 7, 8, 9, 10, 11)
)

# The unit's heave through the water: its path [m], high-passed, the mean square of that [m^2], and the weight of the
# mean so far, which rises to 1.
HEAVE_PATH, HEAVE_SQUARE, HEAVE_WEIGHT = (REFUSED + k for k in (12, 13, 14))

# Settings: generalised-alpha, Newton, seabed (BED_FOLLOWS is 1 where its depth is below the boom tip, else 0; BED_TOP
# is the height of its profile's highest point), waves (how many components; start and duration of their ramp [s];
# height of the surface below the boom tip [m]), current (rows of its profile; whether
# the water's motion changes at all), compensator, whether there are bodies on the cable and whether it is stiff; the
# largest step, the one that the next interval begins with (0: the largest), and the time for which steps stay short
# because the line was slack. Of the unit: whether it depends on its place or motion; points of its table over KC,
# width and memory of KC; height of its box [m], buoyancy [N], and
# slamming (1/2) rho C_s A [kg/m]. Whether the water ends at a surface; gravity [m/s^2]. Friction between wires:
# whether there is any, its stiffness over EA and its limit over the elastic tension.
SETTINGS = REFUSED + 15
(
    ALPHA_F,
    ALPHA_M,
    BETA,
    GAMMA,
    TOLERANCE,
    ITERATIONS,
    BED_ON,
    BED_FOLLOWS,
    BED_DEPTH,
    BED_TOP,
    BED_SLOPE_X,
    BED_SLOPE_Y,
    BED_STIFFNESS,
    BED_DAMPING,
    BED_FRICTION,
    BED_UNIT_STIFFNESS,
    BED_UNIT_DAMPING,
    WAVES,
    WAVE_START,
    WAVE_RAMP,
    LEVEL,
    PROFILE_END,
    FLOW_VARIES,
    SPRING_ON,
    SPRING_STIFFNESS,
    SPRING_DAMPING,
    SPRING_MASS,
    SPRING_HALF_STROKE,
    SPRING_STOP,
    SPRING_STOP_DAMPING,
    SPRING_PRELOAD,
    LUMPS_ON,
    BENDING_ON,
    STEP,
    RESUMED_STEP,
    HELD_SHORT,
    PROFILE_X,
    PROFILE_Y,
    PROFILE_ROWS,
    UNIT_VARIES,
    KC_ROWS,
    KC_WIDTH,
    KC_MEMORY,
    BOX_HEIGHT,
    BUOYANCY,
    SLAMMING,
    SURFACE_ON,
    GRAVITY,
    FRICTION_ON,
    FRICTION_STICKS,
    FRICTION_SLIDES,
    NUMBERS,
) = range(SETTINGS, SETTINGS + 52)
"""Places of the settings. From NUMBERS on come the points of the seabed's profile, three numbers each: distance [m],
height [m], slope. Then those of the unit's table: KC, vertical added mass [kg] and (1/2) rho C_D S [kg/m].
"""

# The components of the waves, a row each of `water` from PROFILE_END on, sorted by wave number: encounter frequency
# and frequency [rad/s], wave number, alone and times the direction's cosine and sine [1/m], phase [rad], amplitude [m]
# and that times the frequency [m/s], the direction's cosine and sine.
WATER_COLUMNS = 10
(
    WAVE_ENCOUNTER,
    WAVE_FREQUENCY,
    WAVE_NUMBER,
    WAVE_NUMBER_X,
    WAVE_NUMBER_Y,
    WAVE_PHASE,
    WAVE_AMPLITUDE,
    WAVE_SPEED,
    WAVE_COSINE,
    WAVE_SINE,
) = range(WATER_COLUMNS)

# The wide system of a line with bending, three rows for each node: half bandwidth 8, and the right side.
CENTRE, RIGHT = 8, 17
BAND_COLUMNS = 18

# Outcomes of an advance.
DONE, NOT_CONVERGED, TOO_SHORT, BAD_MOTION, GRID_TOO_SHORT = range(5)

SPLIT_AT = 0.7
"""Share of the spacing by which the cable exceeds the next grid point when a node is born."""

MERGE_AT = 0.4
"""Share of the spacing below which a top segment loses its node; the gap to SPLIT_AT keeps a heaving winch from doing
both in turn.
"""
