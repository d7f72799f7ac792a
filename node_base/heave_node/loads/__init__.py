"""Loads on the parts of a lift: their cycles, and what the parts can carry."""
