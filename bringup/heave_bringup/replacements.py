"""What takes the places of nodes in a run, as `--replace NODE=WHAT` says: hardware, a program, a bag, nothing."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bags.errors import BagError
from heave_node.extras import MissingExtraError, known_parts, load_part
from heave_node.interface import topics
from heave_node.interface.sensors import SENSORS
from heave_node.parameters import ParameterError
from heave_node.scenario import WILDCARD
from heave_node.tick.clock_rule import parse_clock

from heave_bringup.errors import CommandError
from heave_bringup.nodes import ADVISER, MASTER, NODE_BY_NAME, RECORDER
from heave_bringup.settings import Setting

if TYPE_CHECKING:
    from heave_node.run_parameters import RunParameters

    from heave_bringup.scenarios import Scenario


SUBSTITUTE = "heave_bags.play.substitute_node"
"""Module that plays a bag in the place of a node."""

FROM_BAG = "_from_bag"
"""Ends the name of what plays a bag in the place of a node: the parameters of the node itself do not concern it."""
_BAG = "bag:="
"""Before the path of the bag among the arguments."""


def program(node: str, bag: Path) -> list[str]:
    """Return the module that plays `bag` in the place of `node`, and its arguments; more of ROS may follow."""
    return [
        *(SUBSTITUTE, node, "--ros-args"),
        *("-r", f"__node:={node}{FROM_BAG}"),
        *("-p", f"{_BAG}{bag}"),
    ]


def bag_played(arguments: Sequence[str]) -> Path:
    """Return the bag that a `program` plays, by its module and arguments."""
    return Path(next(one.removeprefix(_BAG) for one in arguments if one.startswith(_BAG)))


OPTION = "--replace"
EXTERNAL, LOCKSTEP, BAG, NONE = "external", "lockstep", "bag", "none"
GROUP = "heave.replacements"
"""Group of entry points that replace a node, by kind: functions of the node and of what follows the kind
(NODE=KIND:WHAT) that check it and return module and arguments of the program to start.
"""
FORMS = f"{EXTERNAL}[:CLOCK[:S]]|{LOCKSTEP}|{BAG}:DIR|fmu:FILE|{NONE}"


@dataclass(frozen=True)
class Replacements:
    """What takes the places of nodes."""

    # outside the ticks, NODE or NODE=CLOCK[:LATENCY] each; a sensor's topic may stand for NODE
    external: tuple[str, ...] = ()
    lockstep: tuple[str, ...] = ()  # nodes in whose place somebody else's program takes part in each tick
    # module and arguments that are started in the place of a node, by node
    programs: Mapping[str, list[str]] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()  # nodes in whose place there is nothing

    @property
    def in_ticks(self) -> list[str]:
        """Nodes in whose place a bag or another program takes part in each tick."""
        return [*self.programs, *self.lockstep]

    @property
    def played(self) -> list[str]:
        """Nodes in whose place a bag takes part."""
        return [node for node, (module, *_) in self.programs.items() if module == SUBSTITUTE]

    def check_bags(self, run: RunParameters) -> None:
        """Refuse a bag that cannot stand in for its node in the whole of a `run`; raises ParameterError."""
        if not self.played:
            return
        from heave_bags.mcap.reader import Bag  # noqa: PLC0415 (few runs need it)
        from heave_bags.play.tick_player import player_for  # noqa: PLC0415

        try:
            for node in self.played:
                player_for(Bag(bag_played(self.programs[node])), node, run)
        except BagError as error:
            raise ParameterError(f"{OPTION}: {error}") from error

    @property
    def entries(self) -> list[str]:
        """What the bag of a run says of `in_ticks`: NODE, or NODE=bag."""
        return [f"{node}={BAG}" if node in self.played else node for node in self.in_ticks]

    def apply(self, scenario: Scenario) -> Scenario:
        """Return the `scenario` without what is left out; raise ParameterError where another takes no part in it."""
        run = scenario.run
        able = [name for name in (MASTER, *run.participants) if name != RECORDER and name not in run.external]
        for node in self.lockstep:
            if node not in able:
                raise ParameterError(f"{OPTION} {node}={LOCKSTEP}: NODE must be one of {', '.join(able)}")
        stay = tuple(name for name in run.participants if name not in self.left_out)
        return replace(scenario, run=replace(run, participants=stay, foreign=self.lockstep))


def add_replace(parser: argparse.ArgumentParser, help_: str, forms: str = FORMS, *, required: bool = False) -> None:
    """Let the user of a command, by its `parser`, replace nodes in the `forms` that are possible; `help_` is of the
    option, and `required`: at least one must be given.
    """
    parser.add_argument(
        OPTION, action="append", default=[], metavar=f"NODE={forms}", required=required, help=help_.replace("%", "%%")
    )


def parse_replacements(texts: Iterable[str], option: str = OPTION, kinds: Sequence[str] = ()) -> Replacements:
    """Return what `texts`, NODE=WHAT each, put in the places of nodes.

    Parameters
    ----------
    texts : of the option
    option : as the user writes it; opens error messages
    kinds : that are possible; none: all

    Raises ParameterError, in one line, for what is none, and CommandError where the extra for it is missing.
    """
    found = Replacements()
    taken: set[str] = set()
    for text in texts:
        source = f"{option} {text}".replace(":= ", ":=")
        node, _, what = text.partition("=")
        kind, _, detail = what.partition(":")
        known = (EXTERNAL, LOCKSTEP, BAG, NONE, *known_parts(GROUP))
        if not node or kind not in (kinds or known):
            raise ParameterError(f"{source}: must be NODE=WHAT, WHAT one of {', '.join(kinds or dict.fromkeys(known))}")
        if kind != EXTERNAL and node not in NODE_BY_NAME:
            raise ParameterError(f"{source}: no such node: {node}; known: {', '.join(NODE_BY_NAME)}")
        if node in taken:
            raise ParameterError(f"{source}: {node} is replaced already")
        taken.add(node)
        found = _with(found, node, kind, detail, source)
    return found


def _with(found: Replacements, node: str, kind: str, detail: str, source: str) -> Replacements:
    if kind == EXTERNAL:
        _check_external(node, detail, source)
        return replace(found, external=(*found.external, f"{node}={detail}" if detail else node))
    if kind in (LOCKSTEP, NONE) and detail:
        raise ParameterError(f"{source}: nothing follows {kind}")
    if kind == LOCKSTEP:
        return replace(found, lockstep=(*found.lockstep, node))
    if kind == NONE:
        if node != ADVISER:
            raise ParameterError(f"{source}: NODE must be {ADVISER}, the only node that can be left out")
        return replace(found, left_out=(*found.left_out, node))
    if not detail:
        raise ParameterError(f"{source}: must be NODE={kind}:{'DIR' if kind == BAG else 'FILE'}")
    program = _bag(node, detail, source) if kind == BAG else _of_extra(node, kind, detail, source)
    return replace(found, programs={**found.programs, node: program})


def _check_external(name: str, clock: str, source: str) -> None:
    known = [*NODE_BY_NAME, *(sensor.topic.name for sensor in SENSORS.values()), topics.CRANE_POSE.name]
    if name not in known:
        raise ParameterError(f"{source}: no such node or sensor topic: {name}; known: {', '.join(known)}")
    if clock:
        try:
            parse_clock(f"{name}={clock}")
        except ValueError as error:
            raise ParameterError(f"{source}: {error}") from error


def _bag(node: str, detail: str, source: str) -> list[str]:
    from heave_bags.mcap.read.folder import bag_of  # noqa: PLC0415 - few runs need it

    bag = bag_of(Path(detail).resolve())
    if not bag.exists():
        raise ParameterError(f"{source}: no such bag: {detail}")
    return program(node, bag)


def _of_extra(node: str, kind: str, detail: str, source: str) -> list[str]:
    try:
        program: list[str] = load_part(GROUP, kind, source)(node, detail)
    except MissingExtraError as error:
        raise CommandError(str(error)) from error
    return program


def external_settings(texts: Sequence[str], source: str = "") -> list[Setting]:
    """Return the changes by which real parts take the places of simulated ones, and the controller expects latencies.

    Each of `texts` is NODE[=CLOCK[:LATENCY]], or a sensor's topic in the place of NODE. `source` is what the user
    wrote, to open error messages; "": the option of a command line.
    """
    source = source or " ".join(f"{OPTION} {text.partition('=')[0]}={EXTERNAL}" for text in texts)
    names = [text.partition("=")[0] for text in texts]
    clocks = [text for text in texts if "=" in text]
    given = {"external": names, "external_clocks": clocks}
    found = [Setting(WILDCARD, name, value, source) for name, value in given.items() if value]
    late = {place: stamping.latency for place, stamping in map(parse_clock, clocks) if stamping.latency}
    return found + [
        Setting("winch_controller", f"sensors.{sensor.name}.latency", late[place], source)
        for sensor in SENSORS.values()
        for place in (sensor.topic.name, sensor.topic.publisher)
        if place in late
    ]
