"""Efficiency over the last ten minutes, by what the controller estimates in each tick."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from heave_bringup.operate.situation import Situation
from heave_node import kpi

STEP = 0.25
"""Simulated time from sample to sample [s]."""

WINDOW, LEAST = 600.0, 60.0
"""Simulated time over which it is taken, and at least [s]: sixty waves, and six."""

ERROR = 0.04
"""Error of it [-]: -0.038 to +0.017 in six runs of 600 s, each in a world other than its controller assumed."""


class Efficiency:
    """Collects estimates; the run pays nothing for it.

    The estimate of the filter moves less than the unit: the variance of its error is added.
    """

    def __init__(self) -> None:
        self._samples: deque[tuple[float, float, float, float]] = deque(maxlen=round(WINDOW / STEP))

    def note(self, situation: Situation) -> None:
        """Take a `situation`; a restart of the run clears it, and what no sensor reports now is left out."""
        controller, figures = situation.controller, situation.figures
        if controller is None or figures is None or not math.isfinite(figures.uncompensated_sigma):
            return
        time = controller.time
        if self._samples and time < self._samples[-1][0]:
            self._samples.clear()
        if self._samples and time < self._samples[-1][0] + STEP - 1e-6:
            return
        sample = (time, controller.unit_heave, controller.uncompensated_heave, controller.unit_error**2)
        if all(map(math.isfinite, sample)):
            self._samples.append(sample)
        while time - self._samples[0][0] > WINDOW if self._samples else False:
            self._samples.popleft()

    @property
    def span(self) -> float:
        """Simulated time from the first sample to the last [s]."""
        return self._samples[-1][0] - self._samples[0][0] if self._samples else 0.0

    @property
    def value(self) -> float:
        """Efficiency at the unit [-]; NaN until LEAST has passed."""
        if self.span < LEAST:
            return math.nan
        _, unit, free, error = np.array(self._samples).T
        return kpi.efficiency(math.hypot(kpi.sigma(unit), math.sqrt(float(error.mean()))), kpi.sigma(free))

    @property
    def words(self) -> str:
        """What a page shows of it [%]."""
        value = self.value
        return f"{100.0 * value:.1f} ± {100.0 * ERROR:.0f}" if math.isfinite(value) else "-"
