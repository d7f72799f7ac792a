"""Processes forked from this one: they have at once what it has loaded, where a new Python would load it again.

A process with threads cannot be forked safely, and ROS starts threads when it is imported. So the fork comes before
that; it loads ROS for itself, waits, and runs the module that it is then given.
"""

from __future__ import annotations

import atexit
import ctypes
import gc
import importlib
import json
import os
import signal
import sys
import traceback
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NoReturn

from heave_node.ros.transport.parents_death import command, end_with, exit_at_once

LOADED_BEFORE = "heave_node.ros.process"
"""Module that a fork loads while it waits, and ROS with it."""

_MALLOPT = {"MALLOC_TRIM_THRESHOLD_": -1, "MALLOC_TOP_PAD_": -2}
"""What `mallopt` of glibc calls its settings, by the environment variable that a new process reads."""

_program = ctypes.create_string_buffer(64)
"""Name of this program, to which ROS adds the process id and calls its log file so."""


@contextmanager
def forks(count: int) -> Iterator[list[Forked]]:
    """Give `count` forks that wait, fewer where the system allows no more; those left in the list are ended.

    There are none where this process cannot be forked safely.
    """
    waiting: list[Forked] = []
    try:
        with suppress(OSError):
            while _is_alone() and len(waiting) < count:
                waiting.append(Forked())
        yield waiting
    finally:
        for fork in waiting:
            fork.kill()
            fork.wait()


def _is_alone() -> bool:
    """Return whether this process has one thread, whatever library might have started more, and no ROS."""
    if sys.platform != "linux" or "rclpy" in sys.modules:
        return False
    return len(list(Path("/proc/self/task").iterdir())) == 1


class Forked:
    """A process forked from this one that ends with it; its face is that of `subprocess.Popen`.

    Attributes
    ----------
    pid : process id
    returncode : exit status, -N where signal N has ended it; None as long as `poll` has not seen its end
    """

    def __init__(self) -> None:
        self.returncode: int | None = None
        orders, self._orders = os.pipe()
        sys.stdout.flush()  # what is buffered is printed once
        sys.stderr.flush()
        parent = os.getpid()
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
        try:
            self.pid = os.fork()
            if not self.pid:
                _wait_and_run(orders, parent, before)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        os.close(orders)

    def run(self, name: str, module: str, *arguments: str, log: Path, environment: Mapping[str, str]) -> None:
        """Let the process do what `python -m MODULE ...` does in a new one.

        Parameters
        ----------
        name : under which it appears in lists of processes
        module, arguments : to run; its `main` is called
        log : file for all that it prints
        environment : variables, and no others
        """
        order = {"name": name, "module": module, "arguments": [*arguments], "log": str(log)}
        with suppress(BrokenPipeError), os.fdopen(self._orders, "w") as orders:  # it was killed: `poll` says so
            json.dump({**order, "environment": {**environment}}, orders)

    def poll(self) -> int | None:
        """Return the exit status; None where the process runs."""
        return self._wait(os.WNOHANG)

    def wait(self) -> None:
        """Wait for its end."""
        self._wait(0)

    def send_signal(self, number: int) -> None:
        """Send the signal of this `number`, where the process runs."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """End the process at once."""
        self.send_signal(signal.SIGKILL)

    def _wait(self, options: int) -> int | None:
        if self.returncode is None:
            process, status = os.waitpid(self.pid, options)
            self.returncode = os.waitstatus_to_exitcode(status) if process else None
        return self.returncode


def _wait_and_run(orders: int, parent: int, signals: set[int | signal.Signals]) -> NoReturn:
    """Be the fork: load ROS, wait for the order, and run its module."""
    try:
        end_with(parent)
        os.setsid()  # a Ctrl-C in the terminal is passed on by the parent
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_SETMASK, signals)
        _forget_parent(orders)
        with suppress(ImportError):  # it comes again, into the log
            importlib.import_module(LOADED_BEFORE)
        with os.fdopen(orders) as given:
            order = json.loads(given.read())
        _take_streams(order["log"])
        os.environ.clear()
        os.environ.update(order["environment"])
        _take_allocator()
        _take_name(order["name"], command(order["module"], *order["arguments"]))
        exit_at_once(_run(order["module"], order["arguments"]))
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(1)


def _forget_parent(orders: int) -> None:
    """Leave to the parent what it has open, but for `orders`, and what it does at its end."""
    gc.freeze()
    atexit._clear()
    for number in [int(file.name) for file in Path("/proc/self/fd").iterdir()]:
        if number not in (0, 1, 2, orders):
            with suppress(OSError):  # the folder itself
                os.close(number)


def _run(name: str, arguments: Sequence[str]) -> int:
    """Call the `main` of the module of this `name` as Python calls a program; return the status to exit with."""
    try:
        module = importlib.import_module(name)
        sys.modules["__main__"] = module  # where the processes that it starts look for what they are to run
        sys.argv = [str(module.__file__), *arguments]
        module.main()
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            return end.code or 0
        sys.stderr.write(f"{end.code}\n")
        return 1
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


def _take_streams(log: str) -> None:
    """Read nothing, and print to the `log`."""
    for path, flags, own in ((os.devnull, os.O_RDONLY, 0), (log, os.O_WRONLY | os.O_APPEND, 1)):
        opened = os.open(path, flags)
        os.dup2(opened, own)
        os.close(opened)
    os.dup2(1, 2)
    sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__  # the parent may have put others in their places


def _take_allocator() -> None:
    """Set glibc's allocator as the environment says; a new process reads that by itself."""
    libc: Any = ctypes.CDLL(None)
    for name, setting in _MALLOPT.items():
        if hasattr(libc, "mallopt") and os.environ.get(name, "").isdecimal():
            libc.mallopt(setting, int(os.environ[name]))


def _take_name(name: str, words: Sequence[str]) -> None:
    """Appear in the list of processes under a `name`, and a command of these `words`, as a new process would.

    The kernel shows as command what is in the memory where the process once got its arguments, and behind them its
    environment, which lies elsewhere by now; a last byte of the arguments other than 0 says that it goes on there.
    """
    Path("/proc/self/comm").write_text(name)
    fields = Path("/proc/self/stat").read_text().rpartition(")")[2].split()
    start, end_of_arguments, end = (int(fields[number]) for number in (45, 46, 48))
    shown = os.fsencode(" ".join(words)).ljust(end_of_arguments - start)[: end - start - 1] + b"\0"
    ctypes.memmove(start, shown, len(shown))
    _program.value = name.encode()
    ctypes.c_void_p.in_dll(ctypes.CDLL(None), "program_invocation_name").value = ctypes.addressof(_program)
