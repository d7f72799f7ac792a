"""What must hold before the winch begins to follow the sea; a closed gate says which it is and by how much."""

from __future__ import annotations

from heave_node.interface.alarm import Alarm

from winch_controller_node.core.supervision.attempts import too_much
from winch_controller_node.core.supervision.guard_checks import PEAK, SIGNIFICANT
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import EntryParameters

PEAK_OVER_SIGNIFICANT = PEAK / SIGNIFICANT
"""Peak over significant amplitude."""


class EntryGates:
    """Watches the sea while the winch stands.

    Parameters
    ----------
    parameters : thresholds
    """

    def __init__(self, parameters: EntryParameters) -> None:
        self._parameters = parameters
        self._tip_sigma = 0.0

    def observe(self, tip_sigma: float) -> None:
        """Take in a tick: the standard deviation of the boom tip over the last waves, `tip_sigma` [m]."""
        self._tip_sigma = tip_sigma

    def for_compensation(self, payout: float, limits: WinchLimits, residual: float, largest: float) -> str:
        """Return why compensation may not begin, in words; empty when it may.

        Parameters
        ----------
        payout : mean, about which it would work [m]
        limits : of the winch
        residual, largest : motion that it is predicted to leave, over that with the winch locked, and the most of it
        """
        reasons = [self._range(payout, limits), too_much(residual, largest) if residual > largest else ""]
        return "; ".join(reason for reason in reasons if reason)

    def for_tension(self, payout: float, limits: WinchLimits, demand: float) -> str:
        """Return why constant tension may not begin, in words; empty when it may.

        The winch must follow the whole boom tip.

        Parameters
        ----------
        payout : mean, about which it would work [m]
        limits : of the winch
        demand : significant amplitude of the boom tip over the winch's limits
        """
        peak, most = PEAK_OVER_SIGNIFICANT * demand, self._parameters.peak_use
        reasons = [self._range(payout, limits)]
        if peak > most:
            reasons.append(
                f"peaks of the boom tip need {100 * peak:.0f} % of the winch's limits, limit {100 * most:.0f} %"
            )
        return "; ".join(reason for reason in reasons if reason)

    def peaks_alarm(self, demand: float, share: float) -> Alarm | None:
        """Return how the peaks of the boom tip are above what a winch should be used for; None where they are not.

        Compensation need not wait for a lower sea: it begins with what it can have of this one.

        Parameters
        ----------
        demand : significant amplitude of the boom tip over the winch's limits
        share : of the sea that compensation begins with
        """
        peak, most = PEAK_OVER_SIGNIFICANT * demand, self._parameters.peak_use
        if peak <= most:
            return None
        rest = "; motion beyond the limits stays" if share * peak > 1.0 else ""
        return ALARMS.alarm(
            "SEA_ABOVE_WINCH", percent=100.0 * peak, limit=100.0 * most, authority=100.0 * share, rest=rest
        )

    def _range(self, payout: float, limits: WinchLimits) -> str:
        """Return how the range of payout does not hold the waves."""
        amplitude = PEAK * self._tip_sigma
        room = min(payout - limits.payout_minimum, limits.payout_maximum - payout)
        if room >= amplitude:
            return ""
        return (
            f"a payout of {payout:.1f} m leaves {max(room, 0.0):.1f} m to the end of the range, and the sea needs "
            f"{amplitude:.1f} m"
        )
