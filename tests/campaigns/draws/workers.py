"""Cases in worker processes: each within a time, all of them ended with the campaign."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from tests.campaigns.draws.ablation import switch_off
from tests.campaigns.draws.cases import Case, draw
from tests.campaigns.draws.run import Outcome, run_case, set_latency

LIMIT = 1200
"""Longest time that a case may take [s]; one that takes longer counts as one that could not be run."""

WARM_UP = ("stacked", 1, 60.0)
"""Kind, day and length [s] of the run with which a worker begins, so that what is compiled then is in no tick."""


@dataclass(frozen=True)
class Task:
    """A case to run."""

    case: Case  # of the campaign
    is_informed: bool = False  # it is run with an informed controller as well


def run_tasks(
    tasks: Sequence[Task], workers: int, latency: str = "", without: str = ""
) -> Iterator[tuple[Case, Outcome]]:
    """Run all `tasks` in so many processes and yield what they came to, as it comes.

    Parameters
    ----------
    tasks : to be run
    workers : number of processes
    latency : of what the controller finds, see `set_latency`; empty: its own
    without : part of the controller that is switched off, see `ablation`; empty: none

    Processes end with the iterator, also where that is left early.
    """
    if not tasks:
        return
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the matrices are small, and a worker has one processor
    context = multiprocessing.get_context("spawn")
    with context.Pool(min(workers, len(tasks)), initializer=_begin, initargs=(latency, without)) as pool:
        results = pool.imap_unordered(_run, tasks)
        for _ in tasks:
            yield results.next(timeout=2.0 * LIMIT)


def _begin(latency: str, without: str) -> None:
    """Leave Ctrl-C to the campaign, which ends its workers; bound each case; compile what a run needs."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGALRM, _end)
    kind, day, duration = WARM_UP
    run_case(draw(kind, day, 0), duration=duration)
    if latency:
        set_latency(latency)
    if without:
        switch_off(without)


def _end(*_: object) -> None:
    raise TimeoutError(f"took longer than {LIMIT} s")


def _run(task: Task) -> tuple[Case, Outcome]:
    signal.alarm(LIMIT)
    try:
        return task.case, run_case(task.case, is_informed=task.is_informed)
    finally:
        signal.alarm(0)
