"""`heave study`: run many cases and judge them, once, from a file."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.arguments import add_settings
from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    from pandas import DataFrame

    from heave_studies.kinds import Opened

SUMMARY = "Run many cases from a study file, or a shipped study, without ROS; write one table and one page."
EXAMPLES = (
    "heave study --list",
    "heave study b2_calm_300 --vary winch_controller.law=off,lqg,mpc --seeds 3",
    "heave study operability unit_1500",
    "heave study my_study.yaml --dask tcp://HOST:8786",
    "heave study --case studies/operability/table.parquet:17",
)


MOST_LISTED = 20
"""Cases that `--check` lists."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument(
        "study", metavar="STUDY", nargs="?", help="a study file, a shipped study (--list), or with --vary a scenario"
    )
    parser.add_argument("scenario", metavar="SCENARIO", nargs="?", help="scenario, instead of the study's")
    parser.add_argument("--list", action="store_true", help="list the shipped studies and their --ask keys")
    parser.add_argument("--show", action="store_true", help="print the study file, to be saved and edited")
    parser.add_argument(
        "--case",
        metavar="FILE.parquet:CASE",
        help="write one case of a table as a scenario, to run it over ROS",
    )
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="NODE.PARAM=V,V,...",
        help="run each of these values, instead of the study's; repeatable: all combinations",
    )
    add_settings(parser)
    parser.add_argument("--seeds", type=int, metavar="N", help="number of seeds per case, instead of the study's")
    parser.add_argument("--draws", type=int, metavar="N", help="only the first N of the study's random draws")
    parser.add_argument("--duration", type=float, metavar="S", help="simulated time per case, instead of the study's")
    parser.add_argument(
        "--require",
        action="append",
        default=[],
        metavar="KPI<VALUE",
        help="add a criterion, such as dynamic_amplification<1.2 or tension_max<400kN",
    )
    parser.add_argument(
        "--ask", action="append", default=[], metavar="KEY=VALUE", help="an option of the study (--list); repeatable"
    )
    parser.add_argument("--forecast", metavar="FILE", help="forecast (time, hs, tp), to find weather windows")
    parser.add_argument("--full", action="store_true", help="run every case in the full loop, without screening")
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder of table and page (default: studies/STUDY). Results are saved as they arrive; repeat the command "
        "to resume. With --case: the scenario file to write",
    )
    parser.add_argument("--check", action="store_true", help="check the study and list its cases, without running it")
    parser.add_argument("--pdf", action="store_true", help="also write a PDF (A4); needs Chromium, Chrome or Edge")
    parser.add_argument("--processes", type=int, metavar="N", help="worker processes (default: one per processor)")
    parser.add_argument("--dask", metavar="ADDRESS", help="run on the workers of this Dask scheduler (tcp://HOST:PORT)")


def execute(options: argparse.Namespace) -> None:
    """List or show studies, write a case, or run a study and answer, as `options` say."""
    if options.case is not None:
        _write_case(options)
    elif options.list:
        _list(options)
    elif options.study is None:
        raise ParameterError("name a study file, a shipped study (heave study --list), or with --vary a scenario")
    elif options.show:
        _show(options)
    else:
        _run(options)


def _run(options: argparse.Namespace) -> None:
    from heave_bags.report.paper import find_browser, save_pdf
    from heave_bringup.errors import CommandError, VerdictError
    from heave_bringup.output import make_table, write_result

    from heave_studies.answers.page import render
    from heave_studies.kinds import Options, open_study
    from heave_studies.study.cases import screening_words
    from heave_studies.study.cost import HEAD, cost_rows
    from heave_studies.study.engine import CSV, PAGE, PDF, TABLE, run_study

    for name in ("processes", "draws", "seeds"):
        value = getattr(options, name)
        if value is not None and value < 1:
            raise ParameterError(f"--{name} {value}: must be at least 1")
    if options.pdf:
        find_browser()
    opened = open_study(
        Options(
            options.study,
            options.scenario,
            options.set,
            options.vary,
            options.require,
            [*options.ask, *([f"forecast={options.forecast}"] if options.forecast else [])],
            options.seeds,
            options.draws,
            options.duration,
            options.output,
            options.full,
        )
    )
    if options.check:
        _check(options, opened)
        return
    folder = opened.folder
    frame, about = run_study(opened.kind, folder, processes=options.processes, dask=options.dask)
    unseen = [name for name in ("scenario", "detail") if name in frame]
    frame.drop(columns=unseen).to_csv(folder / CSV, index=False)
    found = opened.answer(frame)
    page = render(opened.kind.name, opened.lead, opened.lift, found, frame, folder / TABLE, {**about, **opened.facts})
    (folder / PAGE).write_text(page, encoding="utf-8")
    if options.pdf:
        save_pdf(folder / PAGE, folder / PDF)
    names = (("table", TABLE), ("csv", CSV), ("page", PAGE), *([("pdf", PDF)] if options.pdf else []))
    files = {name: str(folder / file) for name, file in names}
    places = "\n".join(f"{name:<9} {path}" for name, path in files.items())
    cost, screened = cost_rows(folder), screening_words(frame)
    result = {"study": opened.kind.name, **found.data, "judged": found.judged, **files}
    result["screening"] = screened
    result["cost_s"] = {name: float(seconds) for name, seconds, _ in cost}
    repeat = [f"its scenario: heave study --case {folder / TABLE}:{found.worst}"] if found.worst else []
    parts = [*found.parts, *repeat, *([screened] if screened else [])]
    parts += [*([make_table(HEAD, cost)] if cost else []), places]
    write_result(options, parts, result)
    if not found.judged:
        raise CommandError(f"nothing was judged in {len(frame)} cases{_why(frame)}")
    if found.failures:
        raise VerdictError(found.failures)


def _why(frame: DataFrame) -> str:
    """Return why nothing of a `frame` was judged, as far as its first case says it."""
    words = str(frame["failure"].iloc[0]) if len(frame) and "failure" in frame else ""
    is_foreign = "deserializ" in words.lower() or "No module named" in words
    hint = ": the workers need this suite, in the same version" if is_foreign else ""
    return f"{hint}; the first: {words}" if words else ": no minute of compensation without an alarm counts; run longer"


def _check(options: argparse.Namespace, opened: Opened) -> None:
    """List what a study would run first."""
    from heave_bringup.output import write_result

    labels = [job.label for job in next(opened.kind.rounds({}))]
    more = [f"and {opened.kind.size - MOST_LISTED} more"] if opened.kind.size > MOST_LISTED else []
    lines = [f"{opened.kind.name}: {opened.kind.size} cases, no errors found", *labels[:MOST_LISTED], *more]
    write_result(options, "\n".join(lines), {"study": opened.kind.name, "size": opened.kind.size, "first": labels})


def _list(options: argparse.Namespace) -> None:
    """List the shipped studies, and what can be asked."""
    from heave_bringup.output import make_table, write_result
    from heave_bringup.scenarios import description_of
    from heave_node.files.given_files import shipped_files

    from heave_studies.kinds import asked_table
    from heave_studies.study.study_file import FOLDER

    studies = [[name, description_of(path)] for name, path in shipped_files(FOLDER).items()]
    answers = asked_table()
    tables = [
        make_table(("study", "what it asks"), studies, texts=("what it asks",)),
        make_table(("answer", "what it shows", "--ask"), answers, texts=("what it shows", "--ask")),
    ]
    write_result(options, tables, {"studies": dict(studies), "answers": {one[0]: one[2].split() for one in answers}})


def _show(options: argparse.Namespace) -> None:
    from heave_bringup.output import write_result

    from heave_studies.study.study_file import find_study

    path = find_study(options.study)
    write_result(options, path.read_text(encoding="utf-8"), {"study": options.study, "file": str(path)})


def _write_case(options: argparse.Namespace) -> None:
    """Write the scenario of the case that `options` name, and print the line that runs it."""
    from heave_bringup.output import check_output, write_result

    from heave_studies.study.case_file import write_case

    check_output("--output", options.output, (".yaml",))
    path = write_case(options.case, options.output)
    line = f"heave run {shlex.quote(str(path))}"
    write_result(options, f"{path} is case {options.case}\nnext: {line}", {"scenario": str(path), "next": line})
