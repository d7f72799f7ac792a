"""Ends a process whose middleware never comes back, and refuses to start it without memory.

Fast DDS waits for ever inside the creation of a participant where it gets no memory or no thread, and, over shared
memory (a transport that the user may choose), inside the removal of one where a process was killed that held a lock
there. Then no handler of a signal, and no thread of Python, has a turn in this process: another process must watch.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress

TIMEOUT = 60.0
"""Wall time in which a node of a command is made, or is removed after the run [s]; each takes a tenth of a second."""

LEAST_ADDRESS_SPACE = 2560 << 20
"""Address space that a process with nodes is given [bytes]: all nodes of a run in one process take 1.9 GB of it."""

WORDS_OF_END = "the work is done, but ROS did not come back from its end within {:g} s; the process is ended"
WORDS = (
    "ROS failed to start: the middleware did not come back within {:g} s. Is there enough memory "
    "(ulimit -v), are there enough threads (ulimit -u)?"
)

_WATCHDOG = """
import os, select, signal, sys
process, seconds, words = sys.argv[1], float(sys.argv[2]), sys.argv[3]
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, signal.SIG_IGN)
def state(number):
    try:
        return open(f"/proc/{number}/stat").read().rpartition(")")[2].split()[0]
    except OSError:
        return "X"
def is_counted():
    return state(process) not in "TtX" and not (has_started and any(state(other) not in "ZX" for other in others))
others, has_started, silent, said = [], False, 0.0, b""
while silent < seconds:
    pause = min(1.0, seconds - silent)
    if not select.select([0], [], [], pause)[0]:
        silent += pause if is_counted() else 0.0
        continue
    read = os.read(0, 4096)
    if not read:
        sys.exit()
    *lines, said = (said + read).split(b"\\n")
    for line in lines:
        kind, _, text = line.decode().partition(" ")
        others += [text] if kind == "end" else []
        has_started = has_started or kind == "started"
        words = text if kind == "words" else words
    silent = 0.0
os.write(2, f"\\nheave: {words}\\n".encode())
for number in [process] if has_started else [*others, process]:
    try:
        os.kill(int(number), signal.SIGKILL)
    except ProcessLookupError:
        pass
"""
"""Reads a line for each sign of life. Those that say more begin with `end` (the number of a process that is to end with
this one), `started` or `words`."""


def check_memory() -> None:
    """Raise MemoryError, in one line, where a limit of this shell leaves ROS and its nodes too little address space."""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < LEAST_ADDRESS_SPACE:
        raise MemoryError(
            f"this shell allows {limit / 1e9:.1f} GB of address space (ulimit -v), and ROS and its nodes are given "
            f"{LEAST_ADDRESS_SPACE / 1e9:.1f} GB: set ulimit -v unlimited, or at least {LEAST_ADDRESS_SPACE >> 10}"
        )


class Watchdog:
    """Another process that ends this one by SIGKILL, with a line on standard error, where it shows no sign of life.

    Time in which this process is stopped, as by Ctrl-Z, does not count; nor, after the start, does time in which a
    process that it has started lives: nodes go on without the command that shows them.

    Parameters
    ----------
    seconds : wall time without a sign of life [s]
    words : what it then says, one line; {:g} is filled with the seconds
    """

    def __init__(self, seconds: float = TIMEOUT, words: str = WORDS) -> None:
        self._process: subprocess.Popen[bytes] | None = subprocess.Popen(
            [sys.executable, "-I", "-S", "-c", _WATCHDOG, str(os.getpid()), str(seconds), words.format(seconds)],
            stdin=subprocess.PIPE,  # it ends when this is closed, by us or by the end of this process
            stdout=subprocess.DEVNULL,
            bufsize=0,
            start_new_session=True,  # a Ctrl-C in the terminal, before it can ignore it, is none for it
        )

    def beat(self) -> None:
        """Show that this process is alive."""
        self._say("")

    def end_too(self, process: int) -> None:
        """End the `process` of this number too, if it comes to that during the start."""
        self._say(f"end {process}")

    def has_started(self) -> None:
        """From now on act only where all processes to end have ended by themselves."""
        self._say("started")

    def will_say(self, words: str) -> None:
        """Say these `words`, one line, if it comes to that."""
        self._say(f"words {words}")

    def close(self) -> None:
        """Watch no longer; may be called again."""
        process, self._process = self._process, None
        if process is not None and process.stdin is not None:
            process.stdin.close()
            process.wait()

    def _say(self, text: str) -> None:
        if self._process is not None and self._process.stdin is not None:
            with suppress(BrokenPipeError):  # somebody has ended it
                self._process.stdin.write(f"{text}\n".encode())


@contextmanager
def watched_start(seconds: float = TIMEOUT) -> Iterator[Watchdog]:
    """End this process by SIGKILL, with a line on standard error, where what is within takes too long.

    It may take so many `seconds` of wall time, or go without a sign of life to the watchdog that is given.
    """
    with closing(Watchdog(seconds)) as watchdog:
        yield watchdog


@contextmanager
def watched_end() -> Iterator[None]:
    """Do the same where what is within removes nodes whose work is done."""
    with closing(Watchdog(TIMEOUT, WORDS_OF_END)):
        yield
