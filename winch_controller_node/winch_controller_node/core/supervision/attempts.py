"""What failed attempts at compensation say of the next, in words: the core counts them (`heave_core`, attempts.cpp)."""

from __future__ import annotations

INTERRUPTION = 0.25
"""Motion that a stop for want of commands leaves, over that with the winch locked: a swing of some waves."""

NO_MORE = "every attempt has failed: request compensation once the cause has been found"
"""What follows the last attempt."""


def too_much(residual: float, largest: float) -> str:
    """Return in words that a predicted `residual` is above the `largest`, over the motion with the winch locked."""
    return f"it would leave {100.0 * residual:.0f} % of the motion with the winch locked, limit {100.0 * largest:.0f} %"


def prospect(residual: float, largest: float, *, awaits_operator: bool) -> str:
    """Return when compensation that is off is tried again.

    Parameters
    ----------
    residual : motion that it is predicted to leave, over that with the winch locked
    largest : most of it with which it is tried
    awaits_operator : it is off until an operator asks for it
    """
    if awaits_operator:
        return NO_MORE
    if residual > largest:
        return f"next attempt when it is predicted to help; {too_much(residual, largest)}"
    return "next attempt once the cause has gone and the load has settled"


def sequel(*, awaits_operator: bool) -> str:
    """Return what follows a failed attempt, as a sentence of its alarm; `awaits_operator` as of `prospect`."""
    if awaits_operator:
        return f"{NO_MORE[0].upper()}{NO_MORE[1:]}"
    return "The next attempt is automatic; if it fails too, request standby"
