"""`heave campaign`: many cases of a scenario, one table."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.arguments import SAME_SEA, add_settings, add_workers
from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    from heave_bringup.output import FittedTable
    from rich.table import Table

    from heave_studies.campaign.plan import Campaign

SUMMARY = "Run many cases of a scenario (seeds, a grid, random draws) without ROS and print a table."
EXAMPLES = (
    "heave campaign b2_calm_300 --vary winch_controller.law=off,lqg,mpc --seeds 3",
    "heave campaign b9_model_error --json result.json",
    "heave campaign b9_model_error --output b9.parquet --plot b9.svg",
    "heave campaign --case b9.parquet:17",
    "heave campaign b3_robustness --no-baseline --output b3.parquet --tornado b3.svg",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument(
        "campaign",
        metavar="CAMPAIGN",
        nargs="?",
        help="a shipped campaign or a file (format: heave_studies/campaign/campaign_file.py); with --vary, a scenario",
    )
    parser.add_argument(
        "--case",
        metavar="FILE.parquet:CASE",
        help="write the scenario of one case of a table from --output, to run it over ROS (with any files it "
        "needs that no longer exist)",
    )
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="NODE.PARAM=V,V,...",
        help="run scenario CAMPAIGN with each of these values; repeatable: all combinations",
    )
    parser.add_argument("--seeds", type=int, metavar="N", help="number of seeds per case, instead of the file's")
    add_settings(parser)
    add_workers(parser)
    parser.add_argument(
        "--baseline",
        action=argparse.BooleanOptionalAction,
        default=True,
        help=f"also show {SAME_SEA}; each case is run twice (default: yes)",
    )
    parser.add_argument("--duration", type=float, metavar="S", help="simulated time per case, instead of the file's")
    parser.add_argument("--draws", type=int, metavar="N", help="only the first N of the file's random draws")
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE.parquet",
        help="result table; any case can be run again from it (--case FILE.parquet:CASE). Results are saved "
        "as they arrive; repeat the command to resume. With --case: the scenario file to write",
    )
    parser.add_argument("--csv", type=Path, metavar="FILE", help="the figures of every case as CSV")
    parser.add_argument(
        "--plot",
        type=Path,
        metavar="FILE",
        help="plot (.png, .svg, .pdf) against what was varied",
    )
    parser.add_argument(
        "--tornado",
        type=Path,
        metavar="FILE",
        help="plot (.png, .svg, .pdf) of what matters: rank correlation of the figure with each drawn parameter",
    )
    parser.add_argument(
        "--kpi", default="unit_sigma_m", metavar="KPI", help="figure of merit to plot (default: unit_sigma_m)"
    )


def execute(options: argparse.Namespace) -> None:
    """Run every case as `options` say; print what the unit and the winch did in each, then the summary."""
    if options.case is not None:
        _write_case(options)
        return
    if options.campaign is None:
        raise ParameterError("name a campaign, or with --vary a scenario")
    from heave_bags.analyse.kpi_set import DEFINITION_OF
    from heave_bringup.output import check_output, write_result

    from heave_studies.campaign import picture
    from heave_studies.campaign.report import case_table, left_out, remarks, summary_table, to_json, without_scenario
    from heave_studies.campaign.sensitivity import check_enough, influence_table, influences, save_tornado
    from heave_studies.campaign.study import run_study
    from heave_studies.campaign.table import check_any_ran

    for option, value in (("--processes", options.processes), ("--draws", options.draws), ("--seeds", options.seeds)):
        if value is not None and value < 1:
            raise ParameterError(f"{option} {value}: must be at least 1")
    if options.kpi not in DEFINITION_OF:
        raise ParameterError(f"--kpi {options.kpi}: is not a figure of merit; known: {', '.join(DEFINITION_OF)}")
    check_output("--output", options.output, (".parquet",))
    check_output("--csv", options.csv, (".csv",))
    check_output("--plot", options.plot, picture.ENDINGS)
    check_output("--tornado", options.tornado, picture.ENDINGS)
    campaign = _campaign(options).shortened(duration=options.duration, draws=options.draws, seeds=options.seeds)
    if options.tornado is not None:
        check_enough(campaign)
    frame = run_study(
        campaign,
        output=options.output,
        processes=options.processes,
        dask=options.dask,
        has_baseline=options.baseline,
    )
    if options.csv is not None:
        without_scenario(frame).to_csv(options.csv, index=False)
    if options.plot is not None:
        picture.save_picture(frame, options.kpi, options.plot)
    parts: list[str | Table | FittedTable] = [case_table(frame), *_text(remarks(frame)), *left_out(frame)]
    parts.append(summary_table(frame))
    result = to_json(campaign, frame)
    if options.tornado is not None:
        found = influences(frame, options.kpi)
        save_tornado(found, options.kpi, options.tornado)
        parts.append(influence_table(found, options.kpi))
        result["influences"] = {"kpi": options.kpi, "parameters": [asdict(one) for one in found]}
    write_result(options, parts, result)
    check_any_ran(frame)


def _write_case(options: argparse.Namespace) -> None:
    """Write the scenario of the case that `options` name, and print the line that runs it."""
    from heave_bringup.output import check_output, warn, write_result

    from heave_studies.tables.case_table import write_case

    check_output("--output", options.output, (".yaml",))
    path, reported = write_case(options.case, options.output)
    warn(reported)
    line = f"heave run {shlex.quote(str(path))}"
    write_result(options, f"{path} is case {options.case}\nnext: {line}", {"scenario": str(path), "next": line})


def _text(lines: Sequence[str]) -> list[str]:
    return ["\n".join(lines)] if lines else []


def _campaign(options: argparse.Namespace) -> Campaign:
    """Return the campaign that `options` name, or that they are themselves."""
    from heave_studies.campaign.campaign_file import campaign_of, find_campaign, read_campaign, with_settings

    if options.vary:
        campaign = campaign_of(options.campaign, options.vary)
    else:
        campaign = read_campaign(find_campaign(options.campaign))
    return with_settings(campaign, options.set)
