"""`heave bench`: how fast the suite is on this machine, beside a peer where there is one."""

from __future__ import annotations

import argparse
import importlib.util
import math
import os
from collections.abc import Callable
from typing import Any

from cable_sim_node.peers.benchmark import measure_plant
from heave_node.parameters import ParameterError

from heave_bringup.bench.controller import measure_controller
from heave_bringup.bench.loop import measure_loop
from heave_bringup.bench.recorder import measure_recorder
from heave_bringup.output import write_result
from heave_bringup.progress import ProgressLine

SEGMENTS = (20, 50, 100, 200)


def execute(options: argparse.Namespace) -> None:
    """Measure what was asked for, one after the other, and print it."""
    if not 0.0 < options.seconds < math.inf:
        raise ParameterError(f"--seconds {options.seconds:g}: must be a number above 0")
    progress = ProgressLine()
    result: dict[str, Any] = {"processors": os.cpu_count()}
    try:
        if "plant" in options.only:
            progress.show("plant: beside MoorDyn")
            result["plant"] = measure_plant(SEGMENTS, peer=importlib.util.find_spec("moordyn") is not None)
        if "loop" in options.only:
            result["loop"] = measure_loop(options.seconds, progress.show)
        if "controller" in options.only:
            result["controller"] = measure_controller(options.seconds, progress.show)
        if "recorder" in options.only:
            result["recorder"] = measure_recorder(min(options.seconds, 20.0), progress.show)
    finally:
        progress.close()
    write_result(options, "\n\n".join(text(result[part]) for part, text in _TEXTS.items() if part in result), result)


def _plant(rows: list[dict[str, Any]]) -> str:
    lines = ["plant       ms per simulated s  times real time  error %  MoorDyn's time over ours"]
    for row in rows:
        own = row["ms_per_simulated_s"]
        peer = row["ratio_to_moordyn"]
        lines.append(
            f"{row['segments']:4d} segments {own:18.3f} {1e3 / own:16.0f} {row['error_percent']:8.4f} "
            + (f"{peer:25.1f}" if math.isfinite(peer) else "  (MoorDyn is not installed)")
        )
    return "\n".join(lines)


def _loop(values: dict[str, Any]) -> str:
    lines = [
        f"loop over ROS, {values['processes']} processes, recorded: {values['ticks_per_s']:.0f} ticks/s, "
        f"{values['real_time_factor']:.1f} x real time, loop age p50 {1e3 * values['loop_age_p50_s']:.2f} ms, "
        f"p99 {1e3 * values['loop_age_p99_s']:.2f} ms"
    ]
    used = values["cpu_ms_per_tick"]
    lines += [
        f"  {name.ljust(18)} {milliseconds:6.3f} ms processor time per tick" for name, milliseconds in used.items()
    ]
    total = sum(used.values())
    floor = total / (os.cpu_count() or 1)
    lines.append(f"  {'together'.ljust(18)} {total:6.3f} ms: no more than {1e3 / floor:.0f} ticks/s on this machine")
    return "\n".join(lines)


def _controller(rows: list[dict[str, Any]]) -> str:
    return "\n".join(
        [
            "controller     step p50 ms     p99 ms     max ms",
            *(
                f"{row['law'].ljust(12)} {1e3 * row['step_p50_s']:13.3f} {1e3 * row['step_p99_s']:10.3f} "
                f"{1e3 * row['step_max_s']:10.3f}"
                for row in rows
            ),
        ]
    )


def _recorder(values: dict[str, Any]) -> str:
    return (
        f"recorder: {values['messages_per_s']:.0f} messages/s of 1 kB, {values['dropped']:.0f} of {values['sent']:.0f} "
        f"dropped, {values['cpu_us_per_message']:.1f} us processor time each"
    )


_TEXTS: dict[str, Callable[[Any], str]] = {
    "plant": _plant,
    "loop": _loop,
    "controller": _controller,
    "recorder": _recorder,
}
