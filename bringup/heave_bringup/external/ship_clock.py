"""The clock of a run in which the plant is the ship itself: it begins ticks by the wall clock, and simulates nothing.

`heave run --replace cable_sim=external` starts it in place of the plant. It leads the tick protocol, supplies `/clock`
and the start barrier, pauses and ends the run; the readings come from the ship's sensors.
"""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.ros.master import ClockMasterNode
from heave_node.ros.process import run_process

NAME = "ship_clock"


@dataclass(frozen=True)
class ShipClockParameters:
    """The clock has no parameters but those of the run."""


class ShipClock(ClockMasterNode):
    """A clock master without a plant."""

    name = NAME
    parameters_type = ShipClockParameters

    def on_build(self) -> None:
        """See HeaveNode: there is nothing to build."""

    def on_reset(self) -> None:
        """See HeaveNode: the ship cannot be put back; the run's time starts again."""


def main() -> None:
    """Run the clock."""
    run_process(ShipClock)


if __name__ == "__main__":
    main()
