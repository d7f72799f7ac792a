"""A simulated sensor: when it samples, when its readings arrive, and what its faults make of them. Pure."""
