"""`make bench`: how fast the suite is on this machine, beside a peer where there is one."""

from __future__ import annotations

import argparse
import math
import os
from typing import Any

from heave_node.parameters import ParameterError

SUMMARY = (
    "Measure the speed of the plant (beside MoorDyn) and of statics (beside MoorPy), the loop over ROS, the "
    "controller and the recorder on this machine, and how late the loop is in real time."
)

EXAMPLE = "example: make bench BENCH='--only loop controller --json bench.json'"

PARTS = ("plant", "statics", "loop", "controller", "recorder", "realtime")
SEGMENTS = (20, 50, 100, 200, 400, 1000)
LONGEST_RECORDING = 20.0
"""The recorder's load is constant: more of it says nothing new [s]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS, metavar="PART", help=", ".join(PARTS))
    parser.add_argument(
        "--rates", nargs="+", type=float, default=(20.0, 50.0, 100.0), metavar="HZ", help="of the loop in real time"
    )
    parser.add_argument("--composed", action="store_true", help="in real time too all nodes in one process")
    parser.add_argument("--seconds", type=float, default=120.0, metavar="S", help="duration of each measurement")


def execute(options: argparse.Namespace) -> None:
    """Run the requested measurements one after another, and print them, as `options` say."""
    from heave_bringup.output import write_result
    from heave_bringup.progress import ProgressLine

    from benchmarks.bench.report import has_peer, tables

    if not 0.0 < options.seconds < math.inf:
        raise ParameterError(f"--seconds {options.seconds:g}: must be a number above 0")
    result: dict[str, Any] = {"processors": os.cpu_count()}
    with ProgressLine() as progress:
        if "plant" in options.only:
            from tests.validation.peers.benchmark import measure_plant

            progress.show("plant: beside MoorDyn" if has_peer() else "plant")
            result["plant"] = measure_plant(SEGMENTS, peer=has_peer())
        if "statics" in options.only:
            from tests.validation.peers.catenaries import measure_statics

            progress.show("statics")
            result["statics"] = measure_statics()
        if "loop" in options.only:
            from heave_bringup.run.run import Composed

            from benchmarks.bench.loop import measure_loop

            result["loop"] = measure_loop(options.seconds, progress.show)
            result["composed_loop"] = measure_loop(options.seconds, progress.show, Composed())
        if "controller" in options.only:
            from benchmarks.bench.controller import measure_controller

            result["controller"] = measure_controller(options.seconds, progress.show)
        if "recorder" in options.only:
            from benchmarks.bench.recorder import measure_recorder

            result["recorder"] = measure_recorder(min(options.seconds, LONGEST_RECORDING), progress.show)
        if "realtime" in options.only:
            from heave_bringup.run.run import Composed

            from benchmarks.bench.loop import measure_realtime

            composed = Composed() if options.composed else None
            result["realtime"] = [
                measure_realtime(rate, options.seconds, progress.show, composed) for rate in options.rates
            ]
    write_result(options, tables(result), result)


def main() -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.bench",
        description=SUMMARY,
        epilog=EXAMPLE,
    )
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for standard output")
    add_arguments(parser)
    execute(parser.parse_args())


if __name__ == "__main__":
    main()
