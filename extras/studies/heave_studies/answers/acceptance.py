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
from heave_bags.report.report import unbroken
from heave_bringup.output import Part

from heave_studies.accept.measured import RESIDUALS
from heave_studies.accept.study import DETAIL, NOT_DONE, Acceptance
from heave_studies.answers.answer import Found, Page, Section
from heave_studies.study.workers import FAILURE

KEYS: Mapping[str, object] = MappingProxyType({"step": [], "winch": None, "replace": [], "network": False})
"""Steps to be run; the map of a real winch, which WILL MOVE; real parts in runs (NODE=external); whether nodes on other
hosts may join.
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
    residuals = _residuals(steps)
    failures = [f"{one['step']}: {words}" for one in steps for words in one["failures"]]
    passed = sum(one["state"] == PASSED for one in steps)
    verdict = f"verdict: {FAILED if failures else PASSED}: {passed} of {len(steps)} steps passed"
    sections: list[Section | Page | Part] = [
        Section(words=[kind.procedure.description], in_terminal=False),
        Section("Steps", head, rows, texts=5, words=[verdict]),
        *([residuals] if residuals.rows else []),
        *(_step(number, one) for number, one in enumerate(steps, 1)),
        Section("What was tested, and with what", ["", ""], _facts(kind, steps), texts=2, in_terminal=False),
        Page(_signatures(kind.procedure.signatures)),
    ]
    data = {
        "title": kind.procedure.title,
        "passed": not failures,
        "steps": [{key: one[key] for key in one if key not in ("figures", "cells")} for one in steps],
        "facts": kind.facts,
    }
    judged = sum(one["state"] != NOT_DONE for one in steps)
    return Found(sections, data, FOOTER, failures, judged)


def _residuals(steps: Sequence[Mapping[str, Any]]) -> Section:
    """Return the four residuals of the `steps` that have one, side by side: compare like with like."""
    definitions = [DEFINITION_OF[key] for key in RESIDUALS]
    head = ["step", *(f"{one.title} [{one.unit}]" for one in definitions)]
    rows = [
        [one["step"], *(of.text(float(one["residuals"][of.key])) for of in definitions)]
        for one in steps
        if any(math.isfinite(one["residuals"][key]) for key in RESIDUALS[:2])
    ]
    return Section("Residuals", head, rows)


def _step(number: int, one: Mapping[str, Any]) -> Section:
    return Section(
        f"{number}. {one['step']}: {one['state']}",
        ["figure", "required", "reached", "verdict"] if one["cells"] else [],
        one["cells"],
        texts=4,
        words=[words for words in (one["what"], *one["done"]) if words],
        notices=[words for words in (one[FAILURE], *one["notes"]) if words],
        figures=[Figure(**figure) for figure in one["figures"]],
        in_terminal=False,
    )


def _facts(kind: Acceptance, steps: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    files = [[f"record of {one['step']}", f"{one['file']}, SHA-256 {one['sha256']}"] for one in steps if one["file"]]
    return [*([name, words] for name, words in kind.facts.items()), *files]


def _signatures(names: Sequence[str]) -> str:
    if not names:
        return ""
    head = "".join(f"<th>{words}</th>" for words in ("for", "name", "date and place", "signature"))
    rows = "".join(f"<tr><td>{html.escape(name)}</td>{_EMPTY_LINE * 3}</tr>" for name in names)
    return f'<h2>Signatures</h2><table style="width:100%"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
