"""The highest tension: whether compensation can keep below it in the sea that is seen now."""

from __future__ import annotations

import math

from heave_core.look import RunningSigma
from heave_node.interface.alarm import Alarm

from winch_controller_node.core.supervision.guard_checks import SLOW_MEAN_FACTOR
from winch_controller_node.interface.alarms import ALARMS

PEAK = 2.7
"""Peak amplitude over standard deviation of forty waves, sqrt(2 ln 40): those of five minutes or more."""

LEFT = 0.1
"""Share of a locked winch's tension that is left where the winch follows the whole sea: the cable has inertia too."""

HOLD = 300.0
"""A highest tension that was once too low must be enough for so long before compensation keeps it again [s]."""


class HighestTension:
    """Compares the highest tension with what compensation needs.

    What the winch follows hardly changes the tension. What is beyond its limits it does not: of that share of a peak
    the tension is that of a locked winch. With a highest tension below it the winch would give way in every group of
    waves, while it has nothing left to bring the unit back with.

    Parameters
    ----------
    window : memory of the waves [s]
    tick_period : [s]

    Attributes
    ----------
    is_kept : the winch gives way to a tension above the highest one, and plans to stay below it
    alarm : that it is too low for this sea; None: it is not
    """

    def __init__(self, window: float, *, tick_period: float) -> None:
        self._dt = tick_period
        self._stretch = RunningSigma(window, tick_period, SLOW_MEAN_FACTOR)
        self._enough_time = math.inf
        self.is_kept = True
        self.alarm: Alarm | None = None

    def update(self, stretch: float, ratio: float, *, tension_per_metre: float, peak_use: float, brake: bool) -> None:
        """Take a tick in.

        Parameters
        ----------
        stretch : by which the cable would be longer than at rest, were the winch locked [m]
        ratio : highest tension over the static one [-]
        tension_per_metre : of stretch, over the static one [1/m]
        peak_use : peak of the boom tip over the winch's limits [-]
        brake : is on: compensation restarts
        """
        self._stretch.add(stretch)
        least = self.least_ratio(tension_per_metre, peak_use)
        needed = math.ceil(100.0 * least) / 100.0
        self.alarm = ALARMS.alarm("TENSION_LIMIT_LOW", needed=needed, limit=ratio) if least > ratio else None
        if self.alarm:
            self._enough_time = 0.0
        else:
            self._enough_time = math.inf if brake else self._enough_time + self._dt
        self.is_kept = self._enough_time > HOLD

    def least_ratio(self, tension_per_metre: float, peak_use: float) -> float:
        """Return the least highest tension over the static one [-], from `tension_per_metre` and `peak_use`."""
        share = max(LEFT, 1.0 - 1.0 / peak_use) if peak_use > 0.0 else LEFT
        return 1.0 + share * PEAK * self._stretch.sigma * tension_per_metre
