"""Designing beside the tick: work longer than a tick is begun in one tick and its result taken in another."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Generic, TypeVar

Result = TypeVar("Result")


class DesignWork(Generic[Result]):
    """One piece of work at a time.

    Parameters
    ----------
    ticks : the result is taken this many ticks after the work was started, or as soon as it is there if that is later
    executor : does the work; None: it is done at once, so that what follows depends on the run alone, never on the
        machine
    """

    def __init__(self, ticks: int, executor: Executor | None = None) -> None:
        self._ticks = ticks
        self._executor = executor
        self._future: Future[Result] | None = None
        self._due = 0

    @property
    def is_under_way(self) -> bool:
        """Return whether there is work whose result has not been taken."""
        return self._future is not None

    def begin(self, tick: int, make: Callable[[], Result]) -> None:
        """Begin in `tick` with what `make` does; it must change nothing that a tick looks at."""
        self._due = tick + self._ticks
        if self._executor is not None:
            self._future = self._executor.submit(make)
            return
        self._future = Future()
        try:
            self._future.set_result(make())
        except Exception as error:  # told where the result is taken, as if it came from another thread
            self._future.set_exception(error)

    def take(self, tick: int) -> Result | None:
        """Return the result if it is due in `tick`, once; None: there is none, or not yet.

        Raises what the work raised.
        """
        if self._future is None or tick < self._due or not self._future.done():
            return None
        future, self._future = self._future, None
        return future.result()

    def drop(self) -> None:
        """Forget the work that is under way: its result is not wanted any more."""
        self._future = None
