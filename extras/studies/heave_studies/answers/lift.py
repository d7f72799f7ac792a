"""The largest sea of each phase of a lift, held against a forecast, and against the bag of the lift."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.verdict import FAILED, Judged, required_words
from heave_bags.mcap.read.folder import bag_of
from heave_bags.report.figure import LIMIT, UNIT, Figure
from heave_bags.report.parts import table
from heave_bags.report.report import place_figure, unbroken
from heave_bringup.output import make_table, sheet_table, warn
from heave_bringup.run.records import read_records
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from heave_node.sheet import Column, Sheet

from heave_studies.answers import limits
from heave_studies.answers.answer import Ask, Found, as_path, criteria_of, first_scenario, number_in
from heave_studies.lift.as_built import AsBuilt, as_built
from heave_studies.lift.forecast import WINDOWS, Window, allowed_heights, read_forecast, warnings, windows
from heave_studies.operability.limits import HEIGHT, PERIOD, UNCOMPENSATED
from heave_studies.operability.seas import HS, SeaRecord, study_situations
from heave_studies.study.plan import Study

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
    parts, body, drawn = list(found.parts), list(found.body), list(found.figures)
    data, failures = dict(found.data), []
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
        parts += [sheet_table(WINDOWS, due), words]
        body += [f"<h2>Forecast</h2><p>{words}</p>", table(WINDOWS.headings, WINDOWS.cells(due), texts=2)]
        body.append(place_figure(_forecast_figure(forecast, np.min(list(allowed.values()), axis=0), due), drawn))
        data["windows"] = WINDOWS.records(due)
    if built:
        rows = [(one, judged) for one in built for judged in one.judged]
        states = [f"as built, {one.phase.name}: {one.state}" for one in built]
        failures += [words for one in built for words in one.failures]
        parts += [make_table(BUILT.headings, BUILT.cells(rows), texts=BUILT.headings), "\n".join(states)]
        cells = [[unbroken(cell) for cell in row] for row in BUILT.cells(rows)]
        body += ["<h2>As built</h2>", *(f"<p>{words}</p>" for words in states), table(BUILT.headings, cells, texts=3)]
        data["as_built"] = [one.to_json() for one in built]
    return replace(found, parts=parts, body=body, figures=drawn, data=data, failures=failures, footer=FOOTER)


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
