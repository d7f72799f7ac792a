"""Parameters of the drives of a winch."""
