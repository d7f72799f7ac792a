"""What a controller has found of its parts, and that it gave an alarm: read from its words, here alone."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

Alarm = tuple[float, str]
"""Time [s] and words."""

WINCH, ENCODER, DRUM = "winch", "encoder", "drum"
_BLAMED = re.compile(r"(?:^|: |; )(mru or drum|mru|depth|encoder|load_cell|cable) (?:suspect|lost)\b")
_NOISE = {"mru_heave": "mru", "mru_heave_rate": "mru", "unit_heave": "depth", "payout": ENCODER, "tension": "load_cell"}
_NO_WARNING = re.compile(
    r"mode (compensating|standby: (stand|brake)|stopped)|sea model updated|programme|share of the sea|^the preview|"
    r"as believed again|agrees with all others"
)


@dataclass(frozen=True)
class Finding:
    """A part that is blamed.

    Attributes
    ----------
    time : [s]
    parts : one of these is at fault
    words : of the alarm
    """

    time: float
    parts: tuple[str, ...]
    words: str


def findings_of(alarms: Sequence[Alarm]) -> list[Finding]:
    """Return what the `alarms` of a run blame."""
    found: list[Finding] = []
    for time, words in alarms:
        blamed: list[tuple[str, ...]] = []
        blamed += [("mru", DRUM, ENCODER) if part == "mru or drum" else (part,) for part in _BLAMED.findall(words)]
        if "winch model updated: " in words:
            changes = re.findall(r"([a-z][a-z ]*?) -?[\d.]+[^,(]*\(was", words.split("winch model updated: ")[1])
            blamed.append((WINCH, ENCODER) if changes == ["gain by the encoder"] else (WINCH,))
        blamed += [(_NOISE.get(name, name),) for name in re.findall(r"noise of (\w+) is", words)]
        found += [Finding(time, parts, words) for parts in blamed]
    return found


def warnings_of(alarms: Sequence[Alarm]) -> list[float]:
    """Return the times [s] of the `alarms` that tell of trouble; news of modes, moves and seas does not."""
    return [time for time, words in alarms if not _NO_WARNING.search(words)]
