"""Errors that the `heave` command tells its user in one line."""

from __future__ import annotations

from collections.abc import Iterable

from heave_bringup.exit_status import ExitStatus


class CommandError(Exception):
    """The command could not do what it says; the message is one line.

    Attributes
    ----------
    status : exit status of the command
    """

    status = ExitStatus.FAILED


class VerdictError(CommandError):
    """The command did what it says, and the verdict is FAILED; the message is one line that says why."""

    status = ExitStatus.VERDICT_FAILED

    def __init__(self, failures: Iterable[str]) -> None:
        super().__init__(f"verdict FAILED: {'; '.join(failures)}")


class NoRunError(CommandError):
    """There is no run to operate."""

    status = ExitStatus.REFUSED
