"""Columns of the plain arrays that the line's compiled kernels share. Lengths and forces in SI units, frame `world`."""

from __future__ import annotations

# A node: position [m], velocity [m/s], acceleration [m/s^2]; the place on the seabed that it holds to [m].
X, Y, Z, VX, VY, VZ, AX, AY, AZ, HOLD_X, HOLD_Y, HOLD_Z = range(12)
NODE_COLUMNS = 12

# The top end: rows now, where the equations hold, and at the end of the step; columns the boom tip's motion as a
# node's, time [s], unstretched length [m], its rate and acceleration.
NOW, MIDDLE, END = range(3)
TIME, TOTAL, RATE, ACCELERATION = range(9, 13)
TOP_COLUMNS = 13

# The water: velocity [m/s], acceleration [m/s^2]. Row 0 at the unit, row i + 1 at the middle of segment i.
FLOW_X, FLOW_Y, FLOW_Z, FLOW_AX, FLOW_AY, FLOW_AZ = range(6)
FLOW_COLUMNS = 6

# The parts of the line. First a segment: unstretched length [m], EA [N], tension law, internal damping [N s]; the
# rest per unstretched metre.
(
    LENGTH,
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
) = range(12)
SEGMENT_COLUMNS = 12

# Then the lump on the node at its lower end: mass and added mass [kg], weight in fluid [N], (1/2) rho C_D A [kg/m].
LUMP_MASS, LUMP_ADDED_MASS, LUMP_WEIGHT, LUMP_DRAG, LUMP_DISPLACED = range(12, 17)
PART_COLUMNS = 17

# A grid point also has its place: unstretched length [m] from the unit.
START = 17
GRID_COLUMNS = 18

# The unit, three columns each: inertia along each axis [kg], (1/2) rho C_D S [kg/m], steady force [N], displaced and
# added mass [kg]; then (1/2) rho C_D S of an isotropic unit.
UNIT_INERTIA, UNIT_DRAG, UNIT_FORCE, UNIT_FLUID, UNIT_BODY_DRAG = 0, 3, 6, 9, 12
UNIT_COLUMNS = 13

# The equations of a node: symmetric blocks on the diagonal and above it, residual [N], correction [m] of its position;
# scratch of the elimination; tension [N] of the segment above it.
DXX, DXY, DXZ, DYY, DYZ, DZZ, UXX, UXY, UXZ, UYY, UYZ, UZZ, RX, RY, RZ, CX, CY, CZ = range(18)
SWEEP = 18
TENSION = 27
EQUATION_COLUMNS = 28

# The wide system of a line with bending, three rows for each node: half bandwidth 8, and the right side.
CENTRE, RIGHT = 8, 17
BAND_COLUMNS = 18

# Settings: generalised-alpha, Newton, seabed, wave, compensator; the largest step, and the one that the next
# interval begins with (0: the largest).
(
    ALPHA_F,
    ALPHA_M,
    BETA,
    GAMMA,
    TOLERANCE,
    ITERATIONS,
    BED_ON,
    BED_DEPTH,
    BED_SLOPE_X,
    BED_SLOPE_Y,
    BED_STIFFNESS,
    BED_DAMPING,
    BED_FRICTION,
    BED_UNIT_STIFFNESS,
    BED_UNIT_DAMPING,
    WAVE_AMPLITUDE,
    WAVE_FREQUENCY,
    WAVE_NUMBER,
    WAVE_X,
    WAVE_Y,
    SPRING_ON,
    SPRING_STIFFNESS,
    SPRING_DAMPING,
    SPRING_MASS,
    SPRING_HALF_STROKE,
    SPRING_STOP,
    SPRING_STOP_DAMPING,
    SPRING_PRELOAD,
    BENDING_ON,
    STEP,
    RESUMED_STEP,
    PROFILE_X,
    PROFILE_Y,
    PROFILE_ROWS,
) = range(34)
SETTING_COLUMNS = 34
"""The points of the seabed's profile follow, three numbers each: distance [m], height [m], slope."""

# Counters that a kernel writes: segments in use; Newton iterations, steps taken and steps refused since the start.
SEGMENTS, NEWTON, STEPS, REFUSED = range(4)
COUNTER_COLUMNS = 4

# What is seen of the line after an evaluation: acceleration of the unit [m/s^2], largest strain of a segment [-], force
# on the top end [N], number of segments without tension.
SEEN_AX, SEEN_AY, SEEN_AZ, SEEN_STRAIN, SEEN_TENSION, SEEN_SLACK = range(6)
SEEN_COLUMNS = 6

# Outcomes of an advance.
DONE, NOT_CONVERGED, TOO_SHORT = range(3)

SPLIT_AT = 0.7
"""A node is born when the cable beyond the next grid point exceeds this share of the spacing there..."""

MERGE_AT = 0.4
"""...and is removed when its top segment is shorter than this share.

The gap between the two keeps a heaving winch from doing both in turn.
"""
