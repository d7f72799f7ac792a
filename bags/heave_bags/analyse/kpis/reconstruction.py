"""What a caller has reconstructed of a run from its sensors alone: motions, figures and their bands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from heave_bags.signals import Signal


@dataclass(frozen=True)
class Reconstruction:
    """What was reconstructed of a run: its unit, and what other laws would have done in its sea."""

    unit_heave: Signal  # of the unit, positive up [m]
    uncompensated_heave: Signal  # of the unit with the winch locked, positive up [m]
    # figures of merit by key, in SI units: as reconstructed, and lower and upper end of its band of 90 %
    bands: Mapping[str, tuple[float, float, float]]
    headings: Sequence[str] = ()  # of the table of what the laws would have done
    rows: Sequence[Sequence[str]] = ()  # of that table, texts
    lines: Sequence[str] = ()  # what a reader must know first: the check, and what the record shows
    warnings: Sequence[str] = ()  # what speaks against the answers
    data: Mapping[str, Any] = field(default_factory=dict)  # all of it for a machine
