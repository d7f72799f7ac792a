"""Governor, laws and command in the core: their structures as arrays, and the calls that work on them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from heave_core import law_table as table
from heave_core.filter_table import STATES
from heave_core.library import library, new

WANTED_NUMBERS, GOVERNED_NUMBERS = len(table.WANTED.rows), len(table.GOVERNED.rows)
PROBLEM_NUMBERS, LOOP_NUMBERS = len(table.PROBLEM.rows) - 1, len(table.LOOP.rows) - 2
"""Numbers in front of the states, of which a structure consists."""


class LoopNow(NamedTuple):
    """What is known of the loop in a tick, and what is to be done: the rows of `Loop`, in their order."""

    way: table.Way
    share: float = 0.0
    heave: float = 0.0
    rate: float = 0.0
    swing: float = 0.0
    swing_rate: float = 0.0
    is_unseen: bool = False
    left_over: float = 0.0
    mean_command: float = 0.0
    mru_rate: float = 0.0
    tension: float = math.nan
    filtered_tension: float = math.nan
    gives_way: bool = False
    bounds_tension: bool = True
    fades: bool = False
    is_held: bool = False
    follows_tip: bool = True
    unit_stands: bool = False


class MadeCommand(NamedTuple):
    """The command of a tick: the rows of `Command`, with their meanings and units."""

    asked: float
    value: float
    sent: float
    standing: float
    compensating: float
    mean: float
    shaped: float
    gives_way: float
    at_travel: float
    by_plan: float
    has_plan: float
    payout: float
    rate: float


def put(record: Any, values: Mapping[str, Any]) -> None:
    """Put `values` by name into an array of one structure; of an array they are the first entries."""
    for name, value in values.items():
        field = record[name]
        if field.ndim > 1:
            field[0, : len(value)] = value
        else:
            field[0] = value


def check_states(count: int) -> None:
    """Refuse, with ValueError in one sentence, a model of more states than fit, `count`."""
    if count > STATES:
        raise ValueError(
            f"the model has {count} states, those of commands on their way included, and {STATES} fit: "
            "shorten winch.command_delay, or make the tick longer"
        )


class Governor:
    """The governor of an active `winch`, an array of one `ActiveWinch`."""

    def __init__(self, winch: Any) -> None:
        self._wanted, self._governed = np.zeros(WANTED_NUMBERS), np.zeros(GOVERNED_NUMBERS)
        self._winch = winch
        self._call = library().heave_core_govern
        self._addresses = [array.ctypes.data for array in (winch, self._wanted, self._governed)]

    def step(self, wanted: Sequence[float]) -> list[float]:
        """Return what is let through of what is `wanted`: the numbers of `Governed` and `Wanted` in their order."""
        self._wanted[:] = wanted
        self._call(*self._addresses)
        numbers: list[float] = self._governed.tolist()
        return numbers


class Law:
    """A law with its memory.

    Parameters
    ----------
    winch : the active one, an array of one `ActiveWinch`
    states : number of them

    Attributes
    ----------
    winch, law, problem, state : arrays of one structure, on the memory that C++ reads and writes
    x : state of the problem, shape (states,)

    Raises ValueError where the states do not fit.
    """

    def __init__(self, winch: Any, states: int) -> None:
        check_states(states)
        self.winch, self.law, self.problem = winch, new(table.LAW), new(table.PROBLEM)
        self.state = new(table.LAW_STATE)
        self.x = self.problem["x"][0, :states]
        self._numbers = self.problem.view("f8")[:PROBLEM_NUMBERS]
        self.addresses = [array.ctypes.data for array in (self.winch, self.law, self.problem, self.state)]
        called = library()
        self._ask, self._follow, self._bound = (
            called.heave_core_ask_law,
            called.heave_core_follow_plan,
            called.heave_core_bound_plan,
        )
        put(self.law, {"states": states, "solve_ticks": 1})
        self.restart()

    def restart(self) -> None:
        """Go on without a plan, away from the limits."""
        library().heave_core_restart_law(self.addresses[3])

    def pose(self, numbers: Sequence[float], x: Any) -> None:
        """Pose a problem: the `numbers` of `Problem` in their order, and the state `x`."""
        self._numbers[:] = numbers
        self.x[:] = x

    def ask(self) -> int:
        """Ask for the command; return what is needed for it first."""
        asks: int = self._ask(*self.addresses)
        return asks

    def follow_plan(self) -> None:
        """Make the command with the correction that was planned."""
        self._follow(*self.addresses)

    def bound_plan(self) -> None:
        """Find the rows of the plan without a correction, and their bounds."""
        self._bound(*self.addresses)


class Commander:
    """The command of a tick.

    Parameters
    ----------
    states : number of them
    law : of the suite; None: another one, that Python asks

    Attributes
    ----------
    design, state : arrays of one structure; the `state` outlives a design
    estimate, mean_state : of the loop, shape (states,); to be set before each step

    Raises ValueError where the states do not fit.
    """

    def __init__(self, winch: Any, states: int, law: Law | None, state: Any) -> None:
        check_states(states)
        self.design, self.state, self._command = new(table.COMMAND_DESIGN), state, new(table.COMMAND)
        loop = new(table.LOOP)
        self._law = Law(winch, states) if law is None else law
        self.estimate, self.mean_state = loop["estimate"][0, :states], loop["mean_state"][0, :states]
        self._loop, self._numbers = loop.view("f8")[:LOOP_NUMBERS], self._command.view("f8")
        _, kind, problem, law_state = self._law.addresses
        given = [array.ctypes.data for array in (winch, self.design, loop)]
        made = [self.state.ctypes.data, self._command.ctypes.data]
        self._act_on = [*given, kind, problem, law_state, *made]
        self._make_on, self._pose_on = [*given, problem, *made], [*given, problem, made[1]]
        called = library()
        self._act, self._pose = called.heave_core_act, called.heave_core_pose
        self._answer, self._make = called.heave_core_answer, called.heave_core_make
        self._kept = winch, loop
        put(self.design, {"states": states})

    @property
    def problem(self) -> Any:
        """The problem of the tick, an array of one `Problem`."""
        return self._law.problem

    @property
    def x(self) -> Any:
        """State that a law acts on, shape (states,)."""
        return self._law.x

    def act(self, loop: LoopNow) -> int:
        """Make the command of a tick in a `loop`; return what is needed for it first, 0 where it is made."""
        self._loop[:] = loop
        asks: int = self._act(*self._act_on)
        return asks

    def pose(self, loop: LoopNow) -> None:
        """Pose the problem of a tick in a `loop`."""
        self._loop[:] = loop
        self._pose(*self._pose_on)

    def answer(self) -> int:
        """Make the command of a problem that was posed; return as `act` does."""
        asks: int = self._answer(*self._act_on)
        return asks

    def make(self, asked: float) -> None:
        """Make the command of what was `asked` for elsewhere."""
        self._numbers[0] = asked
        self._make(*self._make_on)

    @property
    def made(self) -> MadeCommand:
        """The command that was made last."""
        return MadeCommand._make(self._numbers.tolist())
