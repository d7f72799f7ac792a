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

import numpy as np
import pandas
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from heave_node.sheet import Column, Sheet

from heave_studies.operability.limits import PERIOD
from heave_studies.operability.seas import HS, TP, SeaRecord, limit_at, read_record
from heave_studies.study.phases import Phase


@dataclass(frozen=True)
class Window:
    """When a phase takes place."""

    phase: str  # its name
    start: pandas.Timestamp | None = None  # of it; None: there is no window
    waiting: float = math.nan  # before it [h]
    # largest forecast height over what is allowed, in its reference period [-]; NaN without a window
    utilisation: float = math.nan

    @property
    def time(self) -> str:
        """Its start as people read it, in UTC."""
        return "none" if self.start is None else f"{self.start:%Y-%m-%d %H:%M}"


WINDOWS = Sheet(
    Column("phase", "phase", "phase"),
    Column("start (UTC)", "time"),
    Column("", lambda one: None if one.start is None else one.start.isoformat(), "start"),
    Column("wait [h]", "waiting", "waiting_h", ".1f"),
    Column("of allowed [%]", "utilisation", "utilisation", ".0f", 100.0),
)


def read_forecast(path: Path) -> SeaRecord:
    """Return the forecast in the file at `path`; raise ParameterError for one without an order in time."""
    forecast = read_record(path)
    if not forecast.has_order:
        raise ParameterError(f"{path}: is a scatter diagram; a forecast needs the columns time, hs, tp")
    return forecast


def windows(
    phases: Sequence[Phase], allowed: Mapping[str, Array], forecast: SeaRecord, contingency: float
) -> list[Window]:
    """Return when each phase can take place.

    Parameters
    ----------
    phases : of the lift
    allowed : height up to which each may begin, by its name, at each step of the forecast [m]
    forecast : with times
    contingency : time over the planned duration of a phase [-]
    """
    step, times, clock = forecast.step, pandas.DatetimeIndex(forecast.states.index), 0.0
    used = {phase.name: _utilisation(allowed[phase.name], forecast) for phase in phases}
    found: list[Window] = []
    for group in _groups(phases):
        hours = np.cumsum([0.0, *(phase.duration / 3600.0 for phase in group)])
        late = hours * (1.0 + contingency)

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
            return [*found, *(Window(phase.name) for phase in phases[len(found) :])]
        for n, phase in enumerate(group):
            waited = 0.0 if n else start - clock
            when = times[0] + pandas.Timedelta(hours=start + hours[n])
            found.append(Window(phase.name, when, waited, worst(n, start)))
        clock = start + hours[-1]
    return found


def allowed_heights(curve: pandas.DataFrame, forecast: SeaRecord, alpha: float) -> Array:
    """Return the height up to which a phase may begin, by step of a forecast [m]: alpha times its limit.

    Parameters
    ----------
    curve : limits of the phase by period
    forecast : with times
    alpha : share of the limit [-]
    """
    return alpha * limit_at(curve, forecast.states[TP].to_numpy())


def warnings(forecast: SeaRecord, curve: pandas.DataFrame) -> list[str]:
    """Return what is to be known of a `forecast` before it is trusted: what was repaired, what the limits leave open.

    `curve` has the limits of a phase by period.
    """
    first, last = curve["period"].min(), curve["period"].max()
    outside = int(((forecast.states[TP] < first) | (forecast.states[TP] > last)).sum())
    held = f"{forecast.name}: {outside} of {len(forecast.states)} peak periods lie outside {first:g} to {last:g} s"
    words = f"{held}, where the limit of the nearest is taken: vary {PERIOD} further"
    return [*forecast.warnings, *([words] if outside else [])]


def _utilisation(allowed: Array, forecast: SeaRecord) -> Array:
    """Return the forecast height over what is `allowed`, by step; infinite where nothing is forecast."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = forecast.states[HS].to_numpy() / allowed
    return np.where(np.isnan(share), np.inf, share)


def _groups(phases: Sequence[Phase]) -> list[list[Phase]]:
    """Return the phases that follow one another without a wait."""
    groups: list[list[Phase]] = []
    for phase in phases:
        if groups and not phase.does.may_wait:
            groups[-1].append(phase)
        else:
            groups.append([phase])
    return groups
