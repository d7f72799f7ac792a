"""A run in words: what was run, in what it differs from others, and what happened when."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from itertools import pairwise
from pathlib import Path
from typing import Any

from heave_node.interface.codes import without_figures

from heave_bags.analyse import events
from heave_bags.analyse.events import Interval
from heave_bags.analyse.kpis.window import Window
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.run_warnings import worse_times

MOST_DIFFERENCES = 3
"""Runs that differ in more are called by the names of their bags."""
OFTEN = 4
"""An alarm that comes so often in a run is one line of what happened, with their number."""
BURST = 10.0
"""A limit that acts again within this time is reported once [s]."""
UNITS = {"duration": "s", "peak_period": "s", "significant_wave_height": "m", "length": "m", "mass": "kg"}


def facts(record: RunRecord) -> dict[str, str]:
    """Return what was run in the run `record`, as far as its bag says: what it is about -> in words."""
    found = {
        "scenario": record.run.get("scenario", "") or record.name,
        "law": _law(record),
        "sea": _sea(_of(record, "wave_vessel")),
        "vessel": _vessel(_of(record, "wave_vessel")),
        "cable": _cable(_of(record, "cable_sim")),
        "unit": _unit(_of(record, "cable_sim")),
        "winch": _winch(_of(record, "virtual_winch")),
        "run": _run(record),
        "software": _software(record.run),
        "date": _date(record.run),
    }
    return {name: text for name, text in found.items() if text}


def _of(record: RunRecord, node: str) -> Mapping[str, Any]:
    return record.parameters.get(node, {})


def _number(parameters: Mapping[str, Any], name: str, scale: float = 1.0) -> str:
    value = parameters.get(name)
    return f"{scale * value:.4g}" if isinstance(value, int | float) and math.isfinite(value) else "?"


def _law(record: RunRecord) -> str:
    controller = _of(record, "winch_controller")
    law = str(controller.get("law", ""))
    factor = controller.get("factor", 1.0)
    return f"{law}, factor {factor:g}" if law and isinstance(factor, int | float) and factor != 1.0 else law


def _sea(vessel: Mapping[str, Any]) -> str:
    source = vessel.get("boom_tip_source")
    if source == "spectrum":
        height, period = (_number(vessel, name) for name in ("significant_wave_height", "peak_period"))
        return f"{vessel.get('spectrum', 'spectrum')}, Hs {height} m, Tp {period} s"
    if source == "regular":
        return f"none: the boom tip is moved with a period of {_number(vessel, 'period')} s"
    if source == "file":
        name = Path(str(vessel.get("recording_file", ""))).name
        return f"recorded: {name}" if name else "recorded"
    return str(source or "")


def _vessel(vessel: Mapping[str, Any]) -> str:
    model = str(vessel.get("vessel.model", ""))
    if vessel.get("boom_tip_source") != "spectrum":
        return ""
    if model == "second_order":
        own = _number(vessel, "vessel.natural_frequency"), _number(vessel, "vessel.damping_ratio")
        return f"second order, {own[0]} rad/s, damping ratio {own[1]}"
    file = Path(str(vessel.get("vessel.rao_file", ""))).name
    return f"{model} {file}".strip()


def _cable(plant: Mapping[str, Any]) -> str:
    if "length" not in plant:
        return ""
    diameter, mass = _number(plant, "cable.diameter", 1e3), _number(plant, "cable.mass_per_length")
    stiffness = _number(plant, "cable.axial_stiffness", 1e-6)
    return f"{_number(plant, 'length')} m, {diameter} mm, {mass} kg/m, EA {stiffness} MN"


def _unit(plant: Mapping[str, Any]) -> str:
    return f"{_number(plant, 'unit.mass', 1e-3)} t" if "unit.mass" in plant else ""


def _winch(winch: Mapping[str, Any]) -> str:
    if "speed_limit" not in winch:
        return ""
    kind = str(winch.get("law") or winch.get("drive") or "").replace("_", " ")
    limits = f"{_number(winch, 'speed_limit')} m/s, {_number(winch, 'acceleration_limit')} m/s²"
    return f"{kind}, at most {limits}, delay {_number(winch, 'command_delay')} s"


def _run(record: RunRecord) -> str:
    pacing = record.run.get("pacing", "")
    parts = [pacing] if pacing else []
    parts += ["all nodes in one process"] if record.run.get("composed") == "true" else []
    parts += [f"seed {record.run['seed']}"] if "seed" in record.run else []
    return ", ".join([*parts, f"figures from {record.start:.0f} s to {record.end:.0f} s"])


def _software(run: Mapping[str, str]) -> str:
    version = run.get("version.heave", "")
    commit, mark, _ = run.get("git_commit", "").partition("+")
    words = f"heave {version}".strip() if version or commit else ""
    words += f", commit {commit[:10]}{' with changes' if mark else ''}" if commit else ""
    return words + (f", Python {run['version.python']}" if "version.python" in run else "")


def _date(run: Mapping[str, str]) -> str:
    try:
        seconds = int(run["started_at_host_time_ns"]) * 1e-9
        return datetime.fromtimestamp(seconds, tz=timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    except (KeyError, ValueError, OverflowError, OSError):
        return ""


@dataclass(frozen=True)
class Difference:
    """Something in which runs differ: its `name`, and the `values` of the runs in words, in its `unit`."""

    name: str
    values: tuple[str, ...]
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.name}: {' / '.join(dict.fromkeys(self.values))} {self.unit}".rstrip()

    def of(self, number: int) -> str:
        """Return in words what run `number` has."""
        if self.values[number] == "-" and not self.unit:
            return f"no {self.name}"
        return f"{self.name} {self.values[number]} {self.unit}".rstrip()


def differences(records: Sequence[RunRecord]) -> list[Difference]:
    """Return in which parameters the runs `records` differ, what ship and controller share once; the law first."""
    parameters = [{node: _with_faults(own) for node, own in record.parameters.items()} for record in records]
    names = {(node, name) for run in parameters for node, own in run.items() for name in own}
    found: dict[tuple[str, tuple[str, ...]], set[str]] = {}
    for node, name in names:
        values = tuple(_text(run.get(node, {}).get(name)) for run in parameters)
        if len(set(values)) > 1:
            found.setdefault((name.rsplit(".", 1)[-1], values), set()).add(name)
    scenarios = tuple(record.run.get("scenario", "") for record in records)
    own = [Difference("scenario", scenarios)] if len(set(scenarios)) > 1 else []
    others = [
        Difference(
            (short if len(full) > 1 else min(full)).replace("_", " ").replace(".", " "), values, UNITS.get(short, "")
        )
        for (short, values), full in found.items()
    ]
    return own + sorted(others, key=lambda one: (one.name != "law", one.name == "seed", one.name))


def _with_faults(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the `parameters` of a node with the four lists of faults of a device as one value, in words."""
    found = dict(parameters)
    for group in [name.removesuffix(".kind") for name in found if name.endswith("faults.kind")]:
        lists = [found.pop(f"{group}.{name}", ()) for name in ("kind", "start", "duration", "magnitude")]
        found[group] = ", ".join(map(_fault, *(one if isinstance(one, list | tuple) else () for one in lists)))
    return found


def _fault(kind: Any, start: Any, duration: Any, magnitude: Any) -> str:
    """Return a scheduled fault in words: what, how large, when [s] and for how long [s]; a bag may state anything."""
    size = f" {_text(magnitude)}" if magnitude else ""
    return f"{_text(kind)}{size} from {_text(start)} s" + (f" for {_text(duration)} s" if duration else "")


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if value is None or value in ("", [], ()):
        return "-"  # an empty list that one bag states, and another does not, is no difference
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_text(item) for item in value) + "]"
    return str(value)


def labels(records: Sequence[RunRecord]) -> list[str]:
    """Return what to call each of the runs `records` beside the others: what differs, or else the name of its bag."""
    found = differences(records) if len(records) > 1 else []
    if not 0 < len(found) <= MOST_DIFFERENCES:
        return [record.name for record in records]
    if len(found) == 1 and found[0].name in ("law", "scenario"):
        called = list(found[0].values)
    else:
        called = [", ".join(one.of(n) for one in found) for n in range(len(records))]
    return [
        f"{label} ({record.name})" if called.count(label) > 1 else label
        for label, record in zip(called, records, strict=True)
    ]


def title(records: Sequence[RunRecord]) -> str:
    """Return what a report of the runs `records` is about: the lift or its scenario and, of several, what differs."""
    scenarios = list(dict.fromkeys(record.title or record.run.get("scenario") or record.name for record in records))
    if len(records) == 1:
        return scenarios[0]
    found = [one for one in differences(records) if one.name != "scenario"]
    shown = "; ".join(str(one) for one in found[:MOST_DIFFERENCES])
    more = f"; {len(found) - MOST_DIFFERENCES} more differences" if len(found) > MOST_DIFFERENCES else ""
    return f"{' and '.join(scenarios)}: {shown}{more}" if shown else " and ".join(scenarios)


@dataclass(frozen=True)
class Happening:
    """Something that happened, `text`, from `start` to `end` [s]; `level` 0 plain, 1 warning, 2 error."""

    start: float
    end: float
    text: str
    level: int = 0

    @property
    def when(self) -> str:
        """The time in words."""
        return f"{self.start:.1f} s" if self.end - self.start < 0.05 else f"{self.start:.1f} s to {self.end:.1f} s"


def happenings(record: RunRecord) -> list[Happening]:
    """Return what happened in the run `record`, in order: modes, harm, requests, landings, limits and alarms."""
    found = [*_modes(record.modes), *_landings(record), *_limits(record.limits)]
    found += [Happening(one.start, one.end, f"worse than off: {one.most}", 2) for one in worse_times(record)]
    found += [Happening(one.start, one.end, f"operator: {one.name}") for one in record.requests]
    return sorted([*found, *_alarms(record.alarms)], key=lambda one: one.start)


def _alarms(alarms: Sequence[Interval]) -> list[Happening]:
    """Return the `alarms`; one that comes again and again is one line from the first to the last."""
    kinds: dict[tuple[str, int], list[Interval]] = {}
    for alarm in sorted(alarms, key=lambda one: one.start):
        kinds.setdefault((without_figures(alarm.name), alarm.level), []).append(alarm)
    found: list[Happening] = []
    for (_, level), same in kinds.items():
        if len(same) < OFTEN:
            found += [Happening(one.start, one.end, one.name, level) for one in same]
        else:
            end = max(one.end for one in same)
            found.append(Happening(same[0].start, end, f"{len(same)} times, first: {same[0].name}", level))
    return found


def losses(record: RunRecord) -> list[str]:
    """Return in words each loss of compensation in the run `record` that nobody had requested."""
    return [events.loss_words(mode.start, mode.name, mode.reason) for mode in events.losses(record.modes)]


def _modes(modes: Sequence[Interval]) -> list[Happening]:
    found = [_mode(modes[0], f"begins in mode {modes[0].name}")] if modes else []
    for before, mode in pairwise(modes):
        if events.is_loss(before.name, mode.name, mode.reason):
            found.append(_mode(mode, f"{events.LOST}: mode {mode.name}", 2))
        else:
            found.append(_mode(mode, f"mode {mode.name}"))
    return found


def _mode(mode: Interval, words: str, level: int = 0) -> Happening:
    return Happening(mode.start, mode.start, f"{words}{f': {mode.reason}' if mode.reason else ''}", level)


def _landings(record: RunRecord) -> list[Happening]:
    window = Window(record.signals, -math.inf, math.inf)
    words = "the unit touches the bottom at {:.2f} m/s and rebounds by {:.1f} cm"
    return [Happening(one.time, one.time, words.format(one.speed, 100.0 * one.rebound)) for one in window.landings]


def _limits(limits: Sequence[Interval]) -> list[Happening]:
    """Return when a limit acted, those of short order as one."""
    found: list[Happening] = []
    for name in dict.fromkeys(limit.name for limit in limits):
        parts = sorted((limit for limit in limits if limit.name == name), key=lambda limit: limit.start)
        bursts: list[list[Interval]] = []
        for part in parts:
            if bursts and part.start - bursts[-1][-1].end < BURST:
                bursts[-1].append(part)
            else:
                bursts.append([part])
        for burst in bursts:
            acting = sum(part.end - part.start for part in burst)
            words = "brake on" if name == "brake" else f"winch at its {name} limit for {acting:.1f} s"
            found.append(Happening(burst[0].start, burst[-1].end, words))
    return found
