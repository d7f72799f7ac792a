"""Supervision: modes, the guard, landing, and whether the winch behaves as modelled."""
