"""`heave whatif`: what another law, gain or winch would have done in the sea of a bag."""

from __future__ import annotations

import argparse
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.arguments import add_settings
from heave_bringup.commands.command import Command
from heave_bringup.errors import CommandError

if TYPE_CHECKING:
    from heave_bringup.progress import ProgressLine
    from heave_bringup.whatif.words import Result


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("bag", metavar="BAG", type=Path, help="bag folder, the folder of a run; with --map, a log too")
    parser.add_argument("--law", default="", help="the law that is asked for (default: that of the record)")
    parser.add_argument("--compare", default="", metavar="LAW,LAW", help="further laws: off,industrial,lqg,mpc")
    add_settings(parser)
    parser.add_argument(
        "--know", action="append", default=[], metavar="NAME=VALUE+-SPREAD", help="cable.axial_stiffness=1.42e7+-2%%"
    )
    parser.add_argument("--scenario", metavar="SCENARIO", help="of the run, for a record that carries none")
    parser.add_argument(
        "--map", type=Path, metavar="FILE", help="where a record of others has what, as for heave adapt"
    )
    parser.add_argument("--transient", type=float, metavar="S", help="initial time that is left out (the scenario's)")
    parser.add_argument("--end", type=float, metavar="S", help="time at which the record is cut off")
    parser.add_argument("--draws", type=int, default=4, metavar="N", help="plants that are tried for the bands (4)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the draws (1)")
    parser.add_argument(
        "--output", type=Path, metavar="FILE", help="page to write (default: whatif.html beside the bag)"
    )


def execute(options: argparse.Namespace) -> None:
    """Answer and write the page, as `options` say."""
    from cable_sim_node.errors import PlantError
    from heave_bags.mcap.read.folder import bag_of
    from heave_node.parameters import ParameterError
    from winch_controller_node.model.lqr import DesignError

    from heave_bringup.output import check_output, make_table, warn, write_result
    from heave_bringup.progress import ProgressLine
    from heave_bringup.whatif.fitness import warnings
    from heave_bringup.whatif.page import render
    from heave_bringup.whatif.words import causes, check_line, headings, identified_rows, report_line, rows
    from heave_bringup.whatif.words import to_json as json_of

    warn(["whatif is experimental: its answers are not validated (docs/guide/howto/what_would_have_been.md)"])
    check_output("--output", options.output, (".html",))
    if not 0 <= options.draws <= 100:
        raise ParameterError(f"--draws {options.draws}: must be from 0 to 100")
    folder = bag_of(options.bag)
    try:
        with tempfile.TemporaryDirectory(prefix="heave-") as scratch, ProgressLine() as progress:
            result = _result(folder, options, Path(scratch), progress)
    except (DesignError, PlantError) as error:
        raise CommandError(f"{folder}: {error}") from error
    page = options.output or folder.parent / "whatif.html"
    try:
        page.write_text(render(f"{folder.resolve().parent.name}: what would have been", result), encoding="utf-8")
    except OSError as error:
        raise CommandError(f"{page}: cannot be written: {error.strerror}") from error
    table = make_table(headings(), rows(result))
    values = make_table(["identified", "value", "sigma", "assumed"], identified_rows(result.known))
    lines = [check_line(result), report_line(result.known), *causes(result.answers)]
    warn(warnings(result.known, result.answers))
    ends = f"bands are of 90 %\n\npage      {page.resolve()}"
    write_result(options, ["\n".join(lines), table, values, ends], {**json_of(result), "page": str(page.resolve())})


def _result(source: Path, options: argparse.Namespace, scratch: Path, progress: ProgressLine) -> Result:
    """Return what a record answers to what is asked."""
    from heave_bags.mcap.reader import Bag
    from winch_controller_node.beliefs.beliefs import Beliefs

    from heave_bringup.output import warn
    from heave_bringup.whatif.asked import Wish, asked_of, nominal_of
    from heave_bringup.whatif.fitness import check_known, check_record
    from heave_bringup.whatif.identify.prior import prior_of
    from heave_bringup.whatif.known import drawn, learn, other_plants
    from heave_bringup.whatif.signals.from_bag import read_record, scenario_text, write_text
    from heave_bringup.whatif.signals.from_others import read_others
    from heave_bringup.whatif.study import answers, recorded, same_again
    from heave_bringup.whatif.twin.winch import winch_under
    from heave_bringup.whatif.words import Result

    if options.map is not None and options.scenario is None:
        raise CommandError(f"{source}: of others: say with --scenario what cable, unit, winch and controller are")
    scenario = options.scenario or write_text(scratch, scenario_text(Bag(source)))
    nominal, run = nominal_of(scenario)
    wish = Wish(scenario, options.law, options.set, [one for one in options.compare.split(",") if one])
    asked_of(wish, winch_under(Beliefs(-1), nominal), has_adviser=True)
    prior = prior_of(nominal, options.know)
    if options.map is None:
        record = read_record(Bag(source), nominal, progress=lambda share: progress.show("reading", share))
    else:
        record, notes = read_others(source, options.map, nominal, run.tick_period)
        warn(notes)
    record = record if options.end is None else record.part(options.end)
    start = run.transient if options.transient is None else options.transient
    check_record(record, start, str(options.bag))
    known = learn(record, nominal, start=start, prior=prior, show=progress.show)
    check_known(known, str(options.bag))
    others = [drawn(known, options.seed, number) for number in range(options.draws)]
    wanted = asked_of(wish, known.past.winch_parameters, has_adviser=record.has_adviser)
    plants = other_plants(known, options.seed)
    found = answers(known, wanted, others, plants, processes=os.cpu_count() or 1, show=progress.show)
    return Result(known, recorded(known), found, same_again(known, show=progress.show))


COMMAND = Command(
    name="whatif",
    summary="Experimental: say what another law, gain or winch would have done in the sea of a bag, by its sensors.",
    examples=(
        "heave whatif runs/b2_calm_300-001/bag --compare off,industrial,lqg,mpc",
        "heave whatif log.csv --map log_map.yaml --scenario b2_calm_300 --law mpc --compare off",
    ),
    add_arguments=add_arguments,
    execute=execute,
)
