"""Ctrl-C and SIGTERM: an exception in whatever a command does, and a note for where that is swallowed.

Python swallows what is raised in a callback, as of the locks of its imports, and so do compiled modules. This module is
the first that a command imports, and notes Ctrl-C from then on.
"""

from __future__ import annotations

import signal
import threading
from typing import NoReturn

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
    if _came.is_set():
        raise KeyboardInterrupt


def forget_interrupts() -> None:
    """Let the next command of this process know nothing of it."""
    _came.clear()


def _raise(*_: object) -> NoReturn:
    _came.set()
    raise KeyboardInterrupt


if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGINT) is _PYTHONS:
    signal.signal(signal.SIGINT, _raise)
