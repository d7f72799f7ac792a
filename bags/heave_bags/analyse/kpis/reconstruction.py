"""What a caller has reconstructed of a run from its sensors alone: motions, figures and their bands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from heave_bags.signals import Signal


@dataclass(frozen=True)
class Reconstruction:
    """What was reconstructed of a run: its unit, and what other laws would have done in its sea.

    Attributes
    ----------
    unit_heave, uncompensated_heave : of the unit, and of it with the winch locked, positive up [m]
    bands : figures of merit by key, in SI units: as reconstructed, and lower and upper end of its band of 90 %
    headings, rows : table of what the laws would have done, texts
    lines : what a reader must know first: the check, and what the record shows
    warnings : what speaks against the answers
    data : all of it for a machine
    """

    unit_heave: Signal
    uncompensated_heave: Signal
    bands: Mapping[str, tuple[float, float, float]]
    headings: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    lines: Sequence[str] = ()
    warnings: Sequence[str] = ()
    data: Mapping[str, Any] = field(default_factory=dict)
