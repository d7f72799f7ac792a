"""The largest sea in which the criteria hold, compensated and with the winch locked."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import pandas
from heave_bags.report.figure import UNCOMPENSATED, UNIT, Figure
from heave_bringup.output import Part
from heave_bringup.run.criteria import BASELINE_LAW, LAW
from heave_node.parameters import ParameterError

from heave_studies.answers.answer import Ask, Found, Section, check_seas, criteria_of, criteria_section, number_in
from heave_studies.operability.limits import HEIGHT, Bisection, interval, limit_words, title_of, too_few_seeds
from heave_studies.operability.seas import Situation, study_situations
from heave_studies.study.plan import Study, unlinked
from heave_studies.study.workers import FAILURE

PERIOD_AXIS = {"title": {"text": "peak period Tp [s]"}}
HEIGHT_AXIS = {"title": {"text": "significant wave height Hs [m]"}, "rangemode": "tozero"}


def limit_figure(situation: Situation) -> Figure:
    """Return the limit curves of a `situation`, compensated beside locked."""
    traces: list[dict[str, Any]] = []
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


KEYS: Mapping[str, object] = MappingProxyType({"within": None})
"""Width within which bisection is to enclose each limit [m]; none: the grid alone."""

ENDED = "compensated: ended by"
"""Heading of what ends the limit with compensation."""

FOOTER = """The limit of each seed is where a figure of merit, linear between the heights that were run, reaches its
bound, and below the smallest height linear from a calm sea on."""


def prepare(study: Study, ask: Ask, /) -> Study:
    """See `heave_studies.answers.answer.Answer`."""
    check_seas(study)
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


def answer(study: Study, frame: pandas.DataFrame, _: Ask, /) -> Found:
    """See `heave_studies.answers.answer.Answer`."""
    criteria = criteria_of(study)
    found = study_situations(frame, criteria)
    few = too_few_seeds([one.limit for one in found])
    sections: list[Section | Part] = [Section(notices=[few] if few else [])]
    sections += [Section(one.name or "Limits", *limit_rows(one), texts=2, figures=[limit_figure(one)]) for one in found]
    sections.append(criteria_section(criteria))
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
