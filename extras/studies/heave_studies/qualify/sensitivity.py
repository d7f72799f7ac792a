"""The chapter of sensitivity: the shipped study of robustness, and which of its parameters matter."""

from __future__ import annotations

from pathlib import Path

from heave_bags.report.parts import table

from heave_studies.kinds import Options, open_study
from heave_studies.study.engine import run_study
from heave_studies.study.summary import influence_rows, influences, summary_rows

STUDY, KPI, DRAWS = "robustness", "unit_sigma_m", 64


def what_matters(folder: Path, processes: int) -> str:
    """Run the study in a `folder`, with so many `processes`, or go on with it; return the chapter as HTML."""
    opened = open_study(Options(STUDY, draws=DRAWS, folder=folder))
    frame, _ = run_study(opened.kind, folder, processes=processes)
    words = f"<p>Study <code>{STUDY}</code>, {len(frame)} cases: winch, sensors and sea drawn at random.</p>"
    head, rows = influence_rows(influences(frame, KPI), KPI)
    return words + table(head, rows, texts=1, last_is_text=True) + table(*summary_rows(frame), texts=1)
