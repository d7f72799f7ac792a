"""A forecast against the limits of a lift: when each phase can begin, and how long it waits.

A phase needs the sea within `alpha` times its limit from when it begins as planned to when it ends with all contingency
time used up, its own and that of the phases before it in the same window (T_R = T_POP + T_C; the operational criterion
is alpha times the design criterion: DNV-ST-N001, Marine operations and marine warranty, section on weather-restricted
operations, whose tables of alpha are the user's to apply). Phases follow one another at once; only before one that
`may_wait` is the unit left where it is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError

from heave_studies.lift.limits import PeriodLimits, planned_curve
from heave_studies.lift.plan import Phase, Plan
from heave_studies.operability.seas import HS, TP, SeaRecord, limit_at, read_record


@dataclass(frozen=True)
class Window:
    """When a phase takes place."""

    phase: str  # its name
    start: pandas.Timestamp | None = None  # of it; None: there is no window
    waiting: float = math.nan  # before it [h]
    # largest forecast height over what is allowed, in its reference period [-]; NaN without a window
    utilisation: float = math.nan

    def to_json(self) -> Mapping[str, Any]:
        """Return it as plain data."""
        return {
            "phase": self.phase,
            "start": None if self.start is None else self.start.isoformat(),
            "waiting_h": self.waiting,
            "utilisation": self.utilisation,
        }


def read_forecast(path: Path) -> SeaRecord:
    """Return the forecast in the file at `path`; raise ParameterError for one without an order in time."""
    forecast = read_record(path)
    if not forecast.has_order:
        raise ParameterError(f"{path}: is a scatter diagram; a forecast needs the columns time, hs, tp")
    return forecast


def windows(plan: Plan, limits: Mapping[str, Sequence[PeriodLimits]], forecast: SeaRecord) -> list[Window]:
    """Return when each phase can take place.

    Parameters
    ----------
    plan : of the lift
    limits : of each phase by its name, by period
    forecast : with times
    """
    step, times, clock = forecast.step, pandas.DatetimeIndex(forecast.states.index), 0.0
    used = {phase.name: _utilisation(plan, phase, limits[phase.name], forecast) for phase in plan.phases}
    found: list[Window] = []
    for group in _groups(plan.phases):
        hours = np.cumsum([0.0, *(phase.duration / 3600.0 for phase in group)])
        late = hours * (1.0 + plan.whole.contingency)

        def worst(
            number: int, start: float, group: list[Phase] = group, hours: Array = hours, late: Array = late
        ) -> float:
            """Return the largest share of what is allowed, from when a phase begins until it is over at the latest."""
            of_phase = used[group[number].name]
            first = math.floor((start + hours[number]) / step + 1e-9)
            last = max(math.ceil((start + late[number + 1]) / step - 1e-9), 1)
            return float(of_phase[first:last].max()) if last <= of_phase.size else math.inf

        tried = (clock, *(step * n for n in range(math.floor(clock / step) + 1, times.size)))
        start = next((at for at in tried if all(worst(n, at) <= 1.0 for n in range(len(group)))), None)
        if start is None:
            return [*found, *(Window(phase.name) for phase in plan.phases[len(found) :])]
        for n, phase in enumerate(group):
            waited = 0.0 if n else start - clock
            when = times[0] + pandas.Timedelta(hours=start + hours[n])
            found.append(Window(phase.name, when, waited, worst(n, start)))
        clock = start + hours[-1]
    return found


def allowed(plan: Plan, phase: Phase, limits: Sequence[PeriodLimits], forecast: SeaRecord) -> Array:
    """Return the height up to which a phase may begin, by step of a forecast [m]: alpha times its limit.

    Parameters
    ----------
    plan, phase : of the lift
    limits : of the phase, by period
    forecast : with times
    """
    return plan.whole.alpha * limit_at(planned_curve(phase, limits), forecast.states[TP].to_numpy())


def _utilisation(plan: Plan, phase: Phase, limits: Sequence[PeriodLimits], forecast: SeaRecord) -> Array:
    """Return the forecast height over what is allowed, by step; infinite where nothing is forecast."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = forecast.states[HS].to_numpy() / allowed(plan, phase, limits, forecast)
    return np.where(np.isnan(share), np.inf, share)


def warnings(plan: Plan, forecast: SeaRecord) -> list[str]:
    """Return what is to be known of a forecast before it is trusted for a `plan`: what was repaired, what is held."""
    first, last = plan.whole.periods[0], plan.whole.periods[-1]
    outside = int(((forecast.states[TP] < first) | (forecast.states[TP] > last)).sum())
    held = f"{forecast.name}: {outside} of {len(forecast.states)} peak periods lie outside {first:g} to {last:g} s"
    words = f"{held}, where the limit of the nearest is taken: add them to periods in {plan.path}"
    return [*forecast.warnings, *([words] if outside else [])]


def _groups(phases: Sequence[Phase]) -> list[list[Phase]]:
    """Return the phases that follow one another without a wait."""
    groups: list[list[Phase]] = []
    for phase in phases:
        if groups and not phase.does.may_wait:
            groups[-1].append(phase)
        else:
            groups.append([phase])
    return groups
