"""Worker processes that end with what started them: at once where it is interrupted, and where it is killed."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import ParamSpec, TypeVar

from heave_bringup.interrupts import raise_if_interrupted
from heave_node.ros.transport.parents_death import end_with

P = ParamSpec("P")
T = TypeVar("T")


@contextmanager
def worker_pool(processes: int) -> Iterator[ProcessPoolExecutor]:
    """Give a pool of worker processes; leave it by an exception, and they are killed in the midst of their work.

    Parameters
    ----------
    processes : at most so many
    """
    raise_if_interrupted()
    before = set(multiprocessing.active_children())
    pool = _Pool(
        processes,
        mp_context=multiprocessing.get_context("spawn"),
        initializer=end_with,
        initargs=(os.getpid(),),
    )
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in set(multiprocessing.active_children()) - before:
            worker.kill()
        raise
    finally:
        pool.shutdown()


class _Pool(ProcessPoolExecutor):
    """A pool whose workers do not hear the Ctrl-C of a terminal, which is for the command: it ends them."""

    def submit(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """See `ProcessPoolExecutor.submit`, which may start a worker: what is blocked here is blocked there for good.

        Parameters
        ----------
        function, args, kwargs : the work
        """
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            return super().submit(function, *args, **kwargs)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
