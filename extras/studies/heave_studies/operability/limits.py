"""The largest sea in which criteria hold, by period, from the cases of a grid of seas.

Between two heights a figure of merit is taken as linear. Below the smallest it goes to its value in a calm sea: an
estimate, by which seas of a place are counted, and which is reported as a limit below the smallest height. Each
seed has a limit of its own, and their spread is the confidence in the mean (Student's t), from FEWEST_SEEDS on.

By bisection each seed's limit is enclosed ever closer, in the same waves at other heights.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_node.criteria import Criterion
from heave_node.loads.strength import FACTORS, ROPE
from heave_node.numerics.arrays import Array

from heave_studies.study.phases import DEPTH, PHASE
from heave_studies.study.plan import Case, More
from heave_studies.study.summary import FEWEST_SEEDS, half_width
from heave_studies.study.table import BREACHES, LOST, SEED, alike, settings_of
from heave_studies.study.workers import FAILURE

HEIGHT, PERIOD = "system.sea.significant_wave_height", "system.sea.peak_period"
"""Places of what a sea is given by."""

USEFUL_SEEDS = 5
"""Seeds from which on half the interval is at most the standard deviation of one seed's limit."""

NARROW = 0.1
"""Width of a confidence interval [m] below which a limit is stated to the centimetre."""

LOST_LIMIT = "compensation lost"
"""Name of the limit where compensation is lost, or a case cannot be run."""

FAILED_LIMIT = "case failed for another reason"
"""Name of the limit where a case within all criteria failed as any run may."""

CALM = {
    "dynamic_amplification": 1.0,
    "tension_ratio_min": 1.0,
    "compensating_percent": 100.0,
    "unit_efficiency": 1.0,
    "outlet_efficiency": 1.0,
}
"""Figures that are not 0 in a calm sea."""

UNCOMPENSATED = {
    "unit_sigma_m": ("uncompensated_sigma_m", 1.0),
    "significant_residual_m": ("uncompensated_sigma_m", 4.0),
    "max_abs_heave_m": ("uncompensated_max_abs_heave_m", 1.0),
    "dynamic_amplification": ("uncompensated_dynamic_amplification", 1.0),
    "tension_ratio_min": ("uncompensated_tension_ratio_min", 1.0),
    "snaps": ("uncompensated_snaps", 1.0),
    ROPE: ("uncompensated_rope_safety_factor", 1.0),
}
"""Figures that are known of the locked winch in the same sea: their key, and a factor."""


@dataclass(frozen=True)
class SeedLimit:
    """The limit of one seed at one period."""

    height: float  # largest significant wave height in which every criterion holds [m]
    governs: str  # figure of merit that ends it; "" where nothing does up to the largest height of the grid


def situations(frame: pandas.DataFrame) -> list[tuple[str, pandas.DataFrame]]:
    """Return the cases in `frame` apart by what was varied beside the sea (heading, phase, ...), each with its name."""
    others = [place for place in settings_of(frame) if place not in (HEIGHT, PERIOD, DEPTH)]
    if not others:
        return [("", frame)]
    groups = frame.groupby([frame[place].astype(str) for place in others], sort=False)
    return [(_name(others, part), part) for _, part in groups]


def _name(places: Sequence[str], part: pandas.DataFrame) -> str:
    words = []
    for place in places:
        value = part[place].iloc[0]
        is_angle = place.endswith("heading")
        shown = f"{math.degrees(value):.0f} deg" if is_angle else f"{value:g}" if isinstance(value, float) else value
        words.append(str(shown) if place == PHASE else f"{place.rsplit('.', 1)[-1]} {shown}")
    return ", ".join(words)


def limit_curve(frame: pandas.DataFrame, criteria: Sequence[Criterion], *, locked: bool = False) -> pandas.DataFrame:
    """Return the limit by period.

    Parameters
    ----------
    frame : cases of one situation
    criteria : that are to hold
    locked : of the uncompensated unit, by those criteria that it has a figure for

    Returns
    -------
    curve : a row for each peak period, with `period`, `limit` (mean over the seeds), `lower` and `upper` (ends of its
        confidence interval within the grid, NaN for fewer than FEWEST_SEEDS), `is_open` (nothing limits some seed up to
        the largest height), `is_below` (some seed is limited below the smallest height, where nothing was run),
        `at_most` (mean with the smallest height for such seeds), `governs`, `seeds`
    """
    bottom, top = float(frame[HEIGHT].min()), float(frame[HEIGHT].max())
    rows = []
    for period, of_period in frame.groupby(PERIOD):
        found = [_least(of_seed, criteria, locked=locked) for _, of_seed in of_period.groupby(SEED)]
        heights = np.array([min(one.height, top) for one in found])
        half = half_width(heights)
        names = [one.governs for one in found if one.governs]
        rows.append(
            {
                "period": float(period),  # type: ignore[arg-type]
                "limit": float(heights.mean()),
                "lower": max(float(heights.mean()) - half, 0.0),  # not known stays not known
                "upper": min(float(heights.mean()) + half, top),
                "is_open": any(math.isinf(one.height) for one in found),
                "is_below": bool((heights < bottom).any()),
                "at_most": float(np.maximum(heights, bottom).mean()),
                "governs": max(names, key=names.count) if names else "",
                "seeds": len(found),
            }
        )
    return pandas.DataFrame(rows)


def _least(frame: pandas.DataFrame, criteria: Sequence[Criterion], *, locked: bool) -> SeedLimit:
    """Return the limit of one seed at one period: the least of those at the depths of a phase, where it is of one."""
    pieces = [part for _, part in frame.groupby(DEPTH)] if DEPTH in frame else [frame]
    return min((seed_limit(one, criteria, locked=locked) for one in pieces), key=lambda one: one.height)


def limit_words(row: Mapping[Hashable, Any]) -> str:
    """Return the limit of a `row` of a limit curve [m], as far as it lies within the heights that were run.

    It has the digits that its confidence allows: with too few seeds to state one, a single decimal.
    """
    if row["is_below"]:
        return f"below {row['at_most']:.{_digits(row)}f}"
    return f"{'above ' if row['is_open'] else ''}{row['limit']:.{_digits(row)}f}"


def _digits(row: Mapping[Hashable, Any]) -> int:
    return 2 if float(row["upper"]) - float(row["lower"]) < NARROW else 1


def interval(row: Mapping[Hashable, Any]) -> str:
    """Return the confidence interval of a `row` of a limit curve; a dash where it is not known."""
    lower, upper = float(row["lower"]), float(row["upper"])
    digits = _digits(row)
    return f"{lower:.{digits}f} to {upper:.{digits}f}" if upper > lower and not row["is_below"] else "-"


def too_few_seeds(curves: Sequence[pandas.DataFrame]) -> str:
    """Return the line that says why a limit of the `curves` shows no confidence; "" where each has seeds enough."""
    count = min(int(curve["seeds"].min()) for curve in curves)
    if count >= FEWEST_SEEDS:
        return ""
    seeds = f"{count} seed{'s' if count > 1 else ''}"
    return f"Confidence is not stated with {seeds}; use at least {FEWEST_SEEDS}, better {USEFUL_SEEDS}."


def seed_limit(frame: pandas.DataFrame, criteria: Sequence[Criterion], *, locked: bool = False) -> SeedLimit:
    """Return the limit of one seed at one period.

    Parameters
    ----------
    frame : its cases, one for each height
    criteria : that are to hold
    locked : of the uncompensated unit
    """
    cases = frame.sort_values(HEIGHT)
    heights = cases[HEIGHT].to_numpy(dtype=float)
    limits = {}
    for criterion in criteria:
        course = course_of(cases, criterion, locked=locked)
        if course is not None:
            limits[criterion.kpi] = crossing(heights, course.values, course.criterion, course.calm)
    if not locked:
        gone = (cases[LOST].to_numpy(dtype=bool)) | (cases[FAILURE] != "").to_numpy()
        limits[LOST_LIMIT] = _last_before(heights, gone)
        failed = (cases[BREACHES] != "").to_numpy() & (heights <= min(limits.values()))
        limits[FAILED_LIMIT] = _last_before(heights, failed)
    if not limits:
        return SeedLimit(math.inf, "")
    governs = min(limits, key=lambda name: limits[name])
    return SeedLimit(limits[governs], governs if math.isfinite(limits[governs]) else "")


def figure(cases: pandas.DataFrame, kpi: str, *, locked: bool) -> Array | None:
    """Return a figure of merit of `cases`, or that of the locked winch in the same seas; None where it has none.

    Parameters
    ----------
    cases : rows of a study's table
    kpi : key of the figure
    locked : of the uncompensated unit
    """
    if not locked:
        return np.asarray(cases[kpi], dtype=float)
    if kpi not in UNCOMPENSATED:
        return None
    key, factor = UNCOMPENSATED[kpi]
    return np.asarray(factor * cases[key], dtype=float)


@dataclass(frozen=True)
class Course:
    """How a figure goes with the sea, in terms that are linear in the height of the waves."""

    values: Array  # of the cases, shape (n,)
    calm: float  # in a calm sea, SI
    criterion: Criterion  # that is to hold of them


def course_of(cases: pandas.DataFrame, criterion: Criterion, *, locked: bool = False) -> Course | None:
    """Return how the figure of a `criterion` goes with the sea; None where there is no such figure.

    A safety factor is turned into the load over the capacity, which grows with the waves; without waves it is that of
    the static tension.

    Parameters
    ----------
    cases : rows of a study's table
    criterion : on a figure of merit
    locked : of the uncompensated unit
    """
    values = figure(cases, criterion.kpi, locked=locked)
    if values is None or (criterion.kpi in FACTORS and np.isnan(values).all()):  # of a load that is not measured
        return None
    if criterion.kpi not in FACTORS:
        return Course(values, CALM.get(criterion.kpi, 0.0), criterion)
    with np.errstate(divide="ignore"):
        loads = np.where(np.isinf(values), 0.0, 1.0 / values)
    amplification = figure(cases, "dynamic_amplification", locked=locked)
    calm = float(np.nanmean(loads / amplification)) if np.isfinite(loads / amplification).any() else 0.0
    bound = Criterion(criterion.kpi, criterion.relation.replace(">", "<"), 1.0 / criterion.bound)
    return Course(loads, calm, bound)


def crossing(heights: Array, values: Array, criterion: Criterion, calm: float | None = None) -> float:
    """Return the height at which a figure reaches its bound for the first time; infinite where it does not.

    Parameters
    ----------
    heights : rising, shape (n,) [m]
    values : of the figure at them, shape (n,)
    criterion : on the figure
    calm : value in a calm sea; None: that of CALM
    """
    height, value = 0.0, CALM.get(criterion.kpi, 0.0) if calm is None else calm
    for next_height, next_value in zip(heights, values, strict=True):
        if math.isnan(next_value):
            return height  # such a case is lost, which ends the limit anyhow
        if not criterion.is_met(float(next_value)):
            if not criterion.is_met(value):
                return height  # not even a calm sea allows it
            share = (criterion.bound - value) / (next_value - value) if next_value != value else 0.0
            return float(height + (next_height - height) * min(max(share, 0.0), 1.0))
        height, value = next_height, next_value
    return math.inf


def _last_before(heights: Array, gone: Array) -> float:
    """Return the last height before the first case that is lost; infinite where none is."""
    first = np.flatnonzero(gone)
    if not first.size:
        return math.inf
    return float(heights[first[0] - 1]) if first[0] else 0.0


def title_of(name: str) -> str:
    """Return what limits, by the `name` of a figure of merit or `LOST_LIMIT`, in words."""
    return DEFINITION_OF[name].title if name in DEFINITION_OF else name


@dataclass(frozen=True)
class Bisection:
    """Heights between those of the grid (`heave_studies.study.plan.Refinement`), compensated and locked."""

    criteria: Mapping[str, Sequence[Criterion]]  # that are to hold, by phase of a lift; "": there are none
    within: float  # distance of the two heights that enclose a limit, at most [m]

    def size(self, cases: Sequence[Case]) -> int:
        """Number of cases, at most: two limits for each seed, both in the widest step of the grid."""
        heights = sorted({0.0, *(float(str(case.settings[HEIGHT])) for case in cases)})
        widest = max(high - low for low, high in itertools.pairwise(heights))
        rounds = max(math.ceil(math.log2(widest / self.within)), 0)
        return len(cases) + 2 * rounds * len({(case.seed, *_but_height(case)) for case in cases})

    def more(self, cases: Sequence[Case], frame: pandas.DataFrame) -> list[More]:
        """Return the heights in the middle of where limits are known to be, by the `frame` of all `cases`."""
        found: list[More] = []
        for rows in alike(frame, HEIGHT):
            part, first = frame.iloc[rows], cases[rows[0]]
            heights = sorted(part[HEIGHT].to_numpy(dtype=float).tolist())
            criteria = self.criteria[str(first.settings.get(PHASE, ""))]
            limits = [seed_limit(part, criteria, locked=locked).height for locked in (False, True)]
            middles = {self._middle(heights, limit) for limit in limits} - {None}
            found += [(first.seed, {**first.settings, HEIGHT: middle}) for middle in sorted(middles)]  # type: ignore[type-var]
        return found

    def _middle(self, heights: Sequence[float], limit: float) -> float | None:
        """Return the middle of the two `heights` that enclose a `limit` [m]; None where they are near, or none is."""
        above = next((height for height in heights if height > limit), None)
        if above is None:
            return None
        below = max((height for height in heights if height <= limit), default=0.0)
        return 0.5 * (below + above) if above - below > self.within * (1.0 + 1e-9) else None

    def words(self, _: pandas.DataFrame) -> str:
        """Return what was done, in a line."""
        return f"Each seed's limit is enclosed within {self.within:g} m of Hs by bisection, in the same waves."


def _but_height(case: Case) -> list[str]:
    return [f"{name}={value}" for name, value in case.settings.items() if name != HEIGHT]
