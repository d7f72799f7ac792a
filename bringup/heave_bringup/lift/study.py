"""All limits of a lift: every phase in seas of every peak period, on all processors."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from heave_bags.analyse.run_record import RunRecord

from heave_bringup.lift.as_built import AsBuilt, as_built
from heave_bringup.lift.forecast import Window, windows
from heave_bringup.lift.limits import PeriodLimits, period_limits
from heave_bringup.lift.plan import SURFACE, Phase, Plan
from heave_bringup.operability.record import SeaRecord
from heave_bringup.progress import ProgressLine
from heave_bringup.scenarios import load_scenario
from heave_bringup.workers.pool import worker_pool


@dataclass(frozen=True)
class LiftStudy:
    """A lift, its limits, its weather, and what became of it.

    Attributes
    ----------
    plan : of the lift
    height, period : of the sea in which figures are listed [m], [s]
    limits : of each phase by name, one for each of the plan's periods
    at_sea : of each phase by name, with the figures in that sea
    forecast : the seas to come; None: none
    windows : when phases can take place; empty without a forecast
    built : what the bag says of each phase; empty without one
    """

    plan: Plan
    height: float
    period: float
    limits: Mapping[str, Sequence[PeriodLimits]]
    at_sea: Mapping[str, PeriodLimits]
    forecast: SeaRecord | None = None
    windows: Sequence[Window] = field(default_factory=tuple)
    built: Sequence[AsBuilt] = field(default_factory=tuple)

    def to_json(self) -> dict[str, object]:
        """Return it as plain data."""
        return {
            "title": self.plan.title,
            "plan": str(self.plan.path),
            "sea": {"significant_wave_height_m": self.height, "peak_period_s": self.period},
            "limits": [asdict(one) for phase in self.limits.values() for one in phase],
            "figures_in_sea": [asdict(one) for one in self.at_sea.values()],
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
    sea = load_scenario(plan.scenario, settings=plan.settings).parameters["wave_vessel"]
    height = plan.whole.height or sea.significant_wave_height
    period = plan.whole.period or sea.peak_period
    periods = sorted({*plan.whole.periods, period})
    through = [[phase] for phase in plan.phases if phase.kind == SURFACE]  # the longest first
    groups = [*through, [phase for phase in plan.phases if phase.kind != SURFACE]]
    jobs = [(group, one) for group in groups if group for one in periods]
    found = _all_limits(plan, jobs, height, processes or os.cpu_count() or 1)
    by_phase = {
        phase.name: sorted((one for one in found if one.phase == phase.name), key=lambda one: one.period)
        for phase in plan.phases
    }
    at_sea = {name: next(one for one in of if one.period == period) for name, of in by_phase.items()}
    limits = {name: [one for one in of if one.period in plan.whole.periods] for name, of in by_phase.items()}
    due = windows(plan, limits, forecast) if forecast is not None else []
    return LiftStudy(plan, height, period, limits, at_sea, forecast, due, built)


def _all_limits(
    plan: Plan, jobs: Sequence[tuple[Sequence[Phase], float]], height: float, processes: int
) -> list[PeriodLimits]:
    found: list[PeriodLimits] = []
    with ProgressLine() as progress:
        progress.show("limits", 0.0)
        if processes == 1:
            for number, (phases, period) in enumerate(jobs, 1):
                found += period_limits(plan, phases, period, height)
                progress.show("limits", number / len(jobs))
            return found
        with worker_pool(min(processes, len(jobs))) as pool:
            waiting = [pool.submit(period_limits, plan, phases, period, height) for phases, period in jobs]
            for number, future in enumerate(waiting, 1):
                found += future.result()
                progress.show("limits", number / len(jobs))
    return found


def page_of(plan: Plan) -> Path:
    """Return where the page of a `plan` goes where nobody says: beside the user."""
    return Path(f"{plan.path.stem}_lift.html")
