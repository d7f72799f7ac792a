"""Parts of the pages of studies: criteria, the cases, where the numbers come from."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.verdict import Judged, required_words
from heave_bags.report.parts import table
from heave_node.criteria import Criterion

from heave_studies.campaign.table import BREACHES, FAILURE, LOST, REASON, SEED
from heave_studies.operability.seas import HEIGHT, PERIOD
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
