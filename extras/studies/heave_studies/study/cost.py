"""What a case costs, by part: processor time, in a file beside the table, which itself is the same each time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas
from heave_bringup.closed_loop import ClosedLoop
from heave_node.files.given_files import whole_file

from heave_studies.study.case_file import CASE

COST, LIFTS = "cost", "lifts"
"""Keys of a result: its cost [s] by part; the results of the cases of a screening, by number."""
FILE = "cost.csv"
METHODS: Mapping[str, tuple[str, ...]] = {
    "sea": ("sea.step",),
    "plant": ("plant.readings", "plant.advance"),
    "winch": ("winch.step",),
    "controller": ("controller.step",),
    "adviser": ("adviser.advise",),
}
"""Methods of a loop that are timed, by part."""
START, LOOP, JUDGE = "start", "rest of the loop", "judging"
PARTS = (START, *METHODS, LOOP, JUDGE)
HEAD = ["cost of a case, mean", "processor time [s]", "share [%]"]


class Meter:
    """Times the parts of one case."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(PARTS, 0.0)

    @contextmanager
    def of(self, part: str) -> Iterator[None]:
        """Count the time within as that of a `part`, less what other parts take of it."""
        began, others = time.thread_time(), sum(self.seconds.values())
        try:
            yield
        finally:
            inside = sum(self.seconds.values()) - others
            self.seconds[part] += time.thread_time() - began - inside

    def of_one(self, cases: int) -> Meter:
        """Return the meter of one of so many `cases` that were timed together."""
        one = Meter()
        one.seconds = {part: seconds / cases for part, seconds in self.seconds.items()}
        return one

    def watch(self, loop: ClosedLoop) -> None:
        """Time the methods of a `loop` from now on."""
        for part, names in METHODS.items():
            for place, method in (name.split(".") for name in names):
                if (owner := getattr(loop, place)) is not None:
                    setattr(owner, method, self._timed(part, getattr(owner, method)))

    def _timed(self, part: str, method: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*arguments: Any) -> Any:
            began = time.thread_time()
            found = method(*arguments)
            self.seconds[part] += time.thread_time() - began
            return found

        return timed


def write_cost(results: Mapping[int, Mapping[str, Any]], folder: Path) -> None:
    """Write a row for each case of which the `results` have the cost into a `folder`; nothing where none is known."""
    of_cases = {int(case): one for number, of in results.items() for case, one in of.get(LIFTS, {number: of}).items()
                if one.get(COST)}  # fmt: skip
    rows = [{CASE: number, **of_cases[number][COST]} for number in sorted(of_cases)]
    if rows:
        with whole_file(folder / FILE) as unfinished:
            pandas.DataFrame(rows).to_csv(unfinished, index=False, float_format="%.4g")


def cost_rows(folder: Path) -> list[list[str]]:
    """Return the mean cost of a case by part [s], and its share [%], of what a `folder` holds; empty: unknown."""
    if not (folder / FILE).is_file():
        return []
    means = pandas.read_csv(folder / FILE)[list(PARTS)].mean()
    means["all"] = means.sum()
    return [[str(name), f"{value:.3f}", f"{100.0 * value / means['all']:.0f}"] for name, value in means.items()]
