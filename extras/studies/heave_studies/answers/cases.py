"""What every case came to, with a summary and its confidence, what matters among what was drawn, and the worst case."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from types import MappingProxyType

import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bringup.output import Part
from heave_node.parameters import ParameterError

from heave_studies.answers.answer import Ask, Found, Page, Section, criteria_of_cases, criteria_section
from heave_studies.study.case_file import CASE
from heave_studies.study.plan import Study
from heave_studies.study.sampling import SALTELLI
from heave_studies.study.summary import (
    FEWEST_CASES,
    case_table,
    influence_rows,
    influences,
    remarks,
    sobol_indices,
    summary_rows,
    to_json,
)
from heave_studies.study.table import SILENT, SILENT_START
from heave_studies.study.workers import FAILURE

MOTION = "unit_sigma_m"
"""Figure by which a case is the worst of a study that is no search."""
KEYS: Mapping[str, object] = MappingProxyType({"figure": MOTION})
"""Figure of merit that what matters is ranked by."""
FIGURES = (SILENT, *DEFINITION_OF)


def prepare(study: Study, ask: Ask, /) -> Study:
    """See `heave_studies.answers.answer.Answer`."""
    named = [ask["figure"], *([study.search.figure] if study.search else [])]
    for name in named:
        if name not in FIGURES:
            raise ParameterError(f"{study.path}: {name} is not a figure; known: {', '.join(FIGURES)}")
    return study


def answer(study: Study, frame: pandas.DataFrame, ask: Ask, /) -> Found:
    """See `heave_studies.answers.answer.Answer`."""
    figure = study.search.figure if study.search else str(ask["figure"])
    good = frame[frame[FAILURE] == ""]
    judged = int(good[figure].notna().sum()) if study.search else len(good)
    sections: list[Section | Page | Part] = [case_table(frame)]
    sections += ["\n".join(lines)] if (lines := remarks(frame)) else []
    sections += [criteria_section(criteria_of_cases(study))]
    data = to_json(frame)
    if study.draws is not None and not study.search and len(good) >= FEWEST_CASES and figure in DEFINITION_OF:
        what = influences(frame, figure)
        sections.append(Section("What matters", *influence_rows(what, figure), last_is_text=True))
        data["influences"] = {"kpi": figure, "parameters": [asdict(one) for one in what]}
        if study.draws.method == SALTELLI:
            found = sobol_indices(study.draws, frame, figure)
            cells = [[name, f"{first:.2f}", f"{total:.2f}"] for name, (first, total) in found.items()]
            sections.append(Section("", ["share of the variance", "by itself", "with all others"], cells))
            data["sobol"] = found
    worst, failures, number = _worst(study, good, figure if study.search else MOTION)
    more = [study.refinement.words(frame)] if study.refinement is not None else []
    sections += [Section("Summary", *summary_rows(frame), last_is_text=True, words=more), *worst]
    return Found(sections, data, failures=failures, judged=judged, worst=number)


def _worst(study: Study, good: pandas.DataFrame, figure: str) -> tuple[list[str], list[str], int | None]:
    """Return the lines on the worst case, why the verdict of a search is FAILED, and the number of the case."""
    known = good[good[figure].notna()]
    if known.empty:
        return [], [], None
    row = known.loc[known[figure].idxmax()]
    value = float(row[figure])
    when = f" from {row[SILENT_START]:.0f} s on" if figure == SILENT and math.isfinite(row[SILENT_START]) else ""
    title = DEFINITION_OF[figure].title if figure in DEFINITION_OF else "worst minute without an alarm, over locked"
    shown = (
        f"{DEFINITION_OF[figure].text(value)} {DEFINITION_OF[figure].unit}"
        if figure in DEFINITION_OF
        else f"{value:.4g}"
    )
    line = f"worst case: {row[CASE]}, {title} {shown.rstrip()}{when}"
    number = int(row[CASE])
    if study.search is None:
        return [line], [], number
    bound = study.search.at_most
    verdict = "FAILED" if value > bound else "passed"
    lines = [line, f"verdict: {verdict}; {len(known)} of {len(good)} cases that ran were judged (at most {bound:g})"]
    missed = [f"{title} {value:.3f} (at most {bound:g}): case {row[CASE]}"] if value > bound else []
    return ["\n".join(lines)], missed, number
