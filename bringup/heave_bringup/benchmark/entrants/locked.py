"""The winch locked: what no compensation leaves. The operator's target is followed."""

from __future__ import annotations

from heave_bringup.benchmark.interface import Command, Facts, Measurement


class Locked:
    """Follows the target and nothing else, by its rate and a slow pull.

    Parameters
    ----------
    facts : of the case
    """

    def __init__(self, facts: Facts) -> None:
        del facts

    def step(self, measurement: Measurement) -> Command:
        """See `Controller.step`."""
        target = measurement.target
        pull = 0.2 * (target.payout - measurement.winch.payout)
        return Command(target.payout_rate + pull, target.payout)
