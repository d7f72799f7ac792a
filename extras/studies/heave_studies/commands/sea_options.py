"""What studies over a grid of seas share: their options, their cases, their criteria."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.arguments import add_scenario, add_workers
from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import pandas
    from heave_node.criteria import Criterion

    from heave_studies.campaign.plan import Campaign
    from heave_studies.operability.seas import SeaGrid


def add_grid(parser: argparse.ArgumentParser, seeds: int) -> None:
    """Let the user of `parser` choose scenario and seas; so many `seeds` where he does not say."""
    add_scenario(parser)
    parser.add_argument("--heights", type=float, nargs="+", metavar="HS", help="significant wave heights [m]")
    parser.add_argument("--periods", type=float, nargs="+", metavar="TP", help="peak periods [s]")
    parser.add_argument("--seeds", type=int, default=seeds, metavar="N", help=f"seeds per sea (default: {seeds})")
    parser.add_argument(
        "--duration", type=float, metavar="S", help="simulated time per case, instead of the scenario's"
    )
    parser.add_argument(
        "--require",
        action="append",
        default=[],
        metavar="KPI<VALUE",
        help="add a criterion, such as dynamic_amplification<1.2 or tension_max<400kN",
    )
    parser.add_argument(
        "--record",
        type=Path,
        metavar="FILE",
        help="seas of the site: NDBC spectra, any wavespectra format, a .csv with time, hs, tp, or a scatter diagram",
    )


def add_files(parser: argparse.ArgumentParser, name: str, result: str) -> None:
    """Let the user of `parser` name the files of the study `name`, whose `result` goes into a CSV, and its workers."""
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE.parquet",
        help=f"table of the cases (default: NAME_{name}.parquet); repeat the command to resume",
    )
    parser.add_argument(
        "--cases", type=Path, metavar="FILE.parquet", help="run nothing; report the cases of this table"
    )
    parser.add_argument("--report", type=Path, metavar="FILE.html", help=f"default: NAME_{name}.html")
    parser.add_argument("--csv", type=Path, metavar="FILE", help=f"write {result} as CSV")
    add_workers(parser)


def check_files(options: argparse.Namespace) -> None:
    """Refuse endings of the files in `options` that name no format, before anything is run."""
    from heave_bringup.output import check_output

    check_output("--report", options.report, (".html",))
    check_output("--output", options.output, (".parquet",))
    check_output("--csv", options.csv, (".csv",))


def sea_grid(
    options: argparse.Namespace,
    *,
    headings: Sequence[float] = (),
    vary: Mapping[str, Sequence[object]] | None = None,
    heights: Sequence[float] = (),
    periods: Sequence[float] = (),
) -> SeaGrid:
    """Return the seas that `options` ask for.

    Parameters
    ----------
    options : of the command line
    headings : of the vessel [deg]
    vary : other parameters, by place
    heights, periods : where none are given [m, s]; empty: those of an operability study

    Raises ParameterError for what is no grid.
    """
    from heave_studies.operability.seas import HEIGHTS, PERIODS, SeaGrid

    for option, value in (("--seeds", options.seeds), ("--processes", options.processes)):
        if value is not None and value < 1:
            raise ParameterError(f"{option} {value}: must be at least 1")
    try:
        return SeaGrid(
            heights=tuple(options.heights or heights or HEIGHTS),
            periods=tuple(options.periods or periods or PERIODS),
            headings=tuple(headings),
            seeds=tuple(range(1, options.seeds + 1)),
            vary=vary or {},
        )
    except ValueError as error:
        raise ParameterError(str(error)) from error


def study_cases(
    options: argparse.Namespace, table: Path, campaign: Callable[[Mapping[str, object]], Campaign]
) -> tuple[pandas.DataFrame, dict[str, str]]:
    """Return the table of the cases, run or read, and what it reports of itself.

    Parameters
    ----------
    options : of the command line
    table : file of the cases
    campaign : gives what is to be run from the settings of every case

    Raises ParameterError for a table of another scenario.
    """
    from heave_bringup.settings import plain_settings

    from heave_studies.campaign.study import run_study
    from heave_studies.campaign.table import check_any_ran
    from heave_studies.tables.case_table import read_cases

    if options.cases is None:
        run_study(campaign(plain_settings(options.set)), output=table, processes=options.processes, dask=options.dask)
    frame, facts = read_cases(table)
    check_any_ran(frame)
    of_table = facts.get("scenario", options.scenario)
    if Path(of_table).stem != Path(options.scenario).stem:
        raise ParameterError(f"{table}: holds cases of {of_table}, not of {options.scenario}: name {of_table}")
    return frame, facts


def study_criteria(
    frame: pandas.DataFrame, table: Path, required: Sequence[Criterion], *, command: str, without: Sequence[str] = ()
) -> list[Criterion]:
    """Return the criteria of the cases, those of the command line in the place of their own.

    Parameters
    ----------
    frame : table of the cases
    table : its file
    required : criteria of the command line
    command : whose table it should be
    without : figures of merit on which the scenario's own criteria are left out

    Raises ParameterError where there are none, and for a table of other cases.
    """
    from heave_studies.operability.seas import HEIGHT, PERIOD
    from heave_studies.tables.case_table import CASE, load_case

    missing = [name for name in (HEIGHT, PERIOD) if name not in frame.columns]
    if missing:
        raise ParameterError(f"{table}: its cases do not vary {missing[0]}: it is no table of {command}")
    wanted = load_case(table, int(frame[CASE].iloc[0])).wanted
    return with_strengths(frame, criteria_in(wanted, required, without))


def with_strengths(frame: pandas.DataFrame, criteria: Sequence[Criterion]) -> list[Criterion]:
    """Return `criteria`, and beside them that no part carries more than it can, where its strength is stated.

    Parameters
    ----------
    frame : table of the cases, with the safety factors as figures of merit
    criteria : of the study; one on a safety factor stays as it is
    """
    from heave_node.criteria import Criterion
    from heave_node.loads.strength import FACTORS, LEAST

    chosen = {criterion.kpi for criterion in criteria}
    stated = [key for key in FACTORS if key in frame and (frame[key] > 0.0).any()]
    return [*criteria, *(Criterion(key, ">=", LEAST) for key in stated if key not in chosen)]


def criteria_in(
    wanted: Sequence[Criterion], required: Sequence[Criterion], without: Sequence[str] = ()
) -> list[Criterion]:
    """Return the criteria of a study: those `wanted` by its scenario but for `without`, and those `required`.

    Raises ParameterError where there are none: asked before the first case, that costs nothing.
    """
    own = [criterion for criterion in wanted if criterion.kpi not in without]
    criteria = {criterion.kpi: criterion for criterion in (*own, *required)}
    if not criteria:
        raise ParameterError("no criteria: give the scenario some (wanted), or --require, as in 'unit_sigma_m<0.05'")
    return list(criteria.values())
