"""Where cases run: in this process, in worker processes of this machine, or on the workers of a Dask scheduler."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from heave_bringup.errors import CommandError
from heave_node.extras import how_to_install
from heave_node.parameters import ParameterError

from heave_studies.campaign.runs import CaseResult, Task, run_task
from heave_studies.workers.pool import worker_pool

DIED = "its process ended without a result, twice: it was killed, or out of memory"
"""Reason given for a case that ends its process."""

IN_HAND = 2
"""Cases that a worker process has in hand: one runs, one waits."""


def run_tasks(
    tasks: Sequence[Task], processes: int | None = None, dask: str | None = None
) -> Generator[CaseResult, None, None]:
    """Run every case and yield the results as they come.

    Parameters
    ----------
    tasks : to be run
    processes : number of worker processes; None takes one per processor, 1 runs the cases here
    dask : address of a Dask scheduler whose workers run the cases in the place of processes of this machine
    """
    if dask:
        yield from _run_on_dask(tasks, dask)
    elif processes == 1:
        yield from map(run_task, tasks)
    else:
        yield from _run_in_processes(tasks, processes or os.cpu_count() or 1)


def _run_in_processes(tasks: Sequence[Task], processes: int) -> Iterator[CaseResult]:
    """Run the cases in worker processes. Where one dies, those in hand are run again, each in a process of its own."""
    waiting = list(reversed(tasks))
    while waiting:
        in_hand: dict[Future[CaseResult], Task] = {}
        try:
            with worker_pool(min(len(waiting), processes)) as pool:
                while waiting or in_hand:
                    while waiting and len(in_hand) < IN_HAND * processes:
                        task = waiting[-1]
                        in_hand[pool.submit(run_task, task)] = task
                        waiting.pop()
                    for done in wait(in_hand, return_when=FIRST_COMPLETED).done:
                        result = done.result()
                        del in_hand[done]
                        yield result
        except BrokenProcessPool:
            for task in in_hand.values():
                yield _run_alone(task)


def _run_alone(task: Task) -> CaseResult:
    """Run a case in a process of its own, which alone dies with it."""
    try:
        with worker_pool(1) as pool:
            return pool.submit(run_task, task).result()
    except BrokenProcessPool:
        return CaseResult(task.case, failure=DIED)


def _run_on_dask(tasks: Sequence[Task], address: str) -> Iterator[CaseResult]:
    """Run the cases on the workers of a scheduler; what a lost worker had in hand is run by another one."""
    try:
        import distributed  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise ParameterError(f"--dask {address}: needs the package distributed; {how_to_install('dask')}") from error
    dask: Any = distributed  # which has no types
    try:
        client = dask.Client(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as error:
        raise CommandError(f"--dask {address}: no scheduler answers: {' '.join(str(error).split())}") from error
    with client:
        futures = client.map(run_task, tasks, pure=False)
        case_of = {future.key: task.case for future, task in zip(futures, tasks, strict=True)}
        try:
            for future in dask.as_completed(futures, loop=client.loop):
                trouble = future.exception()
                if trouble is None:
                    yield future.result()
                else:
                    words = " ".join(str(trouble).split()) or type(trouble).__name__
                    yield CaseResult(case_of[future.key], failure=f"its worker was lost, or could not run it: {words}")
                future.release()
        except BaseException:
            client.cancel(futures, force=True)  # else the workers would go on with cases that nobody waits for
            raise
