"""What statics can refuse; `NoEquilibriumError` of `cable_sim_node.errors` is the other answer that is not a shape."""

from __future__ import annotations

from cable_sim_node.errors import PlantError


class StaticsError(PlantError, ValueError):
    """A statics problem that is not well posed; the message says what is wrong."""
