"""Law off: the winch is held by its brake, while sensors and estimate are still published."""

from __future__ import annotations

from typing import ClassVar

from heave_core.law_table import LawKind

from winch_controller_node.laws.core_law import CoreLaw
from winch_controller_node.laws.law import LawDesign


class Off(CoreLaw):
    """No command. Its gain is that of the `design`, so that it can be looked at without moving the winch.

    It has no `parameters`.
    """

    name: ClassVar[str] = "off"
    summary: ClassVar[str] = "brake on"
    moves_winch: ClassVar[bool] = False

    def __init__(self, design: LawDesign, parameters: None) -> None:
        del parameters
        super().__init__(design, LawKind.NO_LAW)
        self.gain = design.gain
