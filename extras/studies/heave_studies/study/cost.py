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

COST = "cost"
"""Key of a result with its cost [s] by part."""
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

    def watch(self, loop: ClosedLoop) -> None:
        """Time the methods of a `loop` from now on."""
        for part, names in METHODS.items():
            for name in names:
                place, method = name.split(".")
                owner = getattr(loop, place)
                if owner is not None:
                    setattr(owner, method, self._timed(part, getattr(owner, method)))

    def _timed(self, part: str, method: Callable[..., Any]) -> Callable[..., Any]:
        seconds, clock = self.seconds, time.thread_time

        def timed(*arguments: Any) -> Any:
            began = clock()
            found = method(*arguments)
            seconds[part] += clock() - began
            return found

        return timed


def cost_frame(results: Mapping[int, Mapping[str, Any]]) -> pandas.DataFrame:
    """Return a row for each case of which the `results` have the cost, by part [s]."""
    rows = [{CASE: number, **results[number][COST]} for number in sorted(results) if results[number].get(COST)]
    return pandas.DataFrame(rows, columns=[CASE, *PARTS])


def write_cost(results: Mapping[int, Mapping[str, Any]], folder: Path) -> None:
    """Write the cost of all `results` into a `folder`; nothing where none is known."""
    frame = cost_frame(results)
    if len(frame):
        with whole_file(folder / FILE) as unfinished:
            frame.to_csv(unfinished, index=False, float_format="%.4g")


def cost_rows(folder: Path) -> list[list[str]]:
    """Return the mean cost of a case by part [s], and its share [%], of what a `folder` holds; empty: unknown."""
    if not (folder / FILE).is_file():
        return []
    means = pandas.read_csv(folder / FILE)[list(PARTS)].mean()
    total = max(float(means.sum()), 1e-9)
    rows = [[str(name), f"{value:.3f}", f"{100.0 * value / total:.0f}"] for name, value in means.items()]
    return [*rows, ["all", f"{total:.3f}", "100"]]


HEAD = ["cost of a case, mean", "processor time [s]", "share [%]"]
