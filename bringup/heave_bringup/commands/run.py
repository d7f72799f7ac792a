"""`heave run`: run a scenario, check that the bag is complete, print its figures of merit, write the report."""

from __future__ import annotations

import argparse
import importlib
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path

from heave_bags.mcap.reader import Bag
from heave_msgs.msg import TickStatus
from heave_node.parameters import ParameterError

from heave_bringup.bag_paths import bag_folders
from heave_bringup.errors import CommandError
from heave_bringup.network import set_up_transport
from heave_bringup.output import write_result
from heave_bringup.run.node_table import NODE_BY_NAME
from heave_bringup.run.run import RunFolder, new_run_folder, run_scenario
from heave_bringup.scenarios import Scenario, load_scenario

AFTERMATH = "heave_bringup.run.aftermath"


def execute(options: argparse.Namespace) -> None:
    """Run, check, analyse, report."""
    set_up_transport(network=options.network)
    scenario = load_scenario(options.scenario, settings=options.set, common=_common_values(options))
    folder = new_run_folder(scenario.name, options.bag)
    # What judges the run takes seconds to load: time that the nodes need to find each other.
    threading.Thread(target=importlib.import_module, args=(AFTERMATH,)).start()
    outcome = run_scenario(scenario, folder, substitutes=_substitutes(options.from_bag))
    if scenario.run.is_lockstep:
        _check_complete(folder.bag, outcome.status)
    aftermath = importlib.import_module(AFTERMATH)
    table, figures = aftermath.judge(folder.bag, None if options.no_report else folder.report)
    where = _where(scenario, folder, with_report=not options.no_report)
    text = "\n".join([table, "", *_what_went_wrong(outcome.alarms), *where])
    write_result(options, text, {**figures, "alarms": outcome.alarms, "folder": str(folder.path)})


def _common_values(options: argparse.Namespace) -> Mapping[str, object]:
    """Return the command's own options as parameters of every node."""
    given = {
        "pacing": options.pacing,
        "duration": options.duration,
        "seed": options.seed,
        "external": options.external or None,
    }
    return {name: value for name, value in given.items() if value is not None}


def _substitutes(settings: Sequence[str]) -> dict[str, Path]:
    """Return which bag is played in whose place, from the command's NODE=BAG texts."""
    chosen: dict[str, Path] = {}
    for setting in settings:
        node, _, bag = setting.partition("=")
        if node not in NODE_BY_NAME or not bag:
            raise ParameterError(f"--from-bag {setting}: must be NODE=BAG, NODE one of {', '.join(NODE_BY_NAME)}")
        (chosen[node],) = bag_folders([Path(bag).resolve()])
        if not chosen[node].exists():
            raise ParameterError(f"--from-bag {setting}: there is no {bag}")
    return chosen


def _check_complete(bag: Path, status: TickStatus) -> None:
    """Refuse a lockstep bag that lacks a message which a node says it published."""
    recorded = {name: topic.message_count for name, topic in Bag(bag).topics.items()}
    for topic, published in zip(status.topics, status.published, strict=True):
        if recorded.get(topic, 0) < published:  # another recorder beside the run speaks on /diagnostics, too
            raise CommandError(f"{bag}: holds {recorded.get(topic, 0)} of {published} messages of {topic}")


def _what_went_wrong(alarms: Sequence[str]) -> list[str]:
    return ["what the nodes called an error:", *(f"  {alarm}" for alarm in alarms), ""] if alarms else []


def _where(scenario: Scenario, folder: RunFolder, *, with_report: bool) -> list[str]:
    lines = [f"scenario  {scenario.path}", f"bag       {folder.bag}"]
    return [*lines, f"report    {folder.report}"] if with_report else lines
