"""A unit that its buoyancy lifts above the boom tip: refused, as there is no surface for it to float on."""

from __future__ import annotations

from cable_sim_node.errors import NoEquilibriumError


def refuse_floating(unit_height: float, boom_tip_height: float) -> None:
    """Raise NoEquilibriumError for a unit that hangs upwards, its `unit_height` above the `boom_tip_height` [m]."""
    if unit_height > boom_tip_height:
        raise NoEquilibriumError(floating_words(unit_height))


def floating_words(unit_height: float) -> str:
    """Return in words that a unit floats up to its `unit_height` [m], above the boom tip."""
    return (
        f"the line does not hang: the unit's buoyancy lifts it above the boom tip, to {unit_height:.0f} m; "
        "there is no surface here to float on: use a heavier unit or more cable"
    )
