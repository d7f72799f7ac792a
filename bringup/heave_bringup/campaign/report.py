"""What a campaign came to: its table, its summary, and both for a machine."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from heave_bags.analyse import kpi_set
from heave_node import kpi
from rich.table import Table

from heave_bringup.campaign.plan import Campaign
from heave_bringup.campaign.runs import CaseResult
from heave_bringup.output import make_table

COLUMNS = (
    *("case", "unit cm", "off cm", "ratio", "max cm", "off max cm", "DAF", "DAF off", "Tmin kN", "Tmax kN"),
    *("speed m/s", "at limit %", "remark"),
)


def to_json(campaign: Campaign, results: Sequence[CaseResult]) -> dict[str, object]:
    """Return everything that a campaign gave, for a machine.

    Parameters
    ----------
    campaign : that was run
    results : of its cases, in their order
    """
    return {
        "campaign": str(campaign.path),
        "scenario": campaign.scenario,
        "cases": [_case_content(result) for result in results],
        "summary": summarise(results),
    }


def _case_content(result: CaseResult) -> dict[str, object]:
    case = result.case
    content: dict[str, object] = {"seed": case.seed, "nominal": case.is_nominal, **case.settings}
    if result.failure:
        return {**content, "failure": result.failure}
    return {
        **content,
        "failure": "",
        "compensating_share": result.compensating,
        "lost": result.is_lost,
        **kpi_set.to_json(result.kpis),
    }


def summarise(results: Sequence[CaseResult]) -> dict[str, float]:
    """Return what the cases come to together, nominal ones apart."""
    drawn = [result for result in results if not result.case.is_nominal]
    good = [result for result in drawn if not result.failure]
    counts = {"cases": float(len(drawn)), "failed": float(len(drawn) - len(good))}
    if not good:
        return counts
    unit = np.array([result.kpis["unit_sigma_m"] for result in good])
    off = np.array([result.kpis["uncompensated_sigma_m"] for result in good])
    p90 = float(np.percentile(unit, 90))
    return {
        **counts,
        "lost": float(sum(result.is_lost for result in good)),
        "unit_sigma_m_median": float(np.median(unit)),
        "unit_sigma_m_p90": p90,
        "unit_sigma_m_max": float(unit.max()),
        **_against_nominal(results, p90),
        "worse": kpi.worse(unit, off),
        "snaps": float(np.nansum([result.kpis["snaps"] for result in good])),
        "snaps_uncompensated": float(np.nansum([result.kpis["uncompensated_snaps"] for result in good])),
    }


def _against_nominal(results: Sequence[CaseResult], p90: float) -> dict[str, float]:
    """Return the nominal cases' unit sigma (root mean square) and the others' 90th percentile over it."""
    sigmas = [r.kpis["unit_sigma_m"] for r in results if r.case.is_nominal and not r.failure]
    if not sigmas:
        return {}
    nominal = float(np.sqrt(np.mean(np.square(sigmas))))
    return {"unit_sigma_m_nominal": nominal, "p90_over_nominal": p90 / nominal}


def case_table(results: Sequence[CaseResult]) -> Table:
    """Return a row for each case: unit and uncompensated motion, tension, use of the winch."""
    return make_table(COLUMNS, [_row(result) for result in results], texts=["remark"])


def summary_table(results: Sequence[CaseResult]) -> Table:
    """Return what the cases come to together."""
    return make_table(["all cases", "value"], [[name, f"{value:.6g}"] for name, value in summarise(results).items()])


def _row(result: CaseResult) -> list[str]:
    if result.failure:
        return [result.case.label, *[""] * (len(COLUMNS) - 2), result.failure]
    k = result.kpis
    ratio = k["unit_sigma_m"] / k["uncompensated_sigma_m"] if k["uncompensated_sigma_m"] > 0.0 else math.nan
    return [
        result.case.label,
        f"{100 * k['unit_sigma_m']:.3f}",
        f"{100 * k['uncompensated_sigma_m']:.2f}",
        f"{ratio:.4f}",
        f"{100 * k['max_abs_heave_m']:.2f}",
        f"{100 * k['uncompensated_max_abs_heave_m']:.1f}",
        f"{k['dynamic_amplification']:.2f}",
        f"{k['uncompensated_dynamic_amplification']:.2f}",
        f"{k['tension_min_n'] / 1e3:.1f}",
        f"{k['tension_max_n'] / 1e3:.1f}",
        f"{k['winch_speed_max_mps']:.3f}",
        f"{k['time_at_limit_percent']:.2f}",
        f"lost: compensating {100 * result.compensating:.0f} % of the time" if result.is_lost else "",
    ]
