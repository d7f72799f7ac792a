"""The report of an acceptance test, to be signed."""

from __future__ import annotations

import html
import json
import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.verdict import FAILED, PASSED
from heave_bags.report.figure import Figure
from heave_bags.report.parts import notice, table
from heave_bags.report.report import place_figure, unbroken
from heave_bringup.output import Part, make_table

from heave_studies.accept.measured import RESIDUALS
from heave_studies.accept.study import DETAIL, NOT_DONE, Acceptance
from heave_studies.answers.answer import Found
from heave_studies.study.workers import FAILURE

KEYS: Mapping[str, object] = MappingProxyType(
    {"step": [], "winch": None, "replace": [], "record": None, "map": None, "network": False}
)
"""Steps to be run; the map of a real winch, which WILL MOVE; real parts in runs (NODE=external); a bag or log that is
judged in the place of runs, or one for each step ({STEP: FILE}), and its map; whether nodes on other hosts may join.
"""
FOOTER = (
    "Figures are of the time that is judged. Outlet: what the winch leaves of the boom tip's heave. Residuals are "
    "standard deviations. A figure that is not known is not met."
)
_EMPTY_LINE = '<td style="height:2.6rem;min-width:10rem"></td>'


def answer(kind: Acceptance, frame: pandas.DataFrame) -> Found:
    """Return the answer that the table of an acceptance test gives.

    Parameters
    ----------
    kind : of the test
    frame : its table
    """
    steps = [json.loads(text) for text in frame[DETAIL] if text]
    head = ["step", "verdict", "required", "reached", "against"]
    rows = []
    for row in frame.to_dict("records"):
        required = unbroken(f"{row['figure']}: {row['required']}".strip(": "))
        first = [row["step"], row["state"]] if row[DETAIL] else ["", ""]
        rows.append([*first, required, unbroken(row["reached"]), row["against"] if row[DETAIL] else ""])
    residual_head, residuals = _residuals(steps)
    failures = [f"{one['step']}: {words}" for one in steps for words in one["failures"]]
    drawn: list[Figure] = []
    passed = sum(one["state"] == PASSED for one in steps)
    body = [
        f'<p class="lead">{html.escape(kind.procedure.description)}</p>',
        f"<p><strong>{FAILED if failures else PASSED}</strong>: {passed} of {len(steps)} steps passed</p>",
        f"<h2>Steps</h2>{table(head, rows, texts=5)}",
        f"<h2>Residuals</h2>{table(residual_head, residuals, texts=1)}" if residuals else "",
        *(_step(number, one, drawn) for number, one in enumerate(steps, 1)),
        f"<h2>What was tested, and with what</h2>{table(['', ''], _facts(kind, steps), texts=2)}",
        _signatures(kind.procedure.signatures),
    ]
    parts: list[Part] = [make_table(head, rows, texts=head)]
    parts += [make_table(residual_head, residuals)] if residuals else []
    parts.append(f"verdict: {FAILED if failures else PASSED}")
    data = {
        "title": kind.procedure.title,
        "passed": not failures,
        "steps": [{key: one[key] for key in one if key not in ("figures", "cells")} for one in steps],
        "facts": kind.facts,
    }
    judged = sum(one["state"] != NOT_DONE for one in steps)
    return Found(parts, data, body, drawn, FOOTER, failures, judged)


def _residuals(steps: Sequence[Mapping[str, Any]]) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of the four residuals of the `steps` that have one, side by side: compare like with like."""
    definitions = [DEFINITION_OF[key] for key in RESIDUALS]
    head = ["step", *(f"{one.title} [{one.unit}]" for one in definitions)]
    rows = [
        [one["step"], *(of.text(float(one["residuals"][of.key])) for of in definitions)]
        for one in steps
        if any(math.isfinite(one["residuals"][key]) for key in RESIDUALS[:2])
    ]
    return head, rows


def _step(number: int, one: Mapping[str, Any], drawn: list[Figure]) -> str:
    parts = [f"<h2>{number}. {html.escape(one['step'])}: {html.escape(one['state'])}</h2>"]
    parts += [f'<p class="lead">{html.escape(one["what"])}</p>'] if one["what"] else []
    parts += [f'<p class="caption">{html.escape(words)}</p>' for words in one["done"]]
    parts += [notice(words) for words in (one[FAILURE], *one["notes"]) if words]
    if one["cells"]:
        parts.append(table(["figure", "required", "reached", "verdict"], one["cells"], texts=4))
    parts += [place_figure(Figure(**figure), drawn) for figure in one["figures"]]
    return "\n".join(parts)


def _facts(kind: Acceptance, steps: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    files = [[f"record of {one['step']}", f"{one['file']}, SHA-256 {one['sha256']}"] for one in steps if one["file"]]
    return [*([name, words] for name, words in kind.facts.items()), *files]


def _signatures(names: Sequence[str]) -> str:
    if not names:
        return ""
    head = "".join(f"<th>{words}</th>" for words in ("for", "name", "date and place", "signature"))
    rows = "".join(f"<tr><td>{html.escape(name)}</td>{_EMPTY_LINE * 3}</tr>" for name in names)
    return f'<h2>Signatures</h2><table style="width:100%"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
