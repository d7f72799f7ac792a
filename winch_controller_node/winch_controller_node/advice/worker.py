"""A process that answers questions one after another, so that nobody waits for it: bytes in, bytes out.

It ends with the process that asks: that holds the only other end of the pipe.
"""

from __future__ import annotations

import multiprocessing
import os
from collections import deque
from collections.abc import Callable
from multiprocessing.connection import Connection

from heave_node.ros.transport.real_time import NICENESS

MOST_WAITING = 30
"""Questions that wait for a worker that is behind; beyond that the oldest are dropped."""

ENDED = "its process has ended"

Answer = Callable[[bytes], bytes]


class WorkerError(Exception):
    """A worker that has ended, or could not answer; one line."""


class Worker:
    """The asking side of a worker.

    Parameters
    ----------
    make : makes what answers, in the worker; a function of a module
    tick_period : given to it [s]
    """

    def __init__(self, make: Callable[[float], Answer], tick_period: float) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, make, tick_period), daemon=True)
        self._process.start()
        theirs.close()
        self._waiting: deque[bytes] = deque(maxlen=MOST_WAITING)
        self._has_begun = self._is_idle = False
        self._fault = ""

    def is_ready(self) -> bool:
        """Return whether the worker has begun, or never will."""
        if not self._has_begun:
            self._receive()
        return self._has_begun or bool(self._fault)

    def ask(self, question: bytes) -> None:
        """Put a `question`; its answer comes with a later `answers`."""
        self._waiting.append(question)

    def answers(self) -> list[bytes]:
        """Return the answers that have come, without waiting. Raises WorkerError where none will come any more."""
        answer = self._receive() if self.is_ready() else None
        if self._is_idle and self._waiting and not self._fault:
            try:  # it waits for this, so that the pipe takes it at once
                self._pipe.send(self._waiting.popleft())
                self._is_idle = False
            except OSError:
                self._fault = ENDED
        if self._fault:
            raise WorkerError(self._fault)
        return [] if answer is None else [answer]

    def _receive(self) -> bytes | None:
        """Return an answer that has come; None: there is none. The first message says that the worker has begun."""
        try:
            if self._fault or not self._pipe.poll():
                return None
            is_answer, data = self._pipe.recv()
        except (EOFError, OSError):
            self._fault = ENDED
            return None
        if not is_answer:
            self._fault = data.decode()
            return None
        was_begun, self._has_begun, self._is_idle = self._has_begun, True, True
        return data if was_begun else None

    def close(self) -> None:
        """End the worker, without waiting for it."""
        self._pipe.close()
        self._process.terminate()


def _serve(pipe: Connection, make: Callable[[float], Answer], tick_period: float) -> None:
    """Answer until the other end is closed."""
    os.nice(NICENESS)
    try:
        answer = make(tick_period)
        pipe.send((True, b""))
        while True:
            question = pipe.recv()
            pipe.send((True, answer(question)))
    except (EOFError, BrokenPipeError):
        return
    except Exception as error:  # whatever an adviser raises is said where it was asked
        pipe.send((False, " ".join(f"{type(error).__name__}: {error}".split()).encode()))
