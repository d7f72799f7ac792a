"""`heave campaign`: many cases of a scenario, one table."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence

import numpy as np
from heave_bags import kpi
from heave_node.parameters import ParameterError

from heave_bringup.campaign import find_campaign, read_campaign
from heave_bringup.campaign_runs import CaseResult, run_cases
from heave_bringup.output import write_result
from heave_bringup.progress import ProgressLine


def execute(options: argparse.Namespace) -> None:
    """Run every case and print unit sigma, uncompensated sigma, tension and winch use of each, then the summary."""
    if options.processes < 0:
        raise ParameterError(f"--processes {options.processes}: must be at least 1, or 0 for one per processor")
    campaign = read_campaign(find_campaign(options.campaign))
    cases = list(campaign.cases())
    progress = ProgressLine()
    results: list[CaseResult] = []
    try:
        for result in run_cases(campaign, cases, options.processes or None):
            results.append(result)
            progress.show(f"case {len(results)} of {len(cases)}: {result.case.label}")
    finally:
        progress.close()
    results.sort(key=lambda result: result.case.number)
    summary = _summary(results)
    content = {
        "campaign": str(campaign.path),
        "scenario": campaign.scenario,
        "cases": [{"seed": r.case.seed, **r.case.settings, "failure": r.failure, **r.kpis} for r in results],
        "summary": summary,
    }
    write_result(options, _table(results) + "\n\n" + _summary_text(summary), content)


def _summary(results: Sequence[CaseResult]) -> dict[str, float]:
    good = [result.kpis for result in results if not result.failure]
    unit = np.array([k["unit_sigma_m"] for k in good])
    off = np.array([k["uncompensated_sigma_m"] for k in good])
    if not good:
        return {"cases": float(len(results)), "failed": float(len(results))}
    return {
        "cases": float(len(results)),
        "failed": float(len(results) - len(good)),
        "unit_sigma_m_median": float(np.median(unit)),
        "unit_sigma_m_p90": float(np.percentile(unit, 90)),
        "unit_sigma_m_max": float(unit.max()),
        "worse": kpi.worse(unit, off),
        "snaps": float(np.nansum([k["snaps"] for k in good])),
    }


def _table(results: Sequence[CaseResult]) -> str:
    width = max(len(result.case.label) for result in results)
    lines = [f"{'case'.ljust(width)}  unit cm   off cm   ratio  Tmin kN  Tmax kN  speed m/s  at limit %"]
    for result in results:
        if result.failure:
            lines.append(f"{result.case.label.ljust(width)}  {result.failure}")
            continue
        k = result.kpis
        ratio = k["unit_sigma_m"] / k["uncompensated_sigma_m"] if k["uncompensated_sigma_m"] > 0.0 else math.nan
        lines.append(
            f"{result.case.label.ljust(width)} {100 * k['unit_sigma_m']:8.3f} {100 * k['uncompensated_sigma_m']:8.2f} "
            f"{ratio:7.4f} {k['tension_min_n'] / 1e3:8.1f} {k['tension_max_n'] / 1e3:8.1f} "
            f"{k['winch_speed_max_mps']:10.3f} {k['time_at_limit_percent']:11.2f}"
        )
    return "\n".join(lines)


def _summary_text(summary: dict[str, float]) -> str:
    return "\n".join(f"{name.ljust(22)} {value:.6g}" for name, value in summary.items())
