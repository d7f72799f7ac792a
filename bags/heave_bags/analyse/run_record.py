"""From a bag of the suite to the signals of its run: which topic and field is what. One pass over the bag."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from heave_node.arrays import Array
from heave_node.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.parameters import ParameterError
from heave_node.scenario import parse_sections, values_of_node
from numpy.typing import NDArray

from heave_bags.analyse import kpi_set
from heave_bags.analyse.depth_programme import SPAN, take_out_programme
from heave_bags.analyse.kpi_set import RunSignals, Signal
from heave_bags.cdr.columns import Columns
from heave_bags.errors import BagError
from heave_bags.mcap.reader import TIME, Bag, Progress, no_progress
from heave_bags.mcap.scan import Loss
from heave_bags.record.provenance import PARAMETERS_ATTACHMENT, SCENARIO_ATTACHMENT

NIS_BAND = (0.000982069, 5.02388619)
"""Central 95 % of the chi-square distribution with one degree of freedom."""

SELECTION: dict[str, tuple[str, ...]] = {
    "unit/odometry": ("pose.pose.position.z",),
    "unit_uncompensated": ("position.z",),
    "boom_tip": ("position.z",),
    "winch/state": (
        "payout",
        "payout_rate",
        "payout_acceleration",
        "encoder_payout",
        "encoder_payout_rate",
        "tension",
        "limits_hit",
        "brake",
        "fault",
    ),
    "winch/load_cell": ("tension",),
    "cable/state": ("top_tension", "slack_segments"),
    "controller/state": (
        "mode",
        "reason",
        "measurement_names",
        "innovation",
        "innovation_sigma",
        "nis",
        "active_limits",
        "depth_set_point",
        "sensors",
    ),
    "/diagnostics": ("status",),
}
"""The topics and fields that KPIs and reports are made from."""

SHORTEST_WINDOW = 1.0
"""Figures of less than this behind the transient would mean nothing [s]."""

FAULT_NAMES = {1: "command timeout", 2: "invalid command", 3: "drive", 4: "emergency stop"}
LIMIT_NAMES = {1: "speed", 2: "acceleration", 4: "payout", 8: "power"}


@dataclass(frozen=True)
class Interval:
    """Something that held from `start` to `end` [s]: a mode, an alarm, a limit."""

    start: float
    end: float
    name: str
    level: int = 0
    """0 plain, 1 warning, 2 error."""


@dataclass
class Innovation:
    """Innovations of one measurement: times [s], values and their predicted standard deviation, in its unit."""

    name: str
    time: Array
    value: Array
    sigma: Array


@dataclass
class RunRecord:
    """A run as its bag tells it.

    Attributes
    ----------
    name : of the bag
    signals : what the KPIs are computed from
    start, end : evaluation window [s]: after the transient, to the end
    modes, alarms, limits : what held when
    innovations : per measurement of the estimator
    run, outcome : the bag's own words on the run
    losses : what of the bag could not be read
    notes : what a reader of the figures must know
    """

    name: str
    signals: RunSignals
    start: float
    end: float
    modes: list[Interval] = field(default_factory=list)
    alarms: list[Interval] = field(default_factory=list)
    limits: list[Interval] = field(default_factory=list)
    innovations: list[Innovation] = field(default_factory=list)
    run: Mapping[str, str] = field(default_factory=dict)
    outcome: Mapping[str, str] = field(default_factory=dict)
    losses: list[Loss] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def remarks(self) -> list[str]:
        """Return what a reader of the figures must know: the notes, and what of the bag could not be read."""
        return [*self.notes, *(f"not all of the bag could be read: {loss}" for loss in self.losses)]

    def kpis(self, start: float | None = None, end: float | None = None) -> dict[str, float]:
        """Return every KPI over the evaluation window, or over start..end [s]."""
        return kpi_set.evaluate(self.signals, self.start if start is None else start, self.end if end is None else end)


def read_run(path: str | Path, *, transient: float | None = None, progress: Progress = no_progress) -> RunRecord:
    """Read a bag of the suite in one pass.

    `transient` [s] overrides the start of the evaluation window that the bag itself names. Raises BagError if the bag
    has nothing that a KPI could be computed from.
    """
    bag = Bag(path)
    selection = {topic: fields for topic, fields in SELECTION.items() if bag.has(topic)}
    if not set(selection) - {"/diagnostics"}:
        raise BagError(f"{bag.path}: none of the topics of a run is in it; it has {', '.join(bag.topics) or 'none'}")
    surveyed = list(bag.losses)
    columns = bag.columns(selection, progress=progress)
    end = bag.end_time * 1e-9
    record = RunRecord(_name(bag.path.resolve()), RunSignals(), 0.0, end, run=bag.run, outcome=bag.outcome)
    record.losses = bag.losses or surveyed
    columns = {topic: _newest_run(topic, values, record) for topic, values in columns.items()}
    _fill_motion(record, columns)
    _fill_winch(record, columns)
    _fill_controller(record, columns)
    parameters = _parameters(bag)
    set_point = _signal(columns.get("controller/state"), "depth_set_point")
    if take_out_programme(record.signals, set_point, _cable_weight(parameters.get("cable_sim", {}))):
        record.notes.append(
            f"the unit was moved to other depths: heave is about its running mean of {SPAN:g} s, "
            "payout about its set-point"
        )
    record.alarms += _diagnostic_alarms(columns.get("/diagnostics", {}))
    _fill_outcome(record)
    _fill_parameters(record, parameters)
    window = transient if transient is not None else float(bag.run.get("transient_s", "0"))
    first = bag.start_time * 1e-9
    record.start = window if first < 1.0 else first + window
    if record.start > record.end - SHORTEST_WINDOW:
        record.notes.append(f"the run ended within its transient of {window:g} s: figures are of the whole run")
        record.start = first
    return record


def _name(path: Path) -> str:
    """Return what to call a bag: its folder, or the run's folder where the bag is just called bag."""
    return path.parent.name if path.name == "bag" else path.name


def _newest_run(topic: str, columns: Columns, record: RunRecord) -> Columns:
    """Keep what comes after the last reset (time went back)."""
    time = columns[TIME]
    back = np.flatnonzero(np.diff(time) < -1.0)
    if not back.size:
        return columns
    record.notes.append(f"{topic}: time went back {back.size} times (reset); the last run is shown")
    return {name: values[back[-1] + 1 :] for name, values in columns.items()}


def _signal(columns: Columns | None, name: str) -> Signal:
    """Return a column as a signal, without samples that are not finite."""
    if not columns or name not in columns:
        return Signal()
    values = np.asarray(columns[name], dtype=float)
    good = np.isfinite(values)
    if good.all():
        return Signal(columns[TIME], values)
    return Signal(columns[TIME][good], values[good])


def _fill_motion(record: RunRecord, columns: Mapping[str, Columns]) -> None:
    signals = record.signals
    signals.unit_heave = _signal(columns.get("unit/odometry"), "pose.pose.position.z")
    signals.uncompensated_heave = _signal(columns.get("unit_uncompensated"), "position.z")
    signals.boom_tip_heave = _signal(columns.get("boom_tip"), "position.z")
    signals.tension = _signal(columns.get("cable/state"), "top_tension")
    slack = _signal(columns.get("cable/state"), "slack_segments")
    signals.slack = Signal(slack.time, (slack.value > 0.0).astype(float))
    if not signals.tension.size:
        signals.tension = _signal(columns.get("winch/load_cell"), "tension")
    if not signals.tension.size:
        signals.tension = _signal(columns.get("winch/state"), "tension")
    if signals.tension.size and signals.tension.time[0] < 1.0:
        signals.static_tension = Signal(signals.tension.time[:1], signals.tension.value[:1])


def _fill_winch(record: RunRecord, columns: Mapping[str, Columns]) -> None:
    winch = columns.get("winch/state")
    if not winch:
        return
    signals = record.signals
    signals.payout = _signal(winch, "payout")
    signals.payout_rate = _signal(winch, "payout_rate")
    signals.payout_acceleration = _signal(winch, "payout_acceleration")
    if not signals.payout.size:
        signals.payout = _signal(winch, "encoder_payout")
        signals.payout_rate = _signal(winch, "encoder_payout_rate")
        record.notes.append("payout is the encoder's reading: the winch does not know the truth")
    time = winch[TIME]
    signals.winch_limited = Signal(time, (winch["limits_hit"] != 0).astype(float))
    for bit, name in LIMIT_NAMES.items():
        record.limits += _flagged(time, (winch["limits_hit"] & bit) != 0, name)
    record.limits += _flagged(time, np.asarray(winch["brake"], dtype=bool), "brake")
    for fault, name in FAULT_NAMES.items():
        record.alarms += _flagged(time, winch["fault"] == fault, f"winch: {name}", level=2)


def _fill_controller(record: RunRecord, columns: Mapping[str, Columns]) -> None:
    state = columns.get("controller/state")
    if not state or not state[TIME].size:
        return
    time = state[TIME]
    record.modes = _runs(time, state["mode"])
    record.innovations = _innovations(state)
    nis = state.get("nis")
    if nis is not None and nis.size:
        finite = np.isfinite(nis)
        inside = (nis >= NIS_BAND[0]) & (nis <= NIS_BAND[1])
        rows = np.repeat(time[:, None], nis.shape[1], axis=1)
        record.signals.nis_in_band = Signal(rows[finite], inside[finite].astype(float))
    index = 0
    while f"sensors[{index}].level" in state:
        level, name = state[f"sensors[{index}].level"], state[f"sensors[{index}].sensor"]
        for bad, word in ((1, "suspect"), (2, "lost")):
            where = level == bad
            label = f"{name[where][0]} {word}" if where.any() else ""
            record.alarms += _flagged(time, where, label, level=bad)
        index += 1


def _innovations(state: Columns) -> list[Innovation]:
    time, found = state[TIME], []
    values, sigmas = state.get("innovation"), state.get("innovation_sigma")
    if values is None or sigmas is None or values.ndim != 2:
        return []
    for column in range(values.shape[1]):
        names = state.get(f"measurement_names[{column}]")
        given = [name for name in names if name] if names is not None else []
        good = np.isfinite(values[:, column])
        if good.any():
            name = str(given[0]) if given else f"measurement {column + 1}"
            found.append(Innovation(name, time[good], values[good, column], sigmas[good, column]))
    return found


def _runs(time: Array, names: NDArray[Any]) -> list[Interval]:
    """Return the intervals in which a text stays the same."""
    changes = np.flatnonzero(names[1:] != names[:-1]) + 1
    bounds = [0, *changes.tolist(), len(names)]
    ends = [*(float(time[index]) for index in changes), float(time[-1])]
    return [Interval(float(time[first]), end, str(names[first])) for first, end in zip(bounds[:-1], ends, strict=True)]


def _flagged(time: Array, flags: NDArray[np.bool_], name: str, *, level: int = 0) -> list[Interval]:
    """Return the intervals in which a flag stands; one sample counts until the next."""
    if not flags.any():
        return []
    padded = np.concatenate(([False], flags, [False]))
    edges = np.flatnonzero(padded[1:] != padded[:-1])
    last = time.size - 1
    return [
        Interval(float(time[first]), float(time[min(after, last)]), name, level)
        for first, after in zip(edges[::2], edges[1::2], strict=True)
    ]


def _diagnostic_alarms(columns: Columns) -> list[Interval]:
    """Return the warnings and errors of /diagnostics; each holds for the second until the next."""
    alarms: dict[tuple[str, int], list[float]] = {}
    index = 0
    while f"status[{index}].level" in columns:
        levels = np.asarray(columns[f"status[{index}].level"], dtype=float)
        names, messages = columns[f"status[{index}].name"], columns[f"status[{index}].message"]
        for row in np.flatnonzero(levels >= 1.0):
            label = f"{names[row]}: {messages[row]}"
            alarms.setdefault((label, min(int(levels[row]), 2)), []).append(float(columns[TIME][row]))
        index += 1
    found: list[Interval] = []
    for (label, level), times in alarms.items():
        found += _joined(times, label, level)
    return found


def _joined(times: list[float], name: str, level: int) -> list[Interval]:
    joined: list[Interval] = []
    for time in sorted(times):
        if joined and time <= joined[-1].end + 0.5:
            joined[-1] = Interval(joined[-1].start, time + 1.0, name, level)
        else:
            joined.append(Interval(time, time + 1.0, name, level))
    return joined


def _fill_outcome(record: RunRecord) -> None:
    def number(key: str) -> float:
        return float(record.outcome.get(key, "nan"))

    signals = record.signals
    signals.real_time_factor = number("real_time_factor")
    signals.missed_deadlines = number("missed_deadlines")
    signals.loop_age = (number("loop_age_p50_s"), number("loop_age_p99_s"), number("loop_age_max_s"))
    ended = record.outcome.get("ended", "")
    if ended not in ("complete", ""):
        record.notes.append(f"the run did not end by itself: {ended}")
    if "lost" in record.outcome:
        record.notes.append(f"messages lost while recording: {record.outcome['lost']}")


def _parameters(bag: Bag) -> dict[str, dict[str, Any]]:
    """Return the parameters of the run's nodes, as far as the bag carries them: node -> dotted name -> value.

    A recorder that was killed had no time to add what the nodes said; the scenario is there from the start.
    """
    attachments = bag.attachments
    nodes: dict[str, dict[str, Any]] = {}
    for name in (SCENARIO_ATTACHMENT, PARAMETERS_ATTACHMENT):
        try:
            sections = parse_sections(attachments.get(name, b""), name)
        except ParameterError:
            continue
        for node in ("cable_sim", "wave_vessel", "virtual_winch", "winch_controller"):
            nodes.setdefault(node, {}).update(values_of_node(sections, f"/{node}"))
    return nodes


def _number(parameters: Mapping[str, Any], name: str, default: float) -> float:
    value = parameters.get(name, default)
    return float(value) if isinstance(value, int | float) else default


def _cable_weight(plant: Mapping[str, Any]) -> float:
    """Return weight minus buoyancy of the cable that is paid out [N/m]; 0 where the bag does not say."""
    mass = _number(plant, "cable.mass_per_length", math.nan)
    diameter = _number(plant, "cable.displaced_diameter", 0.0) or _number(plant, "cable.diameter", math.nan)
    displaced = _number(plant, "water_density", SEAWATER_DENSITY) * 0.25 * math.pi * diameter**2
    weight = (mass - displaced) * _number(plant, "gravity", STANDARD_GRAVITY)
    return weight if math.isfinite(weight) else 0.0


def _fill_parameters(record: RunRecord, nodes: Mapping[str, Mapping[str, Any]]) -> None:
    def number(node: str, name: str, default: float) -> float:
        return _number(nodes.get(node, {}), name, default)

    signals = record.signals
    signals.speed_limit = number("virtual_winch", "speed_limit", math.inf)
    signals.acceleration_limit = number("virtual_winch", "acceleration_limit", math.inf)
    if nodes.get("wave_vessel", {}).get("boom_tip_source") == "regular":
        period = number("wave_vessel", "period", math.nan)
        signals.driving_omega = 2.0 * math.pi / period if period > 0.0 else math.nan
