"""A winch on the bench, virtual or real: set signals, what it may be ordered, and what it does."""
