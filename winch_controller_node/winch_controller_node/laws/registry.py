"""The control laws that the parameter `law` can name. A new law is a file beside this one, and a line in `LAWS`."""

from __future__ import annotations

from heave_node.numerics.arrays import Array

from winch_controller_node.laws.feedforward import SpeedFeedforward
from winch_controller_node.laws.industrial import IndustrialBaseline
from winch_controller_node.laws.law import ControlLaw, LawDesign
from winch_controller_node.laws.lqg import FullStateFeedback
from winch_controller_node.laws.lqr import UnitRegulator
from winch_controller_node.laws.mpc import ConstrainedLaw
from winch_controller_node.laws.off import Off

LAWS: dict[str, type[ControlLaw]] = {
    law.name: law
    for law in (
        Off,
        UnitRegulator,
        FullStateFeedback,
        SpeedFeedforward,
        IndustrialBaseline,
        ConstrainedLaw,
    )
}
"""Laws by name, in the order in which they are listed."""


def make_law(name: str, design: LawDesign, all_parameters: object) -> ControlLaw:
    """Return the law `name` for a design; its own parameters are the group of its name in `all_parameters`.

    Raises DesignError where the winch cannot be driven by that law.
    """
    law = LAWS[name]
    own = None if law.parameters_type is None else getattr(all_parameters, name)
    return law(design, own)


def own_gains(name: str, design: LawDesign, all_parameters: object) -> dict[str, Array]:
    """Return the gains that the law `name` would make for a `design`, see `ControlLaw.own_gains`.

    Its own parameters are the group of its name in `all_parameters`.

    Raises DesignError where there are none.
    """
    law = LAWS[name]
    return law.own_gains(design, None if law.parameters_type is None else getattr(all_parameters, name))


def describe_laws() -> str:
    """Return the names of all laws with what they do."""
    return "; ".join(f"{law.name}: {law.summary}" for law in LAWS.values())
