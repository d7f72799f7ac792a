"""How the `heave` command ends: its exit statuses, in one table, and the errors that it reports in one line."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum


class ExitStatus(IntEnum):
    """How a command ended, the same for all of them; `meaning` says it in words."""

    meaning: str

    DONE = 0, "done; the verdict, if there is one, is not FAILED"
    FAILED = 1, "failed: the command could not finish"
    REFUSED = (
        2,
        "refused before it started: invalid command line or scenario, a file of another kind, or no run found",
    )
    VERDICT_FAILED = 3, "done, and the verdict is FAILED: results, bag and report are complete"
    INTERRUPTED = 130, "interrupted by Ctrl-C or SIGTERM"

    def __new__(cls, number: int, meaning: str) -> ExitStatus:
        """Return the status of a `number` with its `meaning`."""
        status = int.__new__(cls, number)
        status._value_ = number
        status.meaning = meaning
        return status


def status_table() -> str:
    """Return the table of all statuses in Markdown."""
    rows = [f"| {status.value} | {status.meaning} |" for status in ExitStatus]
    return "\n".join(["| exit status | meaning |", "|---|---|", *rows])


class CommandError(Exception):
    """The command could not finish; the message is one line.

    Attributes
    ----------
    status : exit status of the command
    """

    status = ExitStatus.FAILED


class InterruptedCommandError(CommandError):
    """Ctrl-C or SIGTERM ended what the command did; the message says what is left of it."""

    status = ExitStatus.INTERRUPTED


class VerdictError(CommandError):
    """The command did what it says, and the verdict is FAILED; the message says which criterion, and where all are.

    Parameters
    ----------
    failures : in words: "what and value (required, ...): state", of which the first is reported up to its bracket
    where : that has them all
    """

    status = ExitStatus.VERDICT_FAILED

    def __init__(self, failures: Sequence[str], where: str = "the verdict above") -> None:
        first = failures[0].partition(" (")[0]
        many = f"{len(failures)} criteria failed, first: " if len(failures) > 1 else ""
        super().__init__(f"verdict FAILED: {many}{first}; see {where}")


class AnotherRunError(CommandError):
    """A run that is refused, since its place is taken by another."""

    status = ExitStatus.REFUSED


class NoRunError(CommandError):
    """There is no run to operate."""

    status = ExitStatus.REFUSED
