"""A controller that takes part in each tick, in lockstep: heave run b2_calm_300 --replace winch_controller=lockstep.

The law is that of controller.py. The contract is docs/contract.md.
"""

import sys
from dataclasses import dataclass

from heave_msgs.msg import MruSample, WinchCommand
from heave_node.interface import topics
from heave_node.parameters import parameter
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.process import run_node
from heave_node.tick.tick import Tick

BRAKED = 2.0  # [s]


@dataclass(frozen=True)
class Parameters:
    ahead: float = parameter(0.4, "s", 0.0, 5.0, "Time that a command takes to act.")
    pull: float = parameter(0.05, "1/s", 0.0, 1.0, "Pull to the middle of the drum.")


class Controller(ParticipantNode):
    name = "winch_controller"
    parameters_type = Parameters
    after = ("wave_vessel",)

    def on_build(self) -> None:
        self.mru = self.add_input(topics.MRU)
        self.winch = self.add_input(topics.WINCH_STATE)
        self.command = self.add_output(topics.WINCH_COMMAND)

    def on_reset(self) -> None:
        """Nothing is kept from one run to the next."""

    def on_tick(self, tick: Tick) -> None:
        self.take(self.mru)
        self.take(self.winch)
        sample, state = self.mru.latest, self.winch.latest
        command = WinchCommand(sequence=tick.number, brake=True)
        command.header.stamp = tick.stamp
        if tick.time > BRAKED and sample and state and sample.status == MruSample.STATUS_OK:
            command.brake = False
            command.payout = sample.heave
            command.payout_rate = sample.heave_rate + self.parameters.ahead * sample.heave_acceleration
            command.payout_rate -= self.parameters.pull * state.encoder_payout
        self.command.publish(command)


sys.exit(run_node(Controller))
