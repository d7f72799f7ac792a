"""A step that runs the whole loop by the machinery of `heave run`, with a bag, or is judged on a foreign record."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from heave_bags.analyse import events
from heave_bags.analyse.read_run import read_run
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.time_base import LONGEST_GAP
from heave_bags.analyse.verdict import judge
from heave_bags.mcap.read.folder import bag_of
from heave_bags.mcap.reader import TIME, Bag
from heave_bags.signals import RunSignals, Signal
from heave_bringup.replacements import OPTION, external_settings
from heave_bringup.run.launcher import Launcher
from heave_bringup.run.run import Composed, RunFolder, run_scenario
from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.settings import Setting, make_setting
from heave_devices.bench.set_signal import Event, WinchTest
from heave_devices.bench.winch import Trace
from heave_devices.maps.device_map import device_map_of
from heave_devices.records.sample_checks import Findings
from heave_devices.records.sea_import import record_channels
from heave_devices.records.sea_mapping import read_mapping
from heave_devices.records.ship_log import is_text
from heave_devices.records.stretches import DEFAULT_BRIDGE
from heave_msgs.msg import TickStatus
from heave_node.interface import topics
from heave_node.interface.alarm import alarms_in
from heave_node.interface.codes import timed_words
from heave_node.interface.sensors import DEPTH, LOAD_CELL, MRU, STANDARD_WATER, Sensor
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import ATMOSPHERIC_PRESSURE
from heave_node.run_parameters import REALTIME
from heave_node.scenario import WILDCARD

from heave_studies.accept.measured import Measured, Nominal, rate_of
from heave_studies.accept.procedure import FAULTS_OF, Procedure, RunTest, Step

_SENSORS: Mapping[str, Sensor] = {"mru": MRU, "depth": DEPTH, "load_cell": LOAD_CELL}
_WINCH = topics.WINCH_STATE.name


def scenario_of(procedure: Procedure, test: RunTest, event: Event | None, external: Sequence[str] = ()) -> Scenario:
    """Return the scenario of a step.

    Parameters
    ----------
    procedure : of the step
    test : the step's own
    event : what happens during it, scheduled where the device is simulated
    external : real parts, as `external_settings` takes them: the run is then in real time

    Raises ParameterError for what is wrong with it.
    """
    where = str(procedure.path)
    changes = [make_setting(place, value, where) for place, value in {**procedure.settings, **test.settings}.items()]
    named = (("duration", test.duration), ("transient", test.transient), ("seed", test.seed))
    changes += [Setting(WILDCARD, name, value, where) for name, value in named if value is not None]
    if event is not None and not is_real(event, external):
        lists = {"kind": event.fault, "start": event.at, "duration": event.duration, "magnitude": event.magnitude}
        changes += [make_setting(f"{FAULTS_OF[event.device]}.{name}", [value], where) for name, value in lists.items()]
    if external:
        changes += [*external_settings(external), Setting(WILDCARD, "pacing", REALTIME, OPTION)]
    return load_scenario(test.scenario or procedure.scenario, settings=changes)


def is_real(event: Event, external: Sequence[str]) -> bool:
    """Return whether the device of an `event` is real: `external` names the node that simulates it, or its topic."""
    sensor = _SENSORS.get(event.device)
    simulated = {FAULTS_OF[event.device].partition(".")[0], *([sensor.topic.name] if sensor else [])}
    return any(text.partition("=")[0] in simulated for text in external)


def run_loop(
    scenario: Scenario, event: Event | None, folder: Path, external: Sequence[str]
) -> tuple[Measured, list[str]]:
    """Run a scenario into a folder; return as `read_loop` does.

    Parameters
    ----------
    scenario : of the step
    event : what happens during it
    folder : of the run
    external : real parts, as `external_settings` takes them; a person is asked for what happens to them

    Raises CommandError where the run does not reach its end.
    """
    asked: list[float] = []

    def look(_: Launcher, status: TickStatus | None) -> None:
        if event is None or asked or status is None or status.simulated_time < event.at:
            return
        if is_real(event, external):
            asked.append(status.simulated_time)
            sys.stderr.write(f"\nheave: now: {event.ask or event.words}\n")

    run = RunFolder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    run_scenario(scenario, run, on_look=look, composed=None if external else Composed())
    at = asked[0] if asked else event.at if event is not None else None
    return read_loop(run.bag, event, at)


def read_loop(bag: Path, event: Event | None, at: float | None) -> tuple[Measured, list[str]]:
    """Return what the bag of a run holds, and what fails any run, in words.

    Parameters
    ----------
    bag : of the suite's topics
    event : of the step
    at : when that was [s]; None: there was none
    """
    record = read_run(bag)
    measured = Measured(record.signals, record.start, record.end, alarms=alarms_of(record), readings=readings_of(bag))
    if event is not None and at is not None:
        measured.event, measured.event_end = at, at + event.duration
    measured.notes += record.remarks()
    return measured, judge(record, moves_winch=False).breaches


def alarms_of(record: RunRecord) -> list[tuple[float, str]]:
    """Return time [s] and code of each alarm of a run, and words of what held: a sensor lost, a winch fault.

    Parameters
    ----------
    record : of the run. Alarms are published once a second, what held in each tick
    """
    found = []
    for interval in record.alarms:
        dated = timed_words(interval.name.removeprefix(f"{events.ALARMS_PART}: "))
        lines = dated or [(interval.start, interval.name)]
        for time, words in lines:
            codes = [alarm.code for alarm in alarms_in(words)]
            found += [(time, code) for code in codes] or ([(time, words)] if interval.level > 1 else [])
    return sorted(found)


def depth_of(pressure: Array) -> Array:
    """Return the depths in standard sea water [m] at absolute pressures `pressure` [Pa], shape (n,)."""
    return (pressure - ATMOSPHERIC_PRESSURE) / STANDARD_WATER.pressure_per_metre


def readings_of(path: Path) -> dict[str, Signal]:
    """Return what the sensors of the bag at `path` read, and the encoder."""
    bag = Bag(path)
    sensors = {name: sensor for name, sensor in _SENSORS.items() if bag.has(sensor.topic.name)}
    selection = {sensor.topic.name: sensor.values[:1] for sensor in sensors.values()}
    if bag.has(_WINCH):
        selection[_WINCH] = ("encoder_payout", "encoder_payout_rate")
    columns = bag.columns(selection)
    found = {}
    for name, sensor in sensors.items():
        table = columns[sensor.topic.name]
        values = table[sensor.values[0]]
        found[name] = Signal(table[TIME], depth_of(values) if name == DEPTH.name else values)
    if bag.has(_WINCH):
        table = columns[_WINCH]
        found["encoder"] = Signal(table[TIME], table["encoder_payout"])
        found["encoder_rate"] = Signal(table[TIME], table["encoder_payout_rate"])
    return found


QUANTITIES = ("heave", "payout", "payout_rate", "ordered_rate", "unit_heave", "tension", "pressure")
"""Quantities of a map that are used: heave of the boom tip, those of the winch, heave of the unit, pressure at it."""
_COLUMNS = dict(zip(("ordered_rate", "payout", "payout_rate"), Trace.HEADER[1:4], strict=True))
OWN = device_map_of(
    "winch", {"time_column": Trace.HEADER[0], **{name: {"column": column} for name, column in _COLUMNS.items()}}
)
"""Map of what a test of a winch leaves."""


SILENCED: Mapping[str, tuple[str, ...]] = {
    "mru": ("heave",),
    "depth": ("depth", "pressure", "unit_heave"),
    "load_cell": ("tension",),
    "encoder": ("payout", "payout_rate"),
}
"""Quantities that an event of a device may silence."""


Span = tuple[float, float]
"""Start and end [s]."""


def lacking_words(signals: Iterable[Signal], window: Span, excused: Iterable[tuple[Signal, Span]] = ()) -> str:
    """Return in words that a record lacks part of a window; "" where it has all of it.

    Within the window gaps up to DEFAULT_BRIDGE count as recorded, as `heave import` has it. At its ends a signal may
    lack LONGEST_GAP of its periods, as in tables.

    Parameters
    ----------
    signals : each of which must be there
    window : that is judged
    excused : further signals, each with the time of an event that may silence it
    """
    start, end = window
    if not end > start:
        return f"nothing to judge from {start:g} s to {end:g} s"
    gaps = [gap for signal in signals for gap in _gaps(signal, window)]
    gaps += [
        gap for signal, event in excused for gap in _gaps(signal, window) if gap[1] < event[0] or gap[0] > event[1]
    ]
    missing, known = 0.0, start
    for first, last in sorted(gaps):
        missing += max(last - max(first, known), 0.0)
        known = max(known, last)
    if not missing:
        return ""
    return f"{math.floor(10.0 * (end - start - missing)) / 10.0:g} s of {end - start:g} s recorded"


def _gaps(signal: Signal, window: Span) -> list[Span]:
    """Return the gaps of a signal within a window that nothing bridges."""
    inside = signal.window(*window).time
    edges = np.concatenate((window[:1], inside, window[1:]))
    bridged = np.full(edges.size - 1, DEFAULT_BRIDGE)
    period = float(np.median(np.diff(inside))) if inside.size > 1 else 0.0
    bridged[[0, -1]] = min(LONGEST_GAP * period, DEFAULT_BRIDGE)
    return [(float(edges[at]), float(edges[at + 1])) for at in np.flatnonzero(np.diff(edges) > bridged)]


class ForeignRecord:
    """A record.

    Parameters
    ----------
    source : bag, log in columns, or what a device sent
    mapping : map file; None: a bag of the suite's topics, or what a test of a winch left

    Raises BagError for what cannot be read.
    """

    def __init__(self, source: Path, mapping: Path | None) -> None:
        self.source = bag_of(source)
        self.notes: list[str] = []
        self._signals: dict[str, Signal] = {}
        self._is_own = mapping is None and not is_text(self.source)
        if self._is_own:
            return
        self._is_of_winch = mapping is None
        findings = Findings(accepts=True)
        found = OWN if mapping is None else read_mapping(mapping)
        self._signals = record_channels(self.source, found, QUANTITIES, findings)
        self.notes = findings.notes

    def measured(self, step: Step, nominal: Nominal) -> Measured:
        """Return what figures of a `step` are computed from, of a winch that should be `nominal`.

        Times of the step count from the start of the record.
        """
        if self._is_own:
            measured, _ = read_loop(self.source, step.event, step.event.at if step.event else None)
            measured.start = max(measured.start, step.window[0])
            end = step.window[1] if math.isfinite(step.window[1]) else measured.end
            motions = (measured.run.payout, measured.run.boom_tip_heave, measured.run.unit_heave)
            whole = Signal(np.unique(np.concatenate([of.time for of in motions])))
            measured.lacks = lacking_words([whole], (measured.start, end))
            measured.end = min(measured.end, end)
            measured.nominal = nominal
            return measured
        first = min(float(signal.time[0]) for signal in self._signals.values())
        signals = {name: Signal(signal.time - first, signal.value) for name, signal in self._signals.items()}
        run = _run_signals(signals)
        last = max(float(signal.time[-1]) for signal in signals.values())
        measured = Measured(run, step.window[0], min(step.window[1], last), nominal=nominal, notes=list(self.notes))
        measured.ordered_rate = signals.get("ordered_rate", Signal())
        names = {"mru": "heave", "depth": "depth", "load_cell": "tension", "encoder": "payout"}
        measured.readings = {name: signals[of] for name, of in names.items() if of in signals}
        if step.event is not None:
            measured.event = step.event.at
            measured.event_end = step.event.at + step.event.duration
        measured.lacks = self._lacking(step, signals, last)
        return measured

    def _lacking(self, step: Step, signals: Mapping[str, Signal], last: float) -> str:
        """Return what the record lacks of what a `step` is judged over, in words; it ends at `last` [s]."""
        if self._is_of_winch and isinstance(step.test, WinchTest) and step.event is None:
            last = step.test.signal.duration
        end = step.window[1] if math.isfinite(step.window[1]) else last
        event = step.event or Event("", "", math.nan)
        silenced = [name for name in SILENCED.get(event.device, ()) if name in signals]
        # an order holds until the next
        steady = [of for name, of in signals.items() if name not in ("ordered_rate", *silenced)]
        span = (event.at, event.at + (event.duration or math.inf))
        return lacking_words(steady, (step.window[0], end), [(signals[name], span) for name in silenced])


def _run_signals(signals: dict[str, Signal]) -> RunSignals:
    """Return the signals of a run; a unit that has no heave of its own has that of its pressure sensor."""
    if "pressure" in signals:
        pressure = signals["pressure"]
        signals["depth"] = Signal(pressure.time, depth_of(pressure.value))
        signals.setdefault("unit_heave", Signal(pressure.time, -signals["depth"].value))
    empty = Signal()
    run = RunSignals(
        boom_tip_heave=signals.get("heave", empty),
        unit_heave=signals.get("unit_heave", empty),
        payout=signals.get("payout", empty),
        payout_rate=signals.get("payout_rate", empty),
        tension=signals.get("tension", empty),
        speed_limit=math.inf,
    )
    if not run.payout_rate.size and run.payout.size > 2:
        run.payout_rate = rate_of(run.payout)
    return run
