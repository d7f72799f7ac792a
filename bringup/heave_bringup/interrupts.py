"""Ctrl-C and SIGTERM: an exception in whatever a command does, but not while Python imports.

Python swallows what is raised in a callback, as of the locks of its imports, with a traceback, and compiled modules
turn it into other errors. So while a module is being imported a signal is noted, and raised once the import is over.
This module is the first that a command imports.
"""

from __future__ import annotations

import signal
import threading
from types import FrameType

RETRY_PERIOD = 0.02
"""Wall time after which a signal that came during an import is raised, if the import is over [s]."""
_IMPORT = "<frozen importlib._bootstrap>"
"""File of the code of each import."""

_came = threading.Event()
_PYTHONS = signal.default_int_handler


def raise_interrupts() -> None:
    """Raise KeyboardInterrupt at Ctrl-C and at SIGTERM from now on, and note that one came.

    A shell may have set SIGINT to be ignored in the background.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _raise)


def raise_if_interrupted() -> None:
    """Raise KeyboardInterrupt where one came that did not get here."""
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    if _came.is_set():
        raise KeyboardInterrupt


def forget_interrupts() -> None:
    """Let the next command of this process know nothing of it."""
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    _came.clear()


def _raise(_: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt in the main thread, which is at a `frame`; later, while it imports a module."""
    _came.set()
    if not _is_importing(frame):
        raise KeyboardInterrupt
    signal.signal(signal.SIGALRM, _raise)
    signal.setitimer(signal.ITIMER_REAL, RETRY_PERIOD)


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename == _IMPORT:
            return True
        frame = frame.f_back
    return False


if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGINT) is _PYTHONS:
    signal.signal(signal.SIGINT, _raise)
