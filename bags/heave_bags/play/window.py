"""What of a record is wanted."""

from __future__ import annotations

from dataclasses import dataclass

from heave_bags.errors import BagError

DEFAULT_BRIDGE, LONGEST_BRIDGE = 2.0, 10.0
"""Longest time without a sample that is interpolated over: unless it is said, and at most [s]."""


@dataclass(frozen=True)
class Window:
    """What of a record is wanted.

    Attributes
    ----------
    start, end : seconds from the start of the record, or a time in ISO 8601; "": its own start and end
    bridge : longest gap that is interpolated over [s]

    Raises BagError for a bridge that is not above 0, or above LONGEST_BRIDGE.
    """

    start: str = ""
    end: str = ""
    bridge: float = DEFAULT_BRIDGE

    def __post_init__(self) -> None:
        """Check the longest gap."""
        if not 0.0 < self.bridge <= LONGEST_BRIDGE:
            raise BagError(f"--bridge {self.bridge:g}: must be above 0 and at most {LONGEST_BRIDGE:g} s")
