"""From a bag of the suite to the signals of its run: which topic and field is what. One pass over the bag."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from heave_node.criteria import WANTED, Criterion, parse_criterion
from heave_node.interface import topics
from heave_node.interface.codes import COMMANDS, LATE
from heave_node.loads.strength import strengths
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.numerics.hydrostatics import displaced_area, weight_in_fluid
from heave_node.parameters import Given, ParameterError
from heave_node.run_parameters import REALTIME
from heave_node.scenario import WILDCARD, Sections, parse_sections, values_of_node
from heave_node.tick.durations import parse_histogram

from heave_bags.analyse import events, kpi_set
from heave_bags.analyse.depth_programme import SPAN, take_out_programme
from heave_bags.analyse.events import Interval
from heave_bags.analyse.fields import Fields, on_one_clock
from heave_bags.errors import BagError
from heave_bags.mcap.files import COMPLETE, SNAPSHOT
from heave_bags.mcap.loss import Loss, remarks
from heave_bags.mcap.reader import Bag, Progress, no_progress
from heave_bags.record.provenance import PARAMETERS_ATTACHMENT, SCENARIO_ATTACHMENT
from heave_bags.signals import RunSignals, Signal

NIS_BAND = (0.000982069, 5.02388619)
"""Central 95 % of the chi-square distribution with one degree of freedom."""

UNIT, UNCOMPENSATED = topics.UNIT_ODOMETRY.name, topics.UNIT_UNCOMPENSATED.name
BOOM_TIP, WINCH, LOAD_CELL = topics.BOOM_TIP.name, topics.WINCH_STATE.name, topics.LOAD_CELL.name
MRU = topics.MRU.name
CABLE, CONTROLLER, DIAGNOSTICS = topics.CABLE_STATE.name, topics.CONTROLLER_STATE.name, topics.DIAGNOSTICS.name

SELECTION: dict[str, tuple[str, ...]] = {
    UNIT: ("pose.pose.position.z",),
    UNCOMPENSATED: ("position.z",),
    BOOM_TIP: ("position.z",),
    WINCH: (
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
    LOAD_CELL: ("tension",),
    CABLE: ("top_tension", "largest_top_tension", "bottom_tension", "slack_segments", "touchdown_force"),
    CONTROLLER: (
        "mode",
        "reason",
        "measurement_names",
        "innovation",
        "execution_time",
        "innovation_sigma",
        "nis",
        "active_limits",
        "depth_set_point",
        "predicted_unit_heave",
        "predicted_uncompensated_heave",
        "sensors",
    ),
    MRU: ("heave",),
    DIAGNOSTICS: ("status[].level", "status[].name", "status[].message"),
}
"""The topics and fields that KPIs and reports are made from."""

LONGEST_ARRAY = 4096
"""Arrays and texts of more elements are not part of a run."""
ROOM = 16 << 20
ROOM_PER_BYTE = 64
"""Bytes of messages that an analysis takes: so many, and so many for each byte of the bag. Runs need a tenth of it."""

LONGEST_TEXT = 1000
"""Letters of a title or description that a bag may bring."""

SHORTEST_WINDOW = 1.0
"""Figures over less than this after the transient would mean nothing [s]."""
LONGEST_SIMULATION = 1e8
"""Stamps below this are simulated time, which begins at 0 [s]; those of a host's clock count from 1970."""
START = 1.0
"""Tension is static until this simulated time [s]: the sea has hardly begun."""


NodeParameters = Mapping[str, Mapping[str, Any]]
"""Parameters of nodes: node -> dotted name -> value. Those of all nodes are under ALL_NODES."""
ALL_NODES = "**"


@dataclass
class Innovation:
    """Innovations of one measurement, its `name`.

    Attributes
    ----------
    name : of the measurement
    time : shape (n,) [s]
    value, sigma : innovation and its predicted standard deviation, shape (n,), in the unit of the measurement
    """

    name: str
    time: Array
    value: Array
    sigma: Array


@dataclass
class RunRecord:
    """A run as its bag records it.

    Attributes
    ----------
    name : of the bag
    signals : what the KPIs are computed from
    start, end : evaluation window [s]: after the transient, to the end
    modes, alarms, limits : what held when
    waits : when the controller did not compensate, and why
    requests : what an operator asked for, and when: factor, speed, depth
    innovations : per measurement of the estimator
    run, outcome : the bag's own words on the run
    losses : what of the bag could not be read
    notes : what a reader of the figures must know
    sources : where each motion comes from: TRUE, MEASURED or ESTIMATED
    parameters : of the run's nodes, as far as they are known: node -> dotted name -> value
    wanted : criteria of the scenario that the bag carries
    timings : histograms of durations in wall time by name, real time only: upper edge [ms] -> count
    is_past_transient : the run went on after its transient; False: the figures are of its start-up
    largest_strain : of the cable in the whole run, as the plant reported it [-]; NaN: it did not
    title, description : of the lift, as the scenario states them; "": it does not
    """

    name: str
    signals: RunSignals
    start: float
    end: float
    modes: list[Interval] = field(default_factory=list)
    alarms: list[Interval] = field(default_factory=list)
    limits: list[Interval] = field(default_factory=list)
    waits: list[Interval] = field(default_factory=list)
    requests: list[Interval] = field(default_factory=list)
    innovations: list[Innovation] = field(default_factory=list)
    run: Mapping[str, str] = field(default_factory=dict)
    outcome: Mapping[str, str] = field(default_factory=dict)
    losses: list[Loss] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    sources: dict[str, str] = field(default_factory=dict)
    parameters: NodeParameters = field(default_factory=dict)
    wanted: tuple[Criterion, ...] = ()
    timings: dict[str, dict[str, int]] = field(default_factory=dict)
    is_past_transient: bool = True
    largest_strain: float = math.nan
    title: str = ""
    description: str = ""

    @property
    def moves_winch(self) -> bool:
        """Whether the run had a law that moves the winch, as far as the bag says."""
        law = self.parameters.get("winch_controller", {}).get("law")
        by_modes = any(mode.name != events.OFF for mode in self.modes)
        return bool(law != events.OFF) if isinstance(law, str) else by_modes

    def remarks(self) -> list[str]:
        """Return what a reader of the figures must know: the notes, and what of the bag could not be read."""
        return remarks(self.notes, self.losses)

    def kpis(self, start: float | None = None, end: float | None = None) -> dict[str, float]:
        """Return every KPI over the evaluation window, or over start..end [s]."""
        if start is None and end is None:
            return kpi_set.evaluate_run(self.signals, self.start, self.end)
        return kpi_set.evaluate(self.signals, self.start if start is None else start, self.end if end is None else end)


TRUE, MEASURED, ESTIMATED = "true", "measured", "estimated"
"""Sources of a figure: what only a simulator knows, a sensor, or the controller's estimate."""
LAST_WORDS = 5_000_000_000
"""Time before the end of a bag within which every node publishes diagnostics [ns]."""
STRAIN_KEY = "largest strain"
"""Name of the plant's figure in its diagnostics."""
TIMING_PREFIX = "timing "
"""Begins the name of a diagnostic status with a histogram of durations in wall time."""


def read_run(
    path: str | Path,
    *,
    transient: float | None = None,
    parameters: NodeParameters | None = None,
    progress: Progress = no_progress,
) -> RunRecord:
    """Read a bag of the suite in one pass.

    Parameters
    ----------
    path : of the bag
    transient : start of the evaluation window [s]; None takes what the bag itself says
    parameters : of the nodes, for a bag that carries none; what the bag carries goes before
    progress : called with the share of the bag that is read

    Raises BagError if the bag has nothing that a KPI could be computed from.
    """
    bag = Bag(path)
    selection = {topic: fields for topic, fields in SELECTION.items() if bag.has(topic)}
    if not set(selection) - {DIAGNOSTICS}:
        lost = f"; {bag.losses[0]}" if bag.losses else ""
        if lost and not bag.message_count:
            raise BagError(f"{bag.path}: nothing of a run in it can be read{lost}")
        raise BagError(f"{bag.path}: it holds none of a run's topics; it holds {', '.join(bag.topics) or 'none'}{lost}")
    surveyed = list(bag.losses)
    room = ROOM + ROOM_PER_BYTE * bag.size
    columns = bag.columns(selection, longest=LONGEST_ARRAY, most_bytes=room, progress=progress)
    on_one_clock(columns)
    fields = {topic: Fields(columns.get(topic)) for topic in SELECTION}
    record = RunRecord(_name(bag.path.resolve()), RunSignals(), 0.0, 0.0, run=bag.run, outcome=bag.outcome)
    record.losses = bag.losses or surveyed
    record.notes += bag.notes
    record.notes += [
        f"{topic}: time went backwards {found.resets} times (reset); the last run is shown"
        for topic, found in fields.items()
        if found.resets
    ]
    record.wanted, own = _scenario(bag)
    record.title, record.description = _title(bag)
    known = record.parameters = {**(parameters or {}), **own}
    _fill(record, fields, known)
    if transient is None:
        of_all = _number(known.get(ALL_NODES, {}), "transient", 0.0)
        transient = _as_number(bag.run.get("transient_s"), of_all)
    _set_window(record, transient)
    _refuse_nothing(record, bag)
    if bag.has(DIAGNOSTICS):
        _fill_last_words(record, bag, is_paced=bag.run.get("pacing") == REALTIME)
    return record


def _fill_last_words(record: RunRecord, bag: Bag, *, is_paced: bool) -> None:
    """Take what the nodes published last, of all the run: strain, and if it `is_paced`, durations and late commands."""
    for _, message in bag.decoded([DIAGNOSTICS], start=bag.end_time - LAST_WORDS):
        for title, values in _statuses(message):
            node, _, name = title.partition(": ")
            if is_paced and name.startswith(TIMING_PREFIX) and "histogram_ms" in values:
                record.timings[f"{node}: {name.removeprefix(TIMING_PREFIX)}"] = parse_histogram(values["histogram_ms"])
            if is_paced and name == COMMANDS:
                record.signals.late_commands = _as_number(values.get(LATE))
            record.largest_strain = _as_number(values.get(STRAIN_KEY, record.largest_strain))


def _statuses(message: Any) -> list[tuple[str, dict[str, Any]]]:
    """Return name and values of each status of a diagnostic message; none of one whose definition is another."""
    try:
        return [(str(part.name), {value.key: value.value for value in part.values}) for part in message.status]
    except (AttributeError, TypeError):
        return []


def _name(path: Path) -> str:
    """Return what to call a bag: its folder, or the run's folder where the bag is just called bag."""
    return path.parent.name if path.name == "bag" else path.name


def _fill(record: RunRecord, fields: Mapping[str, Fields], parameters: NodeParameters) -> None:
    """Fill a record with what the topics tell."""
    _fill_motion(record, fields)
    _note_sources(record)
    _fill_winch(record, fields[WINCH])
    _fill_controller(record, fields[CONTROLLER])
    set_point = fields[CONTROLLER].signal("depth_set_point")
    if take_out_programme(record.signals, set_point, _cable_weight(parameters.get("cable_sim", {}))):
        record.notes.append(
            f"the unit was moved to other depths: heave is about its running mean of {SPAN:g} s, "
            "payout about its set-point"
        )
    record.alarms += events.diagnostic_alarms(fields[DIAGNOSTICS], has_modes=bool(record.modes))
    record.requests += events.operator_requests(fields[DIAGNOSTICS])
    _fill_outcome(record)
    _fill_parameters(record.signals, parameters)


def _set_window(record: RunRecord, transient: float) -> None:
    """Set the evaluation window: from the transient [s] to the end of the first signal that was recorded.

    Simulated time begins at 0, so the transient ends at that time, whenever the recorder joined; by a host's clock
    the transient begins with the record.
    """
    signals = record.signals
    motions = (signals.unit_heave, signals.uncompensated_heave, signals.boom_tip_heave, signals.payout, signals.tension)
    recorded = [signal.time for signal in motions if signal.size]
    if not recorded:
        return
    first, record.end = float(recorded[0][0]), float(recorded[0][-1])
    transient = transient if math.isfinite(transient) else 0.0
    record.start = max(transient, first) if first < LONGEST_SIMULATION else first + transient
    if record.start > record.end - SHORTEST_WINDOW:
        record.notes.append(
            f"the run ended within its transient of {transient:g} s: the figures cover the whole run "
            "(a longer --duration, or --set all.transient=60)"
        )
        record.start, record.is_past_transient = first, False


def _refuse_nothing(record: RunRecord, bag: Bag) -> None:
    """Raise BagError for a bag that gives no figure of the run itself."""
    values = record.kpis()
    about_run = [definition for definition in kpi_set.KPI_DEFINITIONS if definition.group != kpi_set.TIMING]
    if not any(math.isfinite(values[definition.key]) for definition in about_run):
        lost = f"; {record.losses[0]}" if record.losses else ""
        raise BagError(f"{bag.path}: no figures can be computed: its topics hold no motion or tension{lost}")


def _best(record: RunRecord, name: str, known: Sequence[tuple[str, Signal]]) -> Signal:
    """Return the first signal that was recorded, and note where it comes from."""
    for source, signal in known:
        if signal.size > 1 or (signal.size and source == TRUE):
            record.sources[name] = source
            return signal
    return Signal()


def _fill_motion(record: RunRecord, fields: Mapping[str, Fields]) -> None:
    signals = record.signals
    state = fields[CONTROLLER]
    signals.unit_heave = _best(
        record,
        "unit heave",
        ((TRUE, fields[UNIT].signal("pose.pose.position.z")), (ESTIMATED, state.signal("predicted_unit_heave"))),
    )
    signals.uncompensated_heave = _best(
        record,
        "uncompensated unit heave",
        (
            (TRUE, fields[UNCOMPENSATED].signal("position.z")),
            (ESTIMATED, state.signal("predicted_uncompensated_heave")),
        ),
    )
    signals.boom_tip_heave = _best(
        record,
        "boom-tip heave",
        ((TRUE, fields[BOOM_TIP].signal("position.z")), (MEASURED, fields[MRU].signal("heave"))),
    )
    signals.unit_height = fields[UNIT].signal("pose.pose.position.z")
    force = fields[CABLE].signal("touchdown_force")
    signals.touchdown = Signal(force.time, (force.value > 0.0).astype(float))
    slack = fields[CABLE].signal("slack_segments")
    signals.slack = Signal(slack.time, (slack.value > 0.0).astype(float))
    tensions = (
        (TRUE, fields[CABLE].signal("top_tension")),
        (MEASURED, fields[LOAD_CELL].signal("tension")),
        (MEASURED, fields[WINCH].signal("tension")),
    )
    signals.tension = _best(record, "top tension", tensions)
    signals.unit_tension = fields[CABLE].signal("bottom_tension")
    if record.sources.get("top tension") == TRUE:
        signals.largest_tension = fields[CABLE].signal("largest_top_tension")
    if signals.tension.size and signals.tension.time[0] < START:
        signals.static_tension = Signal(signals.tension.time[:1], signals.tension.value[:1])


def _note_sources(record: RunRecord) -> None:
    """Say which motions are not the truth, as on a ship, where it is unknown."""
    other = [f"{name} is {source}" for name, source in record.sources.items() if source != TRUE]
    if other:
        record.notes.append(f"the true values were not recorded:  {', '.join(other)}")


def _fill_winch(record: RunRecord, winch: Fields) -> None:
    if not winch.size:
        return
    signals = record.signals
    signals.payout = winch.signal("payout")
    signals.payout_rate = winch.signal("payout_rate")
    signals.payout_acceleration = winch.signal("payout_acceleration")
    if not signals.payout.size:
        signals.payout = winch.signal("encoder_payout")
        signals.payout_rate = winch.signal("encoder_payout_rate")
        record.sources["payout"] = MEASURED
        record.notes.append("payout is the encoder's reading: the true payout was not recorded")
    signals.limits_hit = Signal(winch.time, winch.codes("limits_hit").astype(float))
    record.limits += events.winch_limits(winch)
    record.alarms += events.winch_faults(winch)


def _fill_controller(record: RunRecord, state: Fields) -> None:
    record.modes, record.waits = events.modes(state), events.waits(state)
    names = state.texts("mode")
    if names is not None:
        events.take_modes(record.signals, state.time, names)
    if record.signals.mode_changes.size:
        lost = [mode.start for mode in events.losses(record.modes)]
        record.signals.losses = Signal(state.time, np.isin(state.time, lost).astype(float))
    record.signals.execution_time = state.signal("execution_time")
    record.alarms += events.sensor_alarms(state)
    record.innovations = _innovations(state)
    nis = state.table("nis")
    if nis is not None and nis.size:
        finite = np.isfinite(nis)
        inside = (nis >= NIS_BAND[0]) & (nis <= NIS_BAND[1])
        rows = np.repeat(state.time[:, None], nis.shape[1], axis=1)
        record.signals.nis_in_band = Signal(rows[finite], inside[finite].astype(float))


def _innovations(state: Fields) -> list[Innovation]:
    values, sigmas = state.table("innovation"), state.table("innovation_sigma")
    if values is None or sigmas is None:
        return []
    found = []
    for column in range(min(values.shape[1], sigmas.shape[1])):
        names = state.texts(f"measurement_names[{column}]")
        given = [name for name in names if name] if names is not None else []
        good = np.isfinite(values[:, column])
        if good.any():
            name = str(given[0]) if given else f"measurement {column + 1}"
            found.append(Innovation(name, state.time[good], values[good, column], sigmas[good, column]))
    return found


def _fill_outcome(record: RunRecord) -> None:
    def number(key: str) -> float:
        return _as_number(record.outcome.get(key))

    signals = record.signals
    signals.real_time_factor = number("real_time_factor")
    signals.missed_deadlines = number("missed_deadlines")
    signals.loop_age = (number("loop_age_p50_s"), number("loop_age_p99_s"), number("loop_age_max_s"))
    ended = record.outcome.get("ended", "")
    if ended not in (COMPLETE, SNAPSHOT, ""):
        record.notes.append(f"the run did not end normally: {ended}")
    if "lost_on_the_way" in record.outcome:
        record.notes.append(record.outcome["lost_on_the_way"])
    if "lost" in record.outcome:
        record.notes.append(f"messages lost while recording: {record.outcome['lost']}")


def _as_number(value: Any, default: float = math.nan) -> float:
    """Return what a bag gives as a number; the default where it is not a number."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return default


def _scenario(bag: Bag) -> tuple[tuple[Criterion, ...], dict[str, dict[str, Any]]]:
    """Return what was wanted of a run, and its nodes' parameters by node and dotted name, as far as the bag has them.

    A killed recorder had no time to add what the nodes reported; the scenario is there from the start.
    """
    attachments = bag.attachments
    wanted: tuple[Criterion, ...] = ()
    nodes: dict[str, dict[str, Any]] = {}
    for name in (SCENARIO_ATTACHMENT, PARAMETERS_ATTACHMENT):
        try:
            content = attachments.get(name, b"")
            sections = parse_sections(content, name)
            if name == SCENARIO_ATTACHMENT:
                wanted = _wanted(sections, name)
        except (ParameterError, ValueError):
            continue
        for node in ("cable_sim", "wave_vessel", "virtual_winch", "winch_controller"):
            nodes.setdefault(node, {}).update(values_of_node(sections, f"/{node}"))
    return wanted, nodes


def _title(bag: Bag) -> tuple[str, str]:
    """Return title and description of the lift, as the scenario in the bag states them: its first line is one."""
    content = bag.attachments.get(SCENARIO_ATTACHMENT, b"")
    first = content[: 4 * LONGEST_TEXT].decode("utf-8", errors="replace").partition("\n")[0]
    try:
        shared = parse_sections(content, SCENARIO_ATTACHMENT).get(WILDCARD, {})
    except (ParameterError, ValueError):
        shared = {}
    title, words = (str(shared.get(name) or "").strip()[:LONGEST_TEXT] for name in ("title", "description"))
    return title, words or (first.lstrip("# ").strip()[:LONGEST_TEXT] if first.startswith("#") else "")


def _wanted(sections: Sections, name: str) -> tuple[Criterion, ...]:
    """Return the criteria of a stored scenario, for figures that are still known."""
    given = (Given(value, key, name) for key, value in sections.get(WILDCARD, {}).items() if key.startswith(WANTED))
    criteria = [parse_criterion(one) for one in given]
    return tuple(criterion for criterion in criteria if criterion.kpi in kpi_set.DEFINITION_OF)


def _number(parameters: Mapping[str, Any], name: str, default: float) -> float:
    return _as_number(parameters.get(name), default)


def _cable_weight(plant: Mapping[str, Any]) -> float:
    """Return weight minus buoyancy of the cable that is paid out [N/m]; 0 where the bag does not say."""
    diameter = _number(plant, "cable.diameter", math.nan)
    displaced = displaced_area(diameter, _number(plant, "cable.displaced_diameter", 0.0))
    weight = weight_in_fluid(
        _number(plant, "cable.mass_per_length", math.nan),
        displaced,
        _number(plant, "water_density", SEAWATER_DENSITY),
        _number(plant, "gravity", STANDARD_GRAVITY),
    )
    return weight if math.isfinite(weight) else 0.0


def _fill_parameters(signals: RunSignals, nodes: NodeParameters) -> None:
    winch, vessel = nodes.get("virtual_winch", {}), nodes.get("wave_vessel", {})
    signals.speed_limit = _number(winch, "speed_limit", math.inf)
    signals.acceleration_limit = _number(winch, "acceleration_limit", math.inf)
    signals.power_limit = _number(winch, "power_limit", math.inf) or math.inf  # 0 means no limit
    # a ship has no plant: its controller knows the same cable and unit
    signals.strengths = strengths({**nodes.get("winch_controller", {}), **nodes.get("cable_sim", {})}, winch)
    if vessel.get("boom_tip_source") == "regular":
        period = _number(vessel, "period", math.nan)
        signals.driving_omega = 2.0 * math.pi / period if period > 0.0 else math.nan
