"""The largest sea in which the criteria hold, compensated and with the winch locked, and the waiting time for it."""

from __future__ import annotations

import math
from calendar import month_abbr
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas
from heave_bags.report.figure import UNCOMPENSATED, UNIT, Figure
from heave_bags.report.parts import table
from heave_bringup.output import Part
from heave_bringup.run.criteria import BASELINE_LAW, LAW
from heave_node.parameters import ParameterError
from heave_node.sheet import Column, Sheet

from heave_studies.answers.answer import (
    Ask,
    Found,
    Page,
    Section,
    as_path,
    check_seas,
    criteria_of,
    criteria_section,
    number_in,
)
from heave_studies.operability.limits import (
    HEIGHT,
    Bisection,
    interval,
    limit_words,
    title_of,
    too_few_seeds,
)
from heave_studies.operability.seas import (
    ALL,
    HS,
    TP,
    Exposure,
    Place,
    SeaRecord,
    Situation,
    exposure_json,
    read_record,
    study_situations,
)
from heave_studies.sizing import number
from heave_studies.study.plan import Study, unlinked
from heave_studies.study.workers import FAILURE

PERIOD_AXIS = {"title": {"text": "peak period Tp [s]"}}
HEIGHT_AXIS = {"title": {"text": "significant wave height Hs [m]"}, "rangemode": "tozero"}


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
            "x": [month_abbr[int(month)] for month in exposure.by_month.index],
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


KEYS: Mapping[str, object] = MappingProxyType(
    {"within": None, "record": None, "windows": [6.0, 12.0, 24.0], "alpha": 1.0}
)
"""Width within which bisection is to enclose each limit [m] (none: the grid alone), seas of the site (a file), lengths
of weather windows [h], share of a limit up to which a forecast may go."""

ENDED = "compensated: ended by"
"""Heading of what ends the limit with compensation."""

FOOTER = """The limit of each seed is where a figure of merit, linear between the heights that were run, reaches its
bound. Workable seas below the smallest height are counted with a figure that is linear from a calm sea on. Waiting
times count from every moment of the record to the next start of a window."""


MONTHS = Sheet(
    Column("window [h]", "window_h", form="g"),
    Column("month", "month"),
    *(Column(heading, name, form=number) for heading, name in (("mean [h]", "mean"), ("P10 [h]", "p10"))),
    *(Column(heading, name, form=number) for heading, name in (("P50 [h]", "p50"), ("P90 [h]", "p90"))),
    Column("window at once [%]", "at_once", form=".1f", scale=100.0),
)
"""Waiting times by length of the window and month."""


def prepare(study: Study, ask: Ask, /) -> Study:
    """See `heave_studies.answers.answer.Answer`."""
    check_seas(study)
    _place(ask)
    if ask["within"] is None:
        return study
    if study.refinement is not None:
        raise ParameterError(f"{study.path}: until: a study whose limits are bisected has the seeds that it states")
    within = number_in(ask, "within")
    if not within > 0.0:
        raise ParameterError(f"ask: within = {within:g}: must be a width above 0 [m]")
    if any(HEIGHT in link and len(unlinked(dict.fromkeys(link))) > 1 for link in study.vary):
        raise ParameterError(f"{study.path}: vary: {HEIGHT} must stand alone where its limit is bisected")
    return replace(study, refinement=Bisection(criteria_of(study), within))


def _place(ask: Ask) -> Place | None:
    hours = ask["windows"]
    windows = tuple(float(str(one)) for one in (hours if isinstance(hours, list) else [hours]))
    if not windows or min(windows) <= 0.0:
        raise ParameterError(f"ask: windows = {hours}: must be numbers above 0 [h]")
    record, alpha = as_path(ask["record"]), alpha_of(ask)
    return None if record is None else Place(read_record(record), windows, alpha)


def alpha_of(ask: Ask) -> float:
    """Return the share of a limit up to which a forecast may go, as `ask` has it; raise ParameterError for none."""
    alpha = number_in(ask, "alpha")
    if not 0.0 < alpha <= 1.0:
        raise ParameterError(f"ask: alpha = {alpha:g}: must be above 0, and at most 1")
    return alpha


def answer(study: Study, frame: pandas.DataFrame, ask: Ask, /) -> Found:
    """See `heave_studies.answers.answer.Answer`."""
    place = _place(ask)
    criteria = criteria_of(study)
    found = study_situations(frame, criteria, place)
    few = too_few_seeds([one.limit for one in found])
    sections: list[Section | Page | Part] = [Section(notices=[*([few] if few else []), *_notices(found, place)])]
    for one in found:
        figures = [limit_figure(one, place.record if place else None), month_figure(one)]
        shown = [figure for figure in figures if figure is not None]
        sections += [Section(one.name or "Limits", *limit_rows(one), texts=2, figures=shown), _months(one.exposure)]
    sections += [*_overview(found, place), criteria_section(criteria)]
    sections += [study.refinement.words(frame)] if study.refinement is not None else []
    if LAW not in frame:
        sections.append(f"To add the limits under law {BASELINE_LAW}: --vary {LAW}=mpc,{BASELINE_LAW}")
    data = {
        "criteria": {name: {one.kpi: one.text for one in of} for name, of in criteria.items()},
        "situations": [
            {
                "name": one.name,
                "limit": one.limit.to_dict("records"),
                "uncompensated_limit": one.locked_limit.to_dict("records"),
                "exposure": exposure_json(one.exposure),
                "uncompensated_exposure": exposure_json(one.locked_exposure),
            }
            for one in found
        ],
    }
    judged = int((frame[FAILURE] == "").sum())
    return Found(sections, data, FOOTER, judged=judged)


def limit_rows(situation: Situation) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of the table of limits by period of a `situation`, for page and terminal."""
    head = ["Tp s", ENDED, "Hs m, compensated", "Hs m, winch locked"]
    pairs = zip(situation.limit.to_dict("records"), situation.locked_limit.to_dict("records"), strict=True)
    rows = [
        [f"{row['period']:g}", title_of(row["governs"] or "nothing"), _limit(row), _limit(other)]
        for row, other in pairs
    ]
    return head, rows


def _limit(row: Mapping[Hashable, Any]) -> str:
    """Return a limit, with its confidence interval in brackets where there is one."""
    spread = interval(row)
    return limit_words(row) + (f" ({spread})" if spread != "-" else "")


def waits(exposure: Exposure, place: Place) -> list[str]:
    """Return the waiting times of an `exposure`, P50 / P90 [h], for each window of a `place`; none without an order."""
    if exposure.windows.empty:
        return []
    whole = exposure.windows[exposure.windows["month"] == ALL].set_index("window_h")
    return [f"{number(whole['p50'][hours])} / {number(whole['p90'][hours])}" for hours in place.windows]


def no_windows(record: SeaRecord) -> str:
    """Return why nobody can wait for a window in the seas of a `record` without an order."""
    return (
        f"no waiting times: {record.name} is a scatter diagram, whose seas have no order in time; "
        "a record with the columns time, hs, tp gives them"
    )


def _notices(found: Sequence[Situation], place: Place | None) -> list[str]:
    words = []
    if place is not None:
        name = place.record.name
        words += [f"{name}: {warning}" for warning in place.record.warnings]
        if place.record.has_order and place.record.missing > 0.0:
            words.append(
                f"{name}: nothing was measured in {100 * place.record.missing:.1f} % of the time; that counts as not "
                "workable in windows, and is left out of shares."
            )
        outside = max((one.exposure.outside for one in found if one.exposure), default=0.0)
        if outside > 0.0:
            words.append(
                f"{100 * outside:.1f} % of the seas have a period outside those of the study; the limit of the nearest "
                "one is held there."
            )
    return words


def _overview(found: Sequence[Situation], place: Place | None) -> list[Section]:
    """Return the answer in one table: how much of the place's seas are workable, and how long one waits."""
    if place is None:
        return []
    rows = []
    for situation in found:
        for name, exposure in (("compensated", situation.exposure), ("winch locked", situation.locked_exposure)):
            if exposure is not None:
                cautious = f"{100 * exposure.cautious:.1f}" if math.isfinite(exposure.cautious) else "-"
                shares = [f"{100 * exposure.share:.1f}", cautious]
                rows.append([situation.name or "all", name, *shares, *waits(exposure, place)])
    head = ["situation", "winch", "workable seas [%]", "at the lower confidence [%]"]
    head += [f"wait for {hours:g} h, P50 / P90 [h]" for hours in place.windows if place.record.has_order]
    ordered = f"windows in seas up to {100 * place.alpha:g} % of a limit"
    words = ordered if place.record.has_order else no_windows(place.record)
    return [Section(f"Workable seas of {place.record.name}", head, rows, texts=2, words=[words])]


def _months(exposure: Exposure | None) -> Page:
    """Return the waiting times of an `exposure` by month, folded up; nothing without an order of the seas."""
    if exposure is None or exposure.windows.empty:
        return Page("")
    cells = table(MONTHS.headings, MONTHS.cells(exposure.windows.itertuples()), texts=2)
    return Page(f"<details><summary>Waiting times by month, compensated</summary>{cells}</details>")
