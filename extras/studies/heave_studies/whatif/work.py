"""Long work: how far it is, and its independent parts, in this process or over several."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

from heave_bringup.errors import CommandError

from heave_studies.study.workers import FAILURE, Job, Run, run_here, workers

Show = Callable[[str, float], None]


def quiet(words: str, share: float) -> None:
    """Show nothing of how far the work is, in `words`, by its `share`."""


@dataclass(frozen=True)
class Work:
    """What does independent parts of some work."""

    run: Run = run_here  # does them
    show: Show = quiet  # called with what is done, and the share of it

    def done(self, words: str, function: Callable[..., Any], tasks: Sequence[Sequence[Any]]) -> list[Any]:
        """Return what a `function` returns for the arguments in each of some `tasks`; `words` are shown.

        Raises CommandError where a process ends without a result.
        """
        found: dict[int, Any] = {}
        self.show(words, 0.0)
        for job, result in self.run([Job(n, words, partial(function, *task)) for n, task in enumerate(tasks)]):
            if isinstance(result, dict) and result.get(FAILURE):
                raise CommandError(str(result[FAILURE]))
            found[job.number] = result
            self.show(words, len(found) / len(tasks))
        return [found[number] for number in range(len(tasks))]


HERE = Work()
"""Work that this process does, and shows nothing."""


@contextmanager
def work_in(processes: int, show: Show = quiet) -> Iterator[Work]:
    """Give work to so many `processes`; `show` as for `Work`."""
    with workers(processes) as run:
        yield Work(run, show)
