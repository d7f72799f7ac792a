"""The page of an operability study: one HTML file that opens offline, and prints as a page of an operations manual."""

from __future__ import annotations

import html
import math
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.report import place_figure, render_page
from heave_bags.analyse.report_figures import Figure
from heave_node.criteria import Criterion

from heave_bringup.campaign.table import FAILURE, LOST, MISSED, REASON, SEED
from heave_bringup.operability import figures
from heave_bringup.operability.limits import title_of
from heave_bringup.operability.seas import HEIGHT, PERIOD
from heave_bringup.operability.study import Exposure, Place, Situation
from heave_bringup.operability.windows import ALL
from heave_bringup.tables.case_table import CASE

FOOTER = """SI units. The limit of each seed is where a figure of merit, linear between the heights that were run,
reaches its bound. Waiting times count from every moment of the record to the next start of a window. For a PDF, print
this page."""


@dataclass(frozen=True)
class About:
    """What a page says of its study.

    Attributes
    ----------
    title : of the page
    table : file of the cases; None: they were not kept
    facts : provenance by name
    """

    title: str
    table: Path | None
    facts: Mapping[str, str]


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
        _criteria(criteria),
    ]
    for situation in found:
        body += _section(situation, criteria, place, drawn)
    body.append(_cases(found, about.table))
    body.append(_provenance(about))
    return render_page(about.title, "\n".join(body), drawn, footer=FOOTER)


def _notices(found: Sequence[Situation], place: Place | None) -> Iterable[str]:
    if any(situation.limit["seeds"].min() < 2 for situation in found):
        yield _notice("One seed only: the limits have no confidence interval.")
    if place is None:
        return
    for warning in place.record.warnings:
        yield _notice(f"{place.record.name}: {warning}")
    if place.record.has_order and place.record.missing > 0.0:
        yield _notice(
            f"{place.record.name}: nothing was measured in {100 * place.record.missing:.1f} % of the time; that counts "
            "as not workable in windows, and is left out of shares."
        )
    outside = max((one.exposure.outside for one in found if one.exposure), default=0.0)
    if outside > 0.0:
        yield _notice(
            f"{100 * outside:.1f} % of the seas have a period outside those of the study; the limit of the nearest one "
            "is held there."
        )


def _notice(text: str) -> str:
    return f'<div class="notice">{html.escape(text)}</div>'


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
    caption = f"Seas of {name}; windows {trust}."
    if not any(row[0] for row in rows):  # the sea alone was varied
        head, rows = head[1:], [row[1:] for row in rows]
    texts = 1 + head.index("winch")
    return f'<h2>Answer</h2><p class="caption">{caption}</p>{_table(head, rows, texts=texts)}'


def _shares(exposure: Exposure, place: Place) -> list[str]:
    cells = [f"{100 * exposure.share:.1f}", f"{100 * exposure.cautious:.1f}"]
    if exposure.windows.empty:
        return cells
    for hours in place.windows:
        of_hours = exposure.windows[exposure.windows["window_h"] == hours]
        whole = of_hours[of_hours["month"] == ALL]
        cells.append(f"{_number(whole['p50'].iloc[0])} / {_number(whole['p90'].iloc[0])}")
    return cells


def _criteria(criteria: Sequence[Criterion]) -> str:
    rows = []
    for criterion in criteria:
        definition = DEFINITION_OF[criterion.kpi]
        rows.append(
            [definition.title, f"{criterion.relation} {criterion.bound * definition.scale:g}", definition.unit or "-"]
        )
    return f"<h2>Criteria</h2>{_table(['figure of merit', 'bound', 'unit'], rows, texts=1)}"


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
        _limits(situation),
        *(place_figure(figure, drawn) for figure in parts if figure is not None),
        _spells(situation),
        "<h3>Figures of merit over the seas</h3>",
        *(place_figure(figure, drawn) for figure in maps if figure is not None),
    ]


def _limits(situation: Situation) -> str:
    locked = situation.locked_limit.set_index("period")
    rows = []
    for row in situation.limit.to_dict("records"):
        other = locked.loc[row["period"]].to_dict()
        governs = title_of(str(row["governs"])) if row["governs"] else "-"
        rows.append([f"{row['period']:g}", governs, _limit(row), interval(row), _limit(other), interval(other)])
    head = ["Tp [s]", "ended by", "Hs, compensated [m]", "confidence [m]", "Hs, uncompensated [m]", "confidence [m]"]
    return _table(head, rows, texts=2)


def _limit(row: Mapping[Hashable, object]) -> str:
    return f"{'at least ' if row['is_open'] else ''}{row['limit']:.2f}"


def interval(row: Mapping[Hashable, object]) -> str:
    """Return the confidence interval of a `row` of a limit curve; a dash where the seeds do not show one."""
    lower, upper = float(row["lower"]), float(row["upper"])  # type: ignore[arg-type]
    return f"{lower:.2f} to {upper:.2f}" if math.isfinite(lower) and upper > lower else "-"


def _spells(situation: Situation) -> str:
    exposure = situation.exposure
    if exposure is None or exposure.spells.empty:
        return ""
    head = ["spells", "number", "mean [h]", "P10 [h]", "P50 [h]", "P90 [h]", "longest [h]"]
    rows = [[str(name), *(_number(value) for value in row)] for name, row in exposure.spells.iterrows()]
    return f"<h3>Persistence, compensated</h3>{_table(head, rows, texts=1)}{_monthly(exposure)}"


def _monthly(exposure: Exposure) -> str:
    table = exposure.windows
    head = ["window [h]", "month", "mean [h]", "P10 [h]", "P50 [h]", "P90 [h]", "window at once [%]"]
    rows = [
        [
            f"{row['window_h']:g}",
            str(row["month"]),
            *(_number(row[column]) for column in ("mean", "p10", "p50", "p90")),
            f"{100 * row['at_once']:.1f}",
        ]
        for row in table.to_dict("records")
    ]
    return f"<details><summary>Waiting times by month, compensated</summary>{_table(head, rows, texts=2)}</details>"


def _cases(found: Sequence[Situation], table: Path | None) -> str:
    head = ["case", "Tp [s]", "Hs [m]", "seed", "unit [cm]", "off [cm]", "why it is not workable"]
    rows = []
    for situation in found:
        for row in situation.cases.sort_values(CASE).to_dict("records"):
            lost = f"lost: {row[REASON]}" if row[LOST] else ""
            why = f"failed: {row[FAILURE]}" if row[FAILURE] else lost or str(row[MISSED]).replace("MISSED: ", "")
            cells = [
                f"{100 * row['unit_sigma_m']:.2f}",
                f"{100 * row['uncompensated_sigma_m']:.2f}",
                why or "-",
            ]
            rows.append([str(row[CASE]), f"{row[PERIOD]:g}", f"{row[HEIGHT]:g}", str(row[SEED]), *cells])
    how = f"<p>A case is repeated over ROS, with a bag: <code>heave run {html.escape(str(table))}:CASE</code></p>"
    return (
        f"<details><summary>All {len(rows)} cases</summary>{how if table else ''}"
        f"{_table(head, rows, texts=1, last_is_text=True)}</details>"
    )


def _provenance(about: About) -> str:
    rows = [[name, value] for name, value in about.facts.items()]
    return (
        f"<details><summary>Where these numbers come from</summary>{_table(['', ''], rows, texts=2)}</details>"
        if rows
        else ""
    )


def _table(head: Sequence[str], rows: Iterable[Sequence[str]], *, texts: int, last_is_text: bool = False) -> str:
    """Return an HTML table; the first columns, so many as `texts`, hold text, the others numbers."""
    last = len(head) - 1

    def cell(tag: str, number: int, text: str) -> str:
        is_text = number < texts or (last_is_text and number == last)
        kind = "" if is_text else ' class="number"'
        return f"<{tag}{kind}>{html.escape(text)}</{tag}>"

    top = "".join(cell("th", number, text) for number, text in enumerate(head))
    lines = "\n".join(
        f"<tr>{''.join(cell('td', number, text) for number, text in enumerate(row))}</tr>" for row in rows
    )
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead><tbody>{lines}</tbody></table></div>'


def _number(value: object) -> str:
    number = float(value)  # type: ignore[arg-type]
    return f"{number:.1f}".removesuffix(".0") if math.isfinite(number) else "-"


def limit_frame(found: Sequence[Situation]) -> pandas.DataFrame:
    """Return the limits of all situations `found` as one table, for people's programs."""
    parts = [
        curve.assign(situation=situation.name, winch=winch)
        for situation in found
        for winch, curve in (("compensated", situation.limit), ("locked", situation.locked_limit))
    ]
    return pandas.concat(parts, ignore_index=True)
