"""Long work: how far it is, and its independent parts, in this process or over several."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from heave_bringup.errors import CommandError

from heave_studies.workers.pool import worker_pool

Show = Callable[[str, float], None]


def quiet(words: str, share: float) -> None:
    """Show nothing of how far the work is, in `words`, by its `share`."""


@dataclass(frozen=True)
class Work:
    """What does independent parts of some work."""

    pool: ProcessPoolExecutor | None = None  # of other processes; None: this one does it
    show: Show = quiet  # called with what is done, and the share of it

    def done(self, words: str, function: Callable[..., Any], tasks: Sequence[Sequence[Any]]) -> list[Any]:
        """Return what a `function` returns for the arguments in each of some `tasks`; `words` are shown."""
        found = []
        if self.pool is None:
            for number, task in enumerate(tasks):
                self.show(words, number / len(tasks))
                found.append(function(*task))
            return found
        coming = [self.pool.submit(function, *task) for task in tasks]
        for number, _ in enumerate(as_completed(coming)):
            self.show(words, number / len(tasks))
        return [future.result() for future in coming]


HERE = Work()
"""Work that this process does, and shows nothing."""


@contextmanager
def work_in(processes: int, show: Show = quiet) -> Iterator[Work]:
    """Give work to so many `processes`, which start with the first part; `show` as for `Work`."""
    try:
        with worker_pool(processes) as pool:
            yield Work(pool, show)
    except BrokenProcessPool as error:
        raise CommandError("a process ended without a result: it was killed, or out of memory") from error
