"""Enough seeds: more of them for each combination, until the confidence interval of a figure's mean is narrow."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_node.criteria import parse_criterion
from heave_node.parameters import Given, ParameterError

from heave_studies.study.plan import Case, More
from heave_studies.study.summary import FEWEST_SEEDS, half_width, wilson
from heave_studies.study.table import MET, SEED, alike
from heave_studies.study.workers import FAILURE

KEYS = {"figure", "width", "most"}


@dataclass(frozen=True)
class Until:
    """Seeds until a width (`heave_studies.study.plan.Refinement`)."""

    figure: str  # of merit whose mean is wanted, or MET: the share of the seeds that meets all criteria
    width: float  # of its confidence interval, SI, or over the mean
    is_relative: bool = False  # the width is
    most: int = 64  # seeds of a combination

    def size(self, cases: Sequence[Case]) -> int:
        """Number of cases, at most."""
        return self.most * len({repr(case.settings) for case in cases})

    def more(self, cases: Sequence[Case], frame: pandas.DataFrame) -> list[More]:
        """Return the seeds that are missing by the `frame` of all `cases`, at most as many again as there are."""
        found: list[More] = []
        for rows in alike(frame, SEED):
            have, excess = len(rows), self._excess(frame.iloc[rows])
            if excess > 1.0 and have < self.most:
                missing = math.ceil(have * min(excess, 2.0) ** 2) - have
                last = max(cases[row].seed for row in rows)
                count = min(missing, max(have, FEWEST_SEEDS), self.most - have)
                found += [(last + n, cases[rows[0]].settings) for n in range(1, count + 1)]
        return found

    def words(self, frame: pandas.DataFrame) -> str:
        """Return whether the width was reached in a `frame`, in a line."""
        groups = alike(frame, SEED)
        good = sum(self._excess(frame.iloc[rows]) <= 1.0 for rows in groups)
        title = "share that meets all criteria" if self.figure == MET else f"mean {DEFINITION_OF[self.figure].title}"
        width = f"{100.0 * self.width:g} % of it" if self.is_relative else f"{self.width:g}"
        counts = [len(rows) for rows in groups]
        return (
            f"enough seeds: the 90 % interval of the {title} is at most {width} wide in {good} of {len(groups)} "
            f"combinations, with {min(counts)} to {max(counts)} seeds"
        )

    def _excess(self, frame: pandas.DataFrame) -> float:
        """Return the width (of a mean: Student's) over the one that is wanted; infinite where it is not known."""
        good = frame[frame[FAILURE] == ""]
        if self.figure == MET:
            low, high = wilson(int(good[MET].sum()), len(good))
            return (high - low) / self.width
        values = good[self.figure].dropna().to_numpy(dtype=float)
        if values.size < FEWEST_SEEDS:
            return math.inf
        width = 2.0 * half_width(values)
        wanted = self.width * (abs(float(values.mean())) if self.is_relative else 1.0)
        return width / wanted if wanted > 0.0 else math.inf if width else 0.0


def read_until(given: Mapping[str, object], where: str) -> Until:
    """Return what is `given` as `until` in a study file; `where` opens the message of a ParameterError."""
    figure, width, most = str(given.get("figure", "")), str(given.get("width", "")), given.get("most", Until.most)
    if figure not in (MET, *DEFINITION_OF):
        raise ParameterError(f"{where}: figure = {figure!r}: must be a figure of merit, or {MET}")
    if not isinstance(most, int) or isinstance(most, bool) or most < FEWEST_SEEDS:
        raise ParameterError(f"{where}: most = {most!r}: must be a number of seeds, at least {FEWEST_SEEDS}")
    is_relative = width.endswith("%") and figure != MET
    key = "unit_efficiency" if is_relative or figure == MET else figure
    bound = parse_criterion(Given(f"<= {width}", key, f"{where}: width")).bound
    if not 0.0 < bound < math.inf:
        raise ParameterError(f"{where}: width = {width!r}: must be above 0, such as 10 % (of the mean), or 0.5 cm")
    return Until(figure, bound, is_relative, most)
