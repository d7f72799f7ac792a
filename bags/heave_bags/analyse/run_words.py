"""A run in words: what was run, and what happened when."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from itertools import pairwise
from pathlib import Path
from typing import Any

from heave_node.interface.alarm import Severity, alarms_in
from heave_node.interface.codes import without_figures
from heave_node.loads.strength import mass_words, payload_words
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY

from heave_bags.analyse import events
from heave_bags.analyse.differences import changes, scheduled_faults
from heave_bags.analyse.events import Interval
from heave_bags.analyse.kpis.window import Window
from heave_bags.analyse.reading.stored import cable_weight, number
from heave_bags.analyse.run_record import SEA, RunRecord
from heave_bags.analyse.run_warnings import ERROR, worse_times

OFTEN = 4
"""An alarm that comes so often in a run is one line of what happened, with their number."""
BURST = 10.0
"""A limit that acts again within this time is reported once [s]."""


def facts(record: RunRecord) -> dict[str, str]:
    """Return what was run in the run `record`, as far as its bag says: what it is about -> in words."""
    found = {
        "scenario": record.run.get("scenario", "") or record.name,
        **lift_facts(record.parameters),
        **({"sea": record.sea_run, "vessel": ""} if SEA in record.replaced else {}),
        "run": _run(record),
        **changes(record),
        "software": _software(record.run),
        "date": _date(record.run),
    }
    return {name: text for name, text in found.items() if text}


def lift_facts(parameters: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """Return law, sea, vessel, load, rope and winch in words, by the `parameters` of each node by dotted name."""
    vessel, plant = parameters.get(SEA, {}), parameters.get("cable_sim", {})
    return {
        "law": _law(parameters.get("winch_controller", {})),
        "sea": _sea(vessel),
        "vessel": _vessel(vessel),
        "load": _load(plant),
        "rope": _cable(plant),
        "winch": _winch(parameters.get("virtual_winch", {})),
    }


def _number(parameters: Mapping[str, Any], name: str, scale: float = 1.0) -> str:
    value = parameters.get(name)
    return f"{scale * value:.4g}" if isinstance(value, int | float) and math.isfinite(value) else "?"


def _law(controller: Mapping[str, Any]) -> str:
    place, _, own = str(controller.get("law", "")).rpartition(":")  # of a law of one's own, which may be a file
    law = f"{Path(place).name}:{own}" if place else own
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


def _load(plant: Mapping[str, Any]) -> str:
    """Return the load in air and in water, and at the hook with the rope that is paid out, at rest."""
    mass, volume = (number(plant, f"unit.{name}", math.nan) for name in ("mass", "volume"))
    density, gravity = (
        number(plant, name, usual)
        for name, usual in (("water_density", SEAWATER_DENSITY), ("gravity", STANDARD_GRAVITY))
    )
    if not math.isfinite(mass + volume):
        return ""
    words = payload_words(mass, volume, density)
    rope = number(plant, "length", math.nan) * cable_weight(plant) / gravity
    return f"{words}, hook load {mass_words(mass - density * volume + rope)}" if math.isfinite(rope) else words


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
    """Return what happened in the run `record`, in order: modes, harm, requests, landings, limits, faults, alarms."""
    found = [*_modes(record.modes), *_landings(record), *_limits(record.limits), *_faults(record)]
    found += [
        Happening(one.start, one.end, f"load moved more than with the winch locked: {one.most}", 2)
        for one in worse_times(record)
    ]
    found += _requests(record.requests)
    return sorted([*found, *_alarms(record.alarms)], key=lambda one: one.start)


def _requests(requests: Sequence[Interval]) -> list[Happening]:
    """Return what an operator has requested; of a joystick's speeds the first, and what ends the motion."""
    found, drives = [], False
    for one in requests:
        drove, drives = drives, one.name.startswith("speed ") and not one.name.startswith("speed +0 m/s")
        if not (drove and drives):
            found.append(Happening(one.start, one.end, f"operator: {one.name}"))
    return found


def _faults(record: RunRecord) -> list[Happening]:
    """Return the faults that were scheduled, as far as the run came to them."""
    begun = [one for one in scheduled_faults(record) if one.start <= record.end]
    return [Happening(one.start, min(one.end, record.end), one.words) for one in begun]


def _alarms(alarms: Sequence[Interval]) -> list[Happening]:
    """Return the `alarms`; one that comes again and again, whatever follows, is one line from the first to the last."""
    kinds: dict[tuple[str, int], list[Interval]] = {}
    for alarm in sorted(alarms, key=lambda one: one.start):
        kinds.setdefault((without_figures(alarm.name.partition(". ")[0]), alarm.level), []).append(alarm)
    found: list[Happening] = []
    for (_, level), same in kinds.items():
        if len(same) < OFTEN:
            found += [Happening(one.start, one.end, _alarm_words(one.name), level) for one in same]
        else:
            words = f"{len(same)} times, first: {_alarm_words(same[0].name)}"
            found.append(Happening(same[0].start, max(one.end for one in same), words, level))
    return found


def errors(record: RunRecord) -> list[str]:
    """Return critical and high alarms of the run `record` and what else was an error, the gravest first, as lines."""
    grave = [one for one in record.alarms if one.level == ERROR]
    found = sorted(_alarms(grave), key=lambda one: (-_severity(one.text), one.start))
    stops = [one for one in _modes(record.modes) if one.text.startswith(f"mode {events.EMERGENCY_STOP}")]
    return [f"{one.when}: {one.text}" for one in (*stops, *found)]


def _severity(text: str) -> Severity:
    """Return the severity of an error: that of its gravest alarm; of one without a code it is high."""
    return max((one.severity for one in alarms_in(text)), default=Severity.HIGH)


def _alarm_words(name: str) -> str:
    """Return what an alarm of a `name` reports, without the part of diagnostics; of an event without its severity."""
    text = name.removeprefix(f"{events.ALARMS_PART}: ")
    found = alarms_in(text)
    if any(one.severity is not Severity.EVENT for one in found):
        return text
    return "; ".join(f"event: {one.code}: {one.text}" for one in found) or text


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
    words = "the load touches the seabed at {:.2f} m/s and rebounds by {:.1f} cm"
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
