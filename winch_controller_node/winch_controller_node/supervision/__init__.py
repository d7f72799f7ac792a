"""Supervision: modes, the guard, landing, and whether the winch is the one believed in."""
