"""`heave operability`: the seas that one can work in."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from heave_node.parameters import ParameterError

from heave_bringup.commands.arguments import add_scenario, add_workers
from heave_bringup.commands.command import Command

if TYPE_CHECKING:
    import pandas
    from heave_node.criteria import Criterion
    from rich.table import Table

    from heave_bringup.operability.seas import SeaGrid
    from heave_bringup.operability.study import Place, Situation


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_scenario(parser)
    parser.add_argument("--heights", type=float, nargs="+", metavar="HS", help="significant wave heights [m]")
    parser.add_argument("--periods", type=float, nargs="+", metavar="TP", help="peak periods [s]")
    parser.add_argument("--headings", type=float, nargs="+", metavar="DEG", help="of a vessel with RAOs [deg]")
    parser.add_argument("--seeds", type=int, default=2, metavar="N", help="seeds of each sea (default: 2)")
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="PLACE=[V, ...]",
        help="another parameter, each value a situation of its own: depth (system.length), cable_sim.current",
    )
    parser.add_argument("--duration", type=float, metavar="S", help="simulated time of a case, not the scenario's")
    parser.add_argument(
        "--require", action="append", default=[], metavar="KPI<VALUE", help="a criterion beside the scenario's own"
    )
    parser.add_argument(
        "--record",
        type=Path,
        metavar="FILE",
        help="seas of the place: NDBC's spectra, what wavespectra reads, a .csv with time, hs, tp or a scatter diagram",
    )
    parser.add_argument("--windows", type=float, nargs="+", metavar="H", help="weather windows [h] (default: 6 12 24)")
    parser.add_argument("--alpha", type=Path, metavar="FILE", help="alpha factors: a .csv of hours by wave heights")
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE.parquet",
        help="table of the cases (default: NAME_operability.parquet); an ended study goes on from it",
    )
    parser.add_argument(
        "--cases", type=Path, metavar="FILE.parquet", help="report the cases of this table; nothing is run"
    )
    parser.add_argument("--report", type=Path, metavar="FILE.html", help="default: NAME_operability.html")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="the limits as CSV")
    add_workers(parser)


def execute(options: argparse.Namespace) -> None:
    """Run the seas that `options` name, print the limits, write the page."""
    from heave_bringup.operability.page import About, limit_frame, render
    from heave_bringup.operability.study import study_situations, to_json
    from heave_bringup.output import check_output, write_result
    from heave_bringup.run.criteria import parse_requirement
    from heave_bringup.scenarios import load_scenario

    check_output("--report", options.report, (".html",))
    check_output("--output", options.output, (".parquet",))
    check_output("--csv", options.csv, (".csv",))
    required = [parse_requirement(text) for text in options.require]
    scenario = load_scenario(options.scenario, settings=options.set)
    place = _place(options)
    table = options.cases or options.output or Path(f"{scenario.name}_operability.parquet")
    page = options.report or Path(f"{scenario.name}_operability.html")
    frame, facts = _cases(options, required, table)
    criteria = _criteria(frame, table, required)
    found = study_situations(frame, criteria, place)
    page.write_text(render(About(f"{scenario.name}: operability", table, facts), found, criteria, place), "utf-8")
    if options.csv is not None:
        limit_frame(found).to_csv(options.csv, index=False)
    files = f"report    {page}\ncases     {table}"
    write_result(options, [*_tables(found, place), files], {**to_json(found, criteria), "report": str(page)})


def _cases(
    options: argparse.Namespace, required: list[Criterion], table: Path
) -> tuple[pandas.DataFrame, dict[str, str]]:
    """Return the table of the cases, run or read, and what it says of itself."""
    from heave_bringup.campaign.study import run_study
    from heave_bringup.tables.case_table import read_cases

    if options.cases is None:
        from heave_bringup.settings import parse_setting

        settings = {}
        for text in options.set:
            parse_setting(text)
            name, _, value = text.partition("=")
            settings[name] = _yaml(value, f"--set {text}")
        campaign = _grid(options).campaign(
            options.scenario,
            settings=settings,
            wanted={criterion.kpi: criterion.text for criterion in required},
            duration=options.duration,
        )
        run_study(campaign, output=table, processes=options.processes, dask=options.dask)
    return read_cases(table)


def _grid(options: argparse.Namespace) -> SeaGrid:
    from heave_bringup.operability.seas import HEIGHTS, PERIODS, SeaGrid

    for option, value in (("--seeds", options.seeds), ("--processes", options.processes)):
        if value is not None and value < 1:
            raise ParameterError(f"{option} {value}: must be at least 1")
    vary = {}
    for text in options.vary:
        name, separator, value = text.partition("=")
        values = _yaml(value, f"--vary {text}")
        if not separator or not isinstance(values, list) or not values:
            raise ParameterError(f"--vary {text}: must be PLACE=[V, ...], for example system.length=[500, 1500]")
        vary[name] = values
    try:
        return SeaGrid(
            heights=tuple(options.heights or HEIGHTS),
            periods=tuple(options.periods or PERIODS),
            headings=tuple(options.headings or ()),
            seeds=tuple(range(1, options.seeds + 1)),
            vary=vary,
        )
    except ValueError as error:
        raise ParameterError(str(error)) from error


def _yaml(text: str, source: str) -> object:
    import yaml
    from heave_node.scenario import parse_yaml

    try:
        return parse_yaml(text, only_true_and_false=True)
    except yaml.YAMLError as error:
        raise ParameterError(f"{source}: {text!r} is not a YAML value") from error


def _place(options: argparse.Namespace) -> Place | None:
    from heave_bringup.operability.alpha import read_alpha
    from heave_bringup.operability.record import read_record
    from heave_bringup.operability.study import WINDOWS, Place

    windows = tuple(options.windows or WINDOWS)
    if min(windows) <= 0.0:
        raise ParameterError(f"--windows {min(windows):g}: must be numbers above 0 [h]")
    alpha = None if options.alpha is None else read_alpha(options.alpha)
    if options.record is None:
        if options.windows or options.alpha:
            raise ParameterError("--windows and --alpha need --record: the seas in which windows are looked for")
        return None
    return Place(read_record(options.record), windows, alpha)


def _criteria(frame: pandas.DataFrame, table: Path, required: list[Criterion]) -> list[Criterion]:
    """Return the criteria of the cases, those of the command line in the place of their own."""
    from heave_bringup.operability.seas import HEIGHT, PERIOD
    from heave_bringup.scenarios import load_scenario
    from heave_bringup.tables.case_table import CASE

    missing = [name for name in (HEIGHT, PERIOD) if name not in frame.columns]
    if missing:
        raise ParameterError(f"{table}: its cases do not vary {missing[0]}: it is no table of heave operability")
    wanted = load_scenario(f"{table}:{frame[CASE].iloc[0]}", needs_files=False).wanted
    criteria = {criterion.kpi: criterion for criterion in (*wanted, *required)}
    if not criteria:
        raise ParameterError("no criteria: give the scenario some (wanted), or --require, as in 'unit_sigma_m<0.05'")
    return list(criteria.values())


def _tables(found: list[Situation], place: Place | None) -> list[str | Table]:
    from heave_bringup.operability.limits import title_of
    from heave_bringup.operability.page import interval
    from heave_bringup.output import make_table

    parts: list[str | Table] = []
    for situation in found:
        head = ["Tp s", "Hs m", "90 % sure", "ended by", "Hs m uncompensated"]
        rows = []
        for row, locked in zip(
            situation.limit.to_dict("records"), situation.locked_limit.to_dict("records"), strict=True
        ):
            least = ">= " if row["is_open"] else ""
            least_locked = ">= " if locked["is_open"] else ""
            governs = title_of(str(row["governs"])) if row["governs"] else "nothing"
            limits = [f"{least}{row['limit']:.2f}", interval(row)]
            rows.append([f"{row['period']:g}", *limits, governs, f"{least_locked}{locked['limit']:.2f}"])
        parts += [situation.name, make_table(head, rows, texts=["ended by"])] if situation.name else []
        parts += [] if situation.name else [make_table(head, rows, texts=["ended by"])]
        if place is not None and situation.exposure is not None and situation.locked_exposure is not None:
            parts.append(
                f"workable seas of {place.record.name}: {100 * situation.exposure.share:.1f} % compensated, "
                f"{100 * situation.locked_exposure.share:.1f} % uncompensated"
            )
    return parts


COMMAND = Command(
    name="operability",
    summary="Find the seas in which criteria hold, compensated and not, and how long one waits for them.",
    examples=(
        "heave operability unit_1500 --record 46042w1996.txt.gz",
        "heave operability b3_deep_900 --heights 1 2 3 4 --periods 8 10 12 --require 'unit_sigma_m<0.02'",
    ),
    add_arguments=add_arguments,
    execute=execute,
)
