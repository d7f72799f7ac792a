"""The figures of an operability study, as plain data for the report's script."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.report.figure import LIMIT, OTHER, UNCOMPENSATED, UNIT, Figure
from heave_node.criteria import Criterion
from heave_node.numerics.arrays import Array

from heave_studies.campaign.table import FAILURE, LOST
from heave_studies.operability.limits import LOST_LIMIT, figure, limit_words, title_of, utilisation
from heave_studies.operability.record import HS, TP, SeaRecord
from heave_studies.operability.seas import HEIGHT, PERIOD
from heave_studies.operability.study import Situation
from heave_studies.operability.windows import ALL

PERIOD_AXIS = {"title": {"text": "peak period Tp [s]"}}
HEIGHT_AXIS = {"title": {"text": "significant wave height Hs [m]"}, "rangemode": "tozero"}
MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
GOVERNING_COLOURS = ("#e69f00", "#0072b2", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442", "#7f7f7f", "#8c564b")
DIGITS = ("#ffffff", "#000000")
"""Colours of the figures on a map."""
SCALE = ((0.0, "#009e73"), (0.4, "#d5e8a8"), (0.5, "#f7e29c"), (0.6, "#f0a860"), (1.0, "#d55e00"))


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
        ("uncompensated", situation.locked_limit, UNCOMPENSATED),
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


def governing_figure(situation: Situation, criteria: Sequence[Criterion]) -> Figure:
    """Return the map of what limits: of each sea the criterion that its worst seed uses most, beyond its bound.

    Parameters
    ----------
    situation : of a study
    criteria : that are to hold
    """
    cases = situation.cases
    names = [*(criterion.kpi for criterion in criteria), LOST_LIMIT]
    used = np.column_stack(
        [*(_used(cases, criterion) for criterion in criteria), np.where(_is_gone(cases), np.inf, 0.0)]
    )
    rows = pandas.DataFrame({"governs": used.argmax(axis=1), "used": used.max(axis=1)}, index=cases.index)
    rows[[HEIGHT, PERIOD]] = cases[[HEIGHT, PERIOD]]
    worst = rows.sort_values("used").groupby([HEIGHT, PERIOD]).tail(1)
    traces = []
    for number, name in enumerate(names):
        part = worst[(worst["governs"] == number) & (worst["used"] > 1.0)]
        if not part.empty:
            traces.append(_squares(part, title_of(name), GOVERNING_COLOURS[number % len(GOVERNING_COLOURS)]))
    within = worst[worst["used"] <= 1.0]
    if not within.empty:
        traces.insert(0, _squares(within, "within all criteria", UNIT))
    return Figure(
        "What limits where",
        "Of each sea the criterion that its worst seed misses most.",
        traces,
        {"xaxis": PERIOD_AXIS, "yaxis": HEIGHT_AXIS, "hovermode": "closest"},
        is_over_time=False,
        height=400,
    )


def _used(cases: pandas.DataFrame, criterion: Criterion) -> Array:
    found = utilisation(cases, criterion)
    return np.zeros(len(cases)) if found is None else np.nan_to_num(found, nan=0.0)


def _is_gone(cases: pandas.DataFrame) -> Array:
    return np.asarray(cases[LOST].to_numpy(dtype=bool) | (cases[FAILURE] != "").to_numpy())


def _squares(part: pandas.DataFrame, name: str, colour: str) -> dict[str, Any]:
    return {
        "name": name,
        "x": part[PERIOD].tolist(),
        "y": part[HEIGHT].tolist(),
        "mode": "markers",
        "marker": {"symbol": "square", "size": 26, "color": colour, "line": {"width": 1, "color": "#ffffff"}},
        "hovertemplate": "Tp %{x} s, Hs %{y} m<extra>" + name + "</extra>",
    }


def map_figure(situation: Situation, criterion: Criterion, *, locked: bool) -> Figure | None:
    """Return a figure of merit over height and period, its mean over the seeds; None where it is not known.

    Parameters
    ----------
    situation : of a study
    criterion : whose bound is the middle of the colours
    locked : of the uncompensated unit
    """
    cases = situation.cases
    values = figure(cases, criterion.kpi, locked=locked)
    used = utilisation(cases, criterion, locked=locked)
    if values is None or used is None or not np.isfinite(values).any():
        return None
    definition = DEFINITION_OF[criterion.kpi]
    table = cases[[HEIGHT, PERIOD]].assign(value=values * definition.scale, used=used)
    shown = table.pivot_table(index=HEIGHT, columns=PERIOD, values="value", aggfunc="mean")
    colour = table.pivot_table(index=HEIGHT, columns=PERIOD, values="used", aggfunc="mean").reindex_like(shown)
    unit = f" [{definition.unit}]" if definition.unit else ""
    heading = "uncompensated" if locked else "compensated"
    shade = np.clip(colour.to_numpy(), 0.0, 2.0)
    texts = [[definition.text(value / definition.scale) for value in row] for row in shown.to_numpy()]
    return Figure(
        f"{definition.title}, {heading}",
        f"Mean over the seeds{unit}; the bound, {definition.text(criterion.bound)}, is the middle of the colours. "
        "Green is within the bound, orange beyond it.",
        [
            {
                "type": "heatmap",
                "x": [f"{period:g}" for period in shown.columns],
                "y": [f"{height:g}" for height in shown.index],
                "z": shade.tolist(),
                "text": texts,
                "hovertemplate": "Tp %{x} s, Hs %{y} m: %{text}<extra></extra>",
                "zmin": 0.0,
                "zmax": 2.0,
                "colorscale": [list(stop) for stop in SCALE],
                "showscale": False,
                "xgap": 2,
                "ygap": 2,
            },
            {
                "mode": "text",
                "x": [f"{period:g}" for _ in shown.index for period in shown.columns],
                "y": [f"{height:g}" for height in shown.index for _ in shown.columns],
                "text": [text for row in texts for text in row],
                "textfont": {"color": [_digits_on(0.5 * value) for row in shade.tolist() for value in row]},
                "hoverinfo": "skip",
                "showlegend": False,
            },
        ],
        {
            "xaxis": {**PERIOD_AXIS, "type": "category"},
            "yaxis": {"title": {"text": "Hs [m]"}, "type": "category"},
            "hovermode": "closest",
        },
        is_over_time=False,
        height=300,
    )


def _digits_on(share: float) -> str:
    """Return the colour of digits with the larger contrast to the colour at a `share` of SCALE, 0 to 1."""
    places = [place for place, _ in SCALE]
    channels = np.array([_channels(colour) for _, colour in SCALE])
    mixed = np.array([np.interp(share, places, channel) for channel in channels.T])
    return max(DIGITS, key=lambda digits: contrast(mixed, _channels(digits)))


def _channels(colour: str) -> Array:
    """Return red, green, blue of a `colour` as #rrggbb, 0 to 1."""
    return np.array([int(colour[first : first + 2], 16) / 255.0 for first in (1, 3, 5)])


def contrast(one: Array, other: Array) -> float:
    """Return the contrast of two colours, 1 to 21, as WCAG 2 defines it.

    Parameters
    ----------
    one, other : red, green, blue in sRGB, 0 to 1
    """
    luminances = []
    for colour in (one, other):
        linear = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
        luminances.append(float(np.array([0.2126, 0.7152, 0.0722]) @ linear))
    return (max(luminances) + 0.05) / (min(luminances) + 0.05)


def month_figure(situation: Situation) -> Figure | None:
    """Return the workable share by month, compensated beside locked, of a `situation`; None without a record."""
    pairs = (
        ("uncompensated", situation.locked_exposure, UNCOMPENSATED),
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


def window_figure(situation: Situation, hours: float) -> Figure | None:
    """Return the waiting time for a window of so many `hours` by month, of a `situation`; None without a record."""
    exposure = situation.exposure
    if exposure is None or exposure.windows.empty:
        return None
    table = exposure.windows[(exposure.windows["window_h"] == hours) & (exposure.windows["month"] != ALL)]
    months = [MONTHS[int(month) - 1] for month in table["month"]]
    styles = (("p50", "median", UNIT), ("p90", "90th percentile", LIMIT), ("mean", "mean", OTHER))
    traces = [
        {
            "name": title,
            "x": months,
            "y": table[column].round(2).tolist(),
            "mode": "lines+markers",
            "line": {"color": colour, "width": 2},
        }
        for column, title, colour in styles
    ]
    return Figure(
        f"Waiting for a window of {hours:g} h",
        "From a moment of the month to the start of the next window, compensated.",
        traces,
        {"yaxis": {"title": {"text": "waiting time [h]"}, "rangemode": "tozero"}, "xaxis": {"type": "category"}},
        is_over_time=False,
        height=320,
    )
