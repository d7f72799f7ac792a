"""The operator's buttons: what each does, and what is asked before anything moves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from heave_bringup.operate.link import RunLink
from heave_bringup.operate.moves import Lowering, MoveBy
from heave_bringup.operate.requests import (
    NODE_OF_DEVICE,
    Task,
    request_factor,
    request_fault,
    request_mode,
    request_redesign,
    request_snapshot,
)
from heave_bringup.operate.situation import Situation
from heave_bringup.operate.tasks import AnyOf, ClockTask, Stop

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


def devices_of(situation: Situation) -> tuple[str, ...]:
    """Return the devices that can be given a fault in a `situation`; all of them while that is not known."""
    return tuple(NODE_OF_DEVICE) if situation.simulated is None else situation.simulated


def inject(link: RunLink, device: str, kind: str, duration: float, magnitude: float) -> Task:
    """Inject a fault of a `kind` into a `device` by a `link`; raise ValueError, in words, where that is not simulated.

    `duration` [s] 0: once, or until cleared; `magnitude` in the unit of the kind.
    """
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
    Command("depth", lambda link, text: link.start_move(number(text), 0.0), "depth [m]", is_confirmed=True),
    Command("move by", lambda link, text: MoveBy(link, number(text), 0.0), "down by [m]", is_confirmed=True),
    Command("lower", lambda link, _: Lowering(link, NUDGE, NUDGE_TIME)),
    Command("lift", lambda link, _: Lowering(link, -NUDGE, NUDGE_TIME)),
    Command("hold", lambda link, _: link.cancel_moves()),
    Command("factor", lambda link, text: link.start(request_factor(number(text, 0.0, 1.0))), "factor, 0 to 1"),
    Command("redesign", lambda link, _: link.start(request_redesign()), is_confirmed=True),
    Command("clear faults", _clear, is_of_simulation=True),
    Command("pause", _pause, is_of_simulation=True),
    Command("step", lambda link, _: ClockTask(link, ticks=1), is_of_simulation=True),
    Command("snapshot", lambda link, _: link.start(request_snapshot())),
)
"""All buttons but those of the emergency stop and of a fault."""
