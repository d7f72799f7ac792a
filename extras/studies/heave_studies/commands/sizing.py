"""`heave sizing`: the winch that one needs."""

from __future__ import annotations

import argparse
from dataclasses import asdict
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
    from rich.table import Table

    from heave_studies.campaign.plan import Campaign
    from heave_studies.sizing.study import Knee, Prices, Sized

SUMMARY = "Find the winch size: what speed, acceleration, power and delay gain and what they cost."
EXAMPLES = (
    "heave sizing unit_1500 --record 46042w1996.txt.gz",
    "heave sizing b3_deep_900 --speed 0.6 1 1.5 --acceleration --power --delay --require 'unit_sigma_m<0.05'",
)

HEIGHTS, PERIODS = (1.5, 3.0, 4.5), (8.0, 11.0)
"""Seas where none are given [m, s]: fewer than for operability, since every winch is tried in each."""

SWEPT = (
    ("speed", "rope speeds [m/s]"),
    ("acceleration", "rope accelerations [m/s^2]"),
    ("power", "powers at the rope [W]"),
    ("delay", "delays of the commands [s]"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_grid(parser, seeds=1)
    for name, words in SWEPT:
        parser.add_argument(
            f"--{name}", type=float, nargs="*", metavar="V", help=f"{words} to try; without values: none is tried"
        )
    parser.add_argument(
        "--efficiency", type=float, metavar="E", help="drive efficiency in either direction (default: 0.8)"
    )
    parser.add_argument(
        "--regeneration", type=float, metavar="R", help="fraction of regenerated energy that is used (default: 0)"
    )
    parser.add_argument("--energy-price", type=float, metavar="P", help="price per kWh, any currency (default: 0.3)")
    add_files(parser, "sizing", "the comparison")


def execute(options: argparse.Namespace) -> None:
    """Try the winches that `options` name, print the answer and the buyer's tables, write the page."""
    import pandas
    from heave_bringup.output import write_result
    from heave_bringup.run.criteria import parse_requirement
    from heave_bringup.scenarios import load_scenario

    from heave_studies.operability.page import About
    from heave_studies.operability.record import read_record
    from heave_studies.sizing import study
    from heave_studies.sizing.page import render
    from heave_studies.sizing.sheets import BUYERS

    check_files(options)
    prices = _prices(options)
    required = [parse_requirement(text) for text in options.require]
    scenario = load_scenario(options.scenario, settings=options.set)
    left_out = [name for name in study.OF_THE_WINCH if name not in {criterion.kpi for criterion in required}]
    criteria_in(scenario.wanted, required, left_out)
    record = None if options.record is None else read_record(options.record)
    table = options.cases or options.output or Path(f"{scenario.name}_sizing.parquet")
    page = options.report or Path(f"{scenario.name}_sizing.html")
    frame, facts = study_cases(options, table, lambda settings: _campaign(options, scenario, settings, required))
    criteria = study_criteria(frame, table, required, command="heave sizing", without=left_out)
    seas = record or study.even_seas(frame)
    try:
        found = study.size_winches(frame, criteria, seas, prices)
    except ParameterError as error:
        raise ParameterError(f"{table}: {error}") from error
    knees = study.knees(found)
    about = About(f"{scenario.name}: which winch", table, facts)
    page.write_text(render(about, found, knees, criteria, seas, prices), "utf-8")
    buyers = BUYERS.records(found)
    if options.csv is not None:
        pandas.DataFrame(buyers).to_csv(options.csv, index=False)
    files = f"report    {page}\ncases     {table}"
    answer = {
        "seas": seas.name,
        "prices": asdict(prices),
        "knees": {knee.particular.name: {"value": knee.value, "is_open": knee.is_open} for knee in knees},
        "winches": buyers,
        "report": str(page),
    }
    write_result(options, [*_tables(found, knees, seas.name), *_left_out(scenario), files], answer)


def _left_out(scenario: Scenario) -> list[str]:
    """Return the line that says how to have the same tables of the baseline law, where they are of another one."""
    from heave_bringup.run.criteria import BASELINE_LAW

    if scenario.parameters["winch_controller"].law == BASELINE_LAW:
        return []
    beside = f"--set winch_controller.law={BASELINE_LAW} --output FILE, in the same time again"
    return [f"left out: the winch that law {BASELINE_LAW} needs ({beside})"]


def _prices(options: argparse.Namespace) -> Prices:
    from heave_studies.sizing.study import Prices

    for option, value, least in (
        ("--efficiency", options.efficiency, 1e-3),
        ("--regeneration", options.regeneration, 0.0),
    ):
        if value is not None and not least <= value <= 1.0:
            raise ParameterError(f"{option} {value:g}: must be a share, from {least:g} to 1")
    if options.energy_price is not None and not 0.0 <= options.energy_price < float("inf"):
        raise ParameterError(f"--energy-price {options.energy_price:g}: must be a number of at least 0")
    given = {
        "efficiency": options.efficiency,
        "regeneration": options.regeneration,
        "energy": options.energy_price,
    }
    return Prices(**{name: value for name, value in given.items() if value is not None})


def _campaign(
    options: argparse.Namespace, scenario: Scenario, settings: Mapping[str, object], required: list[Criterion]
) -> Campaign:
    """Return the campaign of all winches in all seas."""
    from cable_sim_node.vertical.axial_line import axial_line

    from heave_studies.sizing.candidates import candidates, own_winch
    from heave_studies.sizing.study import sizing_campaign

    winch, plant = scenario.parameters["virtual_winch"], scenario.parameters["cable_sim"]
    static_tension = axial_line(plant, plant.boom_tip_height).static_top_tension(plant.length)
    tried = candidates(own_winch(winch), static_tension, {name: getattr(options, name) for name, _ in SWEPT})
    seas = sea_grid(options, heights=HEIGHTS, periods=PERIODS).campaign(
        options.scenario,
        settings=settings,
        wanted={criterion.kpi: criterion.text for criterion in required},
        duration=options.duration,
    )
    return sizing_campaign(seas, tried, winch.stop_deceleration)


def _tables(found: list[Sized], knees: list[Knee], seas: str) -> list[str | Table]:
    from heave_bringup.output import sheet_table

    from heave_studies.sizing.sheets import ABILITY, DUTY, KNEES

    return [
        f"seas: {seas}",
        *([sheet_table(KNEES, knees)] if knees else []),
        sheet_table(ABILITY, found),
        "an hour of compensation, mean over the workable seas",
        sheet_table(DUTY, found),
    ]
