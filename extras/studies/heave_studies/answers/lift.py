"""The largest sea of each phase of a lift, held against a forecast.

A phase needs the sea within `alpha` times its limit from when it begins as planned to when it ends with all contingency
time used up, its own and that of the phases before it in the same window (T_R = T_POP + T_C; the operational criterion
is alpha times the design criterion: DNV-ST-N001, Marine operations and marine warranty, section on weather-restricted
operations, whose tables of alpha are the user's to apply). Phases follow one another at once; only before one that
`may_wait` is the unit left where it is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import pandas
from heave_bags.report.figure import LIMIT, UNIT, Figure
from heave_bringup.output import warn
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from heave_node.sheet import Column, Sheet

from heave_studies.answers import limits
from heave_studies.answers.answer import Ask, Found, Section, as_path, criteria_of, number_in
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


KEYS: Mapping[str, object] = MappingProxyType({"within": None, "alpha": 1.0, "contingency": 0.0, "forecast": None})
"""Width within which bisection is to enclose each limit [m], share of a limit up to which a forecast may go,
contingency time over the planned one; a file of the seas to come (time, hs, tp).
"""
FOOTER = (
    "The limit of a phase is the least of those at its depths, each from runs of the whole loop, as far as it hangs."
)


def alpha_of(ask: Ask) -> float:
    """Return the share of a limit up to which a forecast may go, as `ask` has it; raise ParameterError for none."""
    alpha = number_in(ask, "alpha")
    if not 0.0 < alpha <= 1.0:
        raise ParameterError(f"ask: alpha = {alpha:g}: must be above 0, and at most 1")
    return alpha


def prepare(study: Study, ask: Ask, /) -> Study:
    """See `heave_studies.answers.answer.Answer`."""
    if not study.phases:
        raise ParameterError(f"{study.path}: phases is missing: the phases of the lift")
    if others := [place for link in study.vary for place in link if place not in (HEIGHT, PERIOD)]:
        raise ParameterError(f"{study.path}: vary: {others[0]}: a lift varies its seas alone; set it in a phase")
    if not 0.0 <= number_in(ask, "contingency") < math.inf:
        raise ParameterError(f"ask: contingency = {ask['contingency']}: must be a number of at least 0")
    prepared = limits.prepare(study, ask)
    criteria = criteria_of(study)
    for phase in study.phases:
        unknown = [one.kpi for one in criteria[phase.name] if one.kpi not in UNCOMPENSATED]
        if unknown and not phase.does.compensated:
            raise ParameterError(
                f"{study.path}: {phase.name}: {unknown[0]} is not known with the winch locked; known: "
                f"{', '.join(UNCOMPENSATED)}; or give the phase compensated: true"
            )
    alpha_of(ask)
    _forecast(ask)
    return prepared


def _forecast(ask: Ask) -> SeaRecord | None:
    path = as_path(ask["forecast"])
    return None if path is None else read_record(path)


def answer(study: Study, frame: pandas.DataFrame, ask: Ask, /) -> Found:
    """See `heave_studies.answers.answer.Answer`."""
    found = limits.answer(study, frame, ask)
    sections, data, failures = list(found.sections), dict(found.data), []
    forecast = _forecast(ask)
    if forecast is not None:
        situations = {one.name: one for one in study_situations(frame, criteria_of(study))}
        curves = {
            phase.name: situations[phase.name].limit if phase.does.compensated else situations[phase.name].locked_limit
            for phase in study.phases
        }
        warn(warnings(forecast, next(iter(curves.values()))))
        alpha = alpha_of(ask)
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
