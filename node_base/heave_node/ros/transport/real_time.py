"""What real time asks of Python and of the machine: garbage collected between ticks, locked memory, a priority."""

from __future__ import annotations

import ctypes
import gc
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

MIDDLE_AGED = 50
"""Ticks between two collections of what has lived through some already."""
OLD = 20
"""Collections of middle-aged objects between two of all objects, which take milliseconds."""
MUCH = 10_000
"""Objects that a node may leave without a tick: more than any tick does, and a millisecond to collect."""

NICENESS = 5
"""Steps of priority (nice) by which a process beside the loop is below it."""

_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4


def collect_between_ticks() -> None:
    """Collect what the start has left, never look at what stays again, and from now on collect in `after_tick` alone.

    Python's collector comes when enough objects were made, wherever the program is, and then may look at all of them:
    tens of milliseconds.
    """
    gc.collect()
    gc.freeze()
    gc.disable()


def after_tick() -> None:
    """Collect what a tick has left: mostly what is young, for some 20 us. Nothing where Python's collector is on."""
    if not gc.isenabled():
        _, young, middle_aged = gc.get_count()  # collections of the generation before
        gc.collect(2 if middle_aged >= OLD else 1 if young >= MIDDLE_AGED else 0)


def between_looks() -> None:
    """Collect where much has been left without a tick, as in a run that waits for somebody or is paused."""
    if gc.get_count()[0] > MUCH:  # objects made since the last collection, less those freed
        after_tick()


def take_priority(priority: int) -> Iterator[str]:
    """Lock this process's memory, and give all of its threads the real-time `priority` (SCHED_FIFO, 1 to 99).

    Yields, for each of both that the machine does not permit, one line on what is missing and how it is permitted.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    # What comes later is locked page by page, when it is first touched: to fill a new thread's stack (8 MB) at once,
    # or the next 16 MB of a heap, holds up the ticks by up to 60 ms.
    if libc.mlockall(_MCL_CURRENT) or libc.mlockall(_MCL_FUTURE | _MCL_ONFAULT):
        why = os.strerror(ctypes.get_errno())
        yield f"memory is not locked ({why}), a page fault may delay a tick: set `memlock unlimited` in limits.conf"
    try:
        for thread in Path("/proc/self/task").iterdir():
            with suppress(ProcessLookupError):  # a thread that has ended meanwhile
                os.sched_setscheduler(int(thread.name), os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        yield (
            f"real-time priority {priority} is not permitted ({error.strerror}), other programs may delay a tick: set "
            f"`rtprio {priority}` in limits.conf, or grant CAP_SYS_NICE"
        )
