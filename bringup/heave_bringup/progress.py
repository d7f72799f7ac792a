"""Progress on the terminal: one line that is rewritten, or a line now and then where the output is no terminal."""

from __future__ import annotations

import sys
import time
from typing import TextIO

QUIET_PERIOD = 10.0
"""Wall time between two lines where the output is no terminal [s]."""


class ProgressLine:
    """A line on standard error that says how far a long work is."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._is_terminal = self._stream.isatty()
        self._width = 0
        self._written_at = -QUIET_PERIOD

    def show(self, text: str) -> None:
        """Show the state of the work."""
        now = time.monotonic()
        if self._is_terminal:
            self._stream.write("\r" + text.ljust(self._width))
            self._width = len(text)
        elif now - self._written_at >= QUIET_PERIOD:
            self._written_at = now
            self._stream.write(text + "\n")
        self._stream.flush()

    def tell(self, text: str) -> None:
        """Say something that stays, on a line of its own."""
        self.close()
        self._stream.write(text + "\n")
        self._stream.flush()

    def close(self) -> None:
        """Leave the line, so that what follows begins on a new one."""
        if self._is_terminal and self._width:
            self._stream.write("\n")
            self._stream.flush()
        self._width = 0
