"""Ends a process whose middleware never comes back from its start, and refuses to start it without memory.

Fast DDS waits for ever inside the creation of a participant where it gets no memory or no thread, and then no handler
of a signal, and no thread of Python, has a turn in this process: another process must watch.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

START_TIMEOUT = 60.0
"""Wall time in which a node of a command is made [s]; it takes a tenth of a second."""

LEAST_ADDRESS_SPACE = 2560 << 20
"""Address space that a process with nodes is given [bytes]: all nodes of a run in one process take 1.9 GB of it."""

WORDS = (
    "ROS failed to start: the middleware did not come back within {:g} s. Is there enough memory "
    "(ulimit -v), are there enough threads (ulimit -u)?"
)

_WATCHDOG = """
import os, select, signal, sys
process, seconds, words = int(sys.argv[1]), float(sys.argv[2]), sys.argv[3]
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, signal.SIG_IGN)
def is_stopped():
    try:
        return open(f"/proc/{process}/stat").read().rpartition(")")[2].split()[0] in "Tt"
    except OSError:
        return False
others, silent, said = [], 0.0, b""
while silent < seconds:
    pause = min(1.0, seconds - silent)
    if not select.select([0], [], [], pause)[0]:
        silent += 0.0 if is_stopped() else pause
        continue
    read = os.read(0, 4096)
    if not read:
        sys.exit()
    *lines, said = (said + read).split(b"\\n")
    others += [int(line) for line in lines if line]
    silent = 0.0
os.write(2, f"\\nheave: {words}\\n".encode())
for number in [*others, process]:
    try:
        os.kill(number, signal.SIGKILL)
    except ProcessLookupError:
        pass
"""
"""Reads a line for each sign of life: the number of a process that is to end with this one, or nothing."""


def check_memory() -> None:
    """Raise MemoryError, in one line, where a limit of this shell leaves ROS and its nodes too little address space."""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < LEAST_ADDRESS_SPACE:
        raise MemoryError(
            f"this shell allows {limit / 1e9:.1f} GB of address space (ulimit -v), and ROS and its nodes are given "
            f"{LEAST_ADDRESS_SPACE / 1e9:.1f} GB: set ulimit -v unlimited, or at least {LEAST_ADDRESS_SPACE >> 10}"
        )


class StartWatchdog:
    """Another process that ends this one by SIGKILL, with a line on standard error, where it shows no sign of life.

    Time in which this process is stopped, as by Ctrl-Z, does not count.

    Parameters
    ----------
    seconds : wall time without a sign of life [s]
    """

    def __init__(self, seconds: float = START_TIMEOUT) -> None:
        self._process: subprocess.Popen[bytes] | None = subprocess.Popen(
            [sys.executable, "-I", "-S", "-c", _WATCHDOG, str(os.getpid()), str(seconds), WORDS.format(seconds)],
            stdin=subprocess.PIPE,  # it ends when this is closed, by us or by the end of this process
            stdout=subprocess.DEVNULL,
            bufsize=0,
        )

    def beat(self) -> None:
        """Show that this process is alive."""
        self._say("\n")

    def end_too(self, process: int) -> None:
        """End the `process` of this number too, if it comes to that."""
        self._say(f"{process}\n")

    def close(self) -> None:
        """Watch no longer; may be called again."""
        process, self._process = self._process, None
        if process is not None and process.stdin is not None:
            process.stdin.close()
            process.wait()

    def _say(self, text: str) -> None:
        if self._process is not None and self._process.stdin is not None:
            with suppress(BrokenPipeError):  # somebody has ended it
                self._process.stdin.write(text.encode())


@contextmanager
def watched_start(seconds: float = START_TIMEOUT) -> Iterator[StartWatchdog]:
    """End this process by SIGKILL, with a line on standard error, where what is within takes too long.

    Parameters
    ----------
    seconds : wall time that it may take [s], or the time without a sign of life to the watchdog that is given [s]
    """
    watchdog = StartWatchdog(seconds)
    try:
        yield watchdog
    finally:
        watchdog.close()
