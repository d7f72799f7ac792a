"""`heave identify`: the two-state cable a, b from a simulated or recorded response; the load from a recorded one."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.arguments import add_settings
from heave_bringup.errors import CommandError

if TYPE_CHECKING:
    from heave_studies.identification import Identification
    from heave_studies.reverse import LoadIdentification

SUMMARY = (
    "Fit the second-order cable model a z'' + b z' + z = z0 - p, or mass and drag area of the load, to a response."
)
EXAMPLES = ("heave identify b3_deep_900 --drag quadratic",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("source", metavar="SCENARIO|BAG", help="a shipped scenario, a parameter file, or a bag folder")
    add_settings(parser)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--drag", choices=("linear", "quadratic"), default="linear", help="thesis Eq. 6.2 or Eq. 6.3")
    what.add_argument(
        "--reverse",
        action="store_true",
        help="effective mass and drag area of the load with 95 %% bands, from depth, load cell, MRU and encoder of a "
        "bag, on the nominal cable of its scenario",
    )
    parser.add_argument("--picture", type=Path, metavar="FILE", help="default: NAME_identify.svg")


def execute(options: argparse.Namespace) -> None:
    """Identify and print a and b with their uncertainty, and draw the response by them, as `options` say."""
    from cable_sim_node.errors import PlantError
    from cable_sim_node.vertical.axial_stepper import advance
    from heave_bringup.output import check_output, write_result
    from heave_bringup.progress import ProgressLine
    from heave_bringup.scenarios import load_scenario
    from heave_node.numerics.compiled import is_compiled
    from winch_controller_node.model.lqr import DesignError

    from heave_studies.identification import IdentificationError, draw_identification, identify_simulated

    check_output("--picture", options.picture, (".png", ".svg", ".pdf"), makes_folder=True)
    is_bag = Path(options.source).is_dir()
    if options.reverse and not is_bag:
        raise CommandError(f"{options.source}: --reverse needs the bag of a run")
    if not is_bag and not is_compiled(advance):
        ProgressLine().tell("compiling the axial model: a few seconds, once after installation")
    try:
        found: Identification | LoadIdentification
        if options.reverse:
            found = _load_in_bag(Path(options.source), options.set)
        elif is_bag:
            found = _from_bag(Path(options.source), options.drag)
        else:
            scenario = load_scenario(options.source, settings=options.set)
            found = identify_simulated(
                scenario.parameters["winch_controller"], drag=options.drag, seed=scenario.run.seed
            )
    except (IdentificationError, PlantError, DesignError) as error:
        raise CommandError(f"{options.source}: {error}") from error
    picture = options.picture or Path(f"{Path(options.source).stem}_identify.svg")
    draw_identification(found, picture)
    write_result(options, f"{found.summary()}\n\npicture   {picture.resolve()}", found.values())


def _from_bag(path: Path, drag: str) -> Identification:
    """Identify from the motions in a bag, after its transient, with what the winch paid out."""
    import numpy as np
    from heave_bags.analyse.read_run import read_run
    from heave_bags.mcap.read.folder import bag_of

    from heave_studies.identification import identify

    folder = bag_of(path)
    record = read_run(folder)
    unit = record.signals.unit_heave.window(record.start, record.end)
    if unit.size < 2:
        raise CommandError(f"{folder}: holds no motion of the unit")
    step = float(np.median(np.diff(unit.time)))
    time = unit.time[0] + step * np.arange(int((unit.time[-1] - unit.time[0]) / step))
    signals = record.signals
    tip, heave, payout = (
        np.interp(time, signal.time, signal.value) if signal.size else np.zeros_like(time)
        for signal in (signals.boom_tip_heave, signals.unit_heave, signals.payout)
    )
    return identify(time, tip - tip.mean(), heave - heave.mean(), payout=payout - payout.mean(), drag=drag)


def _load_in_bag(path: Path, settings: Sequence[str]) -> LoadIdentification:
    """Identify the load from the sensors in a bag, on the cable of its scenario with `settings` of the user."""
    import math
    from dataclasses import replace

    from heave_bags.mcap.reader import Bag

    from heave_studies.kappa import stored_scenario
    from heave_studies.reverse import identify_load
    from heave_studies.whatif.fitness import check_record
    from heave_studies.whatif.record import read_record

    bag = Bag(path)
    nominal = stored_scenario(bag, settings).parameters["winch_controller"]
    record = read_record(bag, nominal)
    # an operator's requests and modes move the winch, which is measured
    check_record(replace(record, operated=math.inf, modes=()), float(record.time[0]), str(path))
    return identify_load(record, nominal)
