"""What `make bench` measured, as tables for people."""

from __future__ import annotations

import importlib.util
import math
import os
from collections.abc import Callable, Mapping
from typing import Any

from heave_bringup.output import make_table
from heave_node.extras import how_to_install
from heave_node.tick.durations import LAST
from rich.table import Table

HOW_TO_GET_THE_PEER = "{} is not installed; to compare with it, " + how_to_install("bench")


def has_peer() -> bool:
    """Return whether MoorDyn, the peer of the plant, is installed."""
    return importlib.util.find_spec("moordyn") is not None


def tables(result: Mapping[str, Any]) -> list[Table | str]:
    """Return what is to be printed for the parts of `result` that were measured."""
    return [line for part, make in _PARTS.items() if part in result for line in make(result[part])]


def _plant(rows: list[dict[str, Any]]) -> list[Table | str]:
    peers = list(rows[0]["peers"])
    columns = ["plant", "ms per simulated s", "times real time", "error %"]
    columns += [column for name in peers for column in (f"MoorDyn {name}: ms", "error %")]
    columns += ["MoorDyn's best time over ours"] if peers else []
    cells = []
    for row in rows:
        own = row["ms_per_simulated_s"]
        line = [f"{row['segments']} segments", f"{own:.3f}", f"{1e3 / own:.0f}", f"{row['error_percent']:.4f}"]
        for name in peers:
            peer = row["peers"][name]
            error = peer["error_percent"]
            line += [f"{peer['ms_per_simulated_s']:.2f}", f"{error:.4f}" if math.isfinite(error) else "-"]
        cells.append([*line, f"{row['ratio_to_moordyn']:.1f}"] if peers else line)
    table = make_table(columns, cells)
    return [table] if peers else [table, HOW_TO_GET_THE_PEER.format("MoorDyn")]


def _statics(rows: list[dict[str, Any]]) -> list[Table | str]:
    columns = ["cable between two ends", "ms a solve"]
    cells = [[row["cable"], f"{row['ms']:.3f}"] for row in rows]
    if not math.isfinite(rows[0]["peer_ms"]):
        return [make_table(columns, cells), HOW_TO_GET_THE_PEER.format("MoorPy")]
    columns += ["MoorPy: ms", "its time over ours", "difference of the tension %"]
    for line, row in zip(cells, rows, strict=True):
        line += [f"{row['peer_ms']:.3f}", f"{row['ratio_to_moorpy']:.1f}", f"{row['difference_percent']:.1e}"]
    return [make_table(columns, cells)]


def _loop(values: dict[str, Any]) -> list[Table | str]:
    used = values["cpu_ms_per_tick"]
    total = sum(used.values())
    many = "all nodes in one process" if values["processes"] == 1 else f"over ROS, {values['processes']} processes"
    head = (
        f"loop {many}, recorded: {values['ticks_per_s']:.0f} ticks/s, "
        f"{values['real_time_factor']:.1f} x real time, loop age p50 {1e3 * values['loop_age_p50_s']:.2f} ms, "
        f"p99 {1e3 * values['loop_age_p99_s']:.2f} ms"
    )
    rows = [[name, f"{milliseconds:.3f}"] for name, milliseconds in [*used.items(), ("together", total)]]
    processors = min(len(used), os.cpu_count() or 1)
    bound = f"that allows at most {1e3 * processors / total:.0f} ticks/s on this machine"
    return [head, make_table(["process", "ms of processor time per tick"], rows), bound]


def _controller(rows: list[dict[str, Any]]) -> list[Table | str]:
    return [
        make_table(
            ["controller", "step p50 ms", "p99 ms", "max ms"],
            [
                [row["law"], *(f"{1e3 * row[key]:.3f}" for key in ("step_p50_s", "step_p99_s", "step_max_s"))]
                for row in rows
            ],
        )
    ]


def _recorder(values: dict[str, Any]) -> list[Table | str]:
    return [
        f"recorder: {values['messages_per_s']:.0f} messages/s of 1 kB, {values['dropped']:.0f} of "
        f"{values['sent']:.0f} dropped, {values['cpu_us_per_message']:.1f} us processor time each"
    ]


def _realtime(rows: list[dict[str, Any]]) -> list[Table | str]:
    def line(name: str, values: Mapping[str, Any], prefix: str) -> list[str]:
        return [name, *(f"{1e3 * values[f'{prefix}{key}']:.2f}" for key in ("p50_s", "p99_s", "max_s"))]

    printed: list[Table | str] = []
    for row in rows:
        where = "one process" if row["composed"] else f"{len(row['cpu_ms_per_tick'])} processes"
        printed += [
            f"real time, {row['rate_hz']:g} Hz for {row['duration_s']:g} s, {where}, recorded: "
            f"{row['missed_deadlines']} deadlines missed; load of the machine {row['load']:.1f}",
            make_table(
                ["wall time", "p50 ms", "p99 ms", "largest ms"],
                [line("loop age", row, "loop_age_"), line("stalls of a process that sleeps", row["stalls"], "")],
            ),
        ]
        histograms = {**row["histograms_ms"], "stalls of a process that sleeps": row["stalls"]["histogram_ms"]}
        edges = sorted({edge for counts in histograms.values() for edge in counts}, key=_edge)
        cells = [[name, *(str(counts.get(edge, "")) for edge in edges)] for name, counts in histograms.items()]
        printed.append(make_table(["count up to [ms]", *edges], cells))
        used = [[name, f"{milliseconds:.3f}"] for name, milliseconds in row["cpu_ms_per_tick"].items()]
        printed.append(make_table(["process", "ms of processor time per tick"], used))
    return printed


def _edge(name: str) -> float:
    return math.inf if name == LAST else float(name)


_PARTS: dict[str, Callable[[Any], list[Table | str]]] = {
    "plant": _plant,
    "statics": _statics,
    "loop": _loop,
    "composed_loop": _loop,
    "controller": _controller,
    "recorder": _recorder,
    "realtime": _realtime,
}
