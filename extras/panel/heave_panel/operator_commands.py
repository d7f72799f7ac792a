"""The operator's buttons: what each does, and what is asked before anything moves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from heave_bringup.operate.link import RunLink
from heave_bringup.operate.moves import Lowering, MoveBy
from heave_bringup.operate.requests import (
    NODE_OF_DEVICE,
    request_factor,
    request_fault,
    request_mode,
    request_redesign,
    request_snapshot,
)
from heave_bringup.operate.situation import Situation
from heave_bringup.operate.tasks import AnyOf, ClockTask, Stop, Task
from heave_node.interface.fault_kinds import FAULTS

INJECT = "inject"
NUDGE = 0.1
"""Speed of the buttons that lower and lift [m/s]."""
NUDGE_TIME = 1.0
"""Simulated time for which one push of them holds [s]."""

Begin = Callable[[RunLink, str], Task]


@dataclass(frozen=True)
class Command:
    """What a button does."""

    name: str  # on the button
    begin: Begin  # makes the task of what was typed
    question: str = ""  # for what is to be typed; "" where nothing is
    is_confirmed: bool = False  # asks before it begins: the winch moves, or stops moving
    # raises ValueError, in words, for what was typed wrongly; nobody is asked whether that is meant
    check: Callable[[str], object] = str
    # acts on what is simulated, or on the clock of a simulation; no part of operating a winch
    is_of_simulation: bool = False


def number(text: str, least: float = -math.inf, most: float = math.inf) -> float:
    """Return the number that was typed; raise ValueError, in words, for another `text` or beyond `least` and `most`."""
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"{text!r} is no number") from None
    if not (math.isfinite(value) and least <= value <= most):
        raise ValueError(f"{text}: must be from {least:g} to {most:g}")
    return value


def fault_of(text: str) -> tuple[str, str, float, float]:
    """Return device, kind, duration [s] and magnitude of DEVICE,KIND[,DURATION[,MAGNITUDE]].

    Raises ValueError, in words, for a `text` that is no fault.
    """
    device, kind, *numbers = [*(word.strip() for word in text.split(",")), ""][: max(text.count(",") + 1, 2)]
    if device not in NODE_OF_DEVICE:
        raise ValueError(f"{device!r} is no device; devices are {', '.join(NODE_OF_DEVICE)}")
    if kind not in FAULTS:
        raise ValueError(f"{kind!r} is no kind of fault; kinds are {', '.join(FAULTS)}")
    if len(numbers) > 2:
        raise ValueError("a fault is DEVICE,KIND[,DURATION[,MAGNITUDE]]")
    duration, magnitude = [*(number(word) for word in numbers), 0.0, 0.0][:2]
    return device, kind, duration, magnitude


def devices_of(situation: Situation) -> tuple[str, ...]:
    """Return the devices that can be given a fault in a `situation`; all of them while that is not known."""
    return tuple(NODE_OF_DEVICE) if situation.simulated is None else situation.simulated


def _fault(link: RunLink, text: str) -> Task:
    device, kind, duration, magnitude = fault_of(text)
    simulated = devices_of(link.situation)
    if device not in simulated:
        raise ValueError(f"{device} is not simulated in this run; what is: {', '.join(simulated) or 'nothing'}")
    return link.start(request_fault(device, kind, duration, magnitude))


def _clear(link: RunLink, _: str) -> Task:
    simulated = devices_of(link.situation)
    if not simulated:
        raise ValueError("nothing is simulated in this run: there is no fault to clear")
    return AnyOf([link.start(request_fault(device, "clear")) for device in simulated])


def _pause(link: RunLink, _: str) -> Task:
    return ClockTask(link, is_paused=not link.situation.is_paused)


COMMANDS: tuple[Command, ...] = (
    Command("compensate", lambda link, _: link.start(request_mode("compensating")), is_confirmed=True),
    Command("standby", lambda link, _: link.start(request_mode("standby")), is_confirmed=True),
    Command("tension", lambda link, _: link.start(request_mode("constant_tension")), is_confirmed=True),
    Command("manual", lambda link, _: link.start(request_mode("manual")), is_confirmed=True),
    Command("stop", lambda link, _: Stop(link)),
    Command(
        "depth",
        lambda link, text: link.start_move(number(text), 0.0),
        "depth [m]",
        is_confirmed=True,
        check=number,
    ),
    Command(
        "move by",
        lambda link, text: MoveBy(link, number(text), 0.0),
        "down by [m]",
        is_confirmed=True,
        check=number,
    ),
    Command("lower", lambda link, _: Lowering(link, NUDGE, NUDGE_TIME)),
    Command("lift", lambda link, _: Lowering(link, -NUDGE, NUDGE_TIME)),
    Command("hold", lambda link, _: link.cancel_moves()),
    Command("factor", lambda link, text: link.start(request_factor(number(text, 0.0, 1.0))), "factor, 0 to 1"),
    Command("redesign", lambda link, _: link.start(request_redesign()), is_confirmed=True),
    Command(
        INJECT,
        _fault,
        "DEVICE,KIND[,DURATION[,MAGNITUDE]]",
        is_confirmed=True,
        check=fault_of,
        is_of_simulation=True,
    ),
    Command("clear faults", _clear, is_of_simulation=True),
    Command("pause", _pause, is_of_simulation=True),
    Command("step", lambda link, _: ClockTask(link, ticks=1), is_of_simulation=True),
    Command("snapshot", lambda link, _: link.start(request_snapshot())),
)
"""All buttons but the emergency stop."""
