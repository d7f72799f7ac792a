"""What must hold before the winch begins to follow the sea; a closed gate says which it is and by how much."""

from __future__ import annotations

import math

from heave_node.interface.alarm import Alarm

from winch_controller_node.estimation.loop_tick import LoopTick
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import EntryParameters
from winch_controller_node.supervision.checks import RunningSigma

PEAK = 3.0
"""Peak amplitude over standard deviation of a sea, over some minutes."""

PEAK_OVER_SIGNIFICANT = PEAK / 2.0
"""Peak over significant amplitude."""

INNOVATION_WEIGHT = 0.02
"""Weight of the newest normalised innovation in its running mean square."""

LEAST_EXCESS = 0.1
"""Excess over 1 of a mean square of innovations that counts as settled."""

UNREAD = 10.0
"""Usual intervals without a reading after which a measurement is no longer judged: its sensor is lost, or serves as a
cross-check only."""

ENCODER_ROW = "payout"
"""Readings of the encoder are never far off for long: the winch is identified by them."""


class EntryGates:
    """Watches sea and estimate while the winch stands.

    Parameters
    ----------
    parameters : thresholds
    window : memory of the waves [s]
    tick_period : [s]
    """

    def __init__(self, parameters: EntryParameters, *, window: float, tick_period: float) -> None:
        self._parameters = parameters
        self._heave = RunningSigma(window, tick_period)
        self._mean_squares: dict[str, float] = {}
        self._readings: dict[str, int] = {}
        self._newest: dict[str, float] = {}
        self._time = 0.0
        self._dt = tick_period

    def observe(self, tick: LoopTick) -> None:
        """Take a tick in."""
        self._heave.add(tick.boom_tip.heave)
        self._time += self._dt
        for name, innovation in tick.sensed.innovations.items():
            if name != ENCODER_ROW and math.isfinite(innovation.nis):
                before = self._mean_squares.get(name, 1.0)
                self._mean_squares[name] = before + INNOVATION_WEIGHT * (innovation.nis - before)
                self._readings[name] = self._readings.get(name, 0) + 1
                self._newest[name] = self._time
        self._reset_unread()

    def _reset_unread(self) -> None:
        for name, newest in self._newest.items():
            if self._time - newest > UNREAD * self._interval(name):
                self._mean_squares[name] = 1.0

    def _interval(self, name: str) -> float:
        """Return the usual time between two innovations of a measurement [s]."""
        return self._newest[name] / self._readings[name]

    def for_compensation(self, payout: float, limits: WinchLimits, demand: float, largest_demand: float) -> str:
        """Return why compensation may not begin, in words; empty when it may.

        Parameters
        ----------
        payout : mean, about which it would work [m]
        limits : of the winch
        demand, largest_demand : significant amplitude of the boom tip over the winch's limits, and the most of it
        """
        reasons = [self._innovations(), self._range(payout, limits)]
        if demand > largest_demand:
            reasons.append(f"the sea demands {demand:.1f} times the winch's limits, limit {largest_demand:g}")
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

    def _innovations(self) -> str:
        """Return which readings are too far from what the estimator expects."""
        most = self._parameters.innovation
        far = {name: math.sqrt(value) for name, value in self._mean_squares.items() if value > most**2}
        return "; ".join(
            f"innovations of {name} are {value:.1f} standard deviations, limit {most:g}: about "
            f"{self._settling_time(name):.0f} s more to settle"
            for name, value in far.items()
        )

    def _settling_time(self, name: str) -> float:
        """Return after how long the innovations of a measurement are small enough, if they are as predicted [s]."""
        excess, allowed = self._mean_squares[name] - 1.0, self._parameters.innovation**2 - 1.0
        readings = math.log(max(excess / max(allowed, LEAST_EXCESS), 1.0)) / INNOVATION_WEIGHT
        return readings * self._interval(name)

    def _range(self, payout: float, limits: WinchLimits) -> str:
        """Return how the range of payout does not hold the waves."""
        amplitude = PEAK * self._heave.sigma
        room = min(payout - limits.payout_minimum, limits.payout_maximum - payout)
        if room >= amplitude:
            return ""
        return (
            f"a payout of {payout:.1f} m leaves {max(room, 0.0):.1f} m to the end of the range, and the sea needs "
            f"{amplitude:.1f} m"
        )
