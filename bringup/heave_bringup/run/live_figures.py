"""The live line of a run: what the unit does, by the truth where there is truth; and each loss of compensation."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping

import numpy as np
from heave_bags.analyse.events import COMPENSATES, HOLDS_TENSION, OFF, is_loss, loss_words
from heave_node import kpi
from heave_node.interface.codes import time_of, without_figures
from heave_node.numerics.arrays import Array

WINDOW = 60.0
"""Simulated time over which figures are taken [s]."""
LEAST_TIME = 20.0
"""Simulated time before which there is no figure [s]: three waves."""
LEAST_SAMPLES = 32
"""Least samples of a window: of a run much faster than real time few samples are seen, and the window is longer."""


class LiveFigures:
    """What the line says of the loop.

    Parameters
    ----------
    is_open_loop : load or winch are those of a bag, and their motion is no figure of this run

    Attributes
    ----------
    mode, reason : of the controller, newest; "" before the first
    is_landed : the bottom carries the unit
    has_truth : a simulator has reported where the unit is
    """

    def __init__(self, *, is_open_loop: bool = False) -> None:
        self._is_open_loop = is_open_loop
        self.mode = self.reason = self._loss_reason = ""
        self.is_landed = self.has_truth = False
        self._samples: deque[tuple[float, float, float]] = deque()
        self._depths: deque[tuple[float, float]] = deque()

    def note_mode(self, time: float, mode: str, reason: str) -> str:
        """Take the `mode` of the controller at a simulated `time` [s] and its `reason`.

        Returns the line about compensation that was lost by it; "" for no loss.
        """
        before, self.mode, self.reason = self.mode, mode, reason
        if before != mode:
            self._samples.clear()
        if not is_loss(before, mode, reason):
            return ""
        self._loss_reason = reason
        return loss_words(time, mode, reason)

    def note_modes(self, time: float, words: str, reported: Mapping[str, str]) -> list[str]:
        """Take what the controller reports about its mode in diagnostics.

        Parameters
        ----------
        time : of the diagnostics, simulated [s]
        words : the mode and its reason
        reported : values beside them, each change since the last diagnostics among them

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

    def note_truth(self, time: float, unit: float, uncompensated: float, *, is_landed: bool) -> None:
        """Take where the unit is at a simulated `time` [s].

        Parameters
        ----------
        time : of the sample; one that was taken already is left out
        unit, uncompensated : heights of the unit and of that with the winch locked [m]
        is_landed : the bottom carries the unit
        """
        self.has_truth = True
        if is_landed != self.is_landed:
            self.is_landed = is_landed
            self._samples.clear()
        if self._samples and time <= self._samples[-1][0]:
            return
        self._samples.append((time, unit, uncompensated))
        while len(self._samples) > LEAST_SAMPLES and time - self._samples[0][0] > WINDOW:
            self._samples.popleft()

    def note_depth(self, time: float, depth: float) -> None:
        """Take the mean `depth` [m] at which the controller holds the unit at a simulated `time` [s]; NaN: unknown."""
        if math.isfinite(depth):
            self._depths.append((time, depth))
        while self._depths and self._samples and self._depths[0][0] < self._samples[0][0] - WINDOW:
            self._depths.popleft()

    def words(
        self,
        estimated_sigma: float = math.nan,
        estimated_efficiency: float = math.nan,
        estimated_window: float = math.nan,
    ) -> str:
        """Return what the line says.

        Parameters
        ----------
        estimated_sigma, estimated_efficiency, estimated_window : of the controller [m], [-], [s]; they count where
            there is no truth
        """
        if self._is_open_loop:
            return f"{self._mode_words()}, open loop: load and winch as recorded"
        if self.is_landed:
            return "load on the seabed, constant tension" if self.mode == HOLDS_TENSION else "load on the seabed"
        estimated = estimated_sigma, estimated_efficiency, estimated_window
        sigma, efficiency, window = self._figures() if self.has_truth else estimated
        words = [self._mode_words()]
        if math.isfinite(sigma):
            words.append(f"load {100.0 * sigma:.2f} cm rms")
            if self.mode in COMPENSATES and math.isfinite(efficiency):
                words.append(f"efficiency {100.0 * efficiency:.1f} %")
            how = "" if self.has_truth else "estimated "
            words[-1] += f" ({how}over {window:.0f} s)"
        return ", ".join(word for word in words if word)

    def _mode_words(self) -> str:
        if self.mode == OFF:
            return "law off"
        waits = self.reason and self.mode not in COMPENSATES
        return f"{self.mode} ({self.reason})" if waits else self.mode

    def _figures(self) -> tuple[float, float, float]:
        """Return sigma [m], efficiency and span [s] of the samples, about the depths to which the unit was moved."""
        samples = np.array(self._samples)
        if self._depths and len(samples):
            samples = samples[samples[:, 0] <= self._depths[-1][0]]
        if len(samples) < LEAST_SAMPLES or samples[-1, 0] - samples[0, 0] < LEAST_TIME:
            return math.nan, math.nan, math.nan
        time = samples[:, 0]
        moved = np.interp(time, *np.array(self._depths).T) if self._depths else np.zeros(len(time))
        # the locked winch's unit may follow the programme of depth or stay where it was
        unit, free = (min(_sigma(time, values), _sigma(time, values + moved)) for values in samples[:, 1:].T)
        return unit, kpi.efficiency(unit, free), float(time[-1] - time[0])


def _sigma(time: Array, values: Array) -> float:
    """Return the standard deviation about a straight line."""
    since = time - time[0]
    return kpi.sigma(values - np.polyval(np.polyfit(since, values, 1), since))
