"""What must hold before the winch begins to follow the sea, in words: a closed gate says by how much."""

from __future__ import annotations

import math

from heave_node.interface.alarm import Alarm

from winch_controller_node.core.supervision.guard_checks import PEAK
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.laws.parts.winch_limits import WinchLimits


def peaks_words(peak: float, most: float) -> str:
    """Return that the `peak` of the boom tip over the winch's limits is above the `most` that may be used."""
    return f"peaks of the boom tip need {100 * peak:.0f} % of the winch's limits, limit {100 * most:.0f} %"


def peaks_alarm(peak: float, most: float, share: float) -> Alarm | None:
    """Return how the peaks of the boom tip are above what a winch should be used for; None where they are not.

    Compensation need not wait for a lower sea: it begins with what it can have of this one.

    Parameters
    ----------
    peak : of the boom tip over the winch's limits
    most : that may be used
    share : of the sea that compensation begins with
    """
    if not peak > most:
        return None
    rest = "; motion beyond the limits stays" if share * peak > 1.0 else ""
    return ALARMS.alarm("SEA_ABOVE_WINCH", percent=100.0 * peak, limit=100.0 * most, authority=100.0 * share, rest=rest)


def range_words(payout: float, limits: WinchLimits, tip_sigma: float) -> str:
    """Return how the range of a winch with `limits` does not hold the waves about a `payout` [m].

    `tip_sigma` : standard deviation of the boom tip [m]
    """
    room = min(payout - limits.payout_minimum, limits.payout_maximum - payout)
    return (
        f"a payout of {payout:.1f} m leaves {max(room, 0.0):.1f} m to the end of the range, and the sea needs "
        f"{PEAK * tip_sigma:.1f} m"
    )


def hanging_words(share: float, wait: float) -> str:
    """Return why a unit whose landing was missed counts as hanging.

    `share` of its weight the cable carries; NaN: that is not known until a `wait` [s] is over.
    """
    if not math.isnan(share):
        return (
            f"the load is suspended: the cable carries {100.0 * share:.0f} % of its weight, and constant tension "
            "would drop it; land it first, or set tension.hanging"
        )
    return (
        f"averaging the tension for {wait:.0f} s more, to know whether the load is suspended: request it again "
        "then, or set tension.hanging"
    )
