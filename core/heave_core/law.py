"""Governor, laws and command in the core: their structures as arrays, and the calls that work on them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from heave_core import law_table as table
from heave_core.filter import check_states
from heave_core.library import library, named, new
from heave_core.look_table import MOTIONS

LOOP_NUMBERS = len(table.LOOP.rows) - 2
"""Numbers in front of the states, of which it consists."""

PROBLEM_NUMBERS = len(table.PROBLEM.rows) - 1
"""The same of a problem."""

MadeCommand = named(table.COMMAND)
"""The command of a tick."""


def put(record: Any, values: Mapping[str, Any]) -> None:
    """Put `values` by name into an array of one structure; of an array they are the first entries."""
    for name, value in values.items():
        field = record[name]
        if field.ndim > 1:
            field[0, : len(value)] = value
        else:
            field[0] = value


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
        check_states(states, "law")
        self.winch, self.law, self.problem = winch, new(table.LAW), new(table.PROBLEM)
        self.state = new(table.LAW_STATE)
        self.x = self.problem["x"][0, :states]
        self._numbers = self.problem.view("f8")[:PROBLEM_NUMBERS]
        self.addresses = [array.ctypes.data for array in (self.winch, self.law, self.problem, self.state)]
        called = library()
        self._ask, self._follow = called.heave_core_ask_law, called.heave_core_follow_plan
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
    records : arrays of one structure each, by the names of `Acting` in act.h

    Raises ValueError where the states do not fit.
    """

    def __init__(self, winch: Any, states: int, law: Law | None, state: Any, command: Any = None) -> None:
        check_states(states, "law")
        self.design, self.state = new(table.COMMAND_DESIGN), state
        self._command = new(table.COMMAND) if command is None else command
        loop = new(table.LOOP)
        self._law = Law(winch, states) if law is None else law
        self.estimate, self.mean_state = loop["estimate"][0, :states], loop["mean_state"][0, :states]
        self._numbers = self._command.view("f8")
        self.records = {"winch": winch, "design": self.design, "loop": loop, "law": self._law.law}
        self.records |= {"problem": self._law.problem, "law_state": self._law.state}
        self.records |= {"state": state, "command": self._command}
        put(self.design, {"states": states})

    @property
    def problem(self) -> Any:
        """The problem of the tick, an array of one `Problem`."""
        return self._law.problem

    @property
    def x(self) -> Any:
        """State that a law acts on, shape (states,)."""
        return self._law.x

    @property
    def made(self) -> Any:
        """The command that was made last."""
        return MadeCommand._make(self._numbers.tolist())


class Acting:
    """The acting half of a tick: addresses of all that it works on.

    Attributes
    ----------
    seen, motions, done : numbers of `ActSeen`, `Motions` and `ActDone`, on the memory that C++ reads and writes
    """

    NAMES = (
        *("seen", "motions", "winch", "design", "loop", "law", "problem", "law_state", "state", "command", "A", "B"),
        *("motion", "envelope", "envelope_state", "readings", "order", "place"),
        *("load", "load_state", "kpi", "kpi_state", "kpi_rows", "done"),
    )
    """Rows of `Acting` in act.h, in their order."""

    def __init__(self) -> None:
        self.seen, self.done = np.zeros(len(table.ACT_SEEN.rows)), np.zeros(len(table.ACT_DONE.rows))
        self.motions = np.zeros(len(MOTIONS.rows))
        self._at, self._kept = np.zeros(len(self.NAMES), np.uintp), dict[str, Any]()
        self.take(seen=self.seen, motions=self.motions, done=self.done)
        core, at = library(), self._at.ctypes.data
        self.act, self.pose, self.answer, self.make, self.leave = (
            partial(one, at)
            for one in (
                core.heave_core_act_tick,
                core.heave_core_act_pose,
                core.heave_core_act_answer,
                core.heave_core_act_make,
                core.heave_core_act_leave,
            )
        )

    def take(self, **records: Any) -> None:
        """Work on these arrays from now on, by name; None: there is none."""
        self._kept |= records
        for name, record in records.items():
            self._at[self.NAMES.index(name)] = 0 if record is None else record.ctypes.data


class Place:
    """The place that belongs to a commanded speed, see act.cpp.

    Parameters
    ----------
    leak : time constant with which it is drawn to the drum [s]
    reach : furthest that it leads the drum [m]
    """

    def __init__(self, leak: float, reach: float) -> None:
        self.record = new(table.PLACE)
        put(self.record, {"leak": leak, "reach": reach, "payout": math.nan})
