"""`heave campaign`: many cases of a scenario, one table."""

from __future__ import annotations

import argparse

from heave_node.parameters import ParameterError

from heave_bringup.commands.command import Command


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument(
        "campaign",
        metavar="CAMPAIGN",
        help="a shipped campaign, or a file (format: heave_bringup/campaign/plan.py)",
    )
    parser.add_argument("--processes", type=int, metavar="N", help="default: one per processor")
    parser.add_argument("--duration", type=float, metavar="S", help="simulated time of a case, instead of the file's")
    parser.add_argument("--draws", type=int, metavar="N", help="only the first N of the file's random draws")


def execute(options: argparse.Namespace) -> None:
    """Run every case as `options` say; print what the unit and the winch did in each, then the summary."""
    from heave_bringup.campaign.plan import find_campaign, read_campaign
    from heave_bringup.campaign.report import case_table, summary_table, to_json
    from heave_bringup.campaign.runs import run_cases
    from heave_bringup.output import write_result
    from heave_bringup.progress import ProgressLine

    for option, value in (("--processes", options.processes), ("--draws", options.draws)):
        if value is not None and value < 1:
            raise ParameterError(f"{option} {value}: must be at least 1")
    campaign = read_campaign(find_campaign(options.campaign))
    campaign = campaign.shortened(duration=options.duration, draws=options.draws)
    cases = list(campaign.cases())
    results = []
    with ProgressLine() as progress:
        progress.show(f"{len(cases)} cases of {campaign.scenario}", 0.0)
        for result in run_cases(campaign, cases, options.processes):
            results.append(result)
            progress.show(f"case {len(results)} of {len(cases)}: {result.case.label}", len(results) / len(cases))
    results.sort(key=lambda result: result.case.number)
    write_result(options, [case_table(results), summary_table(results)], to_json(campaign, results))


COMMAND = Command(
    name="campaign",
    summary="Run many cases of a scenario (seeds, a grid, random draws) without ROS, and print a table.",
    examples=("heave campaign b9_model_error --json result.json",),
    add_arguments=add_arguments,
    execute=execute,
)
