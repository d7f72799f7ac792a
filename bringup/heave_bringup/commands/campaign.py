"""`heave campaign`: many cases of a scenario, one table."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence

import numpy as np
from heave_bags.analyse import kpi_set
from heave_node import kpi
from heave_node.parameters import ParameterError

from heave_bringup.campaign.plan import find_campaign, read_campaign
from heave_bringup.campaign.runs import CaseResult, run_cases
from heave_bringup.output import write_result
from heave_bringup.progress import ProgressLine


def execute(options: argparse.Namespace) -> None:
    """Run every case and print unit sigma, uncompensated sigma, tension and winch use of each, then the summary."""
    if options.processes is not None and options.processes < 1:
        raise ParameterError(f"--processes {options.processes}: must be at least 1")
    if options.draws is not None and options.draws < 1:
        raise ParameterError(f"--draws {options.draws}: must be at least 1")
    campaign = read_campaign(find_campaign(options.campaign))
    campaign = campaign.shortened(duration=options.duration, draws=options.draws)
    cases = list(campaign.cases())
    progress = ProgressLine()
    results: list[CaseResult] = []
    try:
        progress.show(f"{len(cases)} cases of {campaign.scenario}")
        for result in run_cases(campaign, cases, options.processes):
            results.append(result)
            progress.show(f"case {len(results)} of {len(cases)}: {result.case.label}")
    finally:
        progress.close()
    results.sort(key=lambda result: result.case.number)
    summary = _summary(results)
    content = {
        "campaign": str(campaign.path),
        "scenario": campaign.scenario,
        "cases": [_case_content(result) for result in results],
        "summary": summary,
    }
    write_result(options, _table(results) + "\n\n" + _summary_text(summary), content)


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


def _summary(results: Sequence[CaseResult]) -> dict[str, float]:
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


def _table(results: Sequence[CaseResult]) -> str:
    width = max(len(result.case.label) for result in results)
    lines = [
        f"{'case'.ljust(width)}  unit cm   off cm   ratio   max cm  off max cm   DAF  DAF off  Tmin kN  Tmax kN  "
        "speed m/s  at limit %"
    ]
    for result in results:
        if result.failure:
            lines.append(f"{result.case.label.ljust(width)}  {result.failure}")
            continue
        k = result.kpis
        ratio = k["unit_sigma_m"] / k["uncompensated_sigma_m"] if k["uncompensated_sigma_m"] > 0.0 else math.nan
        lines.append(
            f"{result.case.label.ljust(width)} {100 * k['unit_sigma_m']:8.3f} {100 * k['uncompensated_sigma_m']:8.2f} "
            f"{ratio:7.4f} {100 * k['max_abs_heave_m']:8.2f} "
            f"{100 * k['uncompensated_max_abs_heave_m']:11.1f} {k['dynamic_amplification']:5.2f} "
            f"{k['uncompensated_dynamic_amplification']:8.2f} "
            f"{k['tension_min_n'] / 1e3:8.1f} {k['tension_max_n'] / 1e3:8.1f} "
            f"{k['winch_speed_max_mps']:10.3f} {k['time_at_limit_percent']:11.2f}"
            + (f"  lost: compensating {100 * result.compensating:.0f} % of the time" if result.is_lost else "")
        )
    return "\n".join(lines)


def _summary_text(summary: dict[str, float]) -> str:
    return "\n".join(f"{name.ljust(22)} {value:.6g}" for name, value in summary.items())
