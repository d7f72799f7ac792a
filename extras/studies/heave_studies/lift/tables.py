"""The tables of a lift, for terminal and page: phases, weather, limits by period, criteria as planned and as built."""

from __future__ import annotations

import math
from collections.abc import Sequence

from heave_bags.analyse.verdict import FAILED, PASSED, Judged, required_words

from heave_studies.lift.limits import Limit, curve_of
from heave_studies.lift.plan import Phase
from heave_studies.lift.study import LiftStudy
from heave_studies.operability.limits import limit_words, title_of

Table = tuple[list[str], list[list[str]]]


def phase_table(study: LiftStudy) -> Table:
    """Return head and rows of the phases of a `study`, with the verdicts on plan and bag."""
    head = ["phase", "way", "planned", *(["as built"] if study.built else [])]
    built = {one.phase.name: one.state for one in study.built}
    rows = []
    for phase in study.plan.phases:
        depths = " to ".join(f"{depth:g}" for depth in dict.fromkeys(phase.does.depth))
        winch = "compensated" if phase.does.compensated else "locked"
        row = [phase.name, f"{depths} m, {phase.duration / 60.0:.0f} min, {winch}", planned_state(study, phase)]
        rows.append([*row, *([built[phase.name]] if built else [])])
    return head, rows


def planned_state(study: LiftStudy, phase: Phase) -> str:
    """Return the verdict on a `phase` of a `study` in its sea, in a word."""
    return PASSED if study.height <= study.planned(phase).height else FAILED


def weather_table(study: LiftStudy) -> Table:
    """Return head and rows of when the phases of a `study` can take place."""
    rows = []
    for one in study.windows:
        start = "none" if one.start is None else f"{one.start:%Y-%m-%d %H:%M}"
        rows.append([one.phase, start, _number(one.waiting, 1), _number(100.0 * one.utilisation, 0)])
    return ["phase", "start (UTC)", "wait h", "of allowed %"], rows


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def limit_table(study: LiftStudy) -> Table:
    """Return head and rows of the limits of a `study`."""
    rows = []
    for phase in study.plan.phases:
        for number, one in enumerate(study.limits[phase.name]):
            cells = [phase.name if number == 0 else "", f"{one.period:g}"]
            rows.append([*cells, _words(one.period, one.compensated), _words(one.period, one.locked)])
    return ["phase", "Tp s", "Hs m, compensated", "Hs m, winch locked"], rows


def _words(period: float, limit: Limit | None) -> str:
    if limit is None:
        return "-"
    (row,) = curve_of({period: limit}).to_dict("records")
    return limit_words(row) + (f" ({title_of(limit.governs)})" if limit.governs else "")


def judged_rows(study: LiftStudy) -> Table:
    """Return head and rows of every criterion of a `study`: required, planned in its sea, and reached in the bag."""
    built = {one.phase.name: one for one in study.built}
    rows = []
    for phase in study.plan.phases:
        values = study.planned(phase).values
        for number, criterion in enumerate(phase.criteria):
            planned = Judged(criterion, values.get(criterion.kpi, math.nan))
            cells = [phase.name, f"{title_of(criterion.kpi)} {required_words(criterion)}", planned.got]
            if built:
                reached = built[phase.name].judged[number : number + 1]
                cells += [_reached(one) for one in reached] or ["-"]
            rows.append(cells)
    return ["phase", "criterion", "planned", *(["as built"] if built else [])], rows


def _reached(one: Judged) -> str:
    return one.got if one.is_met or math.isnan(one.value) else f"{one.got}, FAILED"


def summary(study: LiftStudy) -> Sequence[str]:
    """Return the lines that say of a `study` whether one can go."""
    sea = f"Hs {study.height:g} m, Tp {study.period:g} s"
    failed = [phase.name for phase in study.plan.phases if planned_state(study, phase) == FAILED]
    lines = [f"plan in {sea}: {'beyond the limits in ' + ', '.join(failed) if failed else 'all phases within limits'}"]
    if study.forecast is not None:
        missing = [one.phase for one in study.windows if one.start is None]
        waits = sum(one.waiting for one in study.windows if one.start is not None)
        verdict = f"NO-GO: no window for {', '.join(missing)}" if missing else f"GO after {waits:g} h of waiting"
        allowed = f"{100.0 * study.plan.whole.alpha:.0f} % of the limits"
        lines.append(f"forecast {study.forecast.name}, {allowed}: {verdict}")
    lines += [f"as built, {one.phase.name}: {one.state}" for one in study.built if not one.judged]
    return [*lines, *(f"as built, missed: {words}" for one in study.built for words in one.failures)]
