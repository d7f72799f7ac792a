"""How the stamps of an external node are read, as declared; parameters need no more of its clock, and no numerics."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

LARGEST_LATENCY = 5.0
"""Largest latency that can be declared [s]: what is older is of no use to a controller."""


class ClockRule(Enum):
    """How the stamps of an external node are read."""

    DETECT = "detect"
    """The clock is detected by the first message."""
    SIMULATED = "simulated"
    OWN = "own"
    NONE = "none"


class Stamping(NamedTuple):
    """How an external node stamps."""

    rule: ClockRule = ClockRule.DETECT  # of its clock
    latency: float = 0.0  # by which what it measures is older than its stamp, or its arrival, says [s]


def parse_clock(text: str) -> tuple[str, Stamping]:
    """Return node and stamping of a declaration, `text`, like `virtual_winch=own` or `mru=none:0.04`.

    Raises ValueError for any other.
    """
    node, _, clock = text.partition("=")
    name, _, latency = clock.partition(":")
    rules = [rule.value for rule in ClockRule]
    if not node or name not in rules:
        raise ValueError(f"external_clocks: {text} must be NODE=CLOCK[:LATENCY], CLOCK one of {', '.join(rules)}")
    try:
        seconds = float(latency or 0.0)
    except ValueError:
        seconds = -1.0
    if not 0.0 <= seconds <= LARGEST_LATENCY:
        raise ValueError(f"external_clocks: {text}: the latency must be from 0 to {LARGEST_LATENCY:g} s")
    return node, Stamping(ClockRule(name), seconds)
