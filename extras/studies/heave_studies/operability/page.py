"""The page of an operability study: one HTML file that opens offline, and prints as a page of an operations manual."""

from __future__ import annotations

import html
import math
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.verdict import Judged, required_words
from heave_bags.report.figure import Figure
from heave_bags.report.parts import notice, table
from heave_bags.report.report import place_figure, render_page
from heave_node.criteria import Criterion

from heave_studies.campaign.table import BREACHES, FAILURE, LOST, REASON, SEED
from heave_studies.operability import figures
from heave_studies.operability.limits import interval, limit_words, title_of, too_few_seeds
from heave_studies.operability.record import SeaRecord
from heave_studies.operability.seas import HEIGHT, PERIOD
from heave_studies.operability.study import Exposure, Place, Situation
from heave_studies.operability.windows import ALL
from heave_studies.tables.case_table import CASE


def number(value: object) -> str:
    """Return a `value` with one decimal, none where it is whole; a dash for one that is not known."""
    found = float(value)  # type: ignore[arg-type]
    return f"{found:.1f}".removesuffix(".0") if math.isfinite(found) else "-"


def criteria_table(criteria: Sequence[Criterion]) -> str:
    """Return the `criteria` of a study, under a heading."""
    rows = [[DEFINITION_OF[criterion.kpi].title, required_words(criterion)] for criterion in criteria]
    return f"<h2>Criteria</h2>{table(['figure of merit', 'required'], rows, texts=2)}"


def cases_table(parts: Iterable[pandas.DataFrame], criteria: Sequence[Criterion], file: Path | None) -> str:
    """Return all cases of a study, folded up, with the command that repeats one.

    Parameters
    ----------
    parts : of the campaign's table
    criteria : of the study; those of the scenario alone do not count
    file : in which they are kept; None: they were not
    """
    head = ["case", "Tp [s]", "Hs [m]", "seed", "unit [cm]", "off [cm]", "why it is not workable"]
    rows = []
    for part in parts:
        for row in part.sort_values(CASE).to_dict("records"):
            lost = f"lost: {row[REASON]}" if row[LOST] else ""
            why = f"failed: {row[FAILURE]}" if row[FAILURE] else lost or _missed(row, criteria)
            figures = [f"{100 * row['unit_sigma_m']:.2f}", f"{100 * row['uncompensated_sigma_m']:.2f}", why or "-"]
            rows.append([str(row[CASE]), f"{row[PERIOD]:g}", f"{row[HEIGHT]:g}", str(row[SEED]), *figures])
    line = f"heave campaign --case {html.escape(str(file))}:CASE"
    how = f"<p>The scenario of a case, for a run over ROS: <code>{line}</code></p>"
    cells = table(head, rows, texts=1, last_is_text=True)
    return f"<details><summary>All {len(rows)} cases</summary>{how if file else ''}{cells}</details>"


def _missed(row: Mapping[str, Any], criteria: Sequence[Criterion]) -> str:
    """Return in words what a case misses of the `criteria`, and what no run may do."""
    breaches = str(row.get(BREACHES, ""))
    judged = [Judged(criterion, float(row[criterion.kpi])) for criterion in criteria]
    return "; ".join([*([breaches] if breaches else []), *(str(one) for one in judged if not one.is_met)])


def provenance_table(facts: Mapping[str, str]) -> str:
    """Return where numbers come from, by name in `facts`, folded up; nothing where there are none."""
    if not facts:
        return ""
    rows = table(["", ""], ([name, value] for name, value in facts.items()), texts=2)
    return f"<details><summary>Where these numbers come from</summary>{rows}</details>"


FOOTER = """SI units. The limit of each seed is where a figure of merit, linear between the heights that were run,
reaches its bound. Workable seas below the smallest height are counted with a figure that is linear from a calm sea on.
Waiting times count from every moment of the record to the next start of a window. For a PDF, print this page."""


@dataclass(frozen=True)
class About:
    """Head of the page of a study."""

    title: str  # of the page
    table: Path | None  # file of the cases; None: they were not kept
    facts: Mapping[str, str]  # provenance by name


def render(about: About, found: Sequence[Situation], criteria: Sequence[Criterion], place: Place | None) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    about : what the page says of the study
    found : its situations
    criteria : that are to hold
    place : whose seas they are held against; None: none
    """
    drawn: list[Figure] = []
    body = [
        f"<h1>{html.escape(about.title)}</h1>",
        '<p class="lead">Operability: the seas in which the criteria hold</p>',
        *_notices(found, place),
        _overview(found, place),
        criteria_table(criteria),
    ]
    for situation in found:
        body += _section(situation, criteria, place, drawn)
    body.append(cases_table((situation.cases for situation in found), criteria, about.table))
    body.append(provenance_table(about.facts))
    return render_page(about.title, "\n".join(body), drawn, footer=FOOTER)


def _notices(found: Sequence[Situation], place: Place | None) -> Iterable[str]:
    few = too_few_seeds([situation.limit for situation in found])
    if few:
        yield notice(few)
    if place is None:
        return
    for warning in place.record.warnings:
        yield notice(f"{place.record.name}: {warning}")
    if place.record.has_order and place.record.missing > 0.0:
        yield notice(
            f"{place.record.name}: nothing was measured in {100 * place.record.missing:.1f} % of the time; that counts "
            "as not workable in windows, and is left out of shares."
        )
    outside = max((one.exposure.outside for one in found if one.exposure), default=0.0)
    if outside > 0.0:
        yield notice(
            f"{100 * outside:.1f} % of the seas have a period outside those of the study; the limit of the nearest one "
            "is held there."
        )


def _overview(found: Sequence[Situation], place: Place | None) -> str:
    """Return the answer in one table: how much of the place's seas are workable, and how long one waits."""
    if place is None:
        return ""
    rows = []
    for situation in found:
        for name, exposure in (("compensated", situation.exposure), ("uncompensated", situation.locked_exposure)):
            if exposure is not None:
                rows.append([situation.name, name, *_shares(exposure, place)])
    head = ["situation", "winch", "workable seas [%]", "at the lower confidence [%]"]
    head += [f"wait for {hours:g} h, P50 / P90 [h]" for hours in place.windows if place.record.has_order]
    name = html.escape(place.record.name)
    trust = "with the alpha factors given" if place.alpha is not None else "with a forecast that is trusted"
    windows = f"windows {trust}" if place.record.has_order else html.escape(no_windows(place.record))
    caption = f"Seas of {name}; {windows}."
    if not any(row[0] for row in rows):  # the sea alone was varied
        head, rows = head[1:], [row[1:] for row in rows]
    texts = 1 + head.index("winch")
    return f'<h2>Answer</h2><p class="caption">{caption}</p>{table(head, rows, texts=texts)}'


def no_windows(record: SeaRecord) -> str:
    """Return why nobody can wait for a window in the seas of a `record` without an order."""
    return (
        f"no waiting times: {record.name} is a scatter diagram, whose seas have no order in time; "
        "a record with the columns time, hs, tp gives them"
    )


def _shares(exposure: Exposure, place: Place) -> list[str]:
    cautious = f"{100 * exposure.cautious:.1f}" if math.isfinite(exposure.cautious) else "-"
    return [f"{100 * exposure.share:.1f}", cautious, *waits(exposure, place)]


def waits(exposure: Exposure, place: Place) -> list[str]:
    """Return the waiting times of an `exposure`, P50 / P90 [h], for each window of a `place`; none without an order."""
    cells: list[str] = []
    if exposure.windows.empty:
        return cells
    for hours in place.windows:
        of_hours = exposure.windows[exposure.windows["window_h"] == hours]
        whole = of_hours[of_hours["month"] == ALL]
        cells.append(f"{number(whole['p50'].iloc[0])} / {number(whole['p90'].iloc[0])}")
    return cells


def _section(
    situation: Situation, criteria: Sequence[Criterion], place: Place | None, drawn: list[Figure]
) -> list[str]:
    parts: list[Figure | None] = [
        figures.limit_figure(situation, place.record if place else None),
        figures.governing_figure(situation, criteria),
        figures.month_figure(situation),
        *(figures.window_figure(situation, hours) for hours in (place.windows if place else ())),
    ]
    maps: list[Figure | None] = []
    for criterion in criteria:
        maps += [figures.map_figure(situation, criterion, locked=locked) for locked in (False, True)]
    title = html.escape(situation.name or "Limits")
    return [
        f"<h2>{title}</h2>",
        table(*limit_rows(situation.limit, situation.locked_limit), texts=2),
        *(place_figure(figure, drawn) for figure in parts if figure is not None),
        _spells(situation),
        "<h3>Figures of merit over the seas</h3>",
        *(place_figure(figure, drawn) for figure in maps if figure is not None),
    ]


def limit_rows(limit: pandas.DataFrame, locked: pandas.DataFrame) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of the table of limits by period, for page and terminal.

    Parameters
    ----------
    limit, locked : compensated and with the winch locked, as `limit_curve` gives them, for the same periods
    """
    head = ["Tp s", "ended by", "Hs m, compensated", "Hs m, winch locked"]
    rows = []
    for row, other in zip(limit.to_dict("records"), locked.to_dict("records"), strict=True):
        rows.append([f"{row['period']:g}", title_of(row["governs"] or "nothing"), _limit(row), _limit(other)])
    return head, rows


def _limit(row: Mapping[Hashable, Any]) -> str:
    """Return a limit, with its confidence interval in brackets where there is one."""
    spread = interval(row)
    return limit_words(row) + (f" ({spread})" if spread != "-" else "")


def _spells(situation: Situation) -> str:
    exposure = situation.exposure
    if exposure is None or exposure.spells.empty:
        return ""
    head = ["spells", "number", "mean [h]", "P10 [h]", "P50 [h]", "P90 [h]", "longest [h]"]
    rows = [[str(name), *(number(value) for value in row)] for name, row in exposure.spells.iterrows()]
    return f"<h3>Persistence, compensated</h3>{table(head, rows, texts=1)}{_monthly(exposure)}"


def _monthly(exposure: Exposure) -> str:
    head = ["window [h]", "month", "mean [h]", "P10 [h]", "P50 [h]", "P90 [h]", "window at once [%]"]
    rows = [
        [
            f"{row['window_h']:g}",
            str(row["month"]),
            *(number(row[column]) for column in ("mean", "p10", "p50", "p90")),
            f"{100 * row['at_once']:.1f}",
        ]
        for row in exposure.windows.to_dict("records")
    ]
    return f"<details><summary>Waiting times by month, compensated</summary>{table(head, rows, texts=2)}</details>"


def limit_frame(found: Sequence[Situation]) -> pandas.DataFrame:
    """Return the limits of all situations `found` as one table, for people's programs."""
    parts = [
        curve.assign(situation=situation.name, winch=winch)
        for situation in found
        for winch, curve in (("compensated", situation.limit), ("locked", situation.locked_limit))
    ]
    return pandas.concat(parts, ignore_index=True)
