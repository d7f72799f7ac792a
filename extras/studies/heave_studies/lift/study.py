"""All limits of a lift: every phase in seas of every peak period, as a study, and its tables."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

import pandas
from heave_bags.analyse.verdict import FAILED, PASSED, Judged, required_words
from heave_bringup.errors import CommandError
from heave_bringup.stored_scenario import stored_sections
from heave_node.scenario import sections_text

from heave_studies.lift.as_built import AsBuilt
from heave_studies.lift.figures import PLANNED
from heave_studies.lift.forecast import Window
from heave_studies.lift.limits import Limit, PeriodLimits, curve_of, period_limits
from heave_studies.lift.plan import SURFACE, Phase, Plan
from heave_studies.operability.limits import limit_words, title_of
from heave_studies.operability.seas import SeaRecord
from heave_studies.study.case_file import CASE, FILES, SCENARIO, KeptFile
from heave_studies.study.workers import FAILURE, Job, Plain


@dataclass(frozen=True)
class LiftStudy:
    """A lift, its limits, its weather, and what became of it."""

    plan: Plan  # of the lift
    height: float  # of the sea in which figures are listed [m]
    period: float  # of the sea in which figures are listed [s]
    # of each phase by name, one for each of the plan's periods and that of the sea
    limits: Mapping[str, Sequence[PeriodLimits]]
    forecast: SeaRecord | None = None  # the seas to come; None: none
    windows: Sequence[Window] = field(default_factory=tuple)  # when phases can take place; empty without a forecast
    built: Sequence[AsBuilt] = field(default_factory=tuple)  # what the bag says of each phase; empty without one

    def planned(self, phase: Phase) -> Limit:
        """Return the limit of a `phase` in seas of its period, the way that it is planned, with the figures in it."""
        return next(one for one in self.limits[phase.name] if one.period == self.period).planned(phase)

    @property
    def failures(self) -> list[str]:
        """What the forecast does not allow, and what the bag misses, in words."""
        without = [f"{one.phase}: no window in the forecast" for one in self.windows if one.start is None]
        return [*without, *(words for one in self.built for words in one.failures)]

    def to_json(self) -> dict[str, object]:
        """Return it as plain data."""
        return {
            "title": self.plan.title,
            "plan": str(self.plan.path),
            "sea": {"significant_wave_height_m": self.height, "peak_period_s": self.period},
            "limits": [asdict(one) for phase in self.limits.values() for one in phase],
            "forecast": self.forecast.name if self.forecast else None,
            "windows": [one.to_json() for one in self.windows],
            "as_built": [one.to_json() for one in self.built],
        }


COLUMNS = ("phase", "period_s", "winch", "limit_m", "governs")
"""Columns of the table of a lift, after the number of the row and before the figures of `PLANNED` at its height."""
LOCKED, COMPENSATED = "locked", "compensated"


@dataclass(frozen=True)
class Lift:
    """The limits of a lift, as the engine takes them (`heave_studies.study.engine.Kind`): a job for a phase and period.

    Phases that hang share the runs of a period.
    """

    plan: Plan  # of the lift
    is_local: bool = False  # jobs run anywhere
    is_open: bool = False  # each job runs
    files: Mapping[str, KeptFile] = field(default_factory=dict)  # none is read

    @property
    def name(self) -> str:
        """What its table and page are called."""
        return self.plan.title

    @property
    def identity(self) -> str:
        """What identifies its limits: the plan, and its scenario with all values."""
        scenario = self.plan.with_settings()
        text = sections_text(stored_sections(scenario), title="")
        return f"{self.plan.whole}{self.plan.phases}{text}"

    @property
    def size(self) -> int:
        """Number of jobs."""
        return len(self._jobs())

    def _jobs(self) -> list[Job]:
        plan = self.plan
        height, period = plan.sea
        through = [[phase] for phase in plan.phases if phase.kind == SURFACE]  # the longest first
        groups = [*through, [phase for phase in plan.phases if phase.kind != SURFACE]]
        work = [(group, one) for group in groups if group for one in sorted({*plan.whole.periods, period})]
        return [
            Job(number, f"{group[0].name}, Tp {one:g} s", partial(_rows, plan, group, one, height))
            for number, (group, one) in enumerate(work, 1)
        ]

    def rounds(self, _: Mapping[int, Plain]) -> Iterator[list[Job]]:
        """Yield the jobs."""
        yield self._jobs()

    def frame(self, results: Mapping[int, Plain]) -> pandas.DataFrame:
        """Return a row for each phase, period and way of the winch; raise CommandError where `results` lack one."""
        for result in results.values():
            if result.get(FAILURE):
                raise CommandError(str(result[FAILURE]))
        rows = [row for number in sorted(results) for row in results[number]["rows"]]
        frame = pandas.DataFrame(rows, columns=[*COLUMNS, *PLANNED])
        frame.insert(0, CASE, range(1, len(frame) + 1))
        return frame.astype(dict.fromkeys(PLANNED, float)).assign(**{SCENARIO: "", FILES: ""})


def _rows(plan: Plan, phases: Sequence[Phase], period: float, height: float) -> Plain:
    found = []
    for one in period_limits(plan, phases, period, height):
        for winch, limit in ((LOCKED, one.locked), (COMPENSATED, one.compensated)):
            if limit is not None:
                head = dict(zip(COLUMNS, (one.phase, period, winch, limit.height, limit.governs), strict=True))
                found.append({**head, **limit.values})
    return {"rows": found}


def limits_in(frame: pandas.DataFrame) -> dict[str, list[PeriodLimits]]:
    """Return the limits in the table of a lift, its `frame`, of each phase by period."""
    found: dict[str, list[PeriodLimits]] = {}
    for (phase, period), part in frame.groupby(["phase", "period_s"], sort=False):
        limits = {row["winch"]: _limit(row) for row in part.to_dict("records")}
        one = PeriodLimits(str(phase), float(period), limits[LOCKED], limits.get(COMPENSATED))
        found.setdefault(str(phase), []).append(one)
    return {name: sorted(of, key=lambda one: one.period) for name, of in found.items()}


def _limit(row: Mapping[Hashable, Any]) -> Limit:
    values = {key: float(row[key]) for key in PLANNED}
    return Limit(float(row["limit_m"]), str(row["governs"]), values)


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
