"""`heave operability`: the seas that one can work in."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from heave_node.parameters import ParameterError

from heave_studies.commands.sea_options import (
    add_files,
    add_grid,
    check_files,
    criteria_in,
    sea_grid,
    study_cases,
    study_criteria,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from heave_bringup.scenarios import Scenario
    from heave_node.criteria import Criterion
    from pandas import DataFrame
    from rich.table import Table

    from heave_studies.campaign.plan import Campaign
    from heave_studies.operability.study import Place, Situation

SUMMARY = "Find the limiting sea with AHC and with the winch locked, and the waiting time for it."
EXAMPLES = (
    "heave operability unit_1500 --record 46042w1996.txt.gz",
    "heave operability b3_deep_900 --heights 1 2 3 4 --periods 8 10 12 --require 'unit_sigma_m<0.02'",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_grid(parser, seeds=2)
    parser.add_argument("--headings", type=float, nargs="+", metavar="DEG", help="headings of a vessel with RAOs [deg]")
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="PLACE=[V, ...]",
        help="another parameter; each value is studied separately (system.length, cable_sim.current)",
    )
    parser.add_argument("--windows", type=float, nargs="+", metavar="H", help="weather windows [h] (default: 6 12 24)")
    parser.add_argument("--alpha", type=Path, metavar="FILE", help="alpha factors: a .csv, hours by wave heights")
    add_files(parser, "operability", "the limits")


def execute(options: argparse.Namespace) -> None:
    """Run the seas that `options` name, print the limits, write the page."""
    from heave_bringup.output import write_result
    from heave_bringup.run.criteria import parse_requirement
    from heave_bringup.scenarios import load_scenario

    from heave_studies.operability.page import About, limit_frame, render
    from heave_studies.operability.study import study_situations, to_json

    check_files(options)
    required = [parse_requirement(text) for text in options.require]
    scenario = load_scenario(options.scenario, settings=options.set)
    criteria_in(scenario.wanted, required)
    place = _place(options)
    table = options.cases or options.output or Path(f"{scenario.name}_operability.parquet")
    page = options.report or Path(f"{scenario.name}_operability.html")
    frame, facts = study_cases(options, table, lambda settings: _campaign(options, settings, required))
    criteria = study_criteria(frame, table, required, command="heave operability")
    found = study_situations(frame, criteria, place)
    page.write_text(render(About(f"{scenario.name}: operability", table, facts), found, criteria, place), "utf-8")
    if options.csv is not None:
        limit_frame(found).to_csv(options.csv, index=False)
    files = f"report    {page}\ncases     {table}"
    write_result(
        options,
        [*_tables(found, place), *_remarks(found, place), *_left_out(scenario, frame), files],
        {**to_json(found, criteria), "report": str(page)},
    )


def _campaign(options: argparse.Namespace, settings: Mapping[str, object], required: list[Criterion]) -> Campaign:
    from heave_bringup.settings import yaml_value

    vary = {}
    for text in options.vary:
        name, separator, value = text.partition("=")
        values = yaml_value(value, f"--vary {text}")
        if not separator or not isinstance(values, list) or not values:
            raise ParameterError(f"--vary {text}: must be PLACE=[V, ...], for example system.length=[500, 1500]")
        vary[name] = values
    return sea_grid(options, headings=options.headings or (), vary=vary).campaign(
        options.scenario,
        settings=settings,
        wanted={criterion.kpi: criterion.text for criterion in required},
        duration=options.duration,
    )


def _place(options: argparse.Namespace) -> Place | None:
    from heave_studies.operability.record import read_record
    from heave_studies.operability.study import WINDOWS, Place
    from heave_studies.operability.windows import read_alpha

    windows = tuple(options.windows or WINDOWS)
    if min(windows) <= 0.0:
        raise ParameterError(f"--windows {min(windows):g}: must be numbers above 0 [h]")
    alpha = None if options.alpha is None else read_alpha(options.alpha)
    if options.record is None:
        if options.windows or options.alpha:
            raise ParameterError("--windows and --alpha need --record: the seas in which windows are looked for")
        return None
    return Place(read_record(options.record), windows, alpha)


def _left_out(scenario: Scenario, frame: DataFrame) -> list[str]:
    """Return the line that says how to have the limits under the baseline law, where they are not among the cases."""
    from heave_bringup.run.criteria import BASELINE_LAW, LAW

    law = scenario.parameters["winch_controller"].law
    if LAW in frame or law == BASELINE_LAW:
        return []
    beside = f"--vary '{LAW}=[{law}, {BASELINE_LAW}]'"
    return [f"left out: the limits under law {BASELINE_LAW} ({beside}, in twice the time)"]


def _remarks(found: list[Situation], place: Place | None) -> list[str]:
    """Return the lines below the tables on what they cannot tell: confidence of few seeds, waiting without an order."""
    from heave_studies.operability.limits import too_few_seeds
    from heave_studies.operability.page import no_windows

    without_order = [] if place is None or place.record.has_order else [no_windows(place.record)]
    few = too_few_seeds([situation.limit for situation in found])
    return without_order + ([few] if few else [])


def _tables(found: list[Situation], place: Place | None) -> list[str | Table]:
    from heave_bringup.output import make_table

    from heave_studies.operability.page import limit_rows, waits

    parts: list[str | Table] = []
    for situation in found:
        limits = make_table(*limit_rows(situation.limit, situation.locked_limit), texts=["ended by"])
        parts += [situation.name, limits] if situation.name else [limits]
        if place is not None and situation.exposure is not None and situation.locked_exposure is not None:
            parts.append(
                f"workable seas of {place.record.name}: {100 * situation.exposure.share:.1f} % compensated, "
                f"{100 * situation.locked_exposure.share:.1f} % uncompensated"
            )
            both = (waits(situation.exposure, place), waits(situation.locked_exposure, place))
            parts += [
                f"wait for {hours:g} h, P50 / P90: {compensated} h compensated, {alone} h uncompensated"
                for hours, compensated, alone in zip(place.windows, *both, strict=False)
            ]
    return parts
