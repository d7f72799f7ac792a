"""The tables of a lift, for terminal and page: limits by phase and period, and phases as planned and as built."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.verdict import FAILED, PASSED, Judged, required_words
from heave_node.loads.strength import ROPE

from heave_bringup.lift.as_built import AsBuilt
from heave_bringup.lift.limits import Limit
from heave_bringup.lift.plan import LOADS, WATER, Phase
from heave_bringup.lift.study import LiftStudy
from heave_bringup.operability.limits import title_of

TOUCHDOWN = "touchdown_speed_mps"
SHOWN = ("dynamic_amplification", "tension_ratio_min", ROPE, "significant_residual_m", TOUCHDOWN)
"""Figures of the table of phases."""
HEADINGS = ("DAF", "Tmin / Tstatic", "rope factor", "residual cm", "touchdown m/s")

Table = tuple[list[str], list[list[str]]]


def limit_table(study: LiftStudy) -> Table:
    """Return head and rows of the limits of a `study`."""
    head = ["phase", "Tp s", "Hs m, compensated", "Hs m, locked"]
    rows = []
    for phase in study.plan.phases:
        for place, one in enumerate(study.limits[phase.name]):
            cells = [phase.name if place == 0 else "", f"{one.period:g}"]
            rows.append([*cells, _limit(one.compensated), _limit(one.locked)])
    return head, rows


def _limit(limit: Limit | None) -> str:
    if limit is None:
        return "-"
    return f"{limit.words} ({title_of(limit.governs)})" if limit.governs else limit.words


def phase_table(study: LiftStudy) -> Table:
    """Return head and rows of the phases of a `study`: figures in its sea, the weather, and below them the bag."""
    head = ["phase", "winch", "depth m", "min", *HEADINGS, "verdict"]
    head += ["start (UTC)", "wait h", "of allowed %"] if study.windows else []
    built = {one.phase.name: one for one in study.built}
    due = {one.phase: one for one in study.windows}
    rows = []
    for phase in study.plan.phases:
        row = [phase.name, _way(phase), _depths(phase), f"{phase.duration / 60.0:.0f}"]
        row += [*_cells(phase, planned_values(study, phase)), planned_state(study, phase)]
        if study.windows:
            window = due[phase.name]
            start = "none" if window.start is None else f"{window.start:%Y-%m-%d %H:%M}"
            row += [start, _number(window.waiting, 1), _number(100.0 * window.utilisation, 0)]
        rows.append(row)
        if phase.name in built:
            rows.append(_built_row(built[phase.name], len(head)))
    return head, rows


def _way(phase: Phase) -> str:
    return "compensated" if phase.does.compensated else "locked"


def _depths(phase: Phase) -> str:
    return " to ".join(f"{depth:g}" for depth in dict.fromkeys(phase.does.depth))


def planned_values(study: LiftStudy, phase: Phase) -> Mapping[str, float]:
    """Return the figures of a `phase` of a `study` in its sea, the way that it is planned."""
    return study.at_sea[phase.name].planned(phase)[1]


def planned_state(study: LiftStudy, phase: Phase) -> str:
    """Return the verdict on a `phase` of a `study` in its sea, in a word."""
    limit, _ = study.at_sea[phase.name].planned(phase)
    return PASSED if study.height <= limit.height else FAILED


def _built_row(built: AsBuilt, width: int) -> list[str]:
    minutes = f"{(built.end - built.start) / 60.0:.0f}" if math.isfinite(built.start) else "-"
    row = ["", "as built", "", minutes, *_cells(built.phase, built.values), built.state]
    return [*row, *[""] * (width - len(row))]


def _cells(phase: Phase, values: Mapping[str, float]) -> list[str]:
    """Return the figures of a phase that are known where it takes place; a speed at touchdown only as a criterion."""
    hidden = {TOUCHDOWN} - {one.kpi for one in phase.criteria} | (set() if phase.kind == WATER else {*SHOWN} - {*LOADS})
    return ["-" if key in hidden else DEFINITION_OF[key].text(values.get(key, math.nan)) for key in SHOWN]


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def judged_rows(study: LiftStudy) -> Table:
    """Return head and rows of every criterion of a `study`: required, planned, and reached in the bag."""
    built = {one.phase.name: one for one in study.built}
    head = ["phase", "criterion", "planned", *(["as built"] if built else [])]
    rows = []
    for phase in study.plan.phases:
        values = planned_values(study, phase)
        for criterion in phase.criteria:
            planned = Judged(criterion, values.get(criterion.kpi, math.nan))
            cells = [phase.name, f"{title_of(criterion.kpi)} {required_words(criterion)}", planned.got]
            if built:
                reached = [one for one in built[phase.name].judged if one.criterion == criterion]
                cells.append(f"{reached[0].got}{'' if reached[0].is_met else ', MISSED'}" if reached else "-")
            rows.append(cells)
    return head, rows


def summary(study: LiftStudy) -> Sequence[str]:
    """Return the lines that say of a `study` whether one can go."""
    sea = f"Hs {study.height:g} m, Tp {study.period:g} s"
    failed = [phase.name for phase in study.plan.phases if planned_state(study, phase) == FAILED]
    lines = [f"plan in {sea}: {'beyond the limits in ' + ', '.join(failed) if failed else 'all phases within limits'}"]
    if study.windows:
        allowed = f"{100.0 * study.plan.whole.alpha:.0f} % of the limits"
        missing = [one.phase for one in study.windows if one.start is None]
        waits = sum(one.waiting for one in study.windows if one.start is not None)
        verdict = f"NO-GO: no window for {', '.join(missing)}" if missing else f"GO after {waits:g} h of waiting"
        assert study.forecast is not None
        lines.append(f"forecast {study.forecast.name}, {allowed}: {verdict}")
    for one in study.built:
        lines += [f"as built, {words}" for words in ([one.phase.name + ": " + one.state] if not one.judged else [])]
    missed = [words for one in study.built for words in one.failures]
    return [*lines, *(f"as built, missed: {words}" for words in missed)]
