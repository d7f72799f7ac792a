"""Progress of long work on standard error: a line with a bar in a terminal, elsewhere a line now and then."""

from __future__ import annotations

import sys
import time
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TimeRemainingColumn
from rich.text import Text

QUIET_PERIOD = 10.0
"""Wall time between two lines where the output is not a terminal [s]."""

WIDE = 110
"""Columns of a terminal that has room for a bar and the time to go."""

_quiet = False


def be_quiet() -> None:
    """Show no progress from now on, in this process; lines that stay, alarms among them, are printed as ever."""
    global _quiet  # noqa: PLW0603
    _quiet = True


def time_to_go(elapsed: float, share: float) -> str:
    """Return in words how long work will still take, of which a `share` above 0 took the `elapsed` wall time [s], if it
    goes on as it went.
    """
    rest = elapsed * (1.0 - share) / share
    if rest < 90.0:
        return f"{rest:.0f} s to go"
    return f"{rest / 60.0:.0f} min to go" if rest < 5400.0 else f"{rest / 3600.0:.1f} h to go"


def _done(share: float) -> str:
    """Return in words how much of the work is done: before what is going on, which may have shares of its own."""
    return f"{100.0 * share:3.0f} % done"


class _Done(ProgressColumn):
    """The share of the work that is done."""

    def render(self, task: Task) -> Text:
        """Return what the column shows."""
        return Text(_done(task.completed))


class _Words(ProgressColumn):
    """What is going on, as far as it fits."""

    def render(self, task: Task) -> Text:
        """Return what the column shows."""
        return Text(task.description, no_wrap=True, overflow="ellipsis")


class ProgressLine:
    """A line on standard error, or another `stream`, that says how far long work is; a context manager."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._console = Console(file=self._stream)
        self._shares = [_Done()] if self.is_narrow else [BarColumn(20), _Done(), TimeRemainingColumn()]
        self._display = Progress(
            _Words(),  # cut where it does not fit
            console=self._console,
            auto_refresh=False,  # no thread of its own: it changes when `show` is called
            transient=True,
            disable=not self._console.is_terminal,
        )
        self._task = self._display.add_task("", total=1.0)
        self._begun_at = time.monotonic()
        self._written_at = -QUIET_PERIOD
        self._written = ""

    @property
    def is_narrow(self) -> bool:
        """Whether the line is that of a terminal without room for more than words."""
        return self._console.is_terminal and self._console.width < WIDE

    def __enter__(self) -> ProgressLine:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def show(self, text: str, share: float | None = None) -> None:
        """Show what is being done, `text`, and the `share` of the work that is done, 0 to 1; None where unknown."""
        if _quiet:
            return
        if self._console.is_terminal:
            self._display.start()
            self._display.columns = (*([] if share is None else self._shares), _Words())
            self._display.update(self._task, description=text, completed=share or 0.0, refresh=True)
            return
        line = text if share is None else f"{_done(share)}  {text}"
        now = time.monotonic()
        is_brief = share is not None and now - self._begun_at < QUIET_PERIOD  # a share that no later line would follow
        if line != self._written and now - self._written_at >= QUIET_PERIOD and not is_brief:
            self._written_at, self._written = now, line
            self.tell(line)

    def tell(self, text: str) -> None:
        """Print `text` as a line that stays."""
        if self._console.is_terminal:
            self._console.print(Text(text), soft_wrap=True)
        else:
            self._stream.write(text + "\n")
            self._stream.flush()

    def close(self) -> None:
        """Remove the line, so that what follows has the terminal to itself."""
        self._display.stop()
