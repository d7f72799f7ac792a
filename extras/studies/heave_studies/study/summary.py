"""What the cases of a study came to: their table and summary for people, and both for a machine.

Shares have Wilson's interval (Journal of the American Statistical Association 22, 1927), other figures that of the
bootstrap (Efron, Annals of Statistics 7, 1979): so many cases, and not more, were run.

Spearman's rank correlation asks for no straight line, and a lost case with a huge figure counts as no more than the
worst. A parameter whose confidence interval (Fisher's z with the variance 1.06 / (n - 3) for ranks: Fieller, Hartley
and Pearson, Biometrika 44, 1957) holds 0 has not shown any influence.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas
from heave_bags.analyse import kpi_set
from heave_bringup.output import FittedTable
from heave_bringup.run.criteria import LAW
from heave_node import kpi
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from heave_node.parameters import ParameterError
from scipy import stats

from heave_studies.study.case_file import CASE
from heave_studies.study.plan import Case
from heave_studies.study.sampling import SALTELLI, Draws, problem
from heave_studies.study.table import (
    LOST,
    MET,
    MISSED,
    NOMINAL,
    OUTCOME,
    REASON,
    SCREENED,
    SEED,
    SILENT,
    SILENT_START,
    settings_of,
)
from heave_studies.study.workers import FAILURE, optional

SHOWN = {
    "unit_sigma_m": "load",
    "uncompensated_sigma_m": "locked",
    "unit_efficiency": "effic.",
    "rope_safety_factor": "rope",
    "time_at_limit_percent": "at limit",
    "winch_speed_max_mps": "speed",
    "max_abs_heave_m": "max",
    "uncompensated_max_abs_heave_m": "locked max",
    "tension_max_n": "Tmax",
    "tension_min_n": "Tmin",
    "dynamic_amplification": "DAF",
    "uncompensated_dynamic_amplification": "DAF locked",
}
"""Figures of merit in the table for people, with their headings, the weightiest first; all of them are in files."""
ALWAYS = 3
"""Least number of columns of figures, however narrow the terminal."""

SUMMARY = {
    "cases": "cases",
    "failed": "cases that could not be run",
    "judged": "cases that were judged",
    "lost": "cases in which compensation was lost",
    "met": "cases that met all criteria",
    "snaps": "snaps",
    "snaps_uncompensated": "snaps, winch locked",
    "unit_sigma_m_median": "load heave, standard deviation: median of the cases",
    "unit_sigma_m_p90": "load heave, standard deviation: 90th percentile",
    "unit_sigma_m_max": "load heave, standard deviation: largest",
    "unit_sigma_m_nominal": "load heave, standard deviation: nominal case",
    "p90_over_nominal": "load heave, 90th percentile over nominal case",
    "worse": "load heave, largest ratio to winch locked",
}
"""Rows of the summary, by their key in JSON: counts, then motion, then ratios."""
MOST_REMARKS = 20
"""Cases of which the lines below the table say what went wrong."""
MOST_GROUPS = 8
"""Values of a parameter that the summary has a column for."""

SELDOM_KNOWN = ("rope_safety_factor",)
"""Columns that are omitted where no case has a value."""


def to_json(frame: pandas.DataFrame) -> dict[str, object]:
    """Return everything that the cases of a `frame` gave, for a machine."""
    return {
        "cases": [_case_content(row, settings_of(frame)) for row in frame.to_dict("records")],
        "summary": summarise(frame),
        "summary_by_law": summaries_by_law(frame),
    }


def _case_content(row: dict[object, object], settings: list[str]) -> dict[str, object]:
    kpis = {key: float(row[key]) for key in kpi_set.DEFINITION_OF}  # type: ignore[arg-type]
    head: dict[str, object] = {name: row[name] for name in (CASE, SEED, NOMINAL)}
    given = {name: _plain(row[name]) for name in settings if row[name] is not None}
    if row[FAILURE]:
        return {**head, **given, FAILURE: row[FAILURE]}
    outcome = {name: row[name] for name in (*OUTCOME, SILENT, SILENT_START)}
    return {**head, **given, **outcome, **kpi_set.to_json(kpis)}


def _plain(value: object) -> object:
    """Return a `value` of a table as JSON holds it: lists come from files as arrays."""
    return value.tolist() if isinstance(value, np.ndarray) else value


def summarise(frame: pandas.DataFrame) -> dict[str, float]:
    """Return what the cases of a `frame` come to together, nominal ones apart."""
    drawn = frame[~frame[NOMINAL]]
    good = drawn[drawn[FAILURE] == ""]
    counts = {"cases": float(len(drawn)), "failed": float(len(drawn) - len(good)), "judged": float(len(good))}
    if good.empty:
        return counts
    unit = good["unit_sigma_m"]
    p90 = float(np.percentile(unit, 90)) if len(unit) >= FEWEST_CASES else None
    return {
        **counts,
        "lost": float(good[LOST].sum()),
        "met": float(good[MET].sum()),
        "unit_sigma_m_median": float(unit.median()),
        **({} if p90 is None else {"unit_sigma_m_p90": p90}),
        "unit_sigma_m_max": float(unit.max()),
        **_against_nominal(frame, p90),
        "worse": kpi.worse(unit, good["uncompensated_sigma_m"]),
        "snaps": float(good["snaps"].sum()),
        "snaps_uncompensated": float(good["uncompensated_snaps"].sum()),
    }


def _against_nominal(frame: pandas.DataFrame, p90: float | None) -> dict[str, float]:
    """Return the nominal cases' unit sigma (root mean square) and the others' 90th percentile over it."""
    sigmas = frame.loc[frame[NOMINAL] & (frame[FAILURE] == ""), "unit_sigma_m"]
    if sigmas.empty:
        return {}
    nominal = float(np.sqrt(np.mean(np.square(sigmas))))
    return {"unit_sigma_m_nominal": nominal, **({} if p90 is None else {"p90_over_nominal": p90 / nominal})}


def case_table(frame: pandas.DataFrame) -> FittedTable:
    """Return a row for each case of a `frame`: unit and uncompensated motion, tension, use of the winch."""
    keys = [key for key in SHOWN if key not in SELDOM_KNOWN or frame[key].notna().any()]
    headings = [f"{SHOWN[key]} {kpi_set.DEFINITION_OF[key].unit}".strip() for key in keys]
    columns = ["no.", "case", *headings, "remark"]
    settings = settings_of(frame)
    rows = [_cells(row, settings, keys) for row in frame.to_dict("records")]
    where = "a wider terminal has room for them, table.csv has all figures"
    return FittedTable(columns, rows, ["case", "remark"], headings[ALWAYS:], where)


def _cells(row: dict[object, object], settings: list[str], keys: list[str]) -> list[str]:
    label = Case(
        int(row[CASE]),  # type: ignore[call-overload]
        int(row[SEED]),  # type: ignore[call-overload]
        {place: row[place] for place in settings},
        bool(row[NOMINAL]),
    ).label
    head = [str(row[CASE]), label]
    if row[FAILURE]:
        return [*head, *[""] * len(keys), "failed"]
    values = {key: float(row[key]) for key in keys}  # type: ignore[arg-type]
    remark = "lost" if row[LOST] else "missed" if row[MISSED] else "screened" if row.get(SCREENED) else ""
    cells = [kpi_set.DEFINITION_OF[key].text(value) for key, value in values.items()]
    return [*head, *cells, remark]


def remarks(frame: pandas.DataFrame) -> list[str]:
    """Return the lines below the table of a `frame` that say why cases failed, were lost or missed a criterion."""
    found = []
    for row in frame.to_dict("records"):
        lost = f"lost: {row[REASON]}" if row[LOST] else row[MISSED]
        text = f"failed: {row[FAILURE]}" if row[FAILURE] else lost
        found += [f"case {row[CASE]}: {text}"] if text else []
    more = f"and {len(found) - MOST_REMARKS} cases more, see table.csv"
    return [*found[:MOST_REMARKS], *([more] if len(found) > MOST_REMARKS else [])]


def summary_rows(frame: pandas.DataFrame) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of what the cases of a `frame` come to together; by law, where it varies.

    A law is not a case of another: figures over several of them together would mean nothing.
    """
    names = list(summaries_by_law(frame))
    parts = {name: frame[frame[LAW].astype(str) == name] for name in names} or {"value": frame}
    groups = {name: summarise(part) for name, part in parts.items()}
    rows = []
    for key, words in SUMMARY.items():
        if any(key in found for found in groups.values()):
            cells = [_summary_text(key, found[key]) if key in found else "-" for found in groups.values()]
            rows.append([words, *cells, _SIGMA.unit if key.startswith(_SIGMA.key) else ""])
    for words, of, unit in WIDTHS:
        cells = [of(part) for part in parts.values()]
        rows += [[words, *cells, unit]] if set(cells) != {"-"} else []
    return ["all cases", *groups, "unit"], rows


CONFIDENCE = 0.9
"""Two-sided."""
RESAMPLES = 400
STREAM = "study/bootstrap"
"""Name of the random stream of the resamples."""


def wilson(count: int, of: int) -> tuple[float, float]:
    """Return the confidence interval of a share: `count` of so many cases (`of`), Wilson's [-]."""
    if not of:
        return 0.0, 1.0
    z = float(stats.norm.ppf(0.5 + 0.5 * CONFIDENCE))
    middle = (count + 0.5 * z**2) / (of + z**2)
    half = z / (of + z**2) * math.sqrt(count * (of - count) / of + 0.25 * z**2)
    return max(middle - half, 0.0), min(middle + half, 1.0)


FEWEST_SEEDS = 3
"""Values from which on a spread is stated: of two, Student's t gives 4.5 standard deviations, which say nothing."""


def half_width(values: Array) -> float:
    """Return half the confidence interval of a mean, Student's, of `values` (n,); NaN for fewer than FEWEST_SEEDS."""
    if values.size < FEWEST_SEEDS:
        return math.nan
    quantile = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, values.size - 1))
    return quantile * float(values.std(ddof=1)) / math.sqrt(values.size)


def bootstrap(values: Array, figure: Callable[[Array], float]) -> tuple[float, float]:
    """Return the confidence interval of a `figure` of a sample, `values` of shape (n,), by resampling it."""
    random = random_stream(1, STREAM)
    found = [figure(random.choice(values, values.size)) for _ in range(RESAMPLES)]
    low, high = np.quantile(found, (0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE))
    return float(low), float(high)


def _judged(frame: pandas.DataFrame) -> pandas.DataFrame:
    return frame[~frame[NOMINAL] & (frame[FAILURE] == "")]


def _met_width(frame: pandas.DataFrame) -> str:
    good = _judged(frame)
    return "{:.0f} to {:.0f}".format(*(100.0 * end for end in wilson(int(good[MET].sum()), len(good))))


def _p90_width(frame: pandas.DataFrame) -> str:
    values = _judged(frame)[_SIGMA.key].dropna().to_numpy(dtype=float)
    if values.size < FEWEST_CASES:
        return "-"
    ends = bootstrap(values, lambda sample: float(np.percentile(sample, 90)))
    return " to ".join(map(_SIGMA.text, ends))


_SIGMA = kpi_set.DEFINITION_OF["unit_sigma_m"]
WIDTHS: tuple[tuple[str, Callable[[pandas.DataFrame], str], str], ...] = (
    ("cases that met all criteria: share, 90 % confidence", _met_width, "%"),
    ("load heave, standard deviation: 90th percentile, 90 % confidence", _p90_width, _SIGMA.unit),
)
"""Rows of the summary that say how sure it is."""


def _summary_text(key: str, value: float) -> str:
    return _SIGMA.text(value) if key.startswith(_SIGMA.key) else f"{value:.3f}".rstrip("0").rstrip(".")


def summaries_by_law(frame: pandas.DataFrame) -> dict[str, dict[str, float]]:
    """Return what the cases of a `frame` under each law come to, by law; empty where the law does not vary."""
    if LAW not in settings_of(frame):
        return {}
    laws = frame[LAW].astype(str)
    names = list(dict.fromkeys(laws[~frame[NOMINAL]]))
    return {name: summarise(frame[laws == name]) for name in names} if 1 < len(names) <= MOST_GROUPS else {}


FEWEST_CASES = 10
"""Cases of which a 90th percentile, and what matters, can be stated."""
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
    return ["what matters", "rank correlation", "90 % confidence", *heads, "influence"], rows


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
    analyse = optional("SALib.analyze.sobol", "Sobol' indices", "sensitivity").analyze
    found = analyse(problem(len(draws.names)), values, calc_second_order=False, seed=draws.seed)
    return {
        name: (float(first), float(total))
        for name, first, total in zip(draws.names, found["S1"], found["ST"], strict=True)
    }
