"""Faults of the MRU, scheduled or injected: what holds when."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wave_vessel_node.parameters import MruParameters

RESTART, GAP, FREEZE, SPIKE, BIAS, DELAY = "restart", "gap", "freeze", "spike", "bias", "delay"
FAULT_KINDS = (RESTART, GAP, FREEZE, SPIKE, BIAS, DELAY)
LONGEST_DELAY = 10.0
"""Largest magnitude of a delay [s]."""
_SAME_TIME = 1e-9  # s


@dataclass
class MruFault:
    """One fault: it holds for start <= time < end [s].

    Attributes
    ----------
    size : of a spike or bias [m], of a delay [s]
    taken : whether a fault that happens once has happened
    """

    kind: str
    start: float
    end: float
    size: float = 0.0
    taken: bool = False

    def is_active(self, time: float) -> bool:
        """Tell whether the fault holds at `time` [s]."""
        return self.start - _SAME_TIME <= time < self.end - _SAME_TIME


class MruFaults:
    """The faults of a unit whose readings are `reading_period` [s] apart."""

    def __init__(self, parameters: MruParameters, reading_period: float) -> None:
        self._restart_duration = parameters.restart_duration
        self._reading_period = reading_period
        self._faults: list[MruFault] = []
        for start in parameters.restart_time:
            self.inject(RESTART, start, parameters.restart_duration)
        for start, duration in zip(parameters.dropout_start, parameters.dropout_duration, strict=True):
            self.inject(GAP, start, duration)
        for start, duration in zip(parameters.freeze_start, parameters.freeze_duration, strict=True):
            self.inject(FREEZE, start, duration)
        for start, size in zip(parameters.spike_time, parameters.spike_size, strict=True):
            self.inject(SPIKE, start, 0.0, size)

    def inject(self, kind: str, start: float, duration: float = 0.0, size: float = 0.0) -> None:
        """Add a fault; see `MotionReferenceUnit.inject`."""
        if kind not in FAULT_KINDS:
            raise ValueError(f"the MRU knows no fault {kind!r}: use one of {', '.join(FAULT_KINDS)}")
        if not (math.isfinite(duration) and duration >= 0.0 and math.isfinite(size)):
            raise ValueError(f"a fault needs a duration of at least 0 s and a finite size; got {duration} and {size}")
        if kind == DELAY and not 0.0 <= size <= LONGEST_DELAY:
            raise ValueError(f"a delay of the MRU is from 0 to {LONGEST_DELAY:g} s; got {size}")
        if kind == SPIKE:
            duration = self._reading_period
        elif kind == RESTART and duration == 0.0:
            duration = self._restart_duration
        elif duration == 0.0:
            duration = math.inf
        self._faults.append(MruFault(kind, start, start + duration, size))

    def clear(self, time: float) -> None:
        """End every fault that holds at `time` [s]; those scheduled for later stay."""
        for fault in self._faults:
            if fault.is_active(time):
                fault.end = time

    def is_active(self, kind: str, time: float) -> bool:
        """Tell whether a fault of `kind` holds at `time` [s]."""
        return any(fault.kind == kind and fault.is_active(time) for fault in self._faults)

    def size(self, kind: str, time: float) -> float:
        """Return the sum of the sizes of the faults of `kind` that hold at `time` [s]."""
        return sum(fault.size for fault in self._faults if fault.kind == kind and fault.is_active(time))

    def take_restart(self, time: float) -> MruFault | None:
        """Return a restart that begins at or before `time` [s] and was not taken yet."""
        for fault in self._faults:
            if fault.kind == RESTART and not fault.taken and time >= fault.start - _SAME_TIME:
                fault.taken = True
                return fault
        return None
