"""Whether the promise "never worse than off" holds over its draws, by law; what each part of the controller saves."""

from __future__ import annotations

import html
from collections.abc import Mapping
from types import MappingProxyType

import pandas
from heave_bags.report.parts import table
from heave_bringup.output import Part, make_table
from heave_node.parameters import ParameterError

from heave_studies.answers.answer import Ask, Found, as_path
from heave_studies.promise.figures import PROMISED, ablation_rows, broken, changes, figure_rows, figures_of
from heave_studies.promise.study import Promise
from heave_studies.study.case_file import CASE, read_cases
from heave_studies.study.workers import FAILURE

KEYS: Mapping[str, object] = MappingProxyType({"seed": None, "only": None, "without": None, "against": None})
"""Seed of the draws (none: of the day), numbers of single draws, parts that are switched off one at a time (or all),
and a table of the same draws to compare with.
"""
FOOTER = (
    "Each draw is 390 s. The worst minute begins 30 s after compensation did. 30 s after a fault begins or ends, and a "
    "requested stop, are not judged. A draw that was never judged left the load as it was."
)
SHOWN = 8
"""Worst draws, and draws that changed most, that are listed."""


def answer(kind: Promise, ask: Ask, frame: pandas.DataFrame) -> Found:
    """Return the answer that the table of the draws gives.

    Parameters
    ----------
    kind : of the study
    ask : every one of KEYS
    frame : its table
    """
    whole = frame[frame["without"] == ""]
    found = {"all": figures_of(whole), **{str(law): figures_of(part) for law, part in whole.groupby("law")}}
    breaches = broken(kind.kind, found["all"])
    worst = whole.dropna(subset="worst").sort_values("worst", ascending=False).head(SHOWN)
    rows = [[str(row[CASE]), f"{row['worst']:.3f}", row["words"]] for row in worst.to_dict("records")]
    tables = [(f"Seed {kind.seed}", *figure_rows(found)), ("Worst draws", ["case", "worst minute", "draw"], rows)]
    waiting = whole[(whole["worst"].isna()) & (whole[FAILURE] == "")].to_dict("records")
    tables += [("Never judged", ["case", "why", "draw"], [[str(r[CASE]), r["reason"], r["words"]] for r in waiting])]
    failed = whole[whole[FAILURE] != ""].to_dict("records")
    tables += [("Not run", ["case", "why", "draw"], [[str(r[CASE]), r[FAILURE], r["words"]] for r in failed])]
    if kind.without:
        tables.append(("What each part saves", *ablation_rows(frame)))
    if (path := as_path(ask["against"])) is not None:
        tables.append((f"Against {path}", ["draw", "before", "now"], _against(path, whole)))
    verdict = f"verdict: {'FAILED' if breaches else 'passed'}: {'; '.join(breaches) or 'the promise is kept'}"
    shown = [one for one in tables if one[2]]
    body = [f"<h2>Promised</h2>{table(['worst minute, at most', 'share of the draws [%]'], _promised(kind), texts=0)}"]
    body += [
        f"<h2>{html.escape(title)}</h2>{table(head, cells, texts=1, last_is_text=True)}" for title, head, cells in shown
    ]
    parts: list[Part] = []
    for title, head, cells in shown:
        parts += [title, make_table(head, cells, texts=("draw", "why"))]
    data = {"kind": kind.kind, "seed": kind.seed, "figures": found, "broken": breaches}
    return Found([*parts, verdict], data, body, (), FOOTER, breaches, int(found["all"]["judged"]))


def _promised(kind: Promise) -> list[list[str]]:
    promised = PROMISED.get(kind.kind, PROMISED[""])
    return [[f"{limit:g} times winch locked", f"{100 * share:g}"] for limit, share in promised.items()]


def _against(path: str | object, whole: pandas.DataFrame) -> list[list[str]]:
    """Return the draws that changed most since the table at a `path`."""
    before, _ = read_cases(path)  # type: ignore[arg-type]
    if "worst" not in before or set(before["seed"]) != set(whole["seed"]) or set(before["kind"]) != set(whole["kind"]):
        raise ParameterError(f"ask: against: {path}: is of other draws")
    pairs = changes(before[before["without"] == ""], whole).head(SHOWN)
    return [[str(index), f"{row['before']:.3f}", f"{row['now']:.3f}"] for index, row in pairs.iterrows()]
