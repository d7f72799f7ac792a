"""From a bag of the suite to the signals of its run: which topic and field is what. One pass over the bag."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from heave_node.interface import topics
from heave_node.run_parameters import REALTIME

from heave_bags.analyse import events, kpi_set
from heave_bags.analyse.reading.depth_programme import SPAN, take_out_programme
from heave_bags.analyse.reading.fields import Fields, on_one_clock
from heave_bags.analyse.reading.innovations import innovations, nis_in_band
from heave_bags.analyse.reading.last_words import last_words
from heave_bags.analyse.reading.stored import (
    ALL_NODES,
    NodeParameters,
    as_number,
    cable_weight,
    fill_parameters,
    number,
    stored_changes,
    stored_scenario,
    stored_title,
)
from heave_bags.analyse.reading.unit_height import measured_height, water_of
from heave_bags.analyse.run_record import ESTIMATED, MEASURED, TRUE, RunRecord
from heave_bags.errors import BagError
from heave_bags.mcap.files import COMPLETE, SNAPSHOT
from heave_bags.mcap.reader import Bag, Progress, no_progress
from heave_bags.signals import RunSignals, Signal

UNIT, UNCOMPENSATED = topics.UNIT_ODOMETRY.name, topics.UNIT_UNCOMPENSATED.name
BOOM_TIP, WINCH, LOAD_CELL = topics.BOOM_TIP.name, topics.WINCH_STATE.name, topics.LOAD_CELL.name
MRU, PRESSURE = topics.MRU.name, topics.UNIT_PRESSURE.name
SEA_STATE = topics.SEA_STATE.name
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
    PRESSURE: ("fluid_pressure",),
    SEA_STATE: ("spectrum", "significant_wave_height", "peak_period", "seed"),
    DIAGNOSTICS: ("status[].level", "status[].name", "status[].message"),
}
"""The topics and fields that KPIs and reports are made from."""

LONGEST_ARRAY = 4096
"""Arrays and texts of more elements are not part of a run."""
ROOM = 16 << 20
ROOM_PER_BYTE = 64
"""Bytes of messages that an analysis takes: so many, and so many for each byte of the bag. Runs need a tenth of it."""

SHORTEST_WINDOW = 1.0
"""Figures over less than this after the transient would mean nothing [s]."""
LONGEST_SIMULATION = 1e8
"""Stamps below this are simulated time, which begins at 0 [s]; those of a host's clock count from 1970."""
START = 1.0
"""Tension is static until this simulated time [s]: the sea has hardly begun."""


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
    if not set(selection) - {DIAGNOSTICS, SEA_STATE}:
        lost = f"; {bag.losses[0]}" if bag.losses else ""
        if lost and not bag.message_count:
            raise BagError(f"{bag.path}: nothing of a run in it can be read{lost}")
        raise BagError(f"{bag.path}: none of a run's topics in it; it holds {', '.join(bag.topics) or 'nothing'}{lost}")
    surveyed = list(bag.losses)
    room = ROOM + ROOM_PER_BYTE * bag.size
    columns = bag.columns(selection, longest=LONGEST_ARRAY, most_bytes=room, progress=progress)
    on_one_clock(columns)
    fields = {topic: Fields(columns.get(topic)) for topic in SELECTION if topic != DIAGNOSTICS}
    is_reset = any(one.resets for one in fields.values())  # a node that is seconds behind reports late, beside others
    fields[DIAGNOSTICS] = Fields(columns.get(DIAGNOSTICS), may_reset=is_reset)
    record = RunRecord(_name(bag.path.resolve()), RunSignals(), 0.0, 0.0, outcome=bag.outcome)
    record.run = {**bag.run, **stored_changes(bag)}
    record.losses = bag.losses or surveyed
    record.notes += bag.notes
    record.notes += [
        f"{topic}: time went backwards {found.resets} times (reset); the last run is shown"
        for topic, found in fields.items()
        if found.resets
    ]
    record.wanted, own = stored_scenario(bag)
    record.title, record.description = stored_title(bag)
    known = record.parameters = {**(parameters or {}), **own}
    _fill(record, fields, known)
    if transient is None:
        of_all = number(known.get(ALL_NODES, {}), "transient", 0.0)
        transient = as_number(bag.run.get("transient_s"), of_all)
    _set_window(record, transient)
    _refuse_nothing(record, bag)
    if bag.has(DIAGNOSTICS):
        said = last_words(bag, is_paced=bag.run.get("pacing") == REALTIME)
        record.timings, record.largest_strain = said.timings, said.largest_strain
        record.signals.late_commands = said.late_commands
    return record


def _name(path: Path) -> str:
    """Return what to call a bag: its folder, or the run's folder where the bag is just called bag."""
    return path.parent.name if path.name == "bag" else path.name


def _fill(record: RunRecord, fields: Mapping[str, Fields], parameters: NodeParameters) -> None:
    """Fill a record with what the topics tell."""
    _fill_motion(record, fields, parameters)
    record.notes += record.source_notes()
    _fill_winch(record, fields[WINCH])
    _fill_controller(record, fields[CONTROLLER])
    set_point = fields[CONTROLLER].signal("depth_set_point")
    if take_out_programme(record.signals, set_point, cable_weight(parameters.get("cable_sim", {}))):
        record.notes.append(
            f"the load was moved to other depths: heave is about its running mean of {SPAN:g} s, "
            "payout about its set-point"
        )
    record.sea = _sea(fields[SEA_STATE])
    known = events.sensor_alarms(fields[CONTROLLER]) + events.winch_faults(fields[WINCH])
    holding = [*known, *record.waits]
    record.alarms += events.diagnostic_alarms(fields[DIAGNOSTICS], holding, has_modes=bool(record.modes))
    record.requests += events.operator_requests(fields[DIAGNOSTICS])
    _fill_outcome(record)
    fill_parameters(record.signals, parameters)


def _sea(state: Fields) -> str:
    """Return the last sea that was stated, in words; "": none was."""
    spectra = state.texts("spectrum")
    height, period = (state.signal(name).value for name in ("significant_wave_height", "peak_period"))
    if spectra is None or not (height.size and period.size):
        return ""
    return f"{spectra[-1]}, Hs {height[-1]:.4g} m, Tp {period[-1]:.4g} s, seed {state.codes('seed')[-1]}"


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
            f"the run ended before its figures start to count at {transient:g} s: they cover its start-up "
            "(use a longer --duration or a shorter all.transient)"
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


def _fill_motion(record: RunRecord, fields: Mapping[str, Fields], parameters: NodeParameters) -> None:
    signals, state = record.signals, fields[CONTROLLER]
    pressure, payout = fields[PRESSURE].signal("fluid_pressure"), fields[WINCH].signal("encoder_payout")
    depths = measured_height(pressure, payout, water_of(parameters.get("winch_controller", {})))
    signals.unit_heave = _best(
        record,
        "load heave",
        ((TRUE, fields[UNIT].signal("pose.pose.position.z")), (ESTIMATED, state.signal("predicted_unit_heave"))),
    )
    signals.uncompensated_heave = _best(
        record,
        "load heave, winch locked",
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
    heights = ((TRUE, fields[UNIT].signal("pose.pose.position.z")), (MEASURED, depths))
    signals.unit_height = _best(record, "unit height", heights)
    force, slack = (fields[CABLE].signal(name) for name in ("touchdown_force", "slack_segments"))
    signals.touchdown, signals.slack = (Signal(one.time, (one.value > 0.0).astype(float)) for one in (force, slack))
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


def _fill_controller(record: RunRecord, state: Fields) -> None:
    record.modes, record.waits = events.modes(state), events.waits(state)
    if (names := state.texts("mode")) is not None:
        events.take_modes(record.signals, state.time, names)
    if record.signals.mode_changes.size:
        lost = [mode.start for mode in events.losses(record.modes)]
        record.signals.losses = Signal(state.time, np.isin(state.time, lost).astype(float))
    record.signals.execution_time = state.signal("execution_time")
    record.innovations = innovations(state)
    record.signals.nis_in_band = nis_in_band(state)


def _fill_outcome(record: RunRecord) -> None:
    def number(key: str) -> float:
        return as_number(record.outcome.get(key))

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
