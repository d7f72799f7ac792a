"""The control laws that the parameter `law` can name. A new law is a file beside this one, and a line in `LAWS`."""

from __future__ import annotations

from winch_controller_node.laws.feedforward import SpeedFeedforward
from winch_controller_node.laws.industrial import IndustrialBaseline
from winch_controller_node.laws.law import ControlLaw
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
