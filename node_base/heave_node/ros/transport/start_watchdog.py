"""Ends a process whose middleware never comes back from its start.

Fast DDS waits for ever inside the creation of a participant where it gets no memory or no thread, and then no handler
of a signal, and no thread of Python, has a turn in this process: another process must watch.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

START_TIMEOUT = 60.0
"""Wall time in which a node of a command is made [s]; it takes a tenth of a second."""

WORDS = (
    "ROS failed to start: the middleware did not come back within {:g} s. Is there enough memory "
    "(ulimit -v), are there enough threads (ulimit -u)?"
)

_WATCHDOG = """
import os, select, signal, sys
process, seconds, words = int(sys.argv[1]), float(sys.argv[2]), sys.argv[3]
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, signal.SIG_IGN)
if not select.select([sys.stdin], [], [], seconds)[0]:
    os.write(2, f"\\nheave: {words}\\n".encode())
    os.kill(process, signal.SIGKILL)
"""


@contextmanager
def watched_start(seconds: float = START_TIMEOUT) -> Iterator[None]:
    """End this process by SIGKILL, with a line on standard error, where what is within takes too long.

    Parameters
    ----------
    seconds : wall time that it may take [s]
    """
    watchdog = subprocess.Popen(
        [sys.executable, "-I", "-S", "-c", _WATCHDOG, str(os.getpid()), str(seconds), WORDS.format(seconds)],
        stdin=subprocess.PIPE,  # it ends when this is closed, by us or by the end of this process
        stdout=subprocess.DEVNULL,
    )
    try:
        yield
    finally:
        assert watchdog.stdin is not None
        watchdog.stdin.close()
        watchdog.wait()
