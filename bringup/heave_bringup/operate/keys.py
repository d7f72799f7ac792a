"""The keys of the screen: what each does, and what is asked before anything moves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from heave_node.interface.fault_kinds import FAULTS

from heave_bringup.operate.answer import refusal
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
from heave_bringup.operate.tasks import AnyOf, ClockTask, EmergencyStop, Link, Stop, Task

EMERGENCY, QUIT, ESCAPE, ENTER, ERASE = " ", "q", "\x1b", ("\r", "\n"), ("\x7f", "\b")
NUDGE = 0.1
"""Speed of the keys that lower and lift [m/s]."""
NUDGE_TIME = 1.0
"""Simulated time for which one stroke of them holds [s]."""

Begin = Callable[[Link, str], Task]


@dataclass(frozen=True)
class Command:
    """What a key does.

    Attributes
    ----------
    key : that is pressed
    name : in the line of keys
    begin : makes the task of what was typed
    question : for what is to be typed; "" where nothing is
    is_confirmed : asks before it begins: the winch moves, or stops moving
    check : raises ValueError, in words, for what was typed wrongly; nobody is asked whether that is meant
    is_of_simulation : acts on what is simulated, or on the clock of a simulation; no part of operating a winch
    """

    key: str
    name: str
    begin: Begin
    question: str = ""
    is_confirmed: bool = False
    check: Callable[[str], object] = str
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


def _fault(link: Link, text: str) -> Task:
    device, kind, duration, magnitude = fault_of(text)
    simulated = devices_of(link.situation)
    if device not in simulated:
        raise ValueError(f"{device} is not simulated in this run; what is: {', '.join(simulated) or 'nothing'}")
    return link.start(request_fault(device, kind, duration, magnitude))


def _clear(link: Link, _: str) -> Task:
    simulated = devices_of(link.situation)
    if not simulated:
        raise ValueError("nothing is simulated in this run: there is no fault to clear")
    return AnyOf([link.start(request_fault(device, "clear")) for device in simulated])


def _pause(link: Link, _: str) -> Task:
    return ClockTask(link, is_paused=not link.situation.is_paused)


COMMANDS: tuple[Command, ...] = (
    Command("c", "compensate", lambda link, _: link.start(request_mode("compensating")), is_confirmed=True),
    Command("b", "standby", lambda link, _: link.start(request_mode("standby")), is_confirmed=True),
    Command("t", "tension", lambda link, _: link.start(request_mode("constant_tension")), is_confirmed=True),
    Command("m", "manual", lambda link, _: link.start(request_mode("manual")), is_confirmed=True),
    Command("s", "stop", lambda link, _: Stop(link)),
    Command(
        "d",
        "depth",
        lambda link, text: link.start_move(number(text), 0.0),
        "depth [m]",
        is_confirmed=True,
        check=number,
    ),
    Command(
        "v",
        "move by",
        lambda link, text: MoveBy(link, number(text), 0.0),
        "down by [m]",
        is_confirmed=True,
        check=number,
    ),
    Command("j", "lower", lambda link, _: Lowering(link, NUDGE, NUDGE_TIME)),
    Command("k", "lift", lambda link, _: Lowering(link, -NUDGE, NUDGE_TIME)),
    Command("h", "hold", lambda link, _: link.cancel_moves()),
    Command("f", "factor", lambda link, text: link.start(request_factor(number(text, 0.0, 1.0))), "factor, 0 to 1"),
    Command("r", "redesign", lambda link, _: link.start(request_redesign()), is_confirmed=True),
    Command(
        "i",
        "inject",
        _fault,
        "DEVICE,KIND[,DURATION[,MAGNITUDE]]",
        is_confirmed=True,
        check=fault_of,
        is_of_simulation=True,
    ),
    Command("x", "clear faults", _clear, is_of_simulation=True),
    Command("p", "pause", _pause, is_of_simulation=True),
    Command("n", "step", lambda link, _: ClockTask(link, ticks=1), is_of_simulation=True),
    Command("w", "snapshot", lambda link, _: link.start(request_snapshot())),
)
"""All keys but the space bar, the emergency stop whatever is being typed, and q, which leaves the screen."""

BY_KEY = {command.key: command for command in COMMANDS}


class Keyboard:
    """Takes keys and begins what they stand for.

    Parameters
    ----------
    link : to the run
    begun : is called with the name and the task of what was begun

    Attributes
    ----------
    complaint : why the last key did nothing; "" where it did
    is_left : the operator has left the screen
    """

    def __init__(self, link: Link, begun: Callable[[str, Task], None]) -> None:
        self._link, self._begun = link, begun
        self._command: Command | None = None
        self._typed = ""
        self._is_typed = False
        self.complaint = ""
        self.is_left = False

    @property
    def prompt(self) -> str:
        """What is asked for now; "" for nothing."""
        if self._command is None:
            return ""
        if self._command.question and not self._is_typed:
            return f"{self._command.name}: {self._command.question}: {self._typed}_   (Enter: go on, Esc: leave it)"
        what = f"{self._command.name} {self._typed}".strip()
        return f"{what}: sure? (y: yes, any other key: no)"

    def press(self, key: str) -> None:
        """Take a `key`."""
        self.complaint = ""
        if key == EMERGENCY:
            self._leave_prompt()
            self._begun("EMERGENCY STOP", EmergencyStop(self._link))
        elif self._command is None:
            self._choose(key)
        elif self._command.question and not self._is_typed:
            self._type(key)
        else:
            confirmed = key in ("y", "Y")
            if confirmed:
                self._begin()
            else:
                self.complaint = f"{self._command.name}: left"
            self._leave_prompt()

    def _choose(self, key: str) -> None:
        if key == QUIT:
            self.is_left = True
        elif key in BY_KEY:
            self._command, self._typed, self._is_typed = BY_KEY[key], "", False
            if not self._command.question and not self._command.is_confirmed:
                self._begin()
                self._leave_prompt()
        elif key.isprintable():
            self.complaint = f"{key}: no such key"

    def _type(self, key: str) -> None:
        assert self._command is not None
        if key == ESCAPE:
            self._leave_prompt()
        elif key in ERASE:
            self._typed = self._typed[:-1]
        elif key not in ENTER:
            self._typed += key if key.isprintable() else ""
        elif self._command.is_confirmed and self._typed:
            self._check()
        else:
            self._begin()
            self._leave_prompt()

    def _check(self) -> None:
        """Ask whether what was typed is meant, where it can be."""
        assert self._command is not None
        try:
            self._command.check(self._typed)
            self._is_typed = True
        except ValueError as error:
            self.complaint = refusal(str(error)).text
            self._leave_prompt()

    def _begin(self) -> None:
        assert self._command is not None
        try:
            self._begun(self._command.name, self._command.begin(self._link, self._typed))
        except ValueError as error:
            self.complaint = refusal(str(error)).text

    def _leave_prompt(self) -> None:
        self._command, self._typed, self._is_typed = None, "", False
