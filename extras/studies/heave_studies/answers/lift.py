"""What the limits of a lift say: phase by phase, held against a forecast, and against the bag of the lift."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.verdict import FAILED
from heave_bags.mcap.read.folder import bag_of
from heave_bags.report.figure import LIMIT, OTHER, RUN_COLOURS, UNCOMPENSATED, UNIT, Figure
from heave_bags.report.parts import table
from heave_bags.report.report import place_figure, unbroken
from heave_bringup.output import Part, make_table, warn
from heave_bringup.run.records import read_records

from heave_studies.answers.answer import Ask, Found, as_path
from heave_studies.lift.as_built import as_built
from heave_studies.lift.forecast import allowed, read_forecast, warnings, windows
from heave_studies.lift.limits import planned_curve
from heave_studies.lift.plan import Plan
from heave_studies.lift.study import (
    LiftStudy,
    Table,
    judged_rows,
    limit_table,
    limits_in,
    phase_table,
    planned_state,
    summary,
    weather_table,
)
from heave_studies.operability.figures import HEIGHT_AXIS, PERIOD_AXIS, curve_traces
from heave_studies.operability.seas import HS

FOOTER = (
    "Limits hold while the unit hangs: locked by stochastic linearisation along the way, compensated by a run of the "
    "whole loop, at the surface by runs of the plant. The largest value is that expected in the duration of the phase."
)
KEYS: Mapping[str, object] = MappingProxyType({"forecast": None, "bag": None})
"""Files: the seas to come, with the columns time, hs, tp; the bag of the lift, to be judged phase by phase."""
GUIDE = "docs/guide/howto/plan_a_lift.md"
"""Where the figures of the validation are."""


def prepare(plan: Plan, ask: Ask) -> LiftStudy:
    """Return what is known of a lift before its limits: its `plan`, and forecast and bag by what is asked (`ask`)."""
    forecast, bag = as_path(ask["forecast"]), as_path(ask["bag"])
    seas = None if forecast is None else read_forecast(forecast)
    built = [] if bag is None else as_built(plan, _record(bag))
    if seas is not None:
        warn(warnings(plan, seas))
    warn([f"lift is experimental: one compensated limit is validated ({GUIDE})"])
    height, period = plan.sea
    return LiftStudy(plan, height, period, {}, seas, (), built)


def _record(bag: Path) -> RunRecord:
    (record,) = read_records([bag_of(bag)])
    warn(record.remarks())
    return record


def answer(known: LiftStudy, frame: pandas.DataFrame) -> Found:
    """Return the answer that the limits of a lift give.

    Parameters
    ----------
    known : of the lift, as `prepare` gives it
    frame : its table
    """
    limits = limits_in(frame)
    due = windows(known.plan, limits, known.forecast) if known.forecast is not None else []
    study = replace(known, limits=limits, windows=due)
    drawn: list[Figure] = []
    is_bad = bool(study.failures) or any(planned_state(study, phase) == FAILED for phase in study.plan.phases)
    items = "".join(f"<li>{html.escape(unbroken(words))}</li>" for words in summary(study))
    body = [
        f'<p class="lead">One lift, {"plan to as built" if study.built else "as planned"}</p>',
        f'<div class="verdict {"bad" if is_bad else "good"}"><ul>{items}</ul></div>',
        f"<h2>Phases at Hs {study.height:g} m, Tp {study.period:g} s</h2>",
        _html(phase_table(study), texts=4),
        "<h2>Criteria</h2>",
        _html(judged_rows(study), texts=4),
        "<h2>Largest Hs of each phase, and what ends it</h2>",
        _html(limit_table(study), texts=4),
        place_figure(_limit_figure(study), drawn),
    ]
    if study.forecast is not None:
        body += [
            "<h2>Forecast</h2>",
            _html(weather_table(study), texts=2),
            place_figure(_forecast_figure(study), drawn),
        ]
    texts = ("way", "criterion", "planned", "as built", "start (UTC)", "Hs m, compensated", "Hs m, winch locked")
    tables = [limit_table, phase_table, *([weather_table] if study.windows else []), judged_rows]
    parts: list[Part] = [
        study.plan.title,
        *(make_table(*of(study), texts=texts) for of in tables),
        "\n".join(summary(study)),
    ]
    return Found(parts, study.to_json(), body, drawn, FOOTER, study.failures, len(frame))


def _html(content: Table, *, texts: int) -> str:
    head, rows = content
    return table(head, [[unbroken(cell) for cell in row] for row in rows], texts=texts)


def _limit_figure(study: LiftStudy) -> Figure:
    """Return the limits of every phase, as it is planned."""
    colours = (*RUN_COLOURS, UNCOMPENSATED, OTHER)
    traces: list[dict[str, Any]] = []
    for number, phase in enumerate(study.plan.phases):
        curve = planned_curve(phase, study.limits[phase.name])
        traces += curve_traces(phase.name, curve, colours[number % len(colours)])
    traces.append(
        {
            "name": "plan",
            "x": [study.period],
            "y": [study.height],
            "mode": "markers",
            "marker": {"symbol": "x", "size": 11, "color": LIMIT},
            "hovertemplate": "plan: Tp %{x} s, Hs %{y} m<extra></extra>",
        }
    )
    return Figure(
        "Largest sea of each phase",
        "As planned, compensated or locked. The cross is the sea of the plan. An open triangle: nothing ends "
        "the limit up to this height.",
        traces,
        {"xaxis": PERIOD_AXIS, "yaxis": HEIGHT_AXIS, "hovermode": "closest"},
        is_over_time=False,
    )


def _forecast_figure(study: LiftStudy) -> Figure:
    """Return the forecast, what the lift allows at its periods, and when the phases take place."""
    assert study.forecast is not None
    states = study.forecast.states
    times = [f"{time:%Y-%m-%d %H:%M}" for time in pandas.DatetimeIndex(states.index)]
    curves = [allowed(study.plan, one, study.limits[one.name], study.forecast) for one in study.plan.phases]
    least = np.min(curves, axis=0)
    traces = [
        {
            "name": name,
            "x": times,
            "y": [round(float(value), 3) for value in values],
            "mode": "lines",
            "line": {"color": colour, "width": 2, "dash": dash},
        }
        for name, values, colour, dash in (
            ("forecast", states[HS], UNIT, "solid"),
            ("allowed, strictest phase", least, LIMIT, "dash"),
        )
    ]
    shapes = [
        {
            "type": "line",
            "x0": f"{one.start:%Y-%m-%d %H:%M}",
            "x1": f"{one.start:%Y-%m-%d %H:%M}",
            "yref": "paper",
            "y0": 0,
            "y1": 1,
            "line": {"dash": "dot", "width": 1},
        }
        for one in study.windows
        if one.start is not None
    ]
    return Figure(
        "Forecast and what the lift allows",
        "Dotted: a phase begins.",
        traces,
        {"xaxis": {"title": {"text": "time (UTC)"}}, "yaxis": {"title": {"text": "Hs [m]"}, "rangemode": "tozero"},
         "shapes": shapes},
        is_over_time=False,
        height=320,
    )  # fmt: skip
