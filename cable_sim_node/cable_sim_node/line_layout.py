"""Columns of the plain arrays that the line's compiled kernels share. Lengths and forces in SI units, frame `world`."""

from __future__ import annotations

# A segment: unstretched length [m], EA [N], tension law, internal damping [N s]; the rest per unstretched metre.
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

# A lump on a node: mass and added mass [kg], weight in fluid [N], (1/2) rho C_D A [kg/m].
LUMP_MASS, LUMP_ADDED_MASS, LUMP_WEIGHT, LUMP_DRAG, LUMP_DISPLACED = range(5)
LUMP_COLUMNS = 5

# The unit, three columns each: inertia along each axis [kg], (1/2) rho C_D S [kg/m], steady force [N], displaced and
# added mass [kg].
UNIT_INERTIA, UNIT_DRAG, UNIT_FORCE, UNIT_FLUID = 0, 3, 6, 9
UNIT_COLUMNS = 12

# The moving state: time [s], unstretched length [m], its rate and acceleration.
TIME, TOTAL, RATE, ACCELERATION = range(4)
STATE_COLUMNS = 4

# Settings: generalised-alpha, Newton, contact plane, wave, compensator.
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
    BED_SLIP,
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
) = range(31)
SETTING_COLUMNS = 31

# Counters that a kernel writes: segments in use, and what an advance did.
SEGMENTS, SUBSTEPS, SOLVES, HALVINGS = range(4)
COUNTER_COLUMNS = 4

# Outcomes of an advance.
DONE, NOT_CONVERGED, TOO_SHORT = range(3)

SPLIT_AT = 0.7
"""A node is born when the cable beyond the next grid point exceeds this share of the spacing there..."""

MERGE_AT = 0.4
"""...and dies when its top segment is shorter than this share.

The gap between both keeps a heaving winch from doing both in turn.
"""
