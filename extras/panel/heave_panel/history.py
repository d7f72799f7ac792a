"""The last minute of each signal, as the page draws it."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from heave_bringup.operate.situation import ControllerStatus, Situation, WinchStatus

STEP = 0.25
"""Simulated time from point to point [s]."""
LENGTH = 240
"""Points that are drawn: one minute."""


@dataclass(frozen=True)
class Line:
    """A signal that is drawn."""

    chart: str  # where
    name: str  # what it is called there
    value: Callable[[Situation], float]  # of a situation in the unit of its chart; NaN where it is not known


def _controller(value: Callable[[ControllerStatus], float]) -> Callable[[Situation], float]:
    return lambda now: math.nan if now.controller is None else value(now.controller)


def _winch(value: Callable[[WinchStatus], float]) -> Callable[[Situation], float]:
    return lambda now: math.nan if now.winch is None else value(now.winch)


def _residual(now: Situation) -> float:
    """Return what the winch leaves of the boom tip's heave [m], by encoder and estimate."""
    if now.controller is None or now.winch is None:
        return math.nan
    return now.controller.boom_tip_heave - (now.winch.payout - now.controller.mean_payout)


HEAVE, UNIT, WINCH, TENSION = "heave [m]", "load [cm]", "payout rate [m/s]", "tension [kN]"
LINES: tuple[Line, ...] = (
    Line(HEAVE, "boom tip", _controller(lambda now: now.boom_tip_heave)),
    Line(HEAVE, "load, winch locked", _controller(lambda now: now.uncompensated_heave)),
    Line(UNIT, "load", _controller(lambda now: 100.0 * now.unit_heave)),
    Line(UNIT, "rope at the boom tip", lambda now: 100.0 * _residual(now)),
    Line(WINCH, "payout rate", _winch(lambda now: now.rate)),
    Line(TENSION, "tension", lambda now: 1e-3 * now.tension),
)
"""Heave is estimated, payout and tension are measured: all of it is there on a ship too."""


class History:
    """Points of every line over simulated time."""

    def __init__(self) -> None:
        self._points: deque[tuple[float, ...]] = deque(maxlen=LENGTH)
        self._slot = -1

    def note(self, situation: Situation) -> None:
        """Take a `situation`; a run that restarts begins a new history."""
        slot = int(situation.time / STEP)
        if slot == self._slot:
            return
        if slot < self._slot:
            self._points.clear()
        self._slot = slot
        self._points.append((round(situation.time, 2), *(line.value(situation) for line in LINES)))

    @property
    def span(self) -> tuple[float, float]:
        """Times of the first and the last point [s]; 0 without points."""
        points = tuple(self._points)
        return (points[0][0], points[-1][0]) if points else (0.0, 0.0)

    def series(self, number: int) -> list[list[float | None]]:
        """Return line `number` as pairs of time [s] and value; None breaks a line."""
        return [
            [point[0], round(point[number + 1], 4) if math.isfinite(point[number + 1]) else None]
            for point in tuple(self._points)
        ]
