"""How the stamps of an external node are read, as declared; parameters need no more of its clock, and no numerics."""

from __future__ import annotations

from enum import Enum


class ClockRule(Enum):
    """How the stamps of an external node are read."""

    DETECT = "detect"
    """The clock is detected by the first message."""
    SIMULATED = "simulated"
    OWN = "own"
    NONE = "none"


def parse_clock(text: str) -> tuple[str, ClockRule]:
    """Return node and rule of a declaration, `text`, like `virtual_winch=own`; raise ValueError for any other."""
    node, _, rule = text.partition("=")
    rules = [rule.value for rule in ClockRule]
    if not node or rule not in rules:
        raise ValueError(f"external_clocks: {text} must be NODE=CLOCK, CLOCK one of {', '.join(rules)}")
    return node, ClockRule(rule)
