"""The command `heave` given in this process: its status, what it said, and whether that is how a command may end."""

from __future__ import annotations

import json
import signal
import traceback
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from tempfile import TemporaryFile
from types import FrameType

from heave_bringup.errors import ExitStatus


def heave(words: Sequence[str]) -> tuple[int, str, str]:
    """Give a command of these `words`; return its status, and what it said on standard output and error."""
    from heave_bringup.cli import main  # noqa: PLC0415 - after the limits of this process are set

    with TemporaryFile("w+") as err, redirect_stdout(StringIO()) as out, redirect_stderr(err):
        try:
            status = main(words)
        except SystemExit as error:
            status = int(error.code or 0)
        err.seek(0)
        complaint = err.read()
    return status, out.getvalue(), complaint


def judge(status: int, said: str, complaint: str) -> str:
    """Return what is wrong with the end of a command: it does what it says, or ends in one line.

    Parameters
    ----------
    status : of the command
    said : on standard output: JSON
    complaint : on standard error
    """
    if "Traceback" in complaint:
        return complaint
    if status in (ExitStatus.DONE, ExitStatus.VERDICT_FAILED):
        json.loads(said)
        return ""
    last = complaint.strip().splitlines()[-1:] or [""]
    return "" if status in (1, 2) and last[0].startswith("heave: ") else f"status {status}: {complaint[-300:]}"


class Watch:
    """Turns an exception, or more wall time than is allowed, into an entry of what is wrong.

    Parameters
    ----------
    wrong : by command
    command : its name
    longest : wall time after which it is said to hang [s]
    """

    def __init__(self, wrong: dict[str, str], command: str, longest: int) -> None:
        self._wrong, self._command, self._longest = wrong, command, longest

    def __enter__(self) -> None:
        signal.signal(signal.SIGALRM, self._late)
        signal.alarm(self._longest)

    def _late(self, _number: int, _frame: FrameType | None) -> None:
        raise TimeoutError(f"no end within {self._longest} s")

    def __exit__(self, kind: object, error: BaseException | None, _traceback: object) -> bool:
        signal.alarm(0)
        if error is not None:
            place = " ".join(traceback.format_exception(error)[-2].split())
            self._wrong[self._command] = f"{type(error).__name__}: {error}; {place}"
        return True
