"""A sizing study: what each winch can work in, where a larger one gains little more, what an hour of each costs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import pandas
from heave_node.criteria import Criterion
from heave_node.loads.cycles import DAMAGE_EXPONENT
from heave_node.numerics.arrays import Array
from scipy.interpolate import RegularGridInterpolator

from heave_studies.operability.limits import HEIGHT, PERIOD, limit_curve
from heave_studies.operability.record import HS, TP, SeaRecord, workable, workable_share
from heave_studies.sizing.candidates import PARTICULARS, Candidate, Particular, of_frame

OF_THE_WINCH = (
    "time_at_speed_limit_percent",
    "time_at_acceleration_limit_percent",
    "time_at_limit_percent",
    "power_peak_w",
)
"""Criteria that judge a winch by how much of it is used: left out here, where what it does for the unit counts."""

ENOUGH = 0.95
"""The knee is where a particular gives so much of what the best of its sweep gives."""

EVEN_STEPS = 25
"""Wave heights at which the seas of a study are counted where no place is given."""


@dataclass(frozen=True)
class Prices:
    """What an hour is charged with."""

    efficiency: float = 0.8  # of the drive, either way, 0 to 1 [-]
    # share of the regenerated energy that the ship can use, 0 to 1 [-]; the rest becomes heat
    regeneration: float = 0.0
    energy: float = 0.3  # price of a kWh in any currency [1/kWh]


@dataclass(frozen=True)
class Duty:
    """What an hour of compensation asks of a winch, as a mean over the seas in which it can work; NaN where there are
    none.
    """

    peak: float  # largest power in any of these seas [W]
    rms: float  # root mean square of the power [W]
    motoring: float  # energy at the drum [Wh/h]
    regenerated: float  # energy at the drum [Wh/h]
    electric: float  # energy bought, less what is fed back [Wh/h]
    heat: float  # lost in the drive and burnt in resistors [Wh/h]
    cost: float  # of the energy, in the currency of its price [1/h]
    travel: float  # of the rope [m/h]
    reversals: float  # of the rope [1/h]
    bending_cycles: float  # of the rope [1/h]
    loaded: float  # share of time above half of rated speed or power [%]
    tension_cycles: float  # of the top tension [1/h]
    tension_range: float  # of the top tension, that once a second does the damage of all cycles in the seas' mix [N]


@dataclass(frozen=True)
class Sized:
    """What a study found of one winch."""

    winch: Candidate  # the candidate
    cases: pandas.DataFrame  # its rows of the study's table
    limit: pandas.DataFrame  # by period, as `limit_curve` gives it
    share: float  # of the place's seas that are workable [-]
    lower: float  # lower end of its confidence [-]
    upper: float  # upper end of its confidence [-]
    duty: Duty  # of an hour


@dataclass(frozen=True)
class Knee:
    """Where more of a particular gains little."""

    particular: Particular  # of the winch
    # that gives ENOUGH of the best, linear between the values tried, SI; NaN where only winches without a limit do
    value: float
    share: float  # workable share at the scenario's own value [-]
    best: float  # workable share at the best value [-]
    is_open: bool  # the least (of a delay the largest) value tried gives enough already: the knee lies beyond it

    @property
    def text(self) -> str:
        """The value as people see it."""
        if math.isnan(self.value):
            return "above all tried"
        beyond = "at least" if self.particular.costs_when_small else "at most"
        return f"{beyond} {self.particular.text(self.value)}" if self.is_open else self.particular.text(self.value)


def even_seas(frame: pandas.DataFrame) -> SeaRecord:
    """Return the seas of a study, every height up to its largest and every period equally often: no place is known.

    Parameters
    ----------
    frame : table of the study
    """
    top = float(frame[HEIGHT].max())
    heights = (np.arange(EVEN_STEPS) + 0.5) * top / EVEN_STEPS
    grid = pandas.MultiIndex.from_product([sorted(frame[PERIOD].unique()), heights], names=[TP, HS])
    states = grid.to_frame(index=False).assign(share=1.0 / len(grid))
    return SeaRecord(f"all seas up to Hs {top:g} m, each as often", states, math.nan)


def size_winches(
    frame: pandas.DataFrame, criteria: Sequence[Criterion], seas: SeaRecord, prices: Prices
) -> list[Sized]:
    """Return what each winch of a study can work in and costs, the scenario's own first.

    Parameters
    ----------
    frame : table of the study
    criteria : that are to hold
    seas : of the place
    prices : of an hour

    Raises ParameterError for the table of another study.
    """
    found = []
    for winch, cases in of_frame(frame):
        limit = limit_curve(cases, criteria)
        share, lower, upper = (workable_share(seas, limit, column) for column in ("limit", "lower", "upper"))
        found.append(Sized(winch, cases, limit, share, lower, upper, duty_of(cases, limit, seas, prices)))
    return found


def duty_of(cases: pandas.DataFrame, limit: pandas.DataFrame, seas: SeaRecord, prices: Prices) -> Duty:
    """Return what an hour of compensation asks of a winch.

    Figures are linear between the seas that were run, 0 in a calm sea, and held beyond the grid.

    Parameters
    ----------
    cases : of this winch
    limit : by period; an hour counts in which the sea is within it
    seas : of the place
    prices : of an hour
    """
    states = seas.states[workable(seas, limit)]
    weights = states["share"].to_numpy()
    if not weights.size or weights.sum() <= 0.0:
        return Duty(**{of.name: math.nan for of in fields(Duty)})
    weights = weights / weights.sum()

    def mean(kpi: str) -> float:
        return float(weights @ _at(cases, kpi, states))

    motoring, regenerated = mean("energy_wh_per_h"), mean("energy_regenerated_wh_per_h")
    bought = motoring / prices.efficiency
    ranges = _at(cases, "tension_range_equivalent_n", states)
    fed_back = prices.efficiency * prices.regeneration * regenerated
    electric = bought - fed_back
    return Duty(
        peak=float(_at(cases, "power_peak_w", states).max()),
        rms=float(np.sqrt(weights @ _at(cases, "power_rms_w", states) ** 2)),
        motoring=motoring,
        regenerated=regenerated,
        electric=electric,
        heat=electric - motoring + regenerated,
        cost=1e-3 * electric * prices.energy,
        travel=mean("rope_travel_m_per_h"),
        reversals=mean("reversals_per_h"),
        bending_cycles=mean("bending_cycles_per_h"),
        loaded=mean("time_above_half_rating_percent"),
        tension_cycles=mean("tension_cycles_per_h"),
        tension_range=float((weights @ ranges**DAMAGE_EXPONENT) ** (1.0 / DAMAGE_EXPONENT)),
    )


def _at(cases: pandas.DataFrame, kpi: str, states: pandas.DataFrame) -> Array:
    """Return a figure of merit at seas, its mean over the seeds; NaN where an older table has no such figure."""
    if kpi not in cases:
        return np.full(len(states), math.nan)
    grid = cases.pivot_table(index=PERIOD, columns=HEIGHT, values=kpi, aggfunc="mean", dropna=False)
    grid = grid.bfill(axis=1).ffill(axis=1)  # of a case that could not be run: as in the sea beside it
    grid.insert(0, 0.0, 0.0)
    periods, heights = grid.index.to_numpy(dtype=float), grid.columns.to_numpy(dtype=float)
    points = np.column_stack(
        [
            np.clip(states[TP].to_numpy(), periods[0], periods[-1]),
            np.clip(states[HS].to_numpy(), 0.0, heights[-1]),
        ]
    )
    return np.asarray(RegularGridInterpolator((periods, heights), grid.to_numpy(dtype=float))(points))


def knees(found: Sequence[Sized]) -> list[Knee]:
    """Return the knee of each particular that was swept.

    Parameters
    ----------
    found : winches of a study, the scenario's own first
    """
    own = found[0]
    sweeps = [(one, sweep_of(found, one)) for one in PARTICULARS]
    return [_knee(particular, own, sweep) for particular, sweep in sweeps if len(sweep) > 1]


def sweep_of(found: Sequence[Sized], particular: Particular) -> list[Sized]:
    """Return the winches that differ from the scenario's in a `particular`, and that one, by rising value.

    Parameters
    ----------
    found : winches of a study, the scenario's own first
    particular : that was swept
    """
    part = [one for number, one in enumerate(found) if not number or one.winch.sweep == particular.name]
    return sorted(part, key=lambda one: one.winch.value(particular))


def _knee(particular: Particular, own: Sized, sweep: Sequence[Sized]) -> Knee:
    """Go from the cheap end of a sweep to where it gives enough."""
    ordered = list(reversed(sweep)) if particular.costs_when_small else list(sweep)
    values = [one.winch.value(particular) for one in ordered]
    shares = np.maximum.accumulate([one.share for one in ordered])  # a dearer winch is not worse but by chance
    wanted = ENOUGH * float(shares[-1])
    first = int(np.argmax(shares >= wanted))
    if first == 0:
        return Knee(particular, values[0], own.share, float(shares[-1]), is_open=True)
    if math.isinf(values[first]):
        return Knee(particular, math.nan, own.share, float(shares[-1]), is_open=False)
    way = (wanted - shares[first - 1]) / (shares[first] - shares[first - 1])
    value = values[first - 1] + float(way) * (values[first] - values[first - 1])
    return Knee(particular, value, own.share, float(shares[-1]), is_open=False)
