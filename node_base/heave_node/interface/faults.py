"""Faults of simulated devices, scheduled by simulated time or injected during a run; of what kinds: `fault_kinds`."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from heave_node.interface.fault_kinds import FAULTS, LARGEST_DELAY, PAYS_OUT, faults_of
from heave_node.parameters import parameter

if TYPE_CHECKING:
    from heave_node.numerics.arrays import Array  # numpy, which parameters need not load

Values = TypeVar("Values", "Array", float)
"""Numbers of one sample."""

TIME_TOLERANCE = 1e-9
"""Times nearer than this are the same time [s]: tick times are rounded sums."""


_KINDS = "Kinds of the scheduled faults."


@dataclass(frozen=True)
class FaultParameters:
    """The scheduled faults of a device, one per position of four lists: parameter files have no lists of records."""

    kind: tuple[str, ...] = parameter((), description=_KINDS, choices=tuple(FAULTS))
    start: tuple[float, ...] = parameter((), "s", 0.0, None, "Start of each fault, simulated time.")
    duration: tuple[float, ...] = parameter((), "s", 0.0, None,
        "Duration of each fault; 0: until cleared or to the end of the run.")  # fmt: skip
    magnitude: tuple[float, ...] = parameter((),
        description="Magnitude of each: sensor's unit for spike and jump, factor for scale, Hz for rate, s for delay.",
    )  # fmt: skip

    def check(self, name: str, device: str) -> None:
        """Raise ValueError, opened by `name`, where these are not faults that a kind of `device` can have."""
        FaultSchedule(self, name=name, device=device)


@dataclass(frozen=True)
class SensorFaultParameters(FaultParameters):
    """The scheduled faults of a sensor."""

    kind: tuple[str, ...] = parameter((), description=_KINDS, choices=faults_of("sensor"))


@dataclass(frozen=True)
class MruFaultParameters(FaultParameters):
    """The scheduled faults of the motion reference unit."""

    kind: tuple[str, ...] = parameter((), description=_KINDS, choices=faults_of("mru"))


@dataclass(frozen=True)
class EncoderFaultParameters(FaultParameters):
    """The scheduled faults of the drum's encoder."""

    kind: tuple[str, ...] = parameter((), description=_KINDS, choices=faults_of("encoder"))


@dataclass(frozen=True)
class WinchFaultParameters(FaultParameters):
    """The scheduled faults of the winch."""

    kind: tuple[str, ...] = parameter((), description=_KINDS, choices=faults_of("winch"))


@dataclass
class Fault:
    """One fault of one device."""

    kind: str  # of FAULTS
    start: float  # simulated time [s]; the fault is active at times t with start <= t < end
    end: float  # simulated time [s]
    magnitude: float  # in the unit of its kind
    is_taken: bool = False  # whether a fault that happens once has happened

    def has_begun(self, time: float) -> bool:
        """Return whether the fault has begun by simulated `time` [s]."""
        return self.start - TIME_TOLERANCE <= time

    def is_active(self, time: float) -> bool:
        """Return whether the fault is active at simulated `time` [s]."""
        return self.has_begun(time) and time < self.end - TIME_TOLERANCE


class FaultSchedule:
    """The faults of one device, from its parameters and from injections during the run.

    Parameters
    ----------
    parameters : the scheduled faults
    name : of the device, for messages
    device : kind of the device
    usual_duration : by kind, the duration [s] where 0 does not mean until cleared
    seed : of the run, for jitter

    Raises ValueError for lists of unequal length, and as `inject` does.
    """

    def __init__(
        self,
        parameters: FaultParameters,
        *,
        name: str,
        device: str,
        usual_duration: Mapping[str, float] | None = None,
        seed: int = 0,
    ) -> None:
        self._name = name
        self._device = device
        self._usual_duration = usual_duration or {}
        self._faults: list[Fault] = []
        self._random = random.Random(f"{name}/jitter {seed}")
        columns = (parameters.kind, parameters.start, parameters.duration, parameters.magnitude)
        lengths = [len(column) for column in columns]
        if len(set(lengths)) > 1:
            raise ValueError(
                f"{name}: the lists kind, start, duration and magnitude must have the same length; "
                f"got {', '.join(map(str, lengths))}"
            )
        # in order of time, so that a clear finds what it ends
        for kind, start, duration, magnitude in sorted(zip(*columns, strict=True), key=lambda fault: fault[1]):
            self.inject(kind, start=start, duration=duration, magnitude=magnitude)

    def inject(self, kind: str, *, start: float, duration: float = 0.0, magnitude: float = 0.0) -> None:
        """Add a fault, or clear those that are active at `start`.

        Parameters
        ----------
        kind : of FAULTS
        start : simulated time [s]
        duration : [s]; 0: until cleared or to the end of the run
        magnitude : in the unit of its kind

        Raises ValueError for a kind that this device does not know and for numbers that a fault cannot have.
        """
        self._check(kind, start, duration, magnitude)
        if kind == "clear":
            for fault in self._faults:
                if fault.is_active(start):
                    fault.end, fault.is_taken = start, True
            return
        lasting = duration if duration > 0.0 else self._usual_duration.get(kind, math.inf)
        self._faults.append(Fault(kind, start, start + lasting, magnitude))

    def _check(self, kind: str, start: float, duration: float, magnitude: float) -> None:
        known = faults_of(self._device)
        largest_delay = LARGEST_DELAY.get(self._device, math.inf)
        wrong = ""
        if kind not in known:
            wrong = f"a fault of kind {kind} is unknown; known: {', '.join(known)}"
        elif not all(math.isfinite(number) for number in (start, duration, magnitude)) or duration < 0.0:
            wrong = (
                "a fault needs a finite start, a duration of at least 0 s and a finite magnitude; "
                f"got {start}, {duration}, {magnitude}"
            )
        elif kind == "rate" and magnitude <= 0.0:
            wrong = f"the magnitude of kind rate must be above 0 Hz; got {magnitude:g}"
        elif kind == "scale" and magnitude == 0.0:
            wrong = "the magnitude of kind scale must be a factor that is not 0, such as -1 or 0.5; got 0"
        elif kind == "low_pressure" and magnitude <= 0.0:
            wrong = f"the magnitude of kind low_pressure must be above 0; got {magnitude:g}"
        elif FAULTS[kind].magnitude == PAYS_OUT and magnitude < 0.0:
            wrong = f"the magnitude of kind {kind} must be at least 0 m/s; got {magnitude:g}"
        elif kind in ("delay", "jitter") and not 0.0 <= magnitude <= largest_delay:
            wrong = f"the magnitude of kind {kind} must be from 0 to {largest_delay:g} s; got {magnitude:g}"
        if wrong:
            raise ValueError(f"{self._name}: {wrong}")

    @property
    def is_empty(self) -> bool:
        """Whether there is no fault at all, past or to come."""
        return not self._faults

    def is_active(self, kind: str, time: float) -> bool:
        """Return whether a fault of `kind` is active at `time` [s]."""
        return bool(self._faults) and any(fault.kind == kind and fault.is_active(time) for fault in self._faults)

    def any_active(self, time: float) -> bool:
        """Return whether any fault is active at `time` [s]."""
        return bool(self._faults) and any(fault.is_active(time) for fault in self._faults)

    def total(self, kind: str, time: float) -> float:
        """Return the sum of the magnitudes of the faults of `kind` that are active at `time` [s]; 0 without one."""
        if not self._faults:
            return 0.0
        return sum(fault.magnitude for fault in self._faults if fault.kind == kind and fault.is_active(time))

    def lateness(self, time: float) -> float:
        """Return how late what is sent at `time` [s] arrives by delay and jitter [s]; to be asked once per message."""
        spread = self.total("jitter", time)
        return self.total("delay", time) + (self._random.uniform(0.0, spread) if spread else 0.0)

    def product(self, kind: str, time: float) -> float:
        """Return the product of the magnitudes of the faults of `kind` that are active at `time` [s]; 1 without one."""
        return math.prod(fault.magnitude for fault in self._faults if fault.kind == kind and fault.is_active(time))

    def newest(self, kind: str, time: float) -> float | None:
        """Return the magnitude of the fault of `kind` that is active at `time` [s] and was added last, or None."""
        if not self._faults:
            return None
        active = [fault.magnitude for fault in self._faults if fault.kind == kind and fault.is_active(time)]
        return active[-1] if active else None

    def take_once(self, kind: str, time: float) -> float:
        """Return the sum of the new faults of `kind` active at `time` [s], by magnitude; mark them as taken."""
        total = 0.0
        for fault in self._faults:
            if fault.kind == kind and not fault.is_taken and fault.is_active(time):
                fault.is_taken = True
                total += fault.magnitude
        return total

    def take_begun(self, kind: str, time: float) -> Fault | None:
        """Return a fault of `kind` that has begun by `time` [s] and was not taken before, and mark it as taken."""
        for fault in self._faults:
            if fault.kind == kind and not fault.is_taken and fault.has_begun(time):
                fault.is_taken = True
                return fault
        return None

    def next_start(self, kinds: tuple[str, ...], after: float) -> float:
        """Return the first start of a fault of one of `kinds` later than `after` [s]; infinity without one."""
        starts = [f.start for f in self._faults if f.kind in kinds and f.start > after + TIME_TOLERANCE]
        return min(starts, default=math.inf)


class FaultyValues:
    """What freeze, spike, jump, scale and nan make of the values of a device, sample by sample.

    Parameters
    ----------
    faults : of the device
    axes : shape (n,) or a number, what share of a spike or jump each value gets
    scaled : the same of a scale; 1 for a value that is multiplied, 0 for one that is not
    """

    def __init__(self, faults: FaultSchedule, axes: Array | float = 1.0, scaled: Array | float = 1.0) -> None:
        self._faults = faults
        self._axes: Any = axes
        self._scaled: Any = scaled
        self._last: Any = None

    def apply(self, time: float, values: Values) -> Values:
        """Return what the device says at `time` [s] in place of `values`, shape (n,) or one number; once per sample."""
        faults = self._faults
        if faults.is_empty:
            self._last = values
            return values
        if faults.any_active(time):
            scale = 1.0 + self._scaled * (faults.product("scale", time) - 1.0)
            values = values * scale + self._axes * (faults.total("jump", time) + faults.take_once("spike", time))
            if faults.is_active("freeze", time) and self._last is not None:
                values = self._last
        self._last = values
        return values * math.nan if faults.is_active("nan", time) else values
