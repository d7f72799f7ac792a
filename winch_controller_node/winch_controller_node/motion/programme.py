"""The programme of a run: moves and modes at given times, as an operator would ask for them."""

from __future__ import annotations

from dataclasses import dataclass

from winch_controller_node.parameters.laws import ProgrammeParameters


@dataclass(frozen=True)
class ProgrammeStep:
    """One thing to be done at `time` [s]: a `mode`, or where that is empty a move of the mean payout.

    It goes to `payout` [m] at `speed` [m/s].
    """

    time: float
    mode: str = ""
    payout: float = 0.0
    speed: float = 0.0


class Programme:
    """Hands out each step once, when its time has come.

    `parameters` : times, moves and modes
    """

    def __init__(self, parameters: ProgrammeParameters) -> None:
        speeds = parameters.move_speeds or (0.0,) * len(parameters.move_times)
        moves = [
            ProgrammeStep(time, payout=payout, speed=speed)
            for time, payout, speed in zip(parameters.move_times, parameters.move_payouts, speeds, strict=True)
        ]
        modes = [
            ProgrammeStep(time, mode=mode) for time, mode in zip(parameters.mode_times, parameters.modes, strict=True)
        ]
        self._steps = sorted(moves + modes, key=lambda step: step.time)
        self._done = 0

    def due(self, time: float) -> list[ProgrammeStep]:
        """Return the steps whose time has come and that were not handed out before."""
        due = []
        while self._done < len(self._steps) and self._steps[self._done].time <= time:
            due.append(self._steps[self._done])
            self._done += 1
        return due
