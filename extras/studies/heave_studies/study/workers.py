"""Where the jobs of a study run: in this process, or on Dask: in processes of this machine or on a cluster."""

from __future__ import annotations

import logging
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from typing import Any

from heave_bringup.errors import CommandError
from heave_bringup.interrupts import raise_if_interrupted
from heave_node.extras import how_to_install
from heave_node.parameters import ParameterError
from heave_node.ros.transport.parents_death import end_with

Plain = Mapping[str, Any]
"""What a job gives: plain data, as JSON holds it."""
FAILURE = "failure"
"""Key of a result that says why there is none; empty or absent where there is one."""
DIED = "its process ended without a result, twice: it was killed, or out of memory"
"""Reason given for a job that ends its process."""
KILLED = "KilledWorker"
"""Name of Dask's exception for it."""
IN_HAND = 2
"""Jobs that a worker has in hand: one runs, one waits."""
HAS_SUITE = "heave"
"""Resource of Dask that a worker with the suite has, one for each thread."""
LONGEST_WAIT = 30.0
"""Wall time within which a worker must have joined a scheduler [s]."""


@dataclass(frozen=True)
class Job:
    """A piece of a study that runs by itself."""

    number: int  # counted from 1
    label: str  # for people
    work: Callable[[], Any]  # does it, here or in another process; of a study it gives Plain


Run = Callable[[Sequence[Job]], Iterator[tuple[Job, Any]]]
"""Runs jobs, and yields each with its result as they come."""


@contextmanager
def workers(processes: int | None = None, address: str | None = None) -> Iterator[Run]:
    """Give what runs jobs. Left by an exception, it ends those that are running.

    Parameters
    ----------
    processes : number of worker processes of this machine; None takes one per processor, 1 runs all in this process
    address : of a Dask scheduler, whose workers take the place of processes of this machine

    Raises ParameterError where Dask is not installed, CommandError where no scheduler answers.
    """
    raise_if_interrupted()
    processes = processes or os.cpu_count() or 1
    if processes == 1 and not address:
        yield run_here
        return
    dask = optional("distributed", f"--dask {address}" if address else f"--processes {processes}", "studies")
    with _patience(), _client(dask, processes, address) as client:
        yield lambda jobs: _run_on(dask, client, jobs, {HAS_SUITE: 1} if address else None)


def run_here(jobs: Sequence[Job]) -> Iterator[tuple[Job, Any]]:
    """Run the `jobs` in this process, and yield each with its result."""
    return ((job, job.work()) for job in jobs)


def _patience() -> Any:
    """Return what gives up a job with the first process that it ends: it is then run once more, alone."""
    import dask  # noqa: PLC0415 - slow

    return dask.config.set({"distributed.scheduler.allowed-failures": 0})  # type: ignore[attr-defined]


def optional(module: str, what: str, extra: str) -> Any:
    """Return a `module` that may be missing.

    Parameters
    ----------
    module : its dotted name
    what : needs it, for the message
    extra : of the suite that installs it

    Raises ParameterError where it is not installed.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ParameterError(f"{what}: needs the package {package}; {how_to_install(extra)}") from error


@contextmanager
def _client(dask: Any, processes: int, address: str | None) -> Iterator[Any]:
    """Give a client of the scheduler at an `address`, or of one of its own with so many `processes`."""
    if address:
        try:
            client = dask.Client(address, timeout="10s", set_as_default=False)
        except (OSError, ValueError) as error:
            raise CommandError(f"--dask {address}: no scheduler answers: {' '.join(str(error).split())}") from error
        with client:
            try:
                client.wait_for_workers(1, timeout=LONGEST_WAIT)
                client.run(import_module, "heave_studies")
            except TimeoutError as error:
                raise CommandError(f"--dask {address}: the scheduler has no worker: start one") from error
            except ImportError as error:
                raise CommandError(f"--dask {address}: a worker lacks the suite ({error}): install it there") from error
            client.register_plugin(_says_has_suite(dask))
            yield client
        return
    cluster = dask.LocalCluster(
        n_workers=processes, threads_per_worker=1, memory_limit=0, dashboard_address=None, silence_logs=logging.CRITICAL
    )
    try:
        with dask.Client(cluster, set_as_default=False) as client:
            client.run(_belong_to, os.getpid())
            yield client
    except BaseException:
        level = logging.root.manager.disable
        logging.disable(logging.CRITICAL)  # what Dask has to say of workers that were killed is of no use to anyone
        _kill(cluster)
        cluster.close()
        logging.disable(level)
        raise
    cluster.close()


def _says_has_suite(dask: Any) -> Any:
    """Return what lets each worker, also one that joins later, say that it has the suite.

    One without it would end with its first job, which it cannot read, and nothing would come from it for ever. It is
    no part of this module for such a worker: a class of its own is sent whole.
    """

    class SaysHasSuite(dask.WorkerPlugin):  # type: ignore[misc]
        async def setup(self, worker: Any) -> None:
            import_module("heave_studies")
            await worker.set_resources(**{HAS_SUITE: worker.state.nthreads})

    return SaysHasSuite()


def _belong_to(command: int) -> None:
    """Let a worker end with the process of the `command`, which alone hears the Ctrl-C of a terminal: it ends it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with(command)


def _kill(cluster: Any) -> None:
    """End the worker processes of a `cluster` in the midst of their work."""
    for nanny in cluster.workers.values():
        nanny.auto_restart = False
        if nanny.pid:
            os.kill(nanny.pid, signal.SIGKILL)


def _run_on(dask: Any, client: Any, jobs: Sequence[Job], needs: Mapping[str, int] | None) -> Iterator[tuple[Job, Any]]:
    """Run the jobs on the workers of a scheduler that have what it `needs`.

    What a worker had in hand that died is run once more, one by one.
    """
    waiting = iter(jobs)
    job_of: dict[Any, Job] = {}
    suspects: list[Job] = []
    alone = 0
    coming = dask.as_completed(loop=client.loop)

    def submit(jobs: Iterable[Job]) -> None:
        for job in jobs:
            future = client.submit(job.work, pure=False, resources=needs)
            job_of[future] = job
            coming.add(future)

    submit(islice(waiting, IN_HAND * max(sum(client.nthreads().values()), 1)))
    try:
        for future in coming:
            trouble, job = future.exception(), job_of.pop(future)
            if isinstance(trouble, ParameterError | CommandError):
                raise trouble
            submit(islice(waiting, 1))
            if type(trouble).__name__ == KILLED and job not in suspects:
                suspects.append(job)
            else:
                yield job, future.result() if trouble is None else {FAILURE: _reason(trouble)}
            if not job_of and alone < len(suspects):
                submit(suspects[alone : alone + 1])
                alone += 1
    except BaseException:
        client.cancel(list(job_of), force=True)  # else the workers would go on with jobs that nobody waits for
        raise


def _reason(trouble: BaseException) -> str:
    if type(trouble).__name__ == KILLED:
        return DIED
    words = " ".join(str(trouble).split()) or type(trouble).__name__
    return f"its worker was lost, or could not run it: {words}"
