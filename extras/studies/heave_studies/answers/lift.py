"""The largest sea of each phase of a lift, held against a forecast, and against the bag of the lift.

A phase needs the sea within `alpha` times its limit from when it begins as planned to when it ends with all contingency
time used up, its own and that of the phases before it in the same window (T_R = T_POP + T_C; the operational criterion
is alpha times the design criterion: DNV-ST-N001, Marine operations and marine warranty, section on weather-restricted
operations, whose tables of alpha are the user's to apply). Phases follow one another at once; only before one that
`may_wait` is the unit left where it is.

In a bag phases are found by the depth of the unit, in the order of the study. A ship's bag has no truth: depth is then
that of the depth sensor, loads are those of the load cell, and the strength of the parts is the scenario's. What these
cannot tell stays unknown, and is said of each criterion.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF, evaluate
from heave_bags.analyse.run_record import TRUE, RunRecord
from heave_bags.analyse.verdict import FAILED, PASSED, Judged, required_words
from heave_bags.mcap.read.folder import bag_of
from heave_bags.report.figure import LIMIT, UNIT, Figure
from heave_bags.report.report import unbroken
from heave_bags.signals import RunSignals, Signal
from heave_bringup.output import warn
from heave_bringup.run.records import read_records
from heave_bringup.scenarios import Scenario
from heave_node.criteria import Criterion
from heave_node.loads.strength import strengths
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.parameters import ParameterError, flatten
from heave_node.sheet import Column, Sheet
from scipy.ndimage import uniform_filter1d
from scipy.signal import savgol_filter

from heave_studies.answers import limits
from heave_studies.answers.answer import Ask, Found, Section, as_path, criteria_of, first_scenario, number_in
from heave_studies.operability.limits import HEIGHT, PERIOD, UNCOMPENSATED
from heave_studies.operability.seas import HS, TP, SeaRecord, limit_at, read_record, study_situations
from heave_studies.study.phases import Phase
from heave_studies.study.plan import Study


@dataclass(frozen=True)
class Window:
    """When a phase takes place."""

    phase: str  # its name
    start: pandas.Timestamp | None = None  # of it; None: there is no window
    waiting: float = math.nan  # before it [h]
    # largest forecast height over what is allowed, in its reference period [-]; NaN without a window
    utilisation: float = math.nan

    @property
    def time(self) -> str:
        """Its start as people read it, in UTC."""
        return "none" if self.start is None else f"{self.start:%Y-%m-%d %H:%M}"


WINDOWS = Sheet(
    Column("phase", "phase", "phase"),
    Column("start (UTC)", "time"),
    Column("", lambda one: None if one.start is None else one.start.isoformat(), "start"),
    Column("wait [h]", "waiting", "waiting_h", ".1f"),
    Column("of allowed [%]", "utilisation", "utilisation", ".0f", 100.0),
)


def read_forecast(path: Path) -> SeaRecord:
    """Return the forecast in the file at `path`; raise ParameterError for one without an order in time."""
    forecast = read_record(path)
    if not forecast.has_order:
        raise ParameterError(f"{path}: is a scatter diagram; a forecast needs the columns time, hs, tp")
    return forecast


def windows(
    phases: Sequence[Phase], allowed: Mapping[str, Array], forecast: SeaRecord, contingency: float
) -> list[Window]:
    """Return when each phase can take place.

    Parameters
    ----------
    phases : of the lift
    allowed : height up to which each may begin, by its name, at each step of the forecast [m]
    forecast : with times
    contingency : time over the planned duration of a phase [-]
    """
    step, times, clock = forecast.step, pandas.DatetimeIndex(forecast.states.index), 0.0
    used = {phase.name: _utilisation(allowed[phase.name], forecast) for phase in phases}
    found: list[Window] = []
    for group in _groups(phases):
        hours = np.cumsum([0.0, *(phase.duration / 3600.0 for phase in group)])
        late = hours * (1.0 + contingency)

        def worst(
            number: int, start: float, group: list[Phase] = group, hours: Array = hours, late: Array = late
        ) -> float:
            """Return the largest share of what is allowed, from when a phase begins until it is over at the latest."""
            of_phase = used[group[number].name]
            first = math.floor((start + hours[number]) / step + 1e-9)
            last = max(math.ceil((start + late[number + 1]) / step - 1e-9), 1)
            return float(of_phase[first:last].max()) if last <= of_phase.size else math.inf

        tried = (clock, *(step * n for n in range(math.floor(clock / step) + 1, times.size)))
        start = next((at for at in tried if all(worst(n, at) <= 1.0 for n in range(len(group)))), None)
        if start is None:
            return [*found, *(Window(phase.name) for phase in phases[len(found) :])]
        for n, phase in enumerate(group):
            waited = 0.0 if n else start - clock
            when = times[0] + pandas.Timedelta(hours=start + hours[n])
            found.append(Window(phase.name, when, waited, worst(n, start)))
        clock = start + hours[-1]
    return found


def allowed_heights(curve: pandas.DataFrame, forecast: SeaRecord, alpha: float) -> Array:
    """Return the height up to which a phase may begin, by step of a forecast [m]: alpha times its limit.

    Parameters
    ----------
    curve : limits of the phase by period
    forecast : with times
    alpha : share of the limit [-]
    """
    return alpha * limit_at(curve, forecast.states[TP].to_numpy())


def warnings(forecast: SeaRecord, curve: pandas.DataFrame) -> list[str]:
    """Return what is to be known of a `forecast` before it is trusted: what was repaired, what the limits leave open.

    `curve` has the limits of a phase by period.
    """
    first, last = curve["period"].min(), curve["period"].max()
    outside = int(((forecast.states[TP] < first) | (forecast.states[TP] > last)).sum())
    held = f"{forecast.name}: {outside} of {len(forecast.states)} peak periods lie outside {first:g} to {last:g} s"
    words = f"{held}, where the limit of the nearest is taken: vary {PERIOD} further"
    return [*forecast.warnings, *([words] if outside else [])]


def _utilisation(allowed: Array, forecast: SeaRecord) -> Array:
    """Return the forecast height over what is `allowed`, by step; infinite where nothing is forecast."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = forecast.states[HS].to_numpy() / allowed
    return np.where(np.isnan(share), np.inf, share)


def _groups(phases: Sequence[Phase]) -> list[list[Phase]]:
    """Return the phases that follow one another without a wait."""
    groups: list[list[Phase]] = []
    for phase in phases:
        if groups and not phase.does.may_wait:
            groups[-1].append(phase)
        else:
            groups.append([phase])
    return groups


NOT_REACHED, IN_PART = "not in the bag", "passed in part"
ENDS = 0.5
"""Distance from the depth of its end at which a phase is done [m]."""
WAVES = 20.0
"""Length of the running mean that takes the waves out of the depth [s]."""
SHORTEST = 5.0
"""Time that a phase must have in the bag to be judged [s]."""
LINE = 60.0
"""Length of the running straight line, applied twice, about which a depth sensor shows the heave of the unit [s]."""
OF_UNIT = ("unit_sigma_m", "significant_residual_m", "max_abs_heave_m")
OVER_STATIC = ("dynamic_amplification", "tension_ratio_min")


@dataclass(frozen=True)
class AsBuilt:
    """What became of a phase."""

    phase: Phase  # of the lift
    start: float = math.nan  # in the bag [s]; NaN: not in it
    end: float = math.nan  # in the bag [s]; NaN: not in it
    judged: tuple[Judged, ...] = ()  # its criteria; a value that the bag cannot tell is NaN

    @property
    def state(self) -> str:
        """The verdict in words."""
        if math.isnan(self.start):
            return NOT_REACHED
        if self.failures:
            return FAILED
        return PASSED if all(one.is_met for one in self.judged) else IN_PART

    @property
    def failures(self) -> list[str]:
        """What is missed, in words."""
        return [f"{self.phase.name}: {one}" for one in self.judged if not (one.is_met or math.isnan(one.value))]

    def to_json(self) -> dict[str, object]:
        """Return it as plain data."""
        return {
            "phase": self.phase.name,
            "state": self.state,
            "start_s": self.start,
            "end_s": self.end,
            "criteria": [one.to_json() for one in self.judged],
        }


def as_built(
    phases: Sequence[Phase], criteria: Mapping[str, Sequence[Criterion]], scenario: Scenario, record: RunRecord
) -> list[AsBuilt]:
    """Return what became of each phase of a lift in the bag of it.

    Parameters
    ----------
    phases : of the lift
    criteria : of each, by its name
    scenario : of its study
    record : of the bag

    Raises ParameterError for a bag without the depth of the unit, or with none of the phases.
    """
    height = record.signals.unit_height
    if height.size < 2:
        raise ParameterError(
            f"{record.name}: does not say how deep the unit is (unit/odometry or unit/pressure), by which phases are "
            "found"
        )
    width = max(round(WAVES / float(np.median(np.diff(height.time)))), 1)
    depth = -uniform_filter1d(height.value, width, mode="nearest")
    plant, winch = (flatten(scenario.parameters[node]) for node in ("cable_sim", "virtual_winch"))
    signals = replace(record.signals, strengths=strengths(plant, winch))
    period = scenario.parameters["wave_vessel"].peak_period
    reach = 0.0 if record.sources.get("unit height", TRUE) == TRUE else _reach_of_waves(period)
    found, after = [], record.start
    for phase in phases:
        start, end = _window(phase, height.time, depth, after)
        if not end - start >= SHORTEST:
            found.append(AsBuilt(phase))
            continue
        values = _values(signals, phase, start, end, reach)
        judged = tuple(Judged(one, values[one.kpi]) for one in criteria[phase.name])
        found.append(AsBuilt(phase, start, end, judged))
        after = end
    if all(math.isnan(one.start) for one in found):
        seen = f"{depth.min():.0f} to {depth.max():.0f} m"
        raise ParameterError(f"{record.name}: its unit is at {seen} depth, where the lift has no phase")
    return found


def _reach_of_waves(period: float) -> float:
    """Return half the length of waves of a `period` [s], below which a depth sensor does not notice them [m]."""
    return STANDARD_GRAVITY * period**2 / (4.0 * math.pi)


def _values(signals: RunSignals, phase: Phase, start: float, end: float, reach: float) -> dict[str, float]:
    """Return every figure of a phase; NaN for what `signals` cannot tell: heave within the `reach` of waves [m]."""
    tension, height = (one.window(start, end) for one in (signals.tension, signals.unit_height))
    signals = replace(signals, static_tension=_static(signals, phase, tension))
    if not signals.unit_heave.size:
        signals.unit_heave = Signal(height.time, _about_line(height))
    values = evaluate(signals, start, end)
    if min(phase.does.depth) < reach:
        values.update(dict.fromkeys(OF_UNIT, math.nan))
    if phase.crosses_surface and not signals.static_tension.size:
        values.update(dict.fromkeys(OVER_STATIC, math.nan))
    if not signals.slack.size and values["slack_percent"] == 0.0:  # a load cell knows the top alone
        values["slack_percent"] = math.nan
    return values


def _static(signals: RunSignals, phase: Phase, tension: Signal) -> Signal:
    """Return the tension at rest of a phase: that of the start of a bag may be the weight in air.

    Through the surface the weight at the start is what loads are compared with: of a ship, while the unit is above
    water.
    """
    if phase.crosses_surface:
        dry = tension.value[signals.unit_height.at(tension) > 0.0] if signals.unit_height.size else tension.value
        is_told = signals.static_tension.size or not dry.size
        return signals.static_tension if is_told else Signal(tension.time[:1], np.array([np.median(dry)]))
    static = signals.static_at(tension)
    return Signal(tension.time, static + float(np.median(tension.value - static)) if tension.size else static)


def _about_line(height: Signal) -> Array:
    """Return the heave of a unit that is lowered: its height about a straight line that runs along it [m]."""
    length = min(round(LINE / float(np.median(np.diff(height.time)))), height.size)
    length -= 1 - length % 2
    slow = savgol_filter(savgol_filter(height.value, length, 1), length, 1)
    return np.asarray(height.value - slow)


def _window(phase: Phase, time: Array, depth: Array, after: float) -> tuple[float, float]:
    """Return when a phase begins and ends, from `after` on: within its depths, until the depth of its end [s]."""
    first, last = phase.does.depth
    low, high = min(first, last) - ENDS, max(first, last) + ENDS
    inside = (time >= after) & (depth >= low) & (depth <= high)
    begun = np.flatnonzero(inside)
    if not begun.size:
        return math.nan, math.nan
    start = int(begun[0])
    left = np.flatnonzero(~inside[start:])
    end = start + (int(left[0]) if left.size else inside.size - start) - 1
    if first != last:
        done = np.flatnonzero(np.abs(depth[start : end + 1] - last) <= ENDS)
        end = start + int(done[0]) if done.size else end
    else:
        end = min(end, int(np.searchsorted(time, time[start] + phase.duration)))
    return float(time[start]), float(time[end])


KEYS: Mapping[str, object] = MappingProxyType(
    {"within": None, "alpha": 1.0, "contingency": 0.0, "forecast": None, "bag": None}
)
"""Width within which bisection is to enclose each limit [m], share of a limit up to which a forecast may go,
contingency time over the planned one; files: the seas to come (time, hs, tp), and the bag of the lift.
"""
FOOTER = (
    "The limit of a phase is the least of those at its depths, each from runs of the whole loop, as far as it hangs."
)


def _reached(one: tuple[AsBuilt, Judged]) -> str:
    return one[1].got if one[1].is_met or math.isnan(one[1].value) else f"{one[1].got}, {FAILED}"


BUILT = Sheet(
    Column("phase", lambda one: one[0].phase.name),
    Column("criterion", lambda one: f"{DEFINITION_OF[one[1].criterion.kpi].title} {required_words(one[1].criterion)}"),
    Column("as built", _reached),
)
"""Every criterion with what the bag shows of it."""


def _limits_ask(ask: Ask) -> dict[str, object]:
    return {**limits.KEYS, "within": ask["within"], "alpha": ask["alpha"]}


def prepare(study: Study, ask: Ask, /) -> Study:
    """See `heave_studies.answers.answer.Answer`."""
    if not study.phases:
        raise ParameterError(f"{study.path}: phases is missing: the phases of the lift")
    if others := [place for link in study.vary for place in link if place not in (HEIGHT, PERIOD)]:
        raise ParameterError(f"{study.path}: vary: {others[0]}: a lift varies its seas alone; set it in a phase")
    if not 0.0 <= number_in(ask, "contingency") < math.inf:
        raise ParameterError(f"ask: contingency = {ask['contingency']}: must be a number of at least 0")
    prepared = limits.prepare(study, _limits_ask(ask))
    criteria = criteria_of(study)
    for phase in study.phases:
        unknown = [one.kpi for one in criteria[phase.name] if one.kpi not in UNCOMPENSATED]
        if unknown and not phase.does.compensated:
            raise ParameterError(
                f"{study.path}: {phase.name}: {unknown[0]} is not known with the winch locked; known: "
                f"{', '.join(UNCOMPENSATED)}; or give the phase compensated: true"
            )
    _forecast(ask)
    _built(study, ask)
    return prepared


def _forecast(ask: Ask) -> SeaRecord | None:
    path = as_path(ask["forecast"])
    return None if path is None else read_forecast(path)


def _built(study: Study, ask: Ask) -> list[AsBuilt]:
    path = as_path(ask["bag"])
    if path is None:
        return []
    (record,) = read_records([bag_of(path)])
    warn(record.remarks())
    return as_built(study.phases, criteria_of(study), first_scenario(study), record)


def answer(study: Study, frame: pandas.DataFrame, ask: Ask, /) -> Found:
    """See `heave_studies.answers.answer.Answer`."""
    found = limits.answer(study, frame, _limits_ask(ask))
    sections, data, failures = list(found.sections), dict(found.data), []
    forecast, built = _forecast(ask), _built(study, ask)
    if forecast is not None:
        situations = {one.name: one for one in study_situations(frame, criteria_of(study), None)}
        curves = {
            phase.name: situations[phase.name].limit if phase.does.compensated else situations[phase.name].locked_limit
            for phase in study.phases
        }
        warn(warnings(forecast, next(iter(curves.values()))))
        alpha = limits.alpha_of(ask)
        allowed = {name: allowed_heights(curve, forecast, alpha) for name, curve in curves.items()}
        due = windows(study.phases, allowed, forecast, number_in(ask, "contingency"))
        missing = [one.phase for one in due if one.start is None]
        waits = sum(one.waiting for one in due if one.start is not None)
        verdict = f"NO-GO: no window for {', '.join(missing)}" if missing else f"GO after {waits:g} h of waiting"
        words = f"forecast {forecast.name}, {100.0 * alpha:.0f} % of the limits: {verdict}"
        failures += [f"{name}: no window in the forecast" for name in missing]
        drawn = [_forecast_figure(forecast, np.min(list(allowed.values()), axis=0), due)]
        cells = WINDOWS.cells(due)
        sections.append(Section("Forecast", WINDOWS.headings, cells, texts=2, words=[words], figures=drawn))
        data["windows"] = WINDOWS.records(due)
    if built:
        rows = [(one, judged) for one in built for judged in one.judged]
        states = [f"as built, {one.phase.name}: {one.state}" for one in built]
        failures += [words for one in built for words in one.failures]
        cells = [[unbroken(cell) for cell in row] for row in BUILT.cells(rows)]
        sections.append(Section("As built", BUILT.headings, cells, texts=3, words=states))
        data["as_built"] = [one.to_json() for one in built]
    return replace(found, sections=sections, data=data, failures=failures, footer=FOOTER)


def _forecast_figure(forecast: SeaRecord, allowed: Array, due: Sequence[Window]) -> Figure:
    """Return the forecast, the height that the strictest phase allows by its steps [m], and when the phases begin."""
    times = [f"{time:%Y-%m-%d %H:%M}" for time in pandas.DatetimeIndex(forecast.states.index)]
    pairs = (("forecast", forecast.states[HS], UNIT, "solid"), ("allowed, strictest phase", allowed, LIMIT, "dash"))
    traces = [
        {
            "name": name,
            "x": times,
            "y": [round(float(value), 3) for value in values],
            "mode": "lines",
            "line": {"color": colour, "width": 2, "dash": dash},
        }
        for name, values, colour, dash in pairs
    ]
    line = {"type": "line", "yref": "paper", "y0": 0, "y1": 1, "line": {"dash": "dot", "width": 1}}
    shapes = [{**line, "x0": one.time, "x1": one.time} for one in due if one.start is not None]
    axes = {"xaxis": {"title": {"text": "time (UTC)"}}, "yaxis": {"title": {"text": "Hs [m]"}, "rangemode": "tozero"}}
    return Figure(
        "Forecast and what the lift allows",
        "Dotted: a phase begins.",
        traces,
        {**axes, "shapes": shapes},
        is_over_time=False,
        height=320,
    )
