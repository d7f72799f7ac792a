"""The live line of a run: the mode, what the controller estimates of the unit, and each loss of compensation."""

from __future__ import annotations

import math
from collections.abc import Mapping

from heave_bags.analyse.events import COMPENSATES, OFF, is_loss, loss_words
from heave_node.interface.codes import time_of, without_figures


class LiveFigures:
    """What the line says of the loop.

    Parameters
    ----------
    is_open_loop : load or winch are those of a bag, and their motion is no figure of this run

    Attributes
    ----------
    mode, reason : of the controller, newest; "" before the first
    """

    def __init__(self, *, is_open_loop: bool = False) -> None:
        self._is_open_loop = is_open_loop
        self.mode = self.reason = self._loss_reason = ""

    def note_mode(self, time: float, mode: str, reason: str) -> str:
        """Take the `mode` of the controller at a simulated `time` [s] and its `reason`.

        Returns the line about compensation that was lost by it; "" for no loss.
        """
        before, self.mode, self.reason = self.mode, mode, reason
        if not is_loss(before, mode, reason):
            return ""
        self._loss_reason = reason
        return loss_words(time, mode, reason)

    def note_modes(self, time: float, words: str, reported: Mapping[str, str]) -> list[str]:
        """Take what the controller reports at a `time` [s, simulated] about its mode in diagnostics: mode and reason,
        `words`, and the values `reported` beside them, each change since the last diagnostics among them.

        Returns the lines about compensation that was lost, with the time of the change.
        """
        changes = [(at, change) for key, change in reported.items() if (at := time_of(key)) is not None]
        lines = []
        for at, change in [*changes, (time, words)]:
            mode, _, reason = change.partition(": ")
            lines.append(self.note_mode(at, mode, reason))
        return [line for line in lines if line]

    @property
    def is_reported(self) -> bool:
        """Whether the mode is one that compensation was lost into, for the reason that was reported then."""
        is_same = without_figures(self.reason) == without_figures(self._loss_reason)
        return self.mode not in COMPENSATES and bool(self._loss_reason) and is_same

    def words(self, sigma: float = math.nan, efficiency: float = math.nan, window: float = math.nan) -> str:
        """Return what the line says with the `sigma` [m], `efficiency` and their `window` [s] of the controller."""
        if self._is_open_loop:
            return f"{self._mode_words()}, open loop: load and winch as recorded"
        words = [self._mode_words()]
        if math.isfinite(sigma):
            words.append(f"load {100.0 * sigma:.2f} cm rms")
            if self.mode in COMPENSATES and math.isfinite(efficiency):
                words.append(f"efficiency {100.0 * efficiency:.1f} %")
            words[-1] += f" (estimated over {window:.0f} s)"
        return ", ".join(word for word in words if word)

    def _mode_words(self) -> str:
        if self.mode == OFF:
            return "law off"
        waits = self.reason and self.mode not in COMPENSATES
        return f"{self.mode} ({self.reason})" if waits else self.mode
