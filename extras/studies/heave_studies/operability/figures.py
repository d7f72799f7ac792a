"""The figures of limits, as plain data for the report's script."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import pandas
from heave_bags.report.figure import UNCOMPENSATED, UNIT, Figure

from heave_studies.operability.limits import limit_words, title_of
from heave_studies.operability.seas import HS, TP, SeaRecord, Situation

PERIOD_AXIS = {"title": {"text": "peak period Tp [s]"}}
HEIGHT_AXIS = {"title": {"text": "significant wave height Hs [m]"}, "rangemode": "tozero"}
MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


def limit_figure(situation: Situation, record: SeaRecord | None) -> Figure:
    """Return the limit curves, compensated beside locked, over the seas of a place.

    Parameters
    ----------
    situation : of a study
    record : seas of the place; None: none
    """
    traces: list[dict[str, Any]] = []
    if record is not None:
        traces.append(_cloud(record))
    for name, curve, colour in (
        ("winch locked", situation.locked_limit, UNCOMPENSATED),
        ("compensated", situation.limit, UNIT),
    ):
        traces += curve_traces(name, curve, colour)
    return Figure(
        "Largest workable sea",
        "Mean over the seeds, with the confidence interval of the mean (90 %). An open triangle: the limit lies above "
        "(pointing up) or below (pointing down) this height; the study ran no sea there.",
        traces,
        {"xaxis": PERIOD_AXIS, "yaxis": HEIGHT_AXIS, "hovermode": "closest"},
        is_over_time=False,
        height=430,
    )


def _cloud(record: SeaRecord) -> dict[str, Any]:
    states = record.states.dropna(subset=[HS])
    sizes = 3 if record.has_order else (4.0 + 40.0 * np.sqrt(states["share"].to_numpy())).tolist()
    return {
        "name": f"seas of {record.name}",
        "x": states[TP].round(2).tolist(),
        "y": states[HS].round(2).tolist(),
        "mode": "markers",
        "marker": {"size": sizes, "color": "#8fb7d3", "opacity": 0.35},
        "hoverinfo": "skip",
    }


def curve_traces(name: str, curve: pandas.DataFrame, colour: str) -> list[dict[str, Any]]:
    """Return a limit curve as a line, with the band of its confidence.

    Parameters
    ----------
    name : in the legend
    curve : as `limit_curve` gives it
    colour : of both
    """
    band = curve[~curve["is_below"]].dropna(subset=["lower"])
    traces = []
    if not band.empty:
        traces.append(
            {
                "x": [*band["period"], *band["period"][::-1]],
                "y": [*band["upper"], *band["lower"][::-1]],
                "fill": "toself",
                "fillcolor": colour,
                "opacity": 0.18,
                "line": {"width": 0},
                "mode": "lines",
                "hoverinfo": "skip",
                "showlegend": False,
            }
        )
    rows = curve.to_dict("records")
    symbols = [_symbol(row) for row in rows]
    return [
        *traces,
        {
            "name": name,
            "x": curve["period"].tolist(),
            "y": curve["limit"].where(~curve["is_below"], curve["at_most"]).tolist(),
            "text": [f"{limit_words(row)} m, ended by {title_of(row['governs'] or 'nothing')}" for row in rows],
            "hovertemplate": "Tp %{x} s: Hs %{text}<extra></extra>",
            "mode": "lines+markers",
            "line": {"color": colour, "width": 2.5},
            "marker": {"symbol": symbols, "size": 9, "color": colour},
        },
    ]


def _symbol(row: Mapping[Hashable, Any]) -> str:
    """Return the mark of a `row` of a limit curve: open where the limit lies outside the heights that were run."""
    if row["is_below"]:
        return "triangle-down-open"
    return "triangle-up-open" if row["is_open"] else "circle"


def month_figure(situation: Situation) -> Figure | None:
    """Return the workable share by month, compensated beside locked, of a `situation`; None without a record."""
    pairs = (
        ("winch locked", situation.locked_exposure, UNCOMPENSATED),
        ("compensated", situation.exposure, UNIT),
    )
    traces = [
        {
            "type": "bar",
            "name": name,
            "x": [MONTHS[int(month) - 1] for month in exposure.by_month.index],
            "y": (100.0 * exposure.by_month).round(2).tolist(),
            "marker": {"color": colour},
        }
        for name, exposure, colour in pairs
        if exposure is not None and len(exposure.by_month)
    ]
    if not traces:
        return None
    return Figure(
        "Workable seas by month",
        "Share of the measured seas within the mean limit.",
        traces,
        {"yaxis": {"title": {"text": "workable [%]"}, "range": [0, 100]}, "barmode": "group"},
        is_over_time=False,
        height=320,
    )
