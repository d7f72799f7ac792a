"""A procedure of an acceptance test, as its file states it: steps, what each does, the criteria that it must meet.

A procedure is YAML; numbers are SI, or texts with a unit ("2 m/s", "30 kN"; a speed or an acceleration also in % of the
nominal winch's limit):

    title: Factory acceptance test of the winch
    scenario: b2_calm_300             # nominal winch, cable, unit, sea
    set: {system.winch.speed_limit: 1.5}
    signatures: [manufacturer, buyer]
    steps:
      - name: full speed
        what: The drum reaches its nominal speed out and in.
        winch: {signal: steps, speeds: [100 %, 0, -100 %], hold: 4 s, load: 30 kN}  # the winch by itself
        wanted: {speed_reached: ">= 95 %"}
      - name: emergency stop
        winch: {signal: steps, speeds: [50 %], hold: 6 s}
        event: {device: winch, fault: emergency_stop, at: 3 s, ask: Press the emergency stop.}
        wanted: {stopping_time_s: "<= 1.5"}
      - name: MRU lost
        run: {duration: 300, transient: 120, set: {winch_controller.law: mpc}}      # the whole loop
        event: {device: mru, fault: gap, at: 200 s, duration: 5 s}
        alarms: ["SENSOR_LOST, MRU"]
        wanted: {alarm_time_s: ["> 0", "<= 0.5"], recovery_time_s: "<= 30"}
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from heave_bringup.pages.alarms import TABLES
from heave_devices.bench.limits import Limits
from heave_devices.bench.set_signal import BRAKE, COMMAND_LOSS, KINDS, Event, WinchTest
from heave_node.criteria import Criterion, parse_criterion
from heave_node.files.given_files import as_list, as_mapping, read_stated, refuse_keys, scenario_of
from heave_node.files.units import UNITS
from heave_node.interface.fault_kinds import FAULTS
from heave_node.parameters import Given, ParameterError

from heave_studies.accept.measured import ALARM_TIME, refuse_plain, refuse_unknown

FAULTS_OF: Mapping[str, str] = {
    "mru": "wave_vessel.mru.faults",
    "depth": "cable_sim.sensors.depth.faults",
    "load_cell": "cable_sim.sensors.load_cell.faults",
    "encoder": "virtual_winch.encoder.faults",
    "winch": "virtual_winch.faults",
}
"""Parameter group of the scheduled faults of each device, by the name that a procedure gives it."""


@dataclass(frozen=True)
class RunTest:
    """The whole loop."""

    scenario: str = ""  # shipped name or file; "": that of the procedure
    settings: Mapping[str, object] = field(default_factory=dict)  # changes by place
    duration: float | None = None  # [s]; None: that of the scenario
    transient: float | None = None  # [s]; None: that of the scenario
    seed: int | None = None  # None: that of the scenario


@dataclass(frozen=True)
class Step:
    """A step."""

    name: str  # for people
    what: str  # for people
    wanted: tuple[Criterion, ...]  # criteria, all of which it must meet
    test: WinchTest | RunTest  # what is done
    event: Event | None = None  # what happens during it; None: nothing
    alarms: tuple[str, ...] = ()  # codes of which one must come after the event

    @property
    def slug(self) -> str:
        """Name of its files."""
        return re.sub(r"\W+", "_", self.name.lower()).strip("_")


@dataclass(frozen=True)
class Procedure:
    """A procedure, read and checked."""

    path: Path  # of its file
    text: bytes  # of its file
    title: str  # for people
    scenario: str  # shipped name or file
    steps: tuple[Step, ...]  # in order
    description: str = ""  # for people
    settings: Mapping[str, object] = field(default_factory=dict)  # changes of the scenario, by place
    signatures: tuple[str, ...] = ()  # who signs


_AMOUNT = re.compile(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*")
_KEYS = {"title", "scenario", "set", "signatures", "steps", "description"}
_STEP_KEYS = {"name", "what", "winch", "run", "event", "alarms", "wanted"}
_RUN_KEYS = {"scenario", "set", "duration", "transient", "seed"}
_EVENT_KEYS = {"device", "fault", "at", "duration", "magnitude", "ask"}


@dataclass(frozen=True)
class Head:
    """A procedure's file before its steps are read: they need the nominal winch of its scenario."""

    path: Path  # of the file
    text: bytes  # of the file
    content: Mapping[str, Any]  # of the file

    @property
    def scenario(self) -> str:
        """Shipped name or file; a file is found beside the procedure."""
        return scenario_of(self.path, self.content)

    @property
    def settings(self) -> Mapping[str, object]:
        """Changes of the scenario, by place."""
        return as_mapping(self.content.get("set") or {}, f"{self.path}: set")


def read_head(path: Path) -> Head:
    """Read the file of a procedure at `path`. Raises ParameterError, in one line, for what is wrong with it."""
    text, content = read_stated(path, _KEYS, ("title", "scenario", "steps"))
    as_list(content["steps"], f"{path}: steps")
    return Head(path, text, content)


def read_procedure(head: Head, limits: Limits) -> Procedure:
    """Return the procedure of a file.

    Parameters
    ----------
    head : of the file
    limits : what its percentages are of

    Raises ParameterError, in one line, for what is wrong with it.
    """
    steps = [
        _step(entry, f"{head.path}: step {number}", limits) for number, entry in enumerate(head.content["steps"], 1)
    ]
    names = [step.slug for step in steps]
    twice = next((step.name for step in steps if names.count(step.slug) > 1), None)
    if twice is not None:
        raise ParameterError(f"{head.path}: two steps are called {twice}")
    signatures = as_list(head.content.get("signatures") or [], f"{head.path}: signatures")
    return Procedure(
        head.path,
        head.text,
        str(head.content["title"]),
        head.scenario,
        tuple(steps),
        str(head.content.get("description", "")),
        head.settings,
        tuple(map(str, signatures)),
    )


def _step(entry: Any, where: str, limits: Limits) -> Step:
    entry = as_mapping(entry, where)
    where = f"{where} ({entry['name']})" if entry.get("name") else where
    refuse_keys(entry, _STEP_KEYS, where)
    if not entry.get("name") or not entry.get("wanted"):
        raise ParameterError(f"{where}: {'wanted' if entry.get('name') else 'name'} is missing")
    if ("winch" in entry) == ("run" in entry):
        raise ParameterError(f"{where}: is a test of a winch or a run: give one of them")
    test: WinchTest | RunTest
    if "winch" in entry:
        test = _winch_test(as_mapping(entry["winch"], f"{where}: winch"), f"{where}: winch", limits)
    else:
        test = _run_test(as_mapping(entry["run"] or {}, f"{where}: run"), f"{where}: run")
    event = _event(entry["event"], f"{where}: event", test) if "event" in entry else None
    return Step(
        str(entry["name"]),
        str(entry.get("what", "")),
        _criteria(as_mapping(entry["wanted"], f"{where}: wanted"), where),
        test,
        event,
        _alarms(entry.get("alarms") or [], where, event),
    )


def _criteria(wanted: Mapping[str, Any], where: str) -> tuple[Criterion, ...]:
    found = []
    for key, bounds in wanted.items():
        for bound in _listed(bounds):
            criterion = parse_criterion(Given(bound, key, where))
            refuse_unknown(criterion, where)
            refuse_plain(criterion, str(bound), where)
            found.append(criterion)
    return tuple(found)


def _alarms(codes: Any, where: str, event: Event | None) -> tuple[str, ...]:
    known = {row.code for table in TABLES.values() for row in table.values()}
    codes = codes if isinstance(codes, list) else [codes]
    unknown = next((code for code in codes if code not in known), None)
    if unknown is not None:
        raise ParameterError(f"{where}: alarms: {unknown} is no code of an alarm (docs/alarms.md)")
    if codes and event is None:
        raise ParameterError(f"{where}: alarms: needs an event, after which {ALARM_TIME.key} counts")
    return tuple(codes)


def _winch_test(entry: Mapping[str, Any], where: str, limits: Limits) -> WinchTest:
    kind = str(entry.get("signal"))
    if kind not in KINDS:
        raise ParameterError(f"{where}: signal = {kind}: must be one of {', '.join(KINDS)}")
    known = KINDS[kind]
    refuse_keys(entry, {"signal", "load", *known.arguments}, where)
    values: dict[str, Any] = dict(known.defaults)
    for name, dimension in known.arguments.items():
        if name in entry:
            given = entry[name]
            read = [amount(one, dimension, f"{where}: {name}", limits) for one in _listed(given)]
            values[name] = read if name == "speeds" else int(read[0]) if name == "seed" else read[0]
    missing = next((name for name in known.arguments if name not in values), None)
    if missing is not None:
        raise ParameterError(f"{where}: {kind} needs {missing}")
    wrong = next((name for name in values if name not in ("speeds", "speed") and not values[name] > 0.0), None)
    if wrong is not None:
        raise ParameterError(f"{where}: {wrong} must be above 0")
    signal, load = known.make(**values), amount(entry.get("load", 0.0), "force", f"{where}: load")
    limits.refuse(signal, load, values.get("acceleration", math.nan), where)
    return WinchTest(replace(signal, words=f"{signal.words}, load {1e-3 * load:g} kN") if load else signal, load)


def _run_test(entry: Mapping[str, Any], where: str) -> RunTest:
    refuse_keys(entry, _RUN_KEYS, where)
    times = {
        name: amount(entry[name], "time", f"{where}: {name}") for name in ("duration", "transient") if name in entry
    }
    seed = entry.get("seed")
    if seed is not None and (isinstance(seed, bool) or not isinstance(seed, int)):
        raise ParameterError(f"{where}: seed = {seed!r}: must be a whole number")
    settings = as_mapping(entry.get("set") or {}, f"{where}: set")
    return RunTest(str(entry.get("scenario", "")), settings, times.get("duration"), times.get("transient"), seed)


def _event(entry: Any, where: str, test: WinchTest | RunTest) -> Event:
    entry = as_mapping(entry, where)
    refuse_keys(entry, _EVENT_KEYS, where)
    device, fault = entry.get("device", "winch"), entry.get("fault")
    if device not in FAULTS_OF:
        raise ParameterError(f"{where}: device = {device!r}: must be one of {', '.join(FAULTS_OF)}")
    own = (COMMAND_LOSS, BRAKE) if isinstance(test, WinchTest) else ()
    if fault not in (*FAULTS, *own):
        raise ParameterError(f"{where}: fault = {fault!r}: must be one of {', '.join((*FAULTS, *own))}")
    if isinstance(test, WinchTest) and device != "winch":
        raise ParameterError(f"{where}: device = {device}: the winch is tested by itself")
    if "at" not in entry:
        raise ParameterError(f"{where}: at is missing: when it happens [s]")
    times = [amount(entry.get(name, 0.0), "time", f"{where}: {name}") for name in ("at", "duration")]
    magnitude = amount(entry.get("magnitude", 0.0), "number", f"{where}: magnitude")
    event = Event(device, fault, times[0], times[1], magnitude, str(entry.get("ask", "")))
    if isinstance(test, WinchTest):
        refuse_late(event, test.signal.duration, where)
    return event


def refuse_late(event: Event | None, duration: float, where: str) -> None:
    """Raise ParameterError, naming `where` it stands, for an `event` after the `duration` [s] of its step."""
    if event is not None and not 0.0 <= event.at < duration:
        raise ParameterError(f"{where}: at = {event.at:g} s: must be within the step, which lasts {duration:g} s")


def amount(given: Any, dimension: str, where: str, limits: Limits | None = None) -> float:
    """Return a quantity in SI units.

    Parameters
    ----------
    given : a number in SI units, or a text of number and unit
    dimension : key of `heave_node.files.units.UNITS`
    where : it stands, for the message
    limits : what % is of; None: % is no unit of it

    Raises ParameterError for what is not such a quantity.
    """
    if isinstance(given, int | float) and not isinstance(given, bool) and not math.isnan(given):
        return float(given)
    found = _AMOUNT.fullmatch(given) if isinstance(given, str) else None
    units = dict(UNITS[dimension])
    whole = getattr(limits, dimension, math.nan) if limits is not None else math.nan
    if dimension in ("speed", "acceleration") and math.isfinite(whole):
        units["%"] = 0.01 * whole
    if found is None or (found[2] or "") not in {"": 1.0, **units}:
        raise ParameterError(f"{where} = {given!r}: must be a number, with or without a unit: {', '.join(units)}")
    try:
        return float(found[1]) * {"": 1.0, **units}[found[2] or ""]
    except ValueError as error:
        raise ParameterError(f"{where} = {given!r}: is not a number") from error


def _listed(given: Any) -> list[Any]:
    return given if isinstance(given, list) else [given]
