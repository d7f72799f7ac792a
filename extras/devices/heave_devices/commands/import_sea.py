"""`heave import`: a ship's own record as a sea for the loop."""

from __future__ import annotations

import argparse
import os
import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.command import add_model
from heave_bringup.errors import CommandError
from heave_node.parameters import ParameterError

from heave_devices.records.ship_time import DATE_ORDERS
from heave_devices.records.stretches import DEFAULT_BRIDGE, LONGEST_BRIDGE, Window

if TYPE_CHECKING:
    from heave_node.numerics.arrays import Array
    from heave_node.numerics.spectral_estimate import HeightAndPeriod
    from heave_node.scenario import Sections

    from heave_devices.maps.device_map import DeviceMap

SUMMARY = "Make a sea from a ship's record: a bag with a standard motion type, a log in columns, or a device's raw log."
EXAMPLES = (
    "heave import sea_trial/ --topic /imu/data --output sea.csv",
    "heave import mru.csv --column heave_m --output sea.csv --scenario sea.yaml --like unit_1500",
    "heave import seapath.nmea --mapping psxn --output sea.csv",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument(
        "source", metavar="BAG|LOG", type=Path, help="bag folder, MCAP file, or log (columns, or a device's raw output)"
    )
    chosen = parser.add_mutually_exclusive_group(required=True)
    chosen.add_argument("--topic", help="topic of a standard type that holds the motion")
    chosen.add_argument("--column", help="column that holds heave [m], positive up")
    chosen.add_argument(
        "--mapping",
        type=Path,
        metavar="FILE",
        help="mapping file: where to find surge, heave, roll...; or the device's map (heave adapt)",
    )
    parser.add_argument(
        "--output", type=Path, required=True, metavar="FILE", help="CSV file to write, for wave_vessel's file source"
    )
    parser.add_argument("--scenario", type=Path, metavar="FILE", help="also write a scenario that runs in this sea")
    add_model(parser, "scenario to take the other values from")
    for name, words in (("from", "begin"), ("to", "end")):
        parser.add_argument(
            f"--{name}",
            dest=words,
            default="",
            metavar="TIME",
            help=f"{words} here: seconds from the start of the record, or a time such as 2025-03-01T12:00:00Z",
        )
    parser.add_argument(
        "--bridge",
        type=float,
        default=DEFAULT_BRIDGE,
        metavar="S",
        help=f"interpolate gaps up to S seconds, at most {LONGEST_BRIDGE:g} (default: {DEFAULT_BRIDGE:g})",
    )
    _add_log_options(parser)
    parser.add_argument(
        "--accept-implausible",
        action="store_true",
        help="accept implausible values (heave of 130 m, fill values, a frozen sensor)",
    )
    parser.add_argument("--force", action="store_true", help="overwrite existing files")


def _add_log_options(parser: argparse.ArgumentParser) -> None:
    """Add what says how a log in columns is read, over what the mapping file says."""
    parser.add_argument("--scale", type=float, metavar="X", help="scale of --column: metres = X * number (0.01 for cm)")
    parser.add_argument(
        "--time-column",
        nargs="+",
        metavar="NAME",
        help="heading of the time column, of date and time, or of GPS week and seconds (default: found by name)",
    )
    parser.add_argument("--time-scale", type=float, metavar="X", help="seconds = X * number (0.001 for milliseconds)")
    parser.add_argument("--date-order", choices=DATE_ORDERS, help="how to read 01/03/2025 (default: detected)")


def execute(options: argparse.Namespace) -> None:
    """Write the boom-tip motion as CSV, a scenario of that sea, and say how to run, as `options` say."""
    from heave_bags.mcap.read.folder import bag_of
    from heave_bringup.output import write_result

    from heave_devices.records.sea_import import import_sea, write_sea
    from heave_devices.records.ship_time import time_words

    window = Window(options.begin, options.end, options.bridge)
    source = bag_of(options.source)
    for option in ("output", "scenario"):
        target: Path | None = getattr(options, option)
        if target is not None and target.resolve() == source.resolve():
            raise ParameterError(f"--{option} {target}: is the record itself, never written over; name another")
        if target is not None and target.exists() and not options.force:
            raise ParameterError(f"--{option} {target}: exists already; --force overwrites it")
    sea = import_sea(source, _mapping_of(options), window, accept_implausible=options.accept_implausible)
    write_sea(sea, options.output, source)
    heave = sea.position[:, 2]
    estimate, words = _height_and_period(heave, float(sea.time[1] - sea.time[0]))
    text = [
        f"{options.output}: {sea.time[-1]:.1f} s of boom-tip motion from {time_words(sea.start)}, "
        f"heave sigma {heave.std():.3f} m",
        words,
        *sea.notes,
        *_how_to_run(options, source, estimate, float(sea.time[-1])),
    ]
    result = {
        "output": str(options.output.resolve()),
        "scenario": str(options.scenario.resolve()) if options.scenario else None,
        "start_s": sea.start,
        "duration_s": float(sea.time[-1]),
        "heave_sigma_m": float(heave.std()),
        "significant_heave_m": None if estimate is None else estimate.significant_height,
        "significant_heave_interval_m": None if estimate is None else estimate.significant_height_interval,
        "peak_period_s": None if estimate is None else estimate.peak_period,
        "peak_period_interval_s": None if estimate is None else estimate.peak_period_interval,
        "notes": sea.notes,
    }
    write_result(options, "\n".join(text), result)


def _mapping_of(options: argparse.Namespace) -> DeviceMap | str:
    """Return where the motion is found, as `options` say: a mapping, or the name of a topic."""
    from heave_devices.adapt.shipped import shipped_maps
    from heave_devices.maps.channel import Channel
    from heave_devices.maps.device_map import DeviceMap
    from heave_devices.records.sea_mapping import read_mapping

    given = {name: getattr(options, name) for name in ("time_column", "time_scale", "date_order")}
    of_log = {name: value for name, value in given.items() if value is not None}
    if options.scale is not None and not options.column:
        raise ParameterError("--scale: belongs to --column; in a mapping file, write scale with each motion")
    if options.topic:
        if of_log:
            raise ParameterError(f"--{next(iter(of_log)).replace('_', '-')}: belongs to a log, not to --topic of a bag")
        return str(options.topic)
    if options.mapping:
        path = options.mapping
        return replace(read_mapping(path if path.exists() else shipped_maps().get(str(path), path)), **of_log)
    scale = 1.0 if options.scale is None else options.scale
    return DeviceMap({"heave": Channel(column=options.column, scale=scale)}, **of_log)


def _how_to_run(
    options: argparse.Namespace, source: Path, estimate: HeightAndPeriod | None, duration: float
) -> list[str]:
    """Write the scenario that is asked for; return the lines that say how the record is run."""
    if options.scenario:
        _write_scenario(options, source, estimate, duration)
        return [
            f"{options.scenario}: {options.like} in this sea, which the controller assumes",
            f"run it: heave run {shlex.quote(str(options.scenario))}",
        ]
    return [
        "run it: heave run SCENARIO --set wave_vessel.boom_tip_source=file --set "
        + shlex.quote(f"wave_vessel.recording_file={options.output.resolve()}"),
        "the controller still assumes the scenario's sea: --scenario FILE writes one that assumes this one",
    ]


def _write_scenario(
    options: argparse.Namespace, source: Path, estimate: HeightAndPeriod | None, duration: float
) -> None:
    """Write a scenario whose boom tip moves as recorded, and whose controller assumes its height and period."""
    from heave_bringup.pages.commented_scenario import commented_scenario
    from heave_bringup.scenarios import find_scenario, sections_for, write_scenario
    from heave_node.scenario import WILDCARD

    if estimate is None or estimate.peak_period is None:
        raise CommandError(f"{options.scenario}: not written: {source} gives no height and period to assume")
    sections = sections_for(find_scenario(options.like), options.scenario.parent)
    begun = float(sections[WILDCARD].get("transient", 60.0))  # type: ignore[arg-type]
    if duration <= begun:
        raise CommandError(
            f"{options.scenario}: not written: {duration:.0f} s of record are no more than the transient of "
            f"{options.like}, {begun:g} s; begin --like another"
        )
    of_sea = ("system.sea.", "system.vessel.", "system.course.")
    shared = {name: value for name, value in sections[WILDCARD].items() if not name.startswith(of_sea)}
    shared |= {
        "duration": float(int(duration - 1.0)),  # each tick asks for the boom tip at its end
        "system.sea.spectrum": "bretschneider",
        "system.sea.significant_wave_height": round(estimate.significant_height, 3),
        "system.sea.peak_period": round(estimate.peak_period, 2),
        "system.vessel.model": "direct",
    }
    recording = Path(os.path.relpath(options.output.resolve(), options.scenario.resolve().parent)).as_posix()
    vessel = {"boom_tip_source": "file", "recording_file": recording}
    others = {name: values for name, values in sections.items() if not name.endswith(("wave_vessel", WILDCARD))}
    text = commented_scenario(
        {WILDCARD: shared, "/**/wave_vessel": {**_mru_of(sections), **vessel}, **others},
        title=f"{options.scenario.stem}: the boom tip moves as in {source.name}; the rest is from {options.like}",
        path=str(options.scenario),
    )
    write_scenario(options.scenario, text)


def _mru_of(sections: Sections) -> dict[str, object]:
    """Return the parameters of a scenario's motion reference unit, which stay the same in another sea."""
    section = next((values for name, values in sections.items() if name.endswith("wave_vessel")), {})
    return {name: value for name, value in section.items() if name.startswith("mru.")}


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
