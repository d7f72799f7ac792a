"""Physical constants of the suite. One definition each; SI units."""

STANDARD_GRAVITY = 9.80665
"""Acceleration of gravity [m/s^2]."""

SEAWATER_DENSITY = 1025.0
"""Density of sea water [kg/m^3]."""

ATMOSPHERIC_PRESSURE = 101_325.0
"""Mean pressure at the sea surface [Pa]."""

LARGEST_STRAIN = 0.1
"""Strain above which a cable counts as overstrained [-]: no steel wire or umbilical gets there, few ropes do, and
the plant takes its strain for small."""
