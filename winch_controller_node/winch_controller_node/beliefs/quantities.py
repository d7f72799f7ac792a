"""What the beliefs may replace: one table of quantities, each with its unit and its place in the parameters.

A quantity that no belief names has its nominal value, which is what the parameters say.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, NamedTuple

from winch_controller_node.node_parameters import WinchControllerParameters

SPEED_OUT, SPEED_IN = "winch.speed_out", "winch.speed_in"
ACCELERATION_OUT, ACCELERATION_IN = "winch.acceleration_out", "winch.acceleration_in"
DEADBAND, BACKLASH, POWER_LIMIT = "winch.deadband", "winch.backlash", "winch.power_limit"
ENCODER_SCALE, DEPTH_SCALE, MRU_SCALE = "encoder.scale", "depth.scale", "mru.scale"
MRU_OFFSET, MRU_DELAY = "mru.offset", "mru.delay"


@dataclass(frozen=True)
class Quantity:
    """A quantity."""

    # by which messages, findings and reports know it: its owner (winch, encoder, mru, depth, cable, sea), a dot, and
    # what it is
    name: str
    unit: str  # SI; empty for a ratio
    path: str = ""  # of the parameter that holds it; empty: none does, and `nominal` is its nominal value
    nominal: float = 0.0  # nominal value where no parameter gives it, in its unit
    relative: float = 0.0  # change of its logarithm that is worth a report [-]; 0 here and in `absolute`: any change
    absolute: float = 0.0  # change that is worth a report, in its unit
    label: str = ""  # in words, where all that is new of its owner is one report
    alarm: str = ""  # name of the alarm that it differs from nominal, where it has one of its own

    @property
    def owner(self) -> str:
        """Part of the system that it belongs to."""
        return self.name.partition(".")[0]

    def nominal_in(self, parameters: WinchControllerParameters) -> float:
        """Return its nominal value in `parameters`."""
        return float(_value(parameters, self.path)) if self.path else self.nominal


QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        Quantity("winch.time_constant", "s", "winch.time_constant", absolute=0.02, label="time constant"),
        Quantity("winch.command_delay", "s", "winch.command_delay", absolute=0.02, label="command delay"),
        Quantity("winch.speed_gain", "", "winch.speed_gain", relative=0.02, label="gain by the encoder"),
        Quantity("winch.hauling_gain", "", "winch.hauling_gain", relative=0.05, label="relative gain hauling in"),
        Quantity("winch.creep", "m/s", "winch.creep", absolute=0.02, label="creep"),
        Quantity(SPEED_OUT, "m/s", "winch.speed_limit", relative=0.1, label="speed limit paying out"),
        Quantity(SPEED_IN, "m/s", "winch.speed_limit", relative=0.1, label="speed limit hauling in"),
        Quantity(
            ACCELERATION_OUT, "m/s^2", "winch.acceleration_limit", relative=0.1, label="acceleration limit paying out"
        ),
        Quantity(
            ACCELERATION_IN, "m/s^2", "winch.acceleration_limit", relative=0.1, label="acceleration limit hauling in"
        ),
        Quantity(DEADBAND, "m/s", absolute=0.01, label="dead zone"),
        Quantity(BACKLASH, "m", absolute=0.005, label="encoder backlash"),
        Quantity(POWER_LIMIT, "W", "winch.power_limit", relative=0.1, label="power limit"),
        Quantity(ENCODER_SCALE, "", nominal=1.0, relative=0.03, alarm="IDENTIFIED, ENCODER: scale"),
        Quantity(DEPTH_SCALE, "", nominal=1.0, relative=0.05, alarm="IDENTIFIED, DEPTH: scale"),
        Quantity(MRU_SCALE, "", nominal=1.0, relative=0.05, alarm="IDENTIFIED, MRU: scale"),
        Quantity(MRU_OFFSET, "m", absolute=0.05, alarm="IDENTIFIED, MRU: offset"),
        Quantity(MRU_DELAY, "s", absolute=0.03, alarm="IDENTIFIED, MRU: delay"),
        Quantity(
            "mru.high_pass_period",
            "s",
            "sensors.mru.high_pass_period",
            relative=0.15,
            alarm="IDENTIFIED, MRU: high pass",
        ),
        Quantity("mru.bias_drift", "m/sqrt(s)", "sensors.mru.bias_drift", alarm="IDENTIFIED, MRU: drift"),
        Quantity("mru.bias_sigma", "m", "sensors.mru.bias_sigma"),
        Quantity(
            "cable.inertia_factor", "", "cable_model.inertia_factor", relative=0.05, alarm="IDENTIFIED, CABLE: inertia"
        ),
        Quantity(
            "cable.damping_factor", "", "cable_model.damping_factor", relative=0.3, alarm="IDENTIFIED, CABLE: damping"
        ),
        Quantity(
            "sea.significant_wave_height",
            "m",
            "sea.significant_wave_height",
            relative=0.1,
            label="significant wave height",
        ),
        Quantity("sea.peak_period", "s", "sea.peak_period", relative=0.05, label="peak period"),
        Quantity(
            "sea.swell.significant_wave_height",
            "m",
            "sea.swell.significant_wave_height",
            relative=0.1,
            label="swell, significant wave height",
        ),
        Quantity("sea.swell.peak_period", "s", "sea.swell.peak_period", relative=0.05, label="swell, peak period"),
    )
}
"""All of them, by name."""


class Span(Enum):
    """What a range is of: values, their ratio to nominal, or their difference from it."""

    VALUE, RATIO, DIFFERENCE = range(3)


class Range(NamedTuple):
    """What a quantity can be at all, `lowest` to `highest` of a `span`; outside, its part has another fault."""

    lowest: float
    highest: float
    span: Span = Span.VALUE

    def about(self, nominal: float) -> tuple[float, float]:
        """Return the lowest and the highest value about a `nominal` one."""
        if self.span is Span.DIFFERENCE:
            return nominal + self.lowest, nominal + self.highest
        if self.span is Span.RATIO:
            # a limit of 0 is none
            return (self.lowest * nominal, self.highest * nominal) if nominal > 0.0 else (0.0, math.inf)
        return min(self.lowest, nominal), max(self.highest, nominal)


SCALE = Range(0.5 / 1.05, 2.0 * 1.05)
"""Range of a scale: half to twice, and 5 % for the error of its estimate. A sensor that is reversed, or reads next to
nothing, is excluded."""

SCALED, WEAKER = SCALE._replace(span=Span.RATIO), Range(0.05, 1.0, Span.RATIO)
HEIGHT, PERIOD = Range(0.0, 30.0), Range(1.0, 40.0)

RANGES = {
    "winch.time_constant": Range(0.03, 15.0, Span.RATIO),
    "winch.speed_gain": SCALED,
    "winch.hauling_gain": SCALED,
    "winch.creep": Range(-0.2, 0.2, Span.DIFFERENCE),
    SPEED_OUT: WEAKER,
    SPEED_IN: WEAKER,
    ACCELERATION_OUT: WEAKER,
    ACCELERATION_IN: WEAKER,
    DEADBAND: Range(0.0, 0.2),
    BACKLASH: Range(0.0, 0.2),
    POWER_LIMIT: Range(1e-5, 1.0, Span.RATIO),
    ENCODER_SCALE: SCALE,
    DEPTH_SCALE: SCALE,
    MRU_SCALE: SCALE,
    MRU_OFFSET: Range(-5.0, 5.0),
    MRU_DELAY: Range(-0.4, 0.4),
    "mru.high_pass_period": Range(0.0, 1000.0),
    "mru.bias_drift": Range(0.0, 0.1),
    "mru.bias_sigma": Range(0.0, 5.0),
    "cable.inertia_factor": SCALED,
    "cable.damping_factor": Range(0.1, 10.0, Span.RATIO),
    "sea.significant_wave_height": HEIGHT,
    "sea.peak_period": PERIOD,
    "sea.swell.significant_wave_height": HEIGHT,
    "sea.swell.peak_period": PERIOD,
}
"""Range of each quantity; that of the delay is `lag.largest` about nominal."""


def range_of(name: str, nominal: WinchControllerParameters) -> tuple[float, float]:
    """Return the lowest and the highest value of the quantity `name` that can be with `nominal` parameters."""
    value = QUANTITIES[name].nominal_in(nominal)
    if name in RANGES:
        return RANGES[name].about(value)
    return max(value - nominal.lag.largest, 0.0), value + nominal.lag.largest


def out_of_range(values: Mapping[str, float], nominal: WinchControllerParameters) -> str:
    """Return which of the `values`, by quantity, cannot be with `nominal` parameters, in words; empty: all can."""
    for name, value in values.items():
        lowest, highest = range_of(name, nominal)
        if not lowest <= value <= highest:
            return f"{name} {value:.3g} is outside {lowest:.3g} to {highest:.3g}"
    return ""


RESTATED = (
    "length",
    "sea.significant_wave_height",
    "sea.peak_period",
    "sea.swell.significant_wave_height",
    "sea.swell.peak_period",
)
"""Parameters that an operator's redesign restates."""


def restated(first: WinchControllerParameters, now: WinchControllerParameters) -> tuple[tuple[str, float], ...]:
    """Return those of RESTATED that are other `now` than at `first`."""
    return tuple((path, float(_value(now, path))) for path in RESTATED if _value(now, path) != _value(first, path))


def with_value(parameters: WinchControllerParameters, path: str, value: float) -> WinchControllerParameters:
    """Return `parameters` with another `value` of the one at a dotted `path`."""
    replaced: WinchControllerParameters = _replaced(parameters, path.split("."), value)
    return replaced


def _value(holder: Any, path: str) -> Any:
    for name in path.split("."):
        holder = getattr(holder, name)
    return holder


def _replaced(holder: Any, path: list[str], value: float) -> Any:
    first, *rest = path
    return replace(holder, **{first: _replaced(getattr(holder, first), rest, value) if rest else value})
