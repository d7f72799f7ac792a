"""What the beliefs may replace: one table of quantities, each with its unit and its place in the parameters.

A quantity that no belief names has its nominal value, which is what the parameters say.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

from winch_controller_node.node_parameters import WinchControllerParameters

SPEED_OUT, SPEED_IN = "winch.speed_out", "winch.speed_in"
ACCELERATION_OUT, ACCELERATION_IN = "winch.acceleration_out", "winch.acceleration_in"
DEADBAND, BACKLASH, POWER_LIMIT = "winch.deadband", "winch.backlash", "winch.power_limit"
ENCODER_SCALE, DEPTH_SCALE, MRU_SCALE = "encoder.scale", "depth.scale", "mru.scale"
MRU_OFFSET, MRU_DELAY = "mru.offset", "mru.delay"

LEAST_SCALE, MOST_SCALE = 0.5 / 1.05, 2.0 * 1.05
"""Range of a scale that is corrected, half to twice the nominal one, and 5 % for the error of its estimate; a reversed
sensor, or one that reads next to nothing, is excluded."""


class Span(str, Enum):
    """What the range of a quantity is: of its values, of its ratio to nominal, or of its difference from nominal."""

    VALUE = "value"
    RATIO = "ratio"
    DIFFERENCE = "difference"


@dataclass(frozen=True)
class Quantity:
    """A quantity.

    Attributes
    ----------
    name : by which messages, findings and reports know it: its owner (winch, encoder, mru, depth, cable, sea), a dot,
        and what it is
    unit : SI; empty for a ratio
    path : of the parameter that holds it; empty: none does, and `nominal` is its nominal value
    nominal : without a parameter
    relative, absolute : change that is worth a report: of its logarithm, or in its unit; neither: any change
    label : in words, where all that is new of its owner is one report
    code : of the alarm that it differs from nominal, where it has one of its own
    lowest, highest : what can be at all; outside, a part has another fault than this quantity
    span : what these two are
    reach : path of the parameter that holds the largest difference from nominal; empty: `lowest` and `highest` do
    """

    name: str
    unit: str
    path: str = ""
    nominal: float = 0.0
    relative: float = 0.0
    absolute: float = 0.0
    label: str = ""
    code: str = ""
    lowest: float = -math.inf
    highest: float = math.inf
    span: Span = Span.VALUE
    reach: str = ""

    @property
    def owner(self) -> str:
        """Part of the system that it belongs to."""
        return self.name.partition(".")[0]

    def nominal_in(self, parameters: WinchControllerParameters) -> float:
        """Return its nominal value in `parameters`."""
        return float(_value(parameters, self.path)) if self.path else self.nominal

    def range_in(self, parameters: WinchControllerParameters) -> tuple[float, float]:
        """Return the lowest and the highest value that can be with nominal `parameters`."""
        nominal = self.nominal_in(parameters)
        if self.reach:
            reach = float(_value(parameters, self.reach))
            return max(nominal - reach, 0.0), nominal + reach
        if self.span is Span.DIFFERENCE:
            return nominal + self.lowest, nominal + self.highest
        if self.span is Span.RATIO:
            # a limit of 0 is none
            return (self.lowest * nominal, self.highest * nominal) if nominal > 0.0 else (0.0, math.inf)
        return min(self.lowest, nominal), max(self.highest, nominal)


SCALE: Mapping[str, Any] = {"lowest": LEAST_SCALE, "highest": MOST_SCALE}
WEAKER: Mapping[str, Any] = {"lowest": 0.05, "highest": 1.0, "span": Span.RATIO}
"""Ranges of a scale, and of a limit that may be below the nominal one."""

QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        Quantity(
            "winch.time_constant",
            "s",
            "winch.time_constant",
            absolute=0.02,
            label="time constant",
            lowest=0.03,
            highest=15.0,
            span=Span.RATIO,
        ),
        Quantity(
            "winch.command_delay",
            "s",
            "winch.command_delay",
            absolute=0.02,
            label="command delay",
            reach="lag.largest",
        ),
        Quantity(
            "winch.speed_gain",
            "",
            "winch.speed_gain",
            relative=0.02,
            label="gain by the encoder",
            span=Span.RATIO,
            **SCALE,
        ),
        Quantity(
            "winch.hauling_gain",
            "",
            "winch.hauling_gain",
            relative=0.05,
            label="gain of hauling in over that",
            span=Span.RATIO,
            **SCALE,
        ),
        Quantity(
            "winch.creep",
            "m/s",
            "winch.creep",
            absolute=0.02,
            label="creep",
            lowest=-0.2,
            highest=0.2,
            span=Span.DIFFERENCE,
        ),
        Quantity(SPEED_OUT, "m/s", "winch.speed_limit", relative=0.1, label="speed limit paying out", **WEAKER),
        Quantity(SPEED_IN, "m/s", "winch.speed_limit", relative=0.1, label="speed limit hauling in", **WEAKER),
        Quantity(
            ACCELERATION_OUT,
            "m/s^2",
            "winch.acceleration_limit",
            relative=0.1,
            label="acceleration limit paying out",
            **WEAKER,
        ),
        Quantity(
            ACCELERATION_IN,
            "m/s^2",
            "winch.acceleration_limit",
            relative=0.1,
            label="acceleration limit hauling in",
            **WEAKER,
        ),
        Quantity(DEADBAND, "m/s", absolute=0.01, label="dead zone", lowest=0.0, highest=0.2),
        Quantity(BACKLASH, "m", absolute=0.005, label="encoder play", lowest=0.0, highest=0.2),
        Quantity(
            POWER_LIMIT,
            "W",
            "winch.power_limit",
            relative=0.1,
            label="power limit",
            lowest=1e-5,
            highest=1.0,
            span=Span.RATIO,
        ),
        Quantity(ENCODER_SCALE, "", nominal=1.0, relative=0.03, code="ENCODER_SCALE_ERROR", **SCALE),
        Quantity(DEPTH_SCALE, "", nominal=1.0, relative=0.05, code="DEPTH_SCALE_ERROR", **SCALE),
        Quantity(MRU_SCALE, "", nominal=1.0, relative=0.05, code="MRU_SCALE_ERROR", **SCALE),
        Quantity(MRU_OFFSET, "m", absolute=0.05, code="MRU_OFFSET", lowest=-5.0, highest=5.0),
        Quantity(MRU_DELAY, "s", absolute=0.03, code="MRU_DELAYED", lowest=-0.4, highest=0.4),
        Quantity(
            "mru.high_pass_period",
            "s",
            "sensors.mru.high_pass_period",
            relative=0.15,
            code="MRU_HIGH_PASS",
            lowest=0.0,
            highest=1000.0,
        ),
        Quantity("mru.bias_drift", "m/sqrt(s)", "sensors.mru.bias_drift", code="MRU_DRIFT", lowest=0.0, highest=0.1),
        Quantity("mru.bias_sigma", "m", "sensors.mru.bias_sigma", lowest=0.0, highest=5.0),
        Quantity(
            "cable.inertia_factor",
            "",
            "cable_model.inertia_factor",
            relative=0.05,
            code="CABLE_INERTIA",
            span=Span.RATIO,
            **SCALE,
        ),
        Quantity(
            "cable.damping_factor",
            "",
            "cable_model.damping_factor",
            relative=0.3,
            code="CABLE_DAMPING",
            lowest=0.1,
            highest=10.0,
            span=Span.RATIO,
        ),
        Quantity(
            "sea.significant_wave_height",
            "m",
            "sea.significant_wave_height",
            relative=0.1,
            label="significant wave height",
            lowest=0.0,
            highest=30.0,
        ),
        Quantity(
            "sea.peak_period",
            "s",
            "sea.peak_period",
            relative=0.05,
            label="peak period",
            lowest=1.0,
            highest=40.0,
        ),
        Quantity(
            "sea.swell.significant_wave_height",
            "m",
            "sea.swell.significant_wave_height",
            relative=0.1,
            label="swell, significant wave height",
            lowest=0.0,
            highest=30.0,
        ),
        Quantity(
            "sea.swell.peak_period",
            "s",
            "sea.swell.peak_period",
            relative=0.05,
            label="swell, peak period",
            lowest=1.0,
            highest=40.0,
        ),
    )
}
"""All of them, by name."""


def out_of_range(values: Mapping[str, float], nominal: WinchControllerParameters) -> str:
    """Return which of the `values`, by quantity, cannot be with `nominal` parameters, in words; empty: all can."""
    for name, value in values.items():
        lowest, highest = QUANTITIES[name].range_in(nominal)
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
