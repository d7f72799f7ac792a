"""When to look for the sensor at fault: where readings are foreseen badly for long, and again while one is doubted."""

from __future__ import annotations

import math

from winch_controller_node.estimation.reading_record import RECORD, Surprise

SURPRISED_TIME = 30.0
"""Sensors are suspected when readings have been foreseen badly for so long [s]."""

SHORT_RECORD = 30.0
"""Record that is enough where the guard does not trust the estimate [s]: the first minute has no longer one."""

GROSSLY, GROSS_TIME = 6.0, 10.0
"""And once before, after so long [s], where the mean of their normalised innovations squared is so large."""

FIRST_PATIENCE, LONGER = 30.0, 2.0
"""Time from one look to the next [s], and the factor by which it grows each time that nothing is found."""

DOUBTED_PATIENCE, EARLY_PATIENCE, UNTRUSTED_PATIENCE = 60.0, 10.0, 5.0
"""The same while a sensor is doubted, in the first minute of that, and while the guard does not trust the estimate but
no culprit is known [s]."""


class SuspicionTimes:
    """Tells when to look, and since when there has been something to look at.

    Parameters
    ----------
    tick_period : [s]

    Attributes
    ----------
    onset : number of the tick since which readings have been foreseen badly, or a sensor is doubted
    is_early : a sensor is doubted, for less than a minute: it may be explained from the onset, but is not judged yet
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self.onset = 0
        self.is_early = False
        self._looked = self._judged = -math.inf
        self._patience = FIRST_PATIENCE / LONGER
        self._was_doubted = self._was_gross = False

    def pass_tick(self, tick: int, surprise: Surprise, *, is_doubted: bool) -> None:
        """Note at a `tick` whether there is a `surprise` by readings, or a sensor that `is_doubted`."""
        if surprise.time == 0.0 and not is_doubted:
            self.onset = tick

    def note_found(self, tick: int) -> None:
        """Note that something was found at a `tick`."""
        self._looked, self._patience = tick * self._dt, FIRST_PATIENCE

    def is_due(self, tick: int, surprise: Surprise, *, is_doubted: bool, is_trusted: bool, knows_winch: bool) -> bool:
        """Tell whether to look at a `tick`; a sensor that is doubted is judged anew every minute.

        Parameters
        ----------
        tick : number of the present one
        surprise : by the readings
        is_doubted : a sensor is
        is_trusted : the guard trusts the estimate
        knows_winch : the drum does what it is believed to: what a winch may explain that does not is no sensor's
        """
        now, was_doubted = tick * self._dt, self._was_doubted
        self._was_doubted, self.is_early = is_doubted, False
        if is_doubted:
            return self._is_doubt_due(now, has_begun=not was_doubted)
        surprised_time = SURPRISED_TIME if knows_winch else RECORD
        if surprise.time >= surprised_time and now - self._looked >= self._patience:
            self._looked = now
            self._patience *= LONGER
            return True
        if not is_trusted and now - self._looked >= UNTRUSTED_PATIENCE:
            self._looked = now
            return True
        is_gross = GROSS_TIME <= surprise.time < SURPRISED_TIME and surprise.worst[1] >= GROSSLY
        # once: what was not clear then may be in its turn
        was_gross, self._was_gross = self._was_gross, is_gross or (self._was_gross and surprise.time > 0.0)
        return is_gross and not was_gross

    def _is_doubt_due(self, now: float, *, has_begun: bool) -> bool:
        """Tell whether to look `now` [s] at a sensor that is doubted, since now where that `has_begun`.

        In the first minute of the trouble it is more often: it may be explained from when it began.
        """
        if has_begun:
            self._looked = self._judged = now
        self.is_early = now - self._judged < DOUBTED_PATIENCE
        if not self.is_early:
            self._looked = self._judged = now
            return True
        lasted = now - self.onset * self._dt
        is_due = SHORT_RECORD <= lasted < RECORD + EARLY_PATIENCE and now - self._looked >= EARLY_PATIENCE
        self._looked = now if is_due else self._looked
        return is_due
