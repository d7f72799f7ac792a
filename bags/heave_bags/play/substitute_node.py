"""A bag in the place of a node: plays what the node published, tick by tick, while the others run live.

It takes part in the tick protocol in the node's name, so that the others see no difference. In the place of the clock
master it steps the run. Messages go out in the tick in which they were published; the same sea through the same
scenario gives the same run, whatever recorded it.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from typing import Any

from heave_node.errors import NodeError
from heave_node.interface import topics
from heave_node.interface.topic import Role, Topic
from heave_node.parameters import parameter
from heave_node.ros.master import ClockMasterNode
from heave_node.ros.node import HeaveNode
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.ports import Output
from heave_node.ros.process import run_process
from heave_node.tick.tick import Tick

from heave_bags.errors import BagError
from heave_bags.mcap.reader import Bag
from heave_bags.play.tick_player import player_for

MASTER = topics.CLOCK.publisher


@dataclass(frozen=True)
class SubstituteParameters:
    """Which bag is played in place of which node."""

    bag: str = parameter("", description="The bag.")


class Substitute(HeaveNode):
    """What a substitute of a participant and one of the clock master have in common."""

    parameters_type = SubstituteParameters

    def on_build(self) -> None:
        """Open the bag and make the outputs of the node."""
        bag = Bag(self.parameters.bag)
        try:
            self.player = player_for(bag, self.name, self.run)
        except BagError as error:
            raise NodeError(str(error)) from error
        self.played: dict[str, Output] = {}
        for name in self.player.topics:
            wanted = self.player.name_in_run(name)
            if wanted == topics.DIAGNOSTICS.name:
                continue
            topic = bag.topics[name]
            latched = any(offer.durability == "transient_local" for offer in topic.qos)
            role = Role.LATCHED if latched else Role.STREAM
            self.played[name] = self.add_output(Topic(wanted, topic.type, self.name, role))

    def on_reset(self) -> None:
        """Begin the bag again."""
        self.player.restart()

    def play(self, tick: Tick) -> None:
        """Publish what the node published in this tick, its diagnostics included."""
        for name, data in self.player.take(tick.number):
            self.played.get(name, self._diagnostics).publish(data)

    def publish_diagnostics(self, tick: Tick) -> None:
        """Report nothing in `tick`: the diagnostics are those in the bag."""


class SubstituteParticipant(Substitute, ParticipantNode):
    """Stands in for a participant."""

    def on_tick(self, tick: Tick) -> None:
        """Play the tick."""
        self.play(tick)

    def on_left_out(self, tick: Tick) -> None:
        """See ParticipantNode: what the node published in the tick is left out too."""
        self.player.take(tick.number)


class SubstituteMaster(Substitute, ClockMasterNode):
    """Stands in for the clock master: it steps the run, but integrates nothing."""

    def on_readings(self, tick: Tick) -> None:
        """Play the tick."""
        self.play(tick)


def substitute_type(node: str) -> type[Any]:
    """Return the class of the substitute of `node`."""
    base = SubstituteMaster if node == MASTER else SubstituteParticipant
    return type(f"Substitute_{node}", (base,), {"name": node})


def main() -> None:
    """Run the substitute of the node named on the command line."""
    parser = argparse.ArgumentParser(prog="substitute", description=__doc__)
    parser.add_argument("node", help="name of the node to replace, such as wave_vessel")
    arguments, rest = parser.parse_known_args()
    run_process(substitute_type(arguments.node), [sys.argv[0], *rest])


if __name__ == "__main__":
    main()
