"""Law off: the winch is held by its brake, while sensors and estimate are still published."""

from __future__ import annotations

from typing import ClassVar

from winch_controller_node.laws.law import ControlLaw, LawCommand, LawDesign
from winch_controller_node.laws.parts.loop_state import LoopState


class Off(ControlLaw):
    """No command. Its gain is that of the `design`, so that it can be looked at without moving the winch.

    It has no `parameters`.
    """

    name: ClassVar[str] = "off"
    summary: ClassVar[str] = "brake on"
    moves_winch: ClassVar[bool] = False

    def __init__(self, design: LawDesign, parameters: None) -> None:
        super().__init__(design, parameters)
        self.gain = design.gain

    def command(self, state: LoopState) -> LawCommand:
        """Return no command, whatever the `state`."""
        del state
        return LawCommand(0.0)
