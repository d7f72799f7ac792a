"""What a simulated sensor is: its parameters, and its view of the truth at one time."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from heave_node.interface.faults import FaultParameters, SensorFaultParameters
from heave_node.parameters import group, parameter

if TYPE_CHECKING:
    from heave_node.numerics.arrays import Array  # numpy, which parameters need not load


class View(NamedTuple):
    """What a sensor without noise would say at one time, and how good it is then."""

    value: Array  # shape (n,), SI units
    sigma: Array | float  # standard deviation of the white noise of each value, or of all
    bias: Array | float = 0.0  # constant error of each value, or of all
    extra_latency: float = 0.0  # of a sample taken now, beyond the sensor's own [s]
    resolution: Sequence[float] = ()  # to which each value is rounded, 0: it is not; empty: none is


@dataclass(frozen=True)
class SensorParameters(abc.ABC):
    """What every sensor has: when it measures, when its readings arrive, and its scheduled faults.

    Samples are taken at ticks: the first one at or after each whole multiple of 1/rate. A rate above the tick rate
    gives one sample a tick.
    """

    fitted: bool = parameter(True, description="The sensor is fitted.")
    rate: float = parameter(10.0, "Hz", 0.01, 1000.0, "Samples per second.")
    latency: float = parameter(0.0, "s", 0.0, 5.0, "Delay from time stamp to delivery.")
    scale_error: float = parameter(0.0, "", -1.0, 1.0, "Relative scale error: 0.05 reads 5 % high.")
    faults: FaultParameters = group(SensorFaultParameters)

    @abc.abstractmethod
    def view(self, truth: Any) -> View:
        """Return what this sensor sees of the truth."""


def quantised(value: float, step: float) -> float:
    """Return a `value` rounded to a whole multiple of a `step`; as it is where that is 0, or it is no number."""
    return step * round(value / step, 0) if step > 0.0 else value
