"""What was learnt of the winch, told once it has settled: it is used at once, and hunts a little before it rests."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from heave_node.interface.codes import WINCH_LEARNT

from winch_controller_node.parameters.model import WinchModelParameters

SETTLED, LONGEST = 12.0, 40.0
"""It is told when it has rested for so long, and after the second time at the latest [s]."""

MIXED = 20.0
"""A winch that changes after it was known is told so much later [s]: the record holds the old one beside the new."""

NOTABLE = 0.1
"""Relative change of a limit or a lag, since it was told, that is worth telling."""

NOTABLE_LAG, EXCHANGED_LAG = 0.02, 0.05
"""Least change of a lag [s] that is, and where the other lag has taken up what this one has lost: it is their sum that
a drum shows well.
"""

BY_ANOTHER_SCALE = 0.05
"""Least change of the gain that is, where the encoder's scale was found to be another: that is known no better."""

NOTABLE_OTHERS = {"speed_gain": 0.02, "hauling_gain": 0.05, "creep": 0.02}
"""Least change of the gains, and of the creep [m/s], that is: two directions are told apart by half the record each."""

LET_UP = 1.5
"""A limit that has recovered to so many times the one that was told is news when it falls again."""

NAMED = (
    ("time constant", "time_constant", "s"),
    ("command delay", "command_delay", "s"),
    ("gain by the encoder", "speed_gain", ""),
    ("gain of hauling in over that", "hauling_gain", ""),
    ("creep", "creep", "m/s"),
    ("speed limit", "speed_limit", "m/s"),
    ("acceleration limit", "acceleration_limit", "m/s^2"),
)
LIMITS = ("speed_limit", "acceleration_limit")
LAGS = ("time_constant", "command_delay")


class WinchNews:
    """Turns what is learnt of a winch into findings, one for each change.

    Parameters
    ----------
    winch : that the operator knows of
    tick_period : [s]

    Attributes
    ----------
    told : the winch that has been told of until now
    """

    def __init__(self, winch: WinchModelParameters, *, tick_period: float) -> None:
        self._dt = tick_period
        self.told = self._last = winch
        self._rested = self._withheld = self._known = self._mixed = 0.0

    def update(
        self,
        winch: WinchModelParameters,
        *,
        directions: Callable[[], Mapping[str, str]] = dict,
        is_power_limited: bool,
        is_learning: bool,
        is_rescaled: bool = False,
    ) -> list[str]:
        """Return what is to be told in this tick; empty: nothing.

        Parameters
        ----------
        winch : in force
        directions : returns in which alone a limit was found, by its name
        is_power_limited : the winch has said that its power ends
        is_learning : more may come; otherwise what there is, is told at once
        is_rescaled : the encoder was found to have another scale
        """
        self._known += self._dt if is_learning else 0.0
        is_same = winch is self._last or winch == self._last
        self._rested = self._rested + self._dt if is_same else 0.0
        if is_same and self._withheld == 0.0:
            return []
        self._last = winch
        self._forget_let_up(winch)
        changed = [row for row in NAMED if self._is_notable(row[1], winch, is_rescaled=is_rescaled)]
        if self._withheld == 0.0:
            self._mixed = MIXED if self._known > LONGEST else 0.0
        self._withheld = self._withheld + self._dt if changed else 0.0
        if not changed or (is_learning and not self._has_settled):
            return []
        lone = directions()
        words = []
        for label, name, unit in changed:
            reached = f", reached {lone[name]}" if name in lone else ""
            by_power = ", by its power limit" if name == "speed_limit" and is_power_limited else ""
            words.append(f"{self._change(label, name, unit, winch)}{reached}{by_power}")
        self.told = replace(self.told, **{name: getattr(winch, name) for _, name, _ in changed})
        return [f"{WINCH_LEARNT}{', '.join(words)}"]

    def _change(self, label: str, name: str, unit: str, winch: WinchModelParameters) -> str:
        """Return in words how a value differs from what was told."""
        old, new = getattr(self.told, name), getattr(winch, name)
        if name == "command_delay" and winch.time_constant == self.told.time_constant:
            # a servo that is as it was to the last digit was not told apart
            label, old, new = f"time constant and {label} together", _total_lag(self.told), _total_lag(winch)
        value = f"{label} {new:.3f} {unit}".rstrip()
        return f"{value} (was {old:.3f})"

    @property
    def _has_settled(self) -> bool:
        """Tell whether what is withheld has rested, or will never rest."""
        since = self._withheld - self._mixed
        return since >= LONGEST or (since >= 0.0 and self._rested >= SETTLED)

    def _is_notable(self, name: str, winch: WinchModelParameters, *, is_rescaled: bool) -> bool:
        """Tell whether a value differs from what was told; limits that are only let up again do not count."""
        old, new = getattr(self.told, name), getattr(winch, name)
        if name in LIMITS:
            return bool(new < (1.0 - NOTABLE) * old)
        if name in LAGS:
            change = _total_lag(winch) - _total_lag(self.told)
            is_exchanged = abs(change) <= NOTABLE_LAG and abs(new - old) <= EXCHANGED_LAG
            return not is_exchanged and bool(abs(new - old) > max(NOTABLE_LAG, NOTABLE * old))
        is_scale = name == "speed_gain" and is_rescaled
        return bool(abs(new - old) > (BY_ANOTHER_SCALE if is_scale else NOTABLE_OTHERS[name]))

    def _forget_let_up(self, winch: WinchModelParameters) -> None:
        for name in LIMITS:
            if getattr(winch, name) > LET_UP * getattr(self.told, name):
                self.told = replace(self.told, **{name: getattr(winch, name)})


def _total_lag(winch: WinchModelParameters) -> float:
    """Return servo and delay of a `winch` together [s]."""
    return winch.time_constant + winch.command_delay
