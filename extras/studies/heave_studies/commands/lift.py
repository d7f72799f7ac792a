"""`heave lift`: one lift, from plan to as-built."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from heave_bags.analyse.run_record import RunRecord

SUMMARY = "Experimental: plan a lift in phases: limiting seas, go or no-go for a forecast, as-built check of its bag."
EXAMPLES = ("heave lift module_1500", "heave lift my_lift.yaml --forecast forecast.csv --bag runs/my_lift-001/bag")

GUIDE = "docs/guide/howto/plan_a_lift.md"
"""Where the figures of the validation are."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("plan", metavar="PLAN", help="a plan: a YAML file, or the shipped module_1500")
    parser.add_argument(
        "--forecast", type=Path, metavar="FILE.csv", help="forecast with the columns time, hs, tp: gives go or no-go"
    )
    parser.add_argument("--bag", type=Path, metavar="BAG", help="bag of the lift, to be judged phase by phase")
    parser.add_argument("--report", type=Path, metavar="FILE.html", help="default: PLAN_lift.html")
    parser.add_argument("--processes", type=int, metavar="N", help="default: one per processor")


def execute(options: argparse.Namespace) -> None:
    """Print the limits of the plan that `options` name, hold forecast and bag against them, write the page."""
    from heave_bringup.errors import CommandError, VerdictError
    from heave_bringup.output import check_output, make_table, warn, write_result
    from heave_node.parameters import ParameterError

    from heave_studies.lift.forecast import read_forecast, warnings
    from heave_studies.lift.page import render
    from heave_studies.lift.plan import read_plan
    from heave_studies.lift.study import study_lift
    from heave_studies.lift.tables import judged_rows, limit_table, phase_table, summary, weather_table

    check_output("--report", options.report, (".html",))
    if options.processes is not None and options.processes < 1:
        raise ParameterError(f"--processes {options.processes}: must be at least 1")
    plan = read_plan(options.plan)
    forecast = None if options.forecast is None else read_forecast(options.forecast)
    if forecast is not None:
        warn(warnings(plan, forecast))
    record = None if options.bag is None else _record(options.bag)
    if record is not None:
        warn(record.remarks())
    warn([f"lift is experimental: one compensated limit is validated ({GUIDE})"])
    study = study_lift(plan, processes=options.processes, forecast=forecast, record=record)
    page = options.report or Path(f"{plan.path.stem}_lift.html")
    try:
        page.write_text(render(study), "utf-8")
    except OSError as error:
        raise CommandError(f"{page}: cannot be written: {error.strerror}") from error
    texts = ("way", "criterion", "planned", "as built", "start (UTC)", "Hs m, compensated", "Hs m, winch locked")
    tables = [limit_table, phase_table, *([weather_table] if study.windows else []), judged_rows]
    found = [make_table(*of(study), texts=texts) for of in tables]
    ends = ["\n".join(summary(study)), f"report    {page}"]
    write_result(options, [plan.title, *found, *ends], {**study.to_json(), "report": str(page)})
    if study.failures:
        raise VerdictError(study.failures)


def _record(bag: Path) -> RunRecord:
    from heave_bags.mcap.read.folder import bag_of
    from heave_bringup.run.records import read_records

    return read_records([bag_of(bag)])[0]
