"""Results of entrants on cases: what they come to, the one table, and the digest by which two people compare."""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata

import numpy as np

from heave_bringup.benchmark.case import Case, digest
from heave_bringup.benchmark.outcome import FIGURES, is_lost
from heave_bringup.benchmark.run import Result
from heave_bringup.tables.baseline_law import BASELINE_LAW

VERSION = 3
"""Version of the benchmark: cases, interface and figures. It goes up with every change that moves a figure."""
DIGITS = 4
"""Figures are rounded to this many significant digits before they are hashed and written."""
DISTRIBUTIONS = ("numpy", "scipy", "numba")
"""Libraries whose version may move the last digits."""


@dataclass(frozen=True)
class Summary:
    """What an entrant came to on a case, over its seeds.

    Attributes
    ----------
    case, entrant : by name
    seeds : how many were run
    residual : root mean square over seeds of the unit's standard deviation [m]
    off : the same of the unit without compensation [m]
    worst : largest of the seeds' standard deviations [m]
    largest : largest error of all, about the target where it is known [m]
    lost : seeds in which compensation was harmful, or failed
    failures : why runs failed, each reason once
    figures : the worst of each of FIGURES over the seeds, NaN where it is not known
    is_reference : the entrant was given the future
    """

    case: str
    entrant: str
    seeds: int
    residual: float
    off: float
    worst: float
    largest: float
    lost: int
    failures: tuple[str, ...]
    figures: Mapping[str, float]
    is_reference: bool

    @property
    def ratio(self) -> float:
        """Residual over uncompensated."""
        return self.residual / self.off if self.off > 0.0 else math.nan


def rounded(value: float) -> float | None:
    """Return the figure `value` to DIGITS significant digits, None where it is not known."""
    return float(f"{value:.{DIGITS - 1}e}") if math.isfinite(value) else None


def summarise(results: Sequence[Result]) -> list[Summary]:
    """Return a summary of `results` for each entrant on each case, in the order of first appearance."""
    groups: dict[tuple[str, str], list[Result]] = {}
    for result in results:
        groups.setdefault((result.task.case, result.task.entrant.short_name), []).append(result)
    return [_summary(case, entrant, group) for (case, entrant), group in groups.items()]


def _summary(case: str, entrant: str, results: Sequence[Result]) -> Summary:
    good = [result.figures for result in results if not result.failure]
    failures = tuple(sorted({result.failure for result in results if result.failure}))

    def over(name: str, how: str) -> float:
        values = np.array([figures[name] for figures in good], dtype=float)
        values = values[np.isfinite(values)]
        if not values.size:
            return math.nan
        return float(
            np.sqrt(np.mean(np.square(values))) if how == "rms" else values.max() if how == "max" else values.min()
        )

    largest = over("largest_error_m", "max")
    lowest = {"tension_ratio_min"}
    return Summary(
        case=case,
        entrant=entrant,
        seeds=len(results),
        residual=over("unit_sigma_m", "rms"),
        off=over("uncompensated_sigma_m", "rms"),
        worst=over("unit_sigma_m", "max"),
        largest=largest if math.isfinite(largest) else over("max_abs_heave_m", "max"),
        lost=sum(is_lost(figures) for figures in good) + len(results) - len(good),
        failures=failures,
        figures={name: over(name, "min" if name in lowest else "max") for name in FIGURES},
        is_reference=any(result.is_reference for result in results),
    )


def document(results: Sequence[Result], cases: Mapping[str, Case]) -> dict[str, object]:
    """Return the results for a machine, with digests.

    `problem_digest` says that two people ran the same cases, seeds and durations; `result_digest` that they got the
    same figures, to DIGITS significant digits, with the same versions.
    """
    runs = [
        {
            "case": result.task.case,
            "entrant": result.task.entrant.short_name,
            "seed": result.task.seed,
            "problem": result.problem,
            "failure": result.failure,
            "figures": {name: rounded(value) for name, value in result.figures.items()},
        }
        for result in sorted(results, key=lambda r: (r.task.case, r.task.entrant.short_name, r.task.seed))
    ]
    problems = sorted({(run["case"], run["seed"], run["problem"]) for run in runs}, key=str)
    problem_digest = digest([VERSION, problems])
    versions = software_versions()
    return {
        "benchmark_version": VERSION,
        "problem_digest": problem_digest,
        "result_digest": digest([problem_digest, versions, runs]),
        "versions": versions,
        "published_m": {case.name: dict(case.published) for case in cases.values() if case.published},
        "summary": [_content(summary) for summary in summarise(results)],
        "runs": runs,
    }


def _content(summary: Summary) -> dict[str, object]:
    return {
        "case": summary.case,
        "entrant": summary.entrant,
        "seeds": summary.seeds,
        "residual_m": rounded(summary.residual),
        "uncompensated_m": rounded(summary.off),
        "ratio": rounded(summary.ratio),
        "worst_seed_m": rounded(summary.worst),
        "largest_error_m": rounded(summary.largest),
        "lost": summary.lost,
        "failures": list(summary.failures),
        "is_reference": summary.is_reference,
        **{name: rounded(value) for name, value in summary.figures.items() if name not in ("largest_error_m",)},
    }


def software_versions() -> dict[str, str]:
    """Return the versions that may move a figure."""
    found = {name: metadata.version(name) for name in DISTRIBUTIONS}
    return {"python": ".".join(platform.python_version_tuple()[:2]), "machine": platform.machine(), **found}


def table(summaries: Sequence[Summary], cases: Mapping[str, Case]) -> str:
    """Return the one table, a row for each of `summaries`; `cases`, by name, tell what has been published of them.

    Beside each entrant's efficiency is that of the industrial baseline on the same case, where it was run.
    """
    baseline = {s.case: 1.0 - s.ratio for s in summaries if s.entrant == BASELINE_LAW}
    names = max(len(summary.case) for summary in summaries)
    entrants = max(len(summary.entrant) for summary in summaries) + 1
    lines = [
        f"{'case'.ljust(names)}  {'entrant'.ljust(entrants)} seeds   off cm   rms cm  effic. %  baseline %  "
        "worst cm  largest cm  rT min    DAF  m/s max  limit %  lost  published"
    ]
    before = ""
    for s in summaries:
        f = s.figures
        is_first = s.case != before
        before = s.case
        published = _published(cases[s.case]) if is_first else ""
        lines.append(
            f"{(s.case if is_first else '').ljust(names)}  "
            f"{(s.entrant + '*' * s.is_reference).ljust(entrants)} {s.seeds:5d} "
            f"{_cell(100 * s.off, 8, 2)} {_cell(100 * s.residual, 8, 3)} "
            f"{_cell(100 * (1.0 - s.ratio), 9, 2)} {_cell(100 * baseline.get(s.case, math.nan), 11, 2)} "
            f"{_cell(100 * s.worst, 9, 3)} {_cell(100 * s.largest, 11, 2)} {_cell(f['tension_ratio_min'], 7, 2)} "
            f"{_cell(f['dynamic_amplification'], 6, 2)} {_cell(f['winch_speed_max_mps'], 8, 2)} "
            f"{_cell(f['time_at_limit_percent'], 8, 2)} {s.lost:5d}  {published}".rstrip()
        )
        lines += [f"{''.ljust(names)}    {failure}" for failure in s.failures]
        if math.isfinite(f["touchdown_speed_mps"]):
            lines.append(
                f"{''.ljust(names)}    touchdown at up to {f['touchdown_speed_mps']:.3f} m/s, "
                f"up to {f['lift_offs']:.0f} lift-offs before their time"
            )
    if any(s.is_reference for s in summaries):
        lines.append("* knows the future of the boom tip: a reference, not an entry")
    if not baseline:
        lines.append(f"left out: the efficiency of law {BASELINE_LAW} (name {BASELINE_LAW} among the entrants)")
    return "\n".join(lines)


def _cell(value: float, width: int, digits: int) -> str:
    return f"{value:{width}.{digits}f}" if math.isfinite(value) else "-".rjust(width)


def _published(case: Case) -> str:
    return ", ".join(f"{who} {100.0 * value:.3g} cm" for who, value in case.published.items())
