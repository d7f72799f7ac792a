"""The page of a study: one HTML file that opens offline and prints, whatever was asked."""

from __future__ import annotations

import html
from collections.abc import Mapping
from pathlib import Path

import pandas
from heave_bags.report.parts import notice, table
from heave_bags.report.report import render_page, unbroken

from heave_studies.answers.answer import Found
from heave_studies.study.cases import screening_words
from heave_studies.study.cost import HEAD, cost_rows
from heave_studies.study.summary import case_table, remarks
from heave_studies.study.table import LOST

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
    answer, figures = found.page()
    body = [*head, *_verdict(found), *note, *answer, _cases(frame, table_file), what, whence]
    return render_page(title, "\n".join(body), figures, footer=f"{found.footer} {FOOTER}".strip())


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
    shown = case_table(frame.head(MOST_CASES))
    line = f"heave study --case {html.escape(str(file))}:CASE"
    how = f"<p>The scenario of a case, for a run over ROS: <code>{line}</code></p>"
    cells = table(shown.columns, shown.rows, texts=2, last_is_text=True)
    lines = "".join(f"<li>{html.escape(unbroken(words))}</li>" for words in remarks(frame))
    return f"<details><summary>{len(shown.rows)} of {len(frame)} cases</summary>{how}{cells}<ul>{lines}</ul></details>"
