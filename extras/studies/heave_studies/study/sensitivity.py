"""What matters: which of the drawn parameters a figure of merit follows, as a table.

Spearman's rank correlation asks for no straight line, and a lost case with a huge figure counts as no more than the
worst. A parameter whose confidence interval (Fisher's z with the variance 1.06 / (n - 3) for ranks: Fieller, Hartley
and Pearson, Biometrika 44, 1957) holds 0 has not shown any influence.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas
from heave_bags.analyse import kpi_set
from heave_node.parameters import ParameterError
from scipy import stats

from heave_studies.study.sampling import SALTELLI, Draws, load_salib, problem
from heave_studies.study.table import NOMINAL, settings_of
from heave_studies.study.workers import FAILURE

FEWEST_CASES = 10
CONFIDENCE = 0.9
"""Two-sided."""
SPREAD = 1.06
"""Variance of Fisher's z of ranks, times n - 3."""


@dataclass(frozen=True)
class Influence:
    """How much a figure follows a parameter."""

    place: str  # of the parameter
    correlation: float  # Spearman's, -1 to 1 [-]
    low: float  # lower end of its confidence interval [-]
    high: float  # upper end of its confidence interval [-]
    at_low: float  # median of the figure in the lowest quarter of the parameter, SI
    at_high: float  # the same in the highest quarter [-]

    @property
    def is_shown(self) -> bool:
        """Whether the cases show any influence."""
        return self.low > 0.0 or self.high < 0.0


def influences(frame: pandas.DataFrame, kpi: str) -> list[Influence]:
    """Return the influence of each parameter that is a number, the strongest first.

    Parameters
    ----------
    frame : cases of a campaign, drawn at random
    kpi : key of the figure of merit

    Raises ParameterError for fewer than FEWEST_CASES cases, and where no number was varied.
    """
    good = frame[(frame[FAILURE] == "") & ~frame[NOMINAL] & np.isfinite(frame[kpi])]
    if len(good) < FEWEST_CASES:
        raise ParameterError(f"{len(good)} cases with {kpi}: what matters needs {FEWEST_CASES} and more")
    found = [_influence(good, place, kpi) for place in settings_of(frame) if _is_varied(good[place])]
    if not found:
        raise ParameterError("no parameter was varied that is a number: what matters needs a study with draw or vary")
    return sorted(found, key=lambda one: -abs(one.correlation))


def _is_varied(column: pandas.Series) -> bool:
    is_number = pandas.api.types.is_numeric_dtype(column) and not pandas.api.types.is_bool_dtype(column)
    return bool(is_number and column.nunique() > 1)


def _influence(good: pandas.DataFrame, place: str, kpi: str) -> Influence:
    values, figure = good[place].to_numpy(dtype=float), good[kpi].to_numpy(dtype=float)
    is_flat = float(np.ptp(figure)) == 0.0
    correlation = 0.0 if is_flat else float(stats.spearmanr(values, figure).statistic)
    half = float(stats.norm.ppf(0.5 + 0.5 * CONFIDENCE)) * math.sqrt(SPREAD / (len(good) - 3))
    z = math.atanh(min(max(correlation, -1.0 + 1e-12), 1.0 - 1e-12))
    low, high = np.quantile(values, (0.25, 0.75))
    return Influence(
        place,
        correlation,
        min(math.tanh(z - half), correlation),  # at -1 and 1, where z is cut, it is the end itself
        max(math.tanh(z + half), correlation),
        float(np.median(figure[values <= low])),
        float(np.median(figure[values >= high])),
    )


def influence_rows(found: Sequence[Influence], kpi: str) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of what matters.

    Parameters
    ----------
    found : as `influences` gives it
    kpi : key of the figure of merit
    """
    definition = kpi_set.DEFINITION_OF[kpi]
    heads = [
        f"{definition.title}, {where} {definition.unit}".strip() for where in ("lowest quarter", "highest quarter")
    ]
    rows = [
        [
            one.place,
            f"{one.correlation:+.2f}",
            f"{one.low:+.2f} to {one.high:+.2f}",
            definition.text(one.at_low),
            definition.text(one.at_high),
            "" if one.is_shown else "none shown",
        ]
        for one in found
    ]
    return ["what matters", "rank correlation", "90 % sure", *heads, "influence"], rows


def sobol_indices(draws: Draws, frame: pandas.DataFrame, kpi: str) -> dict[str, tuple[float, float]]:
    """Return the first-order and the total Sobol' index of each parameter: shares of the variance that it explains.

    Parameters
    ----------
    draws : of the study, by Saltelli's method
    frame : their cases, one seed each, in their order
    kpi : key of the figure of merit

    Raises ParameterError for other draws, and where a case gives no figure.
    """
    values = frame.loc[~frame[NOMINAL], kpi].to_numpy(dtype=float)
    if draws.method != SALTELLI or len(values) != len(draws.points()) or not np.isfinite(values).all():
        raise ParameterError("Sobol' indices need every case of draws by method saltelli, with one seed")
    analyse = load_salib("Sobol' indices").analyze.sobol.analyze
    found = analyse(problem(len(draws.names)), values, calc_second_order=False, seed=draws.seed)
    return {
        name: (float(first), float(total))
        for name, first, total in zip(draws.names, found["S1"], found["ST"], strict=True)
    }
