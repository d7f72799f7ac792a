"""Requests to the services of a run: what each verb asks of whom."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from heave_msgs.srv import InjectFault, Redesign, SaveSnapshot, SetMode, StepSimulation
from heave_node.interface import topics
from heave_node.interface.sensors import SENSORS
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from std_srvs.srv import SetBool


@dataclass(frozen=True)
class Answer:
    """A definite answer, in one line."""

    text: str  # what was done, or why it was not
    is_refused: bool = False  # it was not done


class Task(Protocol):
    """Something that an operator requested."""

    def poll(self) -> Answer | None:
        """Return the answer; None while there is none yet."""

    def cancel(self) -> None:
        """Let go: what was only asked for goes on, what needs the operator ends smoothly."""


def refusal(text: str) -> Answer:
    """Return the answer that says in `text` why something was not done."""
    return Answer(text, is_refused=True)


CONTROLLER, MASTER, RECORDER, WINCH = "winch_controller", "cable_sim", "recorder", "virtual_winch"

ANSWER_TIME = 5.0
"""Wall time in which a service must answer [s]."""
DESIGN_TIME = 60.0
"""Wall time in which a service that designs, or writes a snapshot, must answer [s]."""

NODE_OF_DEVICE = {
    **{name: sensor.topic.publisher for name, sensor in SENSORS.items()},
    "crane": topics.CRANE_POSE.publisher,
    "encoder": WINCH,
    "winch": WINCH,
}
"""The node that simulates each device."""


def plain_answer(response: Any) -> Answer:
    """Return what a service with `success` and `message` said in its `response`."""
    return Answer(response.message, is_refused=not response.success)


@dataclass(frozen=True)
class Request:
    """A request to one service."""

    kind: type[Any]  # type of the service
    service: str  # its relative name
    message: Any  # what is asked
    node: str  # that serves it
    bound: float = ANSWER_TIME  # wall time in which it must answer [s]
    judge: Callable[[Any], Answer] = plain_answer  # makes the answer in words of the service's response


def request_mode(mode: str, tension: float = 0.0, *, unproved: bool = False) -> Request:
    """Request a `mode` of the controller, by its name; the `tension` is for constant_tension [N], 0: the present mean.

    With `unproved` compensation may begin although nothing has proved the motion reference unit.
    """

    def judge(response: Any) -> Answer:
        if not response.success:
            return plain_answer(response)
        taken = response.message
        return Answer(f"mode {taken}" if taken == mode else f"{mode}: {taken}")

    message = SetMode.Request(mode=mode, tension=tension, accept_unproved=unproved)
    return Request(SetMode, "controller/set_mode", message, CONTROLLER, judge=judge)


def request_factor(factor: float) -> Request:
    """Request another share of compensation: `factor`, 0 to 1."""
    value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=factor)
    message = SetParameters.Request(parameters=[Parameter(name="factor", value=value)])

    def judge(response: Any) -> Answer:
        (result,) = response.results
        if result.successful:
            return Answer(f"compensation gain set to {factor:g} (ramps over the fade-in time)")
        return Answer(result.reason or "the controller does not take it", is_refused=True)

    return Request(SetParameters, f"{CONTROLLER}/set_parameters", message, CONTROLLER, judge=judge)


@dataclass(frozen=True)
class WinchLimits:
    """Limits of the winch as the controller assumes them; NaN: unknown."""

    speed: float = math.nan  # largest [m/s]
    acceleration: float = math.nan  # largest [m/s^2]
    payout_minimum: float = math.nan  # least, of the drum, positive lowers [m]
    payout_maximum: float = math.nan  # largest, of the drum, positive lowers [m]


LIMIT_NAMES = ("winch.speed_limit", "winch.acceleration_limit", "winch.payout_minimum", "winch.payout_maximum")


def request_limits(take: Callable[[WinchLimits], None]) -> Request:
    """Ask the controller for the limits of the winch, which it knows of a real one as well; `take` is given them."""

    def judge(response: Any) -> Answer:
        values = [
            value.double_value if value.type == ParameterType.PARAMETER_DOUBLE else math.nan
            for value in response.values
        ]
        take(WinchLimits(*values))
        return Answer("limits of the winch are known")

    message = GetParameters.Request(names=list(LIMIT_NAMES))
    return Request(GetParameters, f"{CONTROLLER}/get_parameters", message, CONTROLLER, judge=judge)


def request_redesign(height: float = 0.0, period: float = 0.0, length: float = 0.0) -> Request:
    """Request a new design without stopping, for a sea of significant wave `height` [m] and peak `period` [s]; 0: as
    estimated from the MRU.

    The `length` is that of the deployed cable [m]; 0: the present one.
    """
    message = Redesign.Request(significant_wave_height=height, peak_period=period, length=length)
    return Request(Redesign, "controller/redesign", message, CONTROLLER, bound=DESIGN_TIME)


def request_fault(device: str, kind: str, duration: float = 0.0, magnitude: float = 0.0) -> Request:
    """Make a simulated `device`, one of NODE_OF_DEVICE, misbehave by a `kind` of fault, or clear it.

    It lasts for a `duration` [s, simulated], 0: once, or until cleared, and its `magnitude` is in the unit of the kind.
    """
    node = NODE_OF_DEVICE[device]
    message = InjectFault.Request(device=device, kind=kind, duration=duration, magnitude=magnitude)
    return Request(InjectFault, f"{node}/inject_fault", message, node)


def request_pause(*, is_paused: bool) -> Request:
    """Request that the run's clock stands (`is_paused`), or goes on."""
    return Request(SetBool, "simulation/pause", SetBool.Request(data=is_paused), MASTER)


def request_step(ticks: int) -> Request:
    """Request that a paused run goes on for a number of `ticks`."""
    return Request(StepSimulation, "simulation/step", StepSimulation.Request(ticks=ticks), MASTER)


def request_snapshot(seconds: float = 0.0, directory: Path | None = None) -> Request:
    """Request that the recorder saves the last `seconds` of the run (0: all it keeps), in a `directory` of your own."""
    where = "" if directory is None else str(directory.resolve())
    message = SaveSnapshot.Request(seconds=seconds, directory=where)

    def judge(response: Any) -> Answer:
        if not response.success:
            return plain_answer(response)
        return Answer(f"snapshot: {response.messages} messages in {response.message}")

    return Request(SaveSnapshot, f"{RECORDER}/snapshot", message, RECORDER, bound=DESIGN_TIME, judge=judge)
