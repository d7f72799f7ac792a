"""What statics can refuse."""

from __future__ import annotations


class StaticsError(ValueError):
    """A statics problem that is not well posed; the message says what is wrong."""


class NoEquilibriumError(StaticsError):
    """No equilibrium with these boundary conditions exists or was found; the message says how far it got."""
