"""A drive given as an FMU takes part in each tick: `heave run SCENARIO --replace virtual_winch=fmu:FILE`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from cable_sim_node.conversions import WINCH_COMMAND, winch_command_of, winch_state_message
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import WinchState
from cable_sim_node.winch.parameters import WinchParameters
from heave_bringup.errors import CommandError
from heave_node.errors import NodeError
from heave_node.interface import topics
from heave_node.parameters import ParameterError
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.process import run_process
from heave_node.tick.tick import Tick

from heave_fmu.drive import FmuWinch, read_drive


class FmuWinchNode(ParticipantNode):
    """Steps the FMU `drive` with the command of tick k, and publishes its state at t_{k+1}."""

    name = "virtual_winch"
    parameters_type = WinchParameters
    after = ("winch_controller",)
    drive = Path()

    def on_build(self) -> None:
        """See HeaveNode."""
        try:
            self.winch = FmuWinch(read_drive(self.drive), tick_period=self.run.tick_period)
        except (CommandError, ParameterError) as error:
            raise NodeError(str(error)) from error
        self.state = self.add_output(topics.WINCH_STATE)
        self.command = self.add_input(topics.WINCH_COMMAND, WINCH_COMMAND, lifespan=self.parameters.command_timeout)
        self.top_tension = self.add_input(topics.CABLE_STATE, ("top_tension",), holds_ahead=True)

    def on_reset(self) -> None:
        """See HeaveNode: the FMU is reset."""
        try:
            self.winch.restart()
        except CommandError as error:
            raise NodeError(str(error)) from error

    def on_exit(self) -> None:
        """See HeaveNode."""
        if hasattr(self, "winch"):
            self.winch.close()

    def on_tick(self, tick: Tick) -> None:
        """See ParticipantNode."""
        commands, tensions = self.take(self.command), self.take(self.top_tension)
        command = winch_command_of(commands[-1]) if commands else None
        state = self._moved(tick, command, tensions[-1].numbers[0] if tensions else None)
        self.state.publish(winch_state_message(state, tick.end_nanoseconds))

    def _moved(self, tick: Tick, command: WinchCommand | None = None, tension: float | None = None) -> WinchState:
        try:
            return self.winch.step(tick.number, command, tension)
        except CommandError as error:
            raise NodeError(str(error)) from error

    def on_inactive_tick(self, tick: Tick) -> None:
        """See ParticipantNode: the drive goes on without a command."""
        self._moved(tick)

    def on_left_out(self, tick: Tick) -> None:
        """See ParticipantNode: the drive goes on."""
        self._moved(tick)


def main() -> None:
    """Run the drive named on the command line."""
    parser = argparse.ArgumentParser(prog="winch_node", description=__doc__)
    parser.add_argument("drive", type=Path, help="FMU, or map of one")
    arguments, rest = parser.parse_known_args()
    FmuWinchNode.drive = arguments.drive
    run_process(FmuWinchNode, [sys.argv[0], *rest])


if __name__ == "__main__":
    main()
