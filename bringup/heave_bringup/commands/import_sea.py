"""`heave import`: a ship's own record as a sea for the loop."""

from __future__ import annotations

import argparse

from heave_bags.play.sea_import import import_sea, read_mapping, write_sea

from heave_bringup.bag_paths import bag_folders
from heave_bringup.output import write_result


def execute(options: argparse.Namespace) -> None:
    """Write the boom-tip motion as CSV and say how to run with it."""
    (source,) = bag_folders([options.source])
    sea = import_sea(source, options.topic or read_mapping(options.mapping))
    write_sea(sea, options.output, source)
    heave = sea.position[:, 2]
    text = [
        f"{options.output}: {sea.time[-1]:.1f} s of boom-tip motion, heave sigma {heave.std():.3f} m",
        *sea.notes,
        "run it: heave run SCENARIO --set wave_vessel.boom_tip_source=file "
        f"--set wave_vessel.recording_file={options.output.resolve()}",
    ]
    result = {
        "output": str(options.output.resolve()),
        "duration_s": float(sea.time[-1]),
        "heave_sigma_m": float(heave.std()),
        "notes": sea.notes,
    }
    write_result(options, "\n".join(text), result)
