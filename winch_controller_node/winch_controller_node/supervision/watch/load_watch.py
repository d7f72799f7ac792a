"""Alarms of the load and of the winch: a slack cable, too much tension, a winch that is at its limits too long."""

from __future__ import annotations

import math

from winch_controller_node.parameters.laws import AlarmParameters

QUIET_TIME = 60.0
"""An alarm is given again only after its cause was away for so long [s]: the groups of a swell are one cause."""

PUSH = -0.1
"""Share of the static tension below which no cable is slack: it cannot push."""


class Episode:
    """Tells the beginning of something that comes and goes.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._quiet_time = QUIET_TIME

    def begins(self, is_there: bool) -> bool:
        """Take in whether it `is_there` in this tick; return whether an episode begins with it."""
        was_quiet = self._quiet_time >= QUIET_TIME
        self._quiet_time = 0.0 if is_there else self._quiet_time + self._dt
        return is_there and was_quiet


class LoadWatch:
    """Watches the tension at the top, and how much of the time the winch is at its limits.

    Parameters
    ----------
    parameters : thresholds
    tick_period : [s]
    """

    def __init__(self, parameters: AlarmParameters, *, tick_period: float) -> None:
        self._parameters = parameters
        self._weight = tick_period / parameters.saturation_time
        self._slack, self._over, self._saturated = (Episode(tick_period) for _ in range(3))
        self._share_at_limit = 0.0

    def update(self, tension: float, static_tension: float, *, is_at_limit: bool) -> tuple[str, ...]:
        """Return what has just become wrong, in words.

        Parameters
        ----------
        tension : newest reading at the top [N]; NaN before the first
        static_tension : under the hanging unit at rest [N]
        is_at_limit : a limit of the winch's speed, acceleration or power acts
        """
        parameters = self._parameters
        self._share_at_limit += self._weight * (float(is_at_limit) - self._share_at_limit)
        share = tension / static_tension if math.isfinite(tension) and static_tension > 0.0 else 1.0
        words = []
        if self._slack.begins(share < parameters.slack_ratio):
            words.append(self._slack_words(tension, share))
        if self._over.begins(0.0 < parameters.tension_ratio < share):
            words.append(
                f"tension too high: {tension / 1e3:.1f} kN, {share:.2f} times the static one; "
                f"at most {parameters.tension_ratio:g} is allowed: look whether the unit is held fast; one that swings "
                "below a braked winch is damped by compensation; else wait for a lower sea, or raise "
                "alarms.tension_ratio where cable and winch bear more"
            )
        if self._saturated.begins(self._share_at_limit > parameters.saturation_share):
            words.append(
                f"winch saturated: at its limits for {100.0 * self._share_at_limit:.0f} % of the last "
                f"{parameters.saturation_time:g} s: the unit moves more than it would below a stronger winch; wait for "
                "a lower sea, or compensate a smaller factor"
            )
        return tuple(words)

    @staticmethod
    def _slack_words(tension: float, share: float) -> str:
        """Return what a `tension` [N] so far below the static one, a `share` of it, means."""
        if share < PUSH:
            return f"load_cell suspect: it reads {tension / 1e3:.1f} kN, and no cable pushes: look at its sign and zero"
        return (
            f"cable slack: tension {tension / 1e3:.1f} kN, {100.0 * share:.0f} % of the static one: a snap may follow; "
            "wait for a lower sea, or lower more slowly"
        )
