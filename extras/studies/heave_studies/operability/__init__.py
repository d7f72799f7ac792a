"""Operability: which seas a vessel, a winch and a controller can work in, and how long one waits for them."""
