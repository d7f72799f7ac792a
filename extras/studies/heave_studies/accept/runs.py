"""A step that runs the whole loop by the machinery of `heave run`, with a bag."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from heave_bags.analyse import events
from heave_bags.analyse.read_run import read_run
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.verdict import judge
from heave_bags.mcap.reader import TIME, Bag
from heave_bags.signals import Signal
from heave_bringup.replacements import OPTION, external_settings
from heave_bringup.run.launcher import Launcher
from heave_bringup.run.run import Composed, RunFolder, run_scenario
from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.settings import Setting, make_setting
from heave_devices.bench.set_signal import Event
from heave_msgs.msg import TickStatus
from heave_node.interface import topics
from heave_node.interface.alarm import alarms_in
from heave_node.interface.codes import timed_words
from heave_node.interface.sensors import DEPTH, LOAD_CELL, MRU, STANDARD_WATER, Sensor
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import ATMOSPHERIC_PRESSURE
from heave_node.run_parameters import REALTIME
from heave_node.scenario import WILDCARD

from heave_studies.accept.measured import Measured
from heave_studies.accept.procedure import FAULTS_OF, Procedure, RunTest

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
