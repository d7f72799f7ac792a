"""No process outlives the one that started it: the kernel sees to it, whatever either of them is doing.

    python -m heave_node.ros.transport.parents_death MODULE ...

runs a module as `python -m MODULE ...` does, in a process that is killed when its launcher ends. A node that has begun
its work has files to close and others to tell: from then on it is asked first, and killed if it does not come to it.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import runpy
import signal
import sys
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, NoReturn

LAUNCHER_VARIABLE = "HEAVE_LAUNCHER"
"""Environment variable with the process id of the launcher: a node ends when that process is gone."""

ASKED = signal.SIGUSR1
"""Signal to a node that is at work; its number is the wall time that the node has to end after its launcher [s]."""

_SIGNAL_OF_PARENTS_DEATH = 1
"""`PR_SET_PDEATHSIG` of Linux: the kernel sends a signal to a process whose parent has ended."""


def end_with(parent: int) -> None:
    """Let the kernel kill this process when its `parent` ends; ends it at once where that one has ended already."""
    _ask(parent, signal.SIGKILL)


def close_with(parent: int) -> None:
    """Let this process be killed so long after its `parent` as it may need to close its files, and no longer."""
    if sys.platform == "linux":
        libc: Any = ctypes.CDLL(None)
        # alarm(seconds) in the place of a handler, which is given the signal's number: no turn of Python is needed
        libc.signal(int(ASKED), ctypes.cast(libc.alarm, ctypes.c_void_p))
    _ask(parent, ASKED)


def environment() -> dict[str, str]:
    """Return what is added to the environment of a node that this process starts, and that is to end with it."""
    return {LAUNCHER_VARIABLE: str(os.getpid())}


def launcher_of(environment: Mapping[str, str]) -> int | None:
    """Return the launcher that an `environment` names; None where nobody is to be outlived."""
    name = environment.get(LAUNCHER_VARIABLE, "")
    return int(name) if name.isdecimal() else None


def command(module: str, *arguments: str) -> list[str]:
    """Return the command that runs a `module` with `arguments` and ends with its launcher from its first moment on."""
    return [sys.executable, "-m", __name__, module, *arguments]


def _ask(parent: int, number: signal.Signals) -> None:
    if sys.platform == "linux":
        libc: Any = ctypes.CDLL(None)
        libc.prctl(_SIGNAL_OF_PARENTS_DEATH, int(number))
    if os.getppid() != parent:  # it ended before the kernel knew
        sys.stderr.write(f"the process {parent}, which has started this one ({LAUNCHER_VARIABLE}), has ended\n")
        os._exit(1)


def exit_at_once(status: int) -> NoReturn:
    """End this process with a `status`: it neither waits for threads nor takes its modules apart one by one.

    Python does both at its exit, which takes seconds on a busy machine.
    """
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # nobody reads it any more
            stream.flush()
    os._exit(status)


def main() -> None:
    """Run a module, from the command line."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # as long as the node has nothing to close
    launcher = launcher_of(os.environ)
    if launcher is not None:
        end_with(launcher)
    del sys.argv[0]
    try:
        runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
    except SystemExit as end:
        if isinstance(end.code, int):
            exit_at_once(end.code)
        raise


if __name__ == "__main__":
    main()
