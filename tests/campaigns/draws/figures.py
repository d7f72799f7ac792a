"""What all draws of a kind came to: their distribution, and whether the promise holds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from tests.campaigns.draws.cases import Case
from tests.campaigns.draws.run import Outcome

Drawn = tuple[Case, Outcome]


@dataclass(frozen=True)
class Figures:
    """The distribution of what `cases` draws came to."""

    cases: int  # draws
    failed: int  # draws that could not be run
    judged: int  # draws of which a minute was judged
    p50: float  # median of the worst minute over off, of those that were judged
    p90: float  # 90th percentile
    largest: float  # largest
    within_1_05: float  # share of them up to that
    within_1_2: float  # share of them up to that
    within_1_5: float  # share of them up to that
    never_begun: int  # never begun, or too late to be judged
    without_reason: int  # of these without a true reason
    given_up: int  # draws in which compensation was given up
    lost: int  # draws in which it was so at the end
    named: int  # draws with a finding that is right
    wrong: int  # draws with one that blames a healthy part
    reached: int  # draws that reached 1.5
    unalarmed: int  # those of them without an alarm before
    tick_p50: float  # of the controller's ticks [ms]: median of the draws
    tick_p999: float  # largest of the draws' 99.9 % [ms]
    tick_max: float  # largest [ms]
    efficiency: float  # median
    told_cases: int  # draws also run with an informed controller
    efficiency_of_these: float  # their median efficiency
    told: float  # their median efficiency with the informed controller


def figures_of(drawn: Sequence[Drawn]) -> Figures:
    """Return the distribution of the draws."""
    ran = [found for _, found in drawn if not found.failure]
    ratios = np.array([found.worst for found in ran if found.is_judged])
    waited = [found for found in ran if not found.is_judged]
    told = [found for found in ran if math.isfinite(found.told)]
    ticks = np.array([found.ticks for found in ran]).reshape(-1, 3)

    def within(limit: float) -> float:
        return float(np.mean(ratios <= limit)) if ratios.size else math.nan

    def count(holds: Callable[[Outcome], bool]) -> int:
        return sum(map(holds, ran))

    return Figures(
        cases=len(drawn),
        failed=len(drawn) - len(ran),
        judged=ratios.size,
        p50=_percentile(ratios, 50.0),
        p90=_percentile(ratios, 90.0),
        largest=_percentile(ratios, 100.0),
        within_1_05=within(1.05),
        within_1_2=within(1.2),
        within_1_5=within(1.5),
        never_begun=len(waited),
        without_reason=sum(not found.has_true_reason for found in waited),
        given_up=count(lambda found: found.given_up > 0),
        lost=count(lambda found: found.is_lost),
        named=count(lambda found: bool(found.right)),
        wrong=count(lambda found: bool(found.wrong)),
        reached=count(lambda found: found.is_alarmed is not None),
        unalarmed=count(lambda found: found.is_alarmed is False),
        tick_p50=_percentile(ticks[:, 0], 50.0),
        tick_p999=_percentile(ticks[:, 1], 100.0),
        tick_max=_percentile(ticks[:, 2], 100.0),
        efficiency=_percentile([found.efficiency for found in ran], 50.0),
        told_cases=len(told),
        efficiency_of_these=_percentile([found.efficiency for found in told], 50.0),
        told=_percentile([found.told for found in told], 50.0),
    )


def _percentile(values: Sequence[float] | np.ndarray, percent: float) -> float:
    array = np.asarray(values, dtype=float)
    array = array[np.isfinite(array)]
    return float(np.percentile(array, percent)) if array.size else math.nan


def broken(kind: str, figures: Figures) -> list[str]:
    """Return which parts of the promise the `figures` of a kind break, in words; empty: it is kept."""
    f = figures
    shares = {1.05: f.within_1_05, 1.2: f.within_1_2, 1.5: f.within_1_5}
    least = {1.05: 0.85, 1.5: 0.97} if kind == "stacked" else {1.05: 0.97, 1.2: 0.995}
    words = [
        f"{100 * shares[limit]:.1f} % within {limit:g}, promised {100 * share:g} %"
        for limit, share in least.items()
        if not shares[limit] >= share
    ]
    if kind == "stacked":
        words += [f"{f.unalarmed} reached 1.5 without an alarm"] if f.unalarmed else []
    else:
        words += [f"{f.lost} lost"] if f.lost else []
        words += [f"{f.wrong} with a healthy part blamed"] if f.wrong > SELDOM * f.cases else []
    words += [f"{f.without_reason} never begun without a true reason"] if f.without_reason > SELDOM * f.cases else []
    if f.efficiency_of_these < LEAST_OF_TOLD * f.told:
        words.append(f"median efficiency {f.efficiency_of_these:.3f}, told {f.told:.3f}")
    return words + ([f"{f.failed} could not be run"] if f.failed else [])


SELDOM = 0.01
"""Share of the draws in which a healthy part may be blamed, and in which compensation may never begin for no reason."""

LEAST_OF_TOLD = 0.95
"""Median efficiency over that of the same cases with an informed controller."""


def table(kind: str, figures: Figures) -> str:
    """Return the figures of a kind as lines."""
    f = figures
    told = f"; told {f.told_cases}: {100 * f.efficiency_of_these:.1f} %, when told {100 * f.told:.1f} %"
    return "\n".join(
        [
            f"{kind}: {f.cases} draws, {f.judged} judged" + (f", {f.failed} FAILED" if f.failed else ""),
            f"  worst minute over off   p50 {f.p50:.3f}  p90 {f.p90:.3f}  largest {f.largest:.3f}",
            f"  share of the judged     <= 1.05 {100 * f.within_1_05:.1f} %  <= 1.2 {100 * f.within_1_2:.1f} %  "
            f"<= 1.5 {100 * f.within_1_5:.1f} %",
            f"  never begun             {f.never_begun}, without a true reason {f.without_reason}",
            f"  given up at least once  {f.given_up}, lost at the end {f.lost}",
            f"  findings                right in {f.named}, a healthy part blamed in {f.wrong}",
            f"  reached 1.5             {f.reached}, without an alarm before {f.unalarmed}",
            f"  controller's ticks      p50 {f.tick_p50:.2f} ms, largest p99.9 {f.tick_p999:.1f} ms, largest "
            f"{f.tick_max:.0f} ms",
            f"  efficiency, median      {100 * f.efficiency:.1f} %" + (told if f.told_cases else ""),
        ]
    )


def line(case: Case, found: Outcome) -> str:
    """Return a draw in a line, and one for each finding that is wrong."""
    if found.failure:
        return f"{case.words}\n    FAILED: {found.failure}"
    told = f", told {100 * found.told:.1f} %" if math.isfinite(found.told) else ""
    verdict = f"{found.worst:.3f} at {found.at:.0f} s" if found.is_judged else found.reason
    marks = "".join(
        [
            " LOST" if found.is_lost else "",
            " NO ALARM" if found.is_alarmed is False else "",
            f" given up {found.given_up}" if found.given_up else "",
        ]
    )
    median, high, largest = found.ticks
    lines = [
        case.words,
        f"    {verdict}, efficiency {100 * found.efficiency:.1f} %{told}, "
        f"ticks {median:.2f}/{high:.1f}/{largest:.0f} ms, right {len(found.right)}{marks}",
        *(f"    wrong: {words}" for words in found.wrong),
        *(f"    refused: {words}" for words in found.refused),
    ]
    return "\n".join(lines)


def worst_first(drawn: Sequence[Drawn]) -> list[Drawn]:
    """Return the draws that were judged, the worst of them first."""
    return sorted((one for one in drawn if one[1].is_judged), key=lambda one: -one[1].worst)


CHANGED = 0.1
"""Difference of a worst minute over off from which on a draw counts as changed."""


def comparison(drawn: Sequence[Drawn], before: Mapping[int, Outcome]) -> str:
    """Return how many draws differ from what the same ones came to `before`, by index, and those that changed most.

    A draw that was not judged left the unit as it was: it counts as 1.
    """

    def ratio(found: Outcome) -> float:
        return found.worst if found.is_judged else 1.0

    pairs = [(case, ratio(before[case.index]), ratio(found)) for case, found in drawn if case.index in before]
    pairs.sort(key=lambda pair: -abs(pair[2] - pair[1]))
    better = sum(new < old - CHANGED for _, old, new in pairs)
    worse = sum(new > old + CHANGED for _, old, new in pairs)
    lines = [f"the same {len(pairs)} draws before: {better} are better now, {worse} worse, by more than {CHANGED:g}"]
    lines += [f"  {old:.3f} became {new:.3f}: {case.words}" for case, old, new in pairs[:MOST_CHANGED]]
    return "\n".join(lines)


MOST_CHANGED = 8
"""Number of draws that changed most, which are printed."""


def as_values(kind: str, figures: Figures) -> dict[str, object]:
    """Return the figures and what of the promise they break, for a program."""
    values = {
        key: None if isinstance(value, float) and math.isnan(value) else value for key, value in asdict(figures).items()
    }
    return {"kind": kind, **values, "broken": broken(kind, figures)}
