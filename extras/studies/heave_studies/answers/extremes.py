"""The largest motion and tension to be expected in some hours of the same sea, from seeds of it.

The largest value of each seed is the maximum of a block; maxima of blocks follow a generalised extreme-value
distribution, which gives the largest value of any time (Coles, An Introduction to Statistical Modeling of Extreme
Values, 2001, chapter 3). Fitted, by the package `pyextremes`, is Gumbel's to the squares of deviations from the mean:
crests of a narrow-banded Gaussian motion are Rayleigh, so their squares are exponential and converge at once (Cook,
Journal of Wind Engineering and Industrial Aerodynamics 9, 1982, for wind speeds).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np
import pandas
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from heave_node.sheet import Column, Sheet

from heave_studies.answers.answer import Ask, Found, Section, first_scenario, number_in
from heave_studies.study.plan import Study
from heave_studies.study.summary import CONFIDENCE
from heave_studies.study.table import SEED, settings_of
from heave_studies.study.workers import FAILURE, optional

PYEXTREMES = partial(optional, "pyextremes", "extremes", "extremes")
"""Gives the package of the fit; raises ParameterError where it is missing."""
KEYS: Mapping[str, object] = MappingProxyType({"hours": 3.0})
"""Time in the same sea [h]; three are a stationary sea state, as design codes take it."""
FEWEST_SEEDS, MANY_SEEDS = 5, 20
"""Seeds of a sea from which its extremes are estimated, and from which on a fit is not to be taken with caution."""
LARGEST_EXTENSION = 20.0
"""Time that is extrapolated to, over that of all seeds, beyond which caution is due."""
FLAT = 1e-9
"""Largest value [SI] of what does not move: nothing is fitted to it."""
QUANTITIES = (
    ("load heave about its mean [cm]", 100.0, "", "max_abs_heave_m", 1.0),
    ("uncompensated heave about its mean [cm]", 100.0, "", "uncompensated_max_abs_heave_m", 1.0),
    ("top tension, largest [kN]", 1e-3, "tension_mean_n", "tension_max_n", 1.0),
    ("top tension, smallest [kN]", 1e-3, "tension_mean_n", "tension_min_n", -1.0),
)
"""Heading, scale from SI, figure of the mean, figure of the extreme, and the side on which that lies."""


@dataclass(frozen=True)
class Expected:
    """What is to be expected of a quantity."""

    name: str  # heading, with the unit
    scale: float  # from SI to that unit
    seen: float  # extreme of all seeds, SI
    most_probable: tuple[float, float, float]  # value and ends of its confidence interval, SI
    p90: tuple[float, float, float]  # the same of the 90th percentile: 1 in 10 is beyond

    def range(self, of: str) -> str:
        """Return the confidence interval of most_probable or p90 (`of`), as people see it."""
        _, *ends = getattr(self, of)
        return " to ".join(f"{self.scale * end:.2f}" for end in sorted(ends))


SHEET = Sheet(
    Column("in the same sea", "name", "name"),
    Column("seen", lambda one: one.scale * one.seen, "", ".2f"),
    Column("most probable", lambda one: one.scale * one.most_probable[0], "", ".2f"),
    Column("90 % confidence", lambda one: one.range("most_probable")),
    Column("1 in 10 beyond", lambda one: one.scale * one.p90[0], "", ".2f"),
    Column("90 % confidence ", lambda one: one.range("p90")),
    *(Column("", name, name) for name in ("seen", "most_probable", "p90")),
)


def prepare(study: Study, ask: Ask, /) -> Study:
    """See `heave_studies.answers.answer.Answer`."""
    PYEXTREMES()
    hours = number_in(ask, "hours")
    if not 0.0 < hours < math.inf:
        raise ParameterError(f"ask: hours = {hours:g}: must be a number above 0")
    if len(study.seeds) < FEWEST_SEEDS:
        raise ParameterError(
            f"{study.path}: seeds: {len(study.seeds)} seeds tell no extremes: {FEWEST_SEEDS} at least, "
            f"{MANY_SEEDS} make a fit"
        )
    return study


def answer(study: Study, frame: pandas.DataFrame, ask: Ask, /) -> Found:
    """See `heave_studies.answers.answer.Answer`."""
    hours, run = number_in(ask, "hours"), first_scenario(study).run
    block = (run.duration - run.transient) / 3600.0
    good, settings = frame[frame[FAILURE] == ""], settings_of(frame)
    groups = [("all seeds", good)]
    if settings:
        parts_of = good.groupby([good[name].astype(str) for name in settings], sort=False)
        groups = [(", ".join(map(str, key if isinstance(key, tuple) else (key,))), part) for key, part in parts_of]
    sections, seas, judged = [], [], 0
    for name, part in groups:
        count = part[SEED].nunique()
        expected = [] if count < FEWEST_SEEDS else expected_in(part, block, hours)
        judged += len(part) if expected else 0
        title = f"{name}: largest in {hours:g} h, from {count} seeds of {60.0 * block:.3g} min"
        cautions = _cautions(count, block, hours)
        sections.append(Section(title, SHEET.headings, SHEET.cells(expected), notices=cautions))
        seas.append({"sea": name, "expected": SHEET.records(expected)})
    return Found(sections, {"hours": hours, "seas": seas}, judged=judged)


def _cautions(seeds: int, block: float, hours: float) -> list[str]:
    words = []
    if seeds < MANY_SEEDS:
        words.append(f"only {seeds} seeds: the interval is too narrow; {MANY_SEEDS} and more make a fit")
    if hours > LARGEST_EXTENSION * seeds * block:
        words.append(f"{hours:g} h from {60.0 * seeds * block:.3g} min: run longer, or more seeds")
    return words


def expected_in(part: pandas.DataFrame, block: float, hours: float) -> list[Expected]:
    """Return what the seeds of one sea let one expect.

    Parameters
    ----------
    part : their rows of the table
    block : time that counts of each [h]
    hours : of the time that is asked for
    """
    found = []
    for name, scale, of_mean, of_extreme, side in QUANTITIES:
        values = part[of_extreme].to_numpy(dtype=float)
        centre = float(part[of_mean].mean()) if of_mean else 0.0
        deviations = side * (values - (part[of_mean].to_numpy(dtype=float) if of_mean else 0.0))
        if not np.isfinite(deviations).all() or float(np.ptp(deviations)) < FLAT:
            continue
        most_probable, p90 = (
            [centre + side * math.sqrt(max(square, 0.0)) for square in one]
            for one in largest_squares(np.square(deviations), hours / block)
        )
        if side < 0.0:  # a cable cannot push
            most_probable, p90 = ([max(value, 0.0) for value in one] for one in (most_probable, p90))
        seen = float(values.max() if side > 0.0 else values.min())
        found.append(Expected(name, scale, seen, tuple(most_probable), tuple(p90)))  # type: ignore[arg-type]
    return found


def largest_squares(squares: Array, blocks: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the most probable largest value in a time, and its 90th percentile, each with its confidence interval.

    The most probable one is exceeded once in that time by Gumbel's distribution: by a single block with the probability
    1 - exp(-1 / blocks); the percentile with 1 - 0.9^(1 / blocks).

    Parameters
    ----------
    squares : maxima of blocks, shape (n,)
    blocks : that the time holds
    """
    series = pandas.Series(squares, index=pandas.date_range("2000-01-01", periods=squares.size, freq="D"))
    module = PYEXTREMES()
    fit = module.EVA.from_extremes(extremes=series, method="BM", extremes_type="high", block_size="1D")
    fit.fit_model(model="MLE", distribution="gumbel_r")
    periods = (1.0 / -math.expm1(-1.0 / blocks), 1.0 / (1.0 - 0.9 ** (1.0 / blocks)))
    state = np.random.get_state()  # noqa: NPY002 - the package resamples by it
    np.random.seed(1)  # noqa: NPY002
    try:
        values = [fit.get_return_value(one, return_period_size="1D", alpha=CONFIDENCE) for one in periods]
    finally:
        np.random.set_state(state)  # noqa: NPY002
    first, second = (tuple(float(np.squeeze(part)) for part in value) for value in values)
    return first, second
