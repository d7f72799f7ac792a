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


def show_some(show: Show, words: str, of: int, done: int) -> None:
    """Have `show` say how far the work in `words` is, `of` so many ticks `done`, not at every tick."""
    if done % 200 == 0 or done == of:
        show(words, done / max(of, 1))


@dataclass(frozen=True)
class Work:
    """What does independent parts of some work."""

    pool: ProcessPoolExecutor | None  # of other processes; None: this one does it
    show: Show  # called with what is done, and the share of it

    def done(self, words: str, function: Callable[..., Any], tasks: Sequence[Sequence[Any]]) -> list[Any]:
        """Return what a `function` returns for the arguments in each of some `tasks`; `words` are shown."""
        return self.in_batches(words, function, len(tasks))(tasks) if tasks else []

    def in_batches(
        self, words: str, function: Callable[..., Any], usual: int
    ) -> Callable[[Sequence[Sequence[Any]]], list[Any]]:
        """Return what does batches of tasks for a `function`, of which there are `usual` in all; `words` are shown."""
        count = 0

        def one_more(found: Any) -> Any:
            nonlocal count
            count += 1
            self.show(words, min(count / usual, 1.0))
            return found

        def batch(tasks: Sequence[Sequence[Any]]) -> list[Any]:
            if self.pool is None:
                return [one_more(function(*task)) for task in tasks]
            coming = [self.pool.submit(function, *task) for task in tasks]
            for future in as_completed(coming):
                one_more(future)
            return [future.result() for future in coming]

        self.show(words, 0.0)
        return batch


HERE = Work(None, quiet)
"""Work that this process does, and shows nothing."""


@contextmanager
def work_in(processes: int, show: Show = quiet) -> Iterator[Work]:
    """Give work to so many `processes`, which start with the first part; `show` as for `Work`."""
    if processes <= 1:
        yield Work(None, show)
        return
    try:
        with worker_pool(processes) as pool:
            yield Work(pool, show)
    except BrokenProcessPool as error:
        raise CommandError("a process ended without a result: it was killed, or out of memory") from error
