"""The largest sea by bisection: each seed's limit is enclosed ever closer, in the same waves at other heights."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import pandas
from heave_node.criteria import Criterion

from heave_studies.operability.limits import HEIGHT, seed_limit, with_strengths
from heave_studies.study.plan import Case, More
from heave_studies.study.table import alike


@dataclass(frozen=True)
class Bisection:
    """Heights between those of the grid (`heave_studies.study.plan.Refinement`), compensated and locked."""

    criteria: tuple[Criterion, ...]  # that are to hold
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
        criteria = with_strengths(frame, self.criteria)
        for rows in alike(frame, HEIGHT):
            part, first = frame.iloc[rows], cases[rows[0]]
            heights = sorted(part[HEIGHT].to_numpy(dtype=float).tolist())
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
        return f"limits of each seed by bisection, enclosed within {self.within:g} m of Hs in the same waves"


def _but_height(case: Case) -> list[str]:
    return [f"{name}={value}" for name, value in case.settings.items() if name != HEIGHT]
