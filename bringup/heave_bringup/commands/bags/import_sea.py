"""`heave import`: a ship's own record as a sea for the loop."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.command import Command

if TYPE_CHECKING:
    from heave_node.numerics.arrays import Array
    from heave_node.numerics.spectral_estimate import HeightAndPeriod


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("source", metavar="BAG|CSV", type=Path, help="bag folder, MCAP file or CSV log")
    chosen = parser.add_mutually_exclusive_group(required=True)
    chosen.add_argument("--topic", help="the one topic of a standard type that holds the motion")
    chosen.add_argument(
        "--mapping", type=Path, metavar="FILE", help="mapping file: where to find surge, heave, roll..."
    )
    parser.add_argument(
        "--output", type=Path, required=True, metavar="FILE", help="CSV file to write, for wave_vessel's file source"
    )


def execute(options: argparse.Namespace) -> None:
    """Write the boom-tip motion as CSV and say how to run with it, as `options` say."""
    from heave_bags.play.sea_import import import_sea, read_mapping, write_sea

    from heave_bringup.bag_paths import bag_folders
    from heave_bringup.output import write_result

    (source,) = bag_folders([options.source])
    sea = import_sea(source, options.topic or read_mapping(options.mapping))
    write_sea(sea, options.output, source)
    heave = sea.position[:, 2]
    estimate, words = _height_and_period(heave, float(sea.time[1] - sea.time[0]))
    text = [
        f"{options.output}: {sea.time[-1]:.1f} s of boom-tip motion, heave sigma {heave.std():.3f} m",
        words,
        *sea.notes,
        "run it: heave run SCENARIO --set wave_vessel.boom_tip_source=file "
        f"--set wave_vessel.recording_file={options.output.resolve()}",
        "the controller still assumes the scenario's sea: describe this one with "
        "--set system.sea.significant_wave_height=H --set system.sea.peak_period=T",
    ]
    result = {
        "output": str(options.output.resolve()),
        "duration_s": float(sea.time[-1]),
        "heave_sigma_m": float(heave.std()),
        "significant_heave_m": None if estimate is None else estimate.significant_height,
        "significant_heave_interval_m": None if estimate is None else estimate.significant_height_interval,
        "peak_period_s": None if estimate is None else estimate.peak_period,
        "peak_period_interval_s": None if estimate is None else estimate.peak_period_interval,
        "notes": sea.notes,
    }
    write_result(options, "\n".join(text), result)


def _height_and_period(heave: Array, period: float) -> tuple[HeightAndPeriod | None, str]:
    """Return what the record of heave [m], samples `period` [s] apart, gives, and the line that says it."""
    from heave_node.numerics.spectral_estimate import RecordTooShortError, height_and_period

    try:
        found = height_and_period(heave, period)
    except RecordTooShortError as error:
        return None, f"no significant height and peak period: {error}"
    low, high = found.significant_height_interval
    shortest, longest = found.peak_period_interval
    return found, (
        f"significant heave {found.significant_height:.2f} m ({low:.2f} to {high:.2f}), peak period "
        f"{found.peak_period:.1f} s ({shortest:.1f} to {longest:.1f}); 95 % intervals"
    )


COMMAND = Command(
    name="import",
    summary="Make a sea from a ship's own record: a bag with any standard motion type, or a CSV log.",
    examples=("heave import sea_trial/ --topic /imu/data --output sea.csv",),
    add_arguments=add_arguments,
    execute=execute,
)
