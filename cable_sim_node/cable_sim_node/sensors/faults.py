"""Faults scheduled by simulated time: which of them is active now, and by how much."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cable_sim_node.sensors.fault_parameters import FaultParameters, check_kind, check_magnitude

TIME_TOLERANCE = 1e-9
"""Times nearer than this are the same time [s]: tick times are rounded sums."""


@dataclass
class Fault:
    """One fault of one device.

    Attributes
    ----------
    start, end : simulated time [s]; the fault is active at times t with start <= t < end
    magnitude : in the unit of its kind
    taken : whether a fault that happens once has happened
    """

    kind: str
    start: float
    end: float
    magnitude: float
    taken: bool = False

    def is_active(self, time: float) -> bool:
        """Tell whether the fault is active at simulated `time` [s]."""
        return self.start - TIME_TOLERANCE <= time < self.end - TIME_TOLERANCE


class FaultSchedule:
    """The faults of one device, from its parameters and from injections during the run.

    Parameters
    ----------
    parameters : the scheduled faults
    device : name for messages
    known : kinds the device can have; others raise ValueError
    """

    def __init__(self, parameters: FaultParameters, *, device: str, known: tuple[str, ...]) -> None:
        self._device = device
        self._known = known
        self._faults: list[Fault] = []
        columns = (parameters.kind, parameters.start, parameters.duration, parameters.magnitude)
        for kind, start, duration, magnitude in zip(*columns, strict=True):
            self.inject(kind, start=start, duration=duration, magnitude=magnitude)

    def inject(self, kind: str, *, start: float, duration: float, magnitude: float) -> None:
        """Add a fault from `start` [s] for `duration` [s] (0: to the end of the run).

        A `bias` is a jump by another name. Raises ValueError for a kind this device does not know and for numbers a
        fault cannot have.
        """
        kind = "jump" if kind == "bias" else kind
        check_kind(kind, self._known, self._device)
        if not all(math.isfinite(number) for number in (start, duration, magnitude)) or duration < 0.0:
            raise ValueError(
                f"{self._device}: a fault needs a finite start, a duration of at least 0 s and a finite magnitude; "
                f"got {start}, {duration}, {magnitude}"
            )
        check_magnitude(kind, magnitude)
        self._faults.append(Fault(kind, start, start + duration if duration > 0.0 else math.inf, magnitude))

    def clear(self, time: float) -> None:
        """End every fault that is active at `time` [s]; those scheduled for later stay."""
        for fault in self._faults:
            if fault.is_active(time):
                fault.end = time

    def is_active(self, kind: str, time: float) -> bool:
        """Tell whether a fault of `kind` is active at `time` [s]."""
        return any(fault.kind == kind and fault.is_active(time) for fault in self._faults)

    def total(self, kind: str, time: float) -> float:
        """Return the sum of the magnitudes of the active faults of `kind`; 0 without one."""
        return sum(fault.magnitude for fault in self._faults if fault.kind == kind and fault.is_active(time))

    def newest(self, kind: str, time: float) -> float | None:
        """Return the magnitude of the last listed active fault of `kind`, or None."""
        active = [fault.magnitude for fault in self._faults if fault.kind == kind and fault.is_active(time)]
        return active[-1] if active else None

    def take_once(self, kind: str, time: float) -> float:
        """Return the summed magnitudes of the active faults of `kind` not taken before, and mark them as taken."""
        total = 0.0
        for fault in self._faults:
            if fault.kind == kind and not fault.taken and fault.is_active(time):
                fault.taken = True
                total += fault.magnitude
        return total

    def next_start(self, kinds: tuple[str, ...], after: float) -> float:
        """Return the first start of a fault of one of `kinds` later than `after` [s]; infinity without one."""
        starts = [f.start for f in self._faults if f.kind in kinds and f.start > after + TIME_TOLERANCE]
        return min(starts, default=math.inf)
