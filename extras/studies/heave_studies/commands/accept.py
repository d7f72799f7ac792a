"""`heave accept`: an acceptance test by a procedure, with one report to sign."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.arguments import add_network, add_settings
from heave_bringup.errors import VerdictError
from heave_bringup.replacements import EXTERNAL, add_replace, parse_replacements
from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    from heave_studies.accept.session import Parts

SUMMARY = "Run an acceptance test on simulated parts, real parts or a record, and write a report to sign."
EXAMPLES = (
    "heave accept --list",
    "heave accept winch_factory_test --pdf                      # the virtual winch",
    "heave accept winch_factory_test --winch my_winch.yaml      # a real one: it moves",
    "heave accept my_trial.yaml --record log.csv --map my_log.yaml",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("procedure", metavar="PROCEDURE", nargs="?", help="procedure file, or a shipped one (--list)")
    parser.add_argument("--list", action="store_true", help="list the shipped procedures")
    parser.add_argument("--show", metavar="NAME", help="print a shipped procedure, to be saved and edited")
    parser.add_argument("--figures", action="store_true", help="list the figures that criteria may use")
    parser.add_argument(
        "--check", action="store_true", help="check the procedure and list its steps, without running it"
    )
    add_settings(parser)
    parser.add_argument(
        "--scenario", default="", metavar="SCENARIO", help="use this scenario instead of the procedure's"
    )
    parser.add_argument("--step", action="append", default=[], metavar="NAME", help="run only this step; repeatable")
    parser.add_argument("--winch", metavar="MAP", help="real winch, by its map (heave adapt). IT WILL MOVE")
    add_replace(
        parser,
        "in runs, use a real part (heave adapt in another terminal) instead of NODE; a sensor's topic "
        "such as winch/load_cell replaces that sensor only. CLOCK is how it stamps: simulated, own or "
        "none (default: detected)",
        f"{EXTERNAL}[:CLOCK]",
    )
    parser.add_argument(
        "--record",
        action="append",
        default=[],
        metavar="[STEP=]FILE",
        help="run nothing; judge this bag or log, for all steps or for STEP",
    )
    parser.add_argument("--map", type=Path, metavar="FILE", help="map: where to find the quantities in the record")
    parser.add_argument(
        "--output", type=Path, metavar="DIR", help="folder for records and report (default: runs/PROCEDURE-NNN)"
    )
    parser.add_argument("--pdf", action="store_true", help="also write a PDF (A4); needs Chromium, Chrome or Edge")
    add_network(parser)


def execute(options: argparse.Namespace) -> None:
    """List or show procedures, or run one and report, as `options` say."""
    from heave_bringup.network import set_up_transport
    from heave_bringup.output import make_table, write_result
    from heave_node.files.given_files import shipped_files

    from heave_studies.accept.procedure_file import FOLDER, find_procedure, read_head
    from heave_studies.accept.session import Session

    known = shipped_files(FOLDER)
    if options.list:
        rows = [[name, str(read_head(path).content["title"])] for name, path in known.items()]
        write_result(options, make_table(("procedure", "title"), rows, texts=("title",)), dict(rows))
    elif options.show is not None:
        if options.show not in known:
            raise ParameterError(f"--show {options.show}: is no shipped procedure; known: {', '.join(known)}")
        write_result(options, known[options.show].read_text(encoding="utf-8"), {"procedure": options.show})
    elif options.figures:
        _figures(options)
    elif options.procedure is None:
        raise ParameterError("name a procedure file, or a shipped procedure: heave accept --list")
    else:
        set_up_transport(network=options.network)
        session = Session(read_head(find_procedure(options.procedure)), _parts(options), options.set, options.scenario)
        names = [step.name for step in session.procedure.steps]
        wrong = next((name for name in options.step if name not in names), None)
        if wrong is not None:
            raise ParameterError(f"--step {wrong}: no such step; steps: {', '.join(names)}")
        if options.check:
            _check(options, session)
        else:
            _accept(options, session)


def _parts(options: argparse.Namespace) -> Parts:
    """Return what is tested."""
    from heave_devices.adapt.shipped import find_map

    from heave_studies.accept.session import WHOLE, Parts

    if options.map is not None and not options.record:
        raise ParameterError("--map: says how a record is read: give --record; a real winch has --winch")
    records = {}
    for text in options.record:
        name, separator, path = text.rpartition("=") if not Path(text).exists() else ("", "", text)
        if not Path(path).exists():
            raise ParameterError(f"--record {text}: no such file: {path}")
        records[name if separator else WHOLE] = Path(path)
    winch = find_map(options.winch) if options.winch else None
    return Parts(winch, parse_replacements(options.replace, kinds=[EXTERNAL]).external, records, options.map)


def _accept(options: argparse.Namespace, session: object) -> None:
    from heave_bags.report.paper import find_browser, save_pdf
    from heave_bringup.output import make_table, write_result
    from heave_bringup.run.run import new_run_folder

    from heave_studies.accept.page import render, residual_rows, summary
    from heave_studies.accept.session import Session

    assert isinstance(session, Session)
    if options.pdf:
        find_browser()
    folder = new_run_folder(session.procedure.path.stem, options.output).path
    found = session.run(folder, options.step)
    files = {"report": folder / "report.html"}
    files["report"].write_text(render(found), encoding="utf-8")
    if options.pdf:
        files["pdf"] = folder / "report.pdf"
        save_pdf(files["report"], files["pdf"])
    head, rows = summary(found.results)
    tables = [make_table(head, rows, texts=head)]
    residual_head, residuals = residual_rows(found.results)
    tables += [make_table(residual_head, residuals)] if residuals else []
    verdict = f"verdict: {'passed' if found.is_passed else 'FAILED'}"
    places = "\n".join(f"{name:<9} {path}" for name, path in files.items())
    write_result(
        options, [*tables, f"{verdict}\n\n{places}"], {**found.to_json(), **{k: str(v) for k, v in files.items()}}
    )
    if any(one.failure == "interrupted" for one in found.results):
        raise KeyboardInterrupt
    if not found.is_passed:
        raise VerdictError(found.failures)


def _check(options: argparse.Namespace, session: object) -> None:
    """List the steps of a procedure that is right."""
    from heave_bags.analyse.verdict import required_words
    from heave_bringup.output import make_table, write_result

    from heave_studies.accept.figures import DEFINITIONS
    from heave_studies.accept.session import Session

    assert isinstance(session, Session)
    rows = []
    for step in session.procedure.steps:
        signal = getattr(step.test, "signal", None)
        does = signal.words if signal else "a run" if step.test else "a record"
        wanted = "; ".join(f"{of.kpi} {required_words(of, DEFINITIONS.get(of.kpi))}" for of in step.wanted)
        rows.append([step.name, does, step.event.words if step.event else "", wanted])
    head = ("step", "does", "event", "wanted")
    write_result(options, make_table(head, rows, texts=head), [dict(zip(head, row, strict=True)) for row in rows])


def _figures(options: argparse.Namespace) -> None:
    """List every figure that a criterion may name."""
    from heave_bags.analyse.kpi_set import DEFINITION_OF
    from heave_bringup.output import make_table, write_result

    from heave_studies.accept.figures import DEFINITIONS

    rows = [[key, of.title, of.unit, of.group] for key, of in {**DEFINITIONS, **DEFINITION_OF}.items()]
    head = ("figure", "what it is", "shown in", "group")
    write_result(options, make_table(head, rows, texts=head), [dict(zip(head, row, strict=True)) for row in rows])
