"""`heave run`: run a scenario, check that the bag is complete, print its figures of merit, write the report."""

from __future__ import annotations

import argparse
import importlib
import shlex
import sys
import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from heave_node.criteria import Criterion
from heave_node.parameters import ParameterError
from heave_node.run_parameters import LOCKSTEP as IN_LOCKSTEP
from heave_node.run_parameters import REALTIME
from heave_node.scenario import WILDCARD

from heave_bringup.commands.arguments import add_baseline, add_full, add_namespace, add_network, add_scenario
from heave_bringup.errors import AnotherRunError, CommandError, VerdictError
from heave_bringup.interrupts import raise_if_interrupted
from heave_bringup.nodes import ADVISER, ENVELOPE, node_forks, nodes_to_start
from heave_bringup.replacements import (
    BAG,
    EXTERNAL,
    LOCKSTEP,
    NONE,
    Replacements,
    add_replace,
    external_settings,
    parse_replacements,
)
from heave_bringup.settings import Setting, parse_setting

if TYPE_CHECKING:
    from heave_bringup.run.evaluation import Evaluation
    from heave_bringup.run.run import Composed, RunFolder
    from heave_bringup.scenarios import Scenario

SUMMARY = "Simulate a scenario: start the nodes, record every topic, print figures of merit, write a report."
EXAMPLES = (
    "heave run b2_calm_300 --duration 600 --set system.sea.peak_period=7",
    "heave run b3_deep_900 --require 'unit_sigma_m<0.01' --require 'compensating_percent>=95'",
)

EVALUATION = "heave_bringup.run.evaluation"
SPECTRA = "scipy.signal"
"""What a report computes its spectra by."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_scenario(parser)
    parser.add_argument(
        "--pacing", choices=(IN_LOCKSTEP, REALTIME), help="as fast as possible, or paced by the wall clock"
    )
    parser.add_argument("--duration", type=float, metavar="S", help="simulated seconds")
    parser.add_argument("--seed", type=int, metavar="N", help="seed of all random numbers")
    parser.add_argument(
        "--bag", type=Path, metavar="DIR", help="folder for bag and report (default: runs/SCENARIO-NNN)"
    )
    _add_places(parser)
    add_namespace(
        parser, "put nodes, topics and clock of the run under /NAME, so that several runs can share a ROS domain"
    )
    add_network(parser)
    parser.add_argument(
        "--require",
        action="append",
        default=[],
        metavar="KPI<VALUE",
        help="add a criterion to the verdict, such as significant_residual<5cm; a FAILED verdict gives exit status 3",
    )
    parser.add_argument(
        "--quiet",
        action="store_true",
        help="print only alarms, warnings and errors; see --json and the exit status for the result",
    )
    add_full(parser)
    parser.add_argument("--no-report", action="store_true", help="do not write the HTML report")
    add_baseline(parser)


def _add_places(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` say who takes the place of a node, and where the nodes run."""
    add_replace(
        parser,
        f"replace NODE; repeatable. {EXTERNAL}: by hardware or another program, in real time (the "
        "topic of a sensor, like winch/load_cell, replaces that sensor only; CLOCK is that of its stamps: simulated, "
        f"own, none, or detected; S its latency [s]). {LOCKSTEP}: by your program, which takes part in every cycle "
        f"(docs/contract.md); in place of cable_sim, start ship_clock as clock master. {BAG}: by its messages in that "
        "bag. fmu: virtual_winch only, by an FMU or a map that names one (.yaml); its code runs with your rights, so "
        f"use only one that you trust. {NONE}: {ADVISER} only; the controller keeps its nominal parameters",
    )
    parser.add_argument(
        "--envelope",
        action="store_true",
        help=f"put {ENVELOPE} between controller and winch, to limit the commands of your own controller",
    )
    parser.add_argument(
        "--composed",
        action="store_true",
        help="run all nodes in one process: half the CPU time, the same bag. Services and parameters work as usual; "
        "other processes receive most topics at 10 Hz only",
    )
    parser.add_argument(
        "--publish", action="store_true", help="with --composed: publish every message to other processes too"
    )


def execute(options: argparse.Namespace) -> None:
    """Run, check, analyse, report, as `options` say."""
    from heave_node.ros.transport.watchdog import check_memory

    check_memory()  # before the libraries that want most of it
    from heave_bringup.network import ANOTHER_RUN, only_run_in_domain, set_up_transport
    from heave_bringup.progress import be_quiet
    from heave_bringup.scenarios import load_scenario

    required = _required(options.require)
    if options.quiet:
        be_quiet()
    set_up_transport(network=options.network)
    replaced = parse_replacements(options.replace)
    settings = [*options.set, *_own_settings(options), *external_settings(replaced.external)]
    scenario = with_envelope(load_scenario(options.scenario, settings=settings), is_asked=options.envelope)
    scenario = replaced.apply(scenario)
    _check(options, scenario, replaced)
    with only_run_in_domain(options.namespace or "") as is_only:  # `run_scenario` asks again, after what takes seconds
        if not is_only:
            raise AnotherRunError(ANOTHER_RUN)
    with node_forks(1 if options.composed else len(nodes_to_start(scenario.run, replaced.lockstep))) as forks:
        from heave_bringup.run.run import new_run_folder, run_scenario

        folder = new_run_folder(scenario.name, options.bag)
        _announce(options, scenario, required, replaced.entries)
        # What judges the run takes seconds to load: time that the nodes need to find each other.
        judging = [EVALUATION] if options.no_report else [EVALUATION, SPECTRA]
        threading.Thread(target=lambda: [importlib.import_module(module) for module in judging]).start()
        outcome = run_scenario(
            scenario,
            folder,
            replaced=replaced,
            namespace=options.namespace or "",
            composed=_composed(options),
            forks=forks,
        )
    evaluation = importlib.import_module(EVALUATION)
    raise_if_interrupted()
    if scenario.run.is_lockstep:
        evaluation.check_complete(folder.bag, outcome.status)
    report = None if options.no_report else folder.report
    result = evaluation.evaluate(scenario, folder.bag, report, required=required, baseline=options.baseline)
    _write(options, scenario, folder, result)
    unsound = [*outcome.strangers, *outcome.lost]
    if unsound:
        raise CommandError("; ".join(unsound))
    if result.verdict.failures:
        raise VerdictError(result.verdict.failures, str(report or folder.path))


def _check(options: argparse.Namespace, scenario: Scenario, replaced: Replacements) -> None:
    """Refuse, before anything starts, what this run cannot be; warn of what its files leave open."""
    from heave_bringup.output import warn
    from heave_bringup.run.before import check_design, check_files, check_rest, check_waves
    from heave_bringup.run.criteria import refuse_unknown

    for criterion in scenario.wanted:
        refuse_unknown(criterion, f"{scenario.path}: wanted")
    unread = {*scenario.run.external, *replaced.programs}
    unheard = [one for one in map(parse_setting, options.set) if one.target in unread]
    warn(f"{one.source}: {one.target} is replaced and does not read it" for one in unheard)
    _check_composed(options, [*scenario.run.external, *replaced.in_ticks])
    if "wave_vessel" not in unread:
        warn(check_files(scenario))
    if "winch_controller" not in unread:
        check_design(scenario)
    if "cable_sim" not in unread:
        check_rest(scenario)
    if not {"wave_vessel", "cable_sim"} & unread:
        warn(check_waves(scenario))
    replaced.check_bags(scenario.run)


def _announce(
    options: argparse.Namespace, scenario: Scenario, required: Sequence[Criterion], replaced: Sequence[str]
) -> None:
    """Write in the first line of a run what it will be judged by, or that it cannot be judged."""
    from heave_bringup.output import warn
    from heave_bringup.run.criteria import announce

    words = announce(scenario, required, replaced)
    if not words.is_judged:
        warn([words.text])
    elif not options.quiet:
        sys.stderr.write(f"{words.text}\n")


def _write(options: argparse.Namespace, scenario: Scenario, folder: RunFolder, result: Evaluation) -> None:
    """Write what a run into a `folder` gave: the `result` of its evaluation, for people or as JSON."""
    from heave_bringup.output import warn, write_result

    together = "all in one process" if options.composed else "a process each"
    places = [
        f"scenario  {scenario.path}",
        f"nodes     {together}",
        f"bag       {folder.bag}",
        *([] if options.no_report else [f"report    {folder.report}"]),
    ]
    reported = [
        *_reported("errors reported by the nodes:", result.errors),
        *_reported("compensation was lost:", result.losses),
        *_reported("warnings:", result.warnings),
    ]
    more = f"all figures: heave kpi {shlex.quote(str(folder.path))}"
    table = result.table if options.full else f"{result.headline}\n{more}"
    text = "\n".join([table, "", *reported, *places, "", *result.verdict.lines()])
    if options.quiet:
        warn(result.warnings)
    about = {"composed": options.composed, "folder": str(folder.path)}
    write_result(options, [] if options.quiet else text, {**result.figures, **about})


def _required(texts: Sequence[str]) -> list[Criterion]:
    """Return the criteria of the options --require."""
    if not texts:
        return []
    from heave_bringup.run.criteria import parse_requirement

    return [parse_requirement(text) for text in texts]


def _own_settings(options: argparse.Namespace) -> list[Setting]:
    """Return the command's own options as changes of the scenario."""
    return [
        Setting(WILDCARD, name, value, f"--{name} {value}")
        for name in ("pacing", "duration", "seed")
        if (value := getattr(options, name)) is not None
    ]


def with_envelope(scenario: Scenario, *, is_asked: bool) -> Scenario:
    """Return the scenario with the envelope as a node of its own, where it `is_asked` for."""
    if not is_asked or ENVELOPE in scenario.run.participants:
        return scenario
    return replace(scenario, run=replace(scenario.run, participants=(*scenario.run.participants, ENVELOPE)))


def _check_composed(options: argparse.Namespace, elsewhere: Sequence[str]) -> None:
    """Refuse nodes that are in another process in any case, `elsewhere`, where all are to share one."""
    if options.publish and not options.composed:
        raise ParameterError("--publish: goes with --composed; without it every message is published")
    if options.composed and elsewhere:
        raise ParameterError(
            f"--composed: {elsewhere[0]} is replaced, so the nodes need a process each; omit --composed"
        )


def _composed(options: argparse.Namespace) -> Composed | None:
    from heave_bringup.run.run import Composed

    return Composed(is_public=options.publish) if options.composed else None


def _reported(heading: str, lines: Sequence[str]) -> list[str]:
    return [heading, *(f"  {line}" for line in lines), ""] if lines else []
