"""The page of a study: one HTML file that opens offline and prints, whatever was asked."""

from __future__ import annotations

import html
from collections.abc import Mapping
from pathlib import Path

import pandas
from heave_bags.report.parts import notice, table
from heave_bags.report.report import render_page, unbroken
from heave_bringup.nodes import NODES
from heave_node.parameters import describe
from heave_node.system_parameters import SYSTEM, own_name

from heave_studies.answers.answer import Found
from heave_studies.study.case_file import CASE
from heave_studies.study.cases import screening_words
from heave_studies.study.cost import HEAD, cost_rows
from heave_studies.study.table import LOST, MISSED, REASON, SCREENED, SEED, settings_of
from heave_studies.study.workers import FAILURE

FOOTER = "For a PDF, print this page."
MOST_CASES = 2000
"""Cases that the page lists; the table has all."""


def render(
    title: str,
    lead: str,
    lift: Mapping[str, str],
    found: Found,
    frame: pandas.DataFrame,
    table_file: Path,
    about: Mapping[str, str],
) -> str:
    """Return the page of a study as HTML.

    Parameters
    ----------
    title, lead, lift : of the study, what it asks, and what was run, in words by name
    found : its answer
    frame, table_file : its table, and where that is
    about : where the numbers come from, by name
    """
    head = [f"<h1>{html.escape(title)}</h1>", f'<p class="lead">{html.escape(lead)}</p>' if lead else ""]
    head += [table(["lift", ""], ([name, words] for name, words in lift.items()), texts=2)] if lift else []
    facts = table(["", ""], ([name, value] for name, value in about.items()), texts=2)
    whence = f"<details><summary>Where these numbers come from</summary>{facts}</details>"
    cost = cost_rows(table_file.parent)
    what = f"<details><summary>What a case costs</summary>{table(HEAD, cost, texts=1)}</details>" if cost else ""
    screened = screening_words(frame)
    note = [notice(html.escape(screened))] if screened else []
    body = [*head, *_verdict(found), *note, *found.body, _cases(frame, table_file), what, whence]
    return render_page(title, "\n".join(body), list(found.figures), footer=f"{found.footer} {FOOTER}".strip())


def _verdict(found: Found) -> list[str]:
    if not found.judged:
        return [notice("Nothing was judged.")]
    if not found.failures:
        return []
    items = "".join(f"<li>{html.escape(unbroken(words))}</li>" for words in found.failures)
    return [f'<div class="verdict bad"><strong>FAILED</strong><ul>{items}</ul></div>']


def _cases(frame: pandas.DataFrame, file: Path) -> str:
    """Return all cases, folded up, with the command that writes the scenario of one."""
    if LOST not in frame:
        return ""
    places = settings_of(frame)
    named = (
        f"{place.rsplit('.', 1)[-1]} {f'[{unit}]' if (unit := unit_of(place)) else ''}".strip() for place in places
    )
    head = ["case", "seed", *named, "load heave, rms [cm]", "winch locked, rms [cm]", "remark"]
    rows = []
    for row in frame.head(MOST_CASES).to_dict("records"):
        lost = f"lost: {row[REASON]}" if row[LOST] else row[MISSED] or ("screened" if row.get(SCREENED) else "")
        remark = f"failed: {row[FAILURE]}" if row[FAILURE] else lost
        values = [f"{row[one]:.4g}" if isinstance(row[one], float) else str(row[one]) for one in places]
        figures = [f"{100 * row[key]:.2f}" for key in ("unit_sigma_m", "uncompensated_sigma_m")]
        rows.append([str(row[CASE]), str(row[SEED]), *values, *figures, str(remark or "-")])
    line = f"heave study --case {html.escape(str(file))}:CASE"
    how = f"<p>The scenario of a case, for a run over ROS: <code>{line}</code></p>"
    cells = table(head, rows, texts=1, last_is_text=True)
    return f"<details><summary>{len(rows)} of {len(frame)} cases</summary>{how}{cells}</details>"


def unit_of(place: str) -> str:
    """Return the unit of the parameter at a `place`, such as system.sea.peak_period; empty: it has none."""
    target, _, name = place.partition(".")
    for node in NODES:
        own = own_name(node.name, place) if place.startswith(SYSTEM) else name if node.name == target else ""
        for info in describe(node.parameters_type()) if own else ():
            if info.name == own:
                return info.unit
    return ""
