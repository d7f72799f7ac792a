"""Design: from parameters to gains, bounds, margins and the design report, before a run and during it."""
