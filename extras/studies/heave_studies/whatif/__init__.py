"""What would have been: another law, gain or winch in the sea of a record, from its sensors alone."""

DRAWS = 4
"""Plants over which each loop is closed again for the bands, where nobody says how many."""
