"""The highest tension that compensation needs in the sea that is seen now."""

from __future__ import annotations

import math

from winch_controller_node.supervision.checks import RunningSigma

PEAK = 2.7
"""Peak amplitude over standard deviation of forty waves, sqrt(2 ln 40): those of five minutes or more."""

LEFT = 0.1
"""Share of a locked winch's tension that is left where the winch follows the whole sea: the cable has inertia too."""

HOLD = 300.0
"""A highest tension that was once too low must be enough for so long before the winch gives way again [s]."""


class TensionNeed:
    """The tension that peaks of the sea bring beyond what the winch can follow.

    What the winch follows hardly changes the tension. What is beyond its limits it does not: of that share of a peak
    the tension is that of a locked winch. A highest tension below it would have the winch give way in every group of
    waves while it has nothing left to bring the unit back with.

    Parameters
    ----------
    window : memory of the waves [s]
    tick_period : [s]
    """

    def __init__(self, window: float, *, tick_period: float) -> None:
        self._stretch = RunningSigma(window, tick_period)

    def add(self, stretch: float) -> None:
        """Take in the `stretch` of the cable beyond that at rest, were the winch locked [m]."""
        self._stretch.add(stretch)

    def least_ratio(self, static_tension: float, stiffness: float, peak_use: float) -> float:
        """Return the least highest tension over the static one [-].

        Parameters
        ----------
        static_tension : [N]
        stiffness : of the cable [N/m]
        peak_use : peak of the boom tip over the winch's limits [-]
        """
        share = max(LEFT, 1.0 - 1.0 / peak_use) if peak_use > 0.0 else LEFT
        return 1.0 + share * PEAK * self._stretch.sigma * stiffness / static_tension


def in_words(least_ratio: float, ratio: float) -> str:
    """Return that a highest tension is below what compensation needs, and what to do about it.

    Parameters
    ----------
    least_ratio, ratio : what is needed and what is allowed, over the static tension [-]
    """
    needed = math.ceil(100.0 * least_ratio) / 100.0
    return (
        f"compensation needs a tension of {needed:.2f} times the static one in this sea; the highest allowed is "
        f"{ratio:.2f} times: raise limits.maximum_tension_ratio or wait for a lower sea"
    )
