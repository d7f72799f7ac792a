"""`heave import`: a ship's own record as a sea for the loop."""

from __future__ import annotations

import argparse
from pathlib import Path

from heave_bringup.commands.command import Command


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("source", metavar="BAG|CSV", type=Path, help="bag folder, MCAP file or CSV log")
    chosen = parser.add_mutually_exclusive_group(required=True)
    chosen.add_argument("--topic", help="the one topic of a standard type that holds the motion")
    chosen.add_argument("--mapping", type=Path, metavar="FILE", help="mapping file: where surge, heave, roll... are")
    parser.add_argument("--output", type=Path, required=True, metavar="FILE", help="CSV for wave_vessel's file source")


def execute(options: argparse.Namespace) -> None:
    """Write the boom-tip motion as CSV and say how to run with it."""
    from heave_bags.play.sea_import import import_sea, read_mapping, write_sea

    from heave_bringup.bag_paths import bag_folders
    from heave_bringup.output import write_result

    (source,) = bag_folders([options.source])
    sea = import_sea(source, options.topic or read_mapping(options.mapping))
    write_sea(sea, options.output, source)
    heave = sea.position[:, 2]
    text = [
        f"{options.output}: {sea.time[-1]:.1f} s of boom-tip motion, heave sigma {heave.std():.3f} m",
        *sea.notes,
        "run it: heave run SCENARIO --set wave_vessel.boom_tip_source=file "
        f"--set wave_vessel.recording_file={options.output.resolve()}",
        "the controller still believes in the scenario's sea: describe this one by "
        "--set system.sea.significant_wave_height=H --set system.sea.peak_period=T",
    ]
    result = {
        "output": str(options.output.resolve()),
        "duration_s": float(sea.time[-1]),
        "heave_sigma_m": float(heave.std()),
        "notes": sea.notes,
    }
    write_result(options, "\n".join(text), result)


COMMAND = Command(
    name="import",
    summary="Make a sea of a ship's own record: a bag of any standard motion type, or a CSV log.",
    examples=("heave import sea_trial/ --topic /imu/data --output sea.csv",),
    add_arguments=add_arguments,
    execute=execute,
)
