"""Ctrl-C and SIGTERM: an exception in whatever a command does, and a note for where a library swallows that."""

from __future__ import annotations

import signal
import threading
from typing import NoReturn

_came = threading.Event()


def raise_interrupts() -> None:
    """Raise KeyboardInterrupt at Ctrl-C and at SIGTERM from now on, and note that one came.

    A shell may have set SIGINT to be ignored in the background.
    """
    _came.clear()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _raise)


def _raise(*_: object) -> NoReturn:
    _came.set()
    raise KeyboardInterrupt


def raise_if_interrupted() -> None:
    """Raise KeyboardInterrupt where one came that did not get here: modules that are imported may swallow it."""
    if _came.is_set():
        raise KeyboardInterrupt
