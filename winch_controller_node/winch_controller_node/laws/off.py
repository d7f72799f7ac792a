"""Law off: the winch stands on its brake, while sensors and estimate are still published."""

from __future__ import annotations

from typing import ClassVar

from winch_controller_node.laws.law import ControlLaw, LawCommand, LawDesign
from winch_controller_node.laws.loop_state import LoopState


class Off(ControlLaw):
    """No command. Its gain is that of law lqg, so that the design can be looked at without moving the winch."""

    name: ClassVar[str] = "off"
    summary: ClassVar[str] = "brake on"
    moves_winch: ClassVar[bool] = False

    def __init__(self, design: LawDesign, parameters: None) -> None:
        super().__init__(design, parameters)
        self.gain = design.gain

    def command(self, state: LoopState) -> LawCommand:
        """Return no command."""
        del state
        return LawCommand(0.0)
