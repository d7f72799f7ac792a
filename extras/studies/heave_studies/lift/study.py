"""All limits of a lift: every phase in seas of every peak period, on all processors."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, field
from functools import partial

from heave_bags.analyse.run_record import RunRecord
from heave_bringup.progress import ProgressLine

from heave_studies.lift.as_built import AsBuilt, as_built
from heave_studies.lift.forecast import Window, windows
from heave_studies.lift.limits import Limit, PeriodLimits, period_limits
from heave_studies.lift.plan import SURFACE, Phase, Plan
from heave_studies.operability.record import SeaRecord
from heave_studies.workers.pool import worker_pool


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


def study_lift(
    plan: Plan, *, processes: int | None = None, forecast: SeaRecord | None = None, record: RunRecord | None = None
) -> LiftStudy:
    """Return the limits of a lift, and what a forecast and a bag say of them.

    Parameters
    ----------
    plan : of the lift
    processes : number of worker processes; None takes one per processor, 1 works in this one
    forecast : the seas to come; None: none
    record : of the bag of the lift; None: none

    Raises ParameterError for what is wrong with the plan.
    """
    built = as_built(plan, record) if record is not None else []
    height, period = plan.sea
    through = [[phase] for phase in plan.phases if phase.kind == SURFACE]  # the longest first
    groups = [*through, [phase for phase in plan.phases if phase.kind != SURFACE]]
    jobs = [(group, one) for group in groups if group for one in sorted({*plan.whole.periods, period})]
    found = _all_limits(plan, jobs, height, processes or os.cpu_count() or 1)
    limits = {
        phase.name: sorted((one for one in found if one.phase == phase.name), key=lambda one: one.period)
        for phase in plan.phases
    }
    due = windows(plan, limits, forecast) if forecast is not None else []
    return LiftStudy(plan, height, period, limits, forecast, due, built)


def _all_limits(
    plan: Plan, jobs: Sequence[tuple[Sequence[Phase], float]], height: float, processes: int
) -> list[PeriodLimits]:
    found: list[PeriodLimits] = []
    work = partial(_job, plan, height)
    with (
        ProgressLine() as progress,
        nullcontext() if processes == 1 else worker_pool(min(processes, len(jobs))) as pool,
    ):
        progress.show("limits", 0.0)
        for number, limits in enumerate(map(work, jobs) if pool is None else pool.map(work, jobs), 1):
            found += limits
            progress.show("limits", number / len(jobs))
    return found


def _job(plan: Plan, height: float, job: tuple[Sequence[Phase], float]) -> list[PeriodLimits]:
    return period_limits(plan, *job, height)
