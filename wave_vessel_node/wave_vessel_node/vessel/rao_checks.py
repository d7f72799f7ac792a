"""Implausible response amplitude operators: wrong units, exchanged columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from heave_node.files.plausible import question, refusal

from wave_vessel_node.implausible import ACCEPT
from wave_vessel_node.vessel.motion import DEGREES_OF_FREEDOM
from wave_vessel_node.vessel.rao import RaoError, ResponseTable

_LONG_WAVES = 0.3
"""Frequency up to which waves (of 690 m or more) are long to a ship [rad/s]."""


def judged(path: Path, table: ResponseTable, questions: Sequence[str] = (), *, accept: bool) -> ResponseTable:
    """Return a table that is plausible, or accepted; what is implausible then joins its warnings.

    Parameters
    ----------
    path : of its file
    table : as read
    questions : of its reader, which come first
    accept : take what is implausible

    Raises RaoError for what is implausible and not accepted.
    """
    objections = [*questions, *response_questions(table)]
    if objections and not accept:
        raise RaoError(f"{path}: {refusal(objections, ACCEPT)}")
    return replace(table, warnings=(*table.warnings, *(f"{path}: {objection}" for objection in objections)))


def response_questions(table: ResponseTable) -> list[str]:
    """Return what is implausible about a table, one line each."""
    asked = [
        question("lowest wave frequency", float(table.frequency[0])),
        question("highest wave frequency", float(table.frequency[-1])),
    ]
    if table.frequency[0] <= _LONG_WAVES:
        long = np.abs(table.response[:, :, DEGREES_OF_FREEDOM.index("heave"), 0])
        worst = float(long.flat[np.argmax(np.abs(np.log(np.maximum(long, 1e-12))))])
        asked.append(question("heave in long waves", worst, f"at {table.frequency[0]:g} rad/s"))
    for motion, name in enumerate(DEGREES_OF_FREEDOM):
        size = np.abs(table.response[:, :, motion])
        at = np.unravel_index(np.argmax(size), size.shape)
        where = f"at {table.frequency[at[2]]:g} rad/s, heading {table.heading[at[1]]:.3g} rad"
        asked.append(question(f"{name} response", float(size[at]), where))
    return [objection for objection in asked if objection]
