"""When the adviser looks: at the sensors, and at the sea."""

from __future__ import annotations

import math

import numpy as np

from winch_controller_node.adviser.judge import Hypothesis
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.seas import SeaSeen, SeaTracker
from winch_controller_node.interface.observations import TICK_COLUMNS, Observations

JUDGED_EVERY = 5
"""Seconds from one look at the sensors to the next; each second while a sensor is set aside, or not trusted."""

WORSE, RESTS = 1.3, 60
"""Hypotheses that explained nothing are tried again when the misfit is so many times larger, or after some seconds."""

CLEAR = 4.0
"""Heave rate of a sea over the noise of the MRU from which on its period is judged."""

SEA_PATIENCE, LONGER, LONGEST_SEA_PATIENCE = 5.0, 1.3, 120.0
"""Time from one comparison of seas to the next [s], and by what it grows, to the last, while no other is found."""


class Looks:
    """When hypotheses are tried: where the sensors read otherwise than foreseen, and something is new about it.

    Attributes
    ----------
    before : the best hypothesis of the last look, that was not accepted; None: what is believed was the best
    """

    def __init__(self) -> None:
        self.before: Hypothesis | None = None
        self._best_since, self._tried, self._misfit = 0, -RESTS, 1.0

    def is_due(self, misfit: float, second: int, *, is_asked: bool) -> bool:
        """Tell whether hypotheses are tried in a `second` with a `misfit`, or where that `is_asked`; note that."""
        is_news = misfit > WORSE * self._misfit or second >= self._tried + RESTS
        if not (is_news or self.before is not None or is_asked):
            return False
        self._tried, self._misfit = second, misfit
        return True

    def held_before(self, best: Hypothesis, second: int) -> Hypothesis | None:
        """Return that of the last look, where the `best` in this `second` blames the same as it for long enough."""
        if self.before is None or self.before.culprits != best.culprits:
            self._best_since = second
        return self.before if second - self._best_since >= JUDGED_EVERY else None


class SeaLooks:
    """The sea that is seen, and when it is compared with others.

    Parameters
    ----------
    design : in force
    """

    def __init__(self, design: ControllerDesign) -> None:
        self.tracker = SeaTracker(design)
        self._compared, self._patience = -math.inf, SEA_PATIENCE

    def add(self, observations: Observations, noise: float) -> None:
        """Have the motion of the boom tip in a batch seen; `noise` is that of the heave rate [m/s]."""
        row = observations.rows.index("mru_heave_rate")
        readings = observations.readings[observations.readings[:, 2] == row]
        for nis in readings[np.isfinite(readings[:, -1]), -1].tolist():
            self.tracker.note_surprise(nis, noise)
        tip = [TICK_COLUMNS.index("tip_heave"), TICK_COLUMNS.index("tip_rate")]
        for heave, rate in observations.ticks[:, tip].tolist():
            self.tracker.update(heave, rate)

    def news(self, now: float, noise: float) -> SeaSeen | None:
        """Return what is seen where it is time to compare seas [s]; None: it is not, or `noise` [m/s] hides it."""
        seen = self.tracker.newly_seen()
        if seen is None or seen.heave * seen.frequency < CLEAR * noise or now - self._compared < self._patience:
            return None
        self._compared, self._patience = now, min(LONGER * self._patience, LONGEST_SEA_PATIENCE)
        return seen

    def has_changed(self) -> None:
        """Compare again soon: another sea has just been found."""
        self._patience = SEA_PATIENCE
