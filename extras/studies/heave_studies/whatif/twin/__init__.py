"""Winch, cable and unit of a record, and the loop closed over it."""
