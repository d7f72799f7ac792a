"""Governor, laws and command in the core: their structures as arrays, and the calls that work on them."""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import accumulate
from typing import Any

import numpy as np

from heave_core import law_table as table
from heave_core.filter import check_states
from heave_core.library import library, named, new

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
    estimate : of the loop, shape (states,)
    records : arrays of one structure each, by the names of ACTING

    Raises ValueError where the states do not fit.
    """

    def __init__(self, winch: Any, states: int, law: Law | None, state: Any, command: Any = None) -> None:
        check_states(states, "law")
        self.design, self.state = new(table.COMMAND_DESIGN), state
        self._command = new(table.COMMAND) if command is None else command
        loop = new(table.LOOP)
        self._law = Law(winch, states) if law is None else law
        self.estimate = loop["estimate"][0, :states]
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


SENSING = (
    *("delivered", "sense", "filter", "look", "sense_state", "filter_state", "look_state"),
    *("found", "observed", "taken", "said", "by_measurement", "depths", "tick"),
)
PROVING = ("proofs", "proof_state", "proof_work")
WATCHING = ("winch_watch", "winch_state", "drum_rows", "drum_work", "minute", "reflex", "reflex_state")
SUPERVISING = (
    *("sense", "sense_state", "tick", "design", "state", "seen", "done", "landing", "landing_state"),
    *("guard", "guard_state", "verdict", "attempt_design", "attempts", "modes", "mode", "situation"),
)
ACTING = (
    *("seen", "motions", "winch", "design", "loop", "law", "problem", "law_state", "state", "command", "A", "B"),
    *("motion", "envelope", "envelope_state", "readings", "order", "place"),
    *("load", "load_state", "kpi", "kpi_state", "kpi_rows", "done"),
)
"""What each part of a tick works on, in the order of `Control` in tick.h and of the structures in it."""

GIVING, GIVES = ("given", "active"), ("controlled",)

OF_WINCH = [row.name for row in table.GIVEN.rows].index("has_winch")
"""Numbers of GIVEN before the report of the winch, which is kept as long as no other comes."""

GROUPS = (GIVING, SENSING, PROVING, WATCHING, GIVES, SUPERVISING, ACTING)
"""All of `Control`."""


class Control:
    """What a tick works on, and its call.

    Attributes
    ----------
    given, done : numbers of GIVEN and CONTROLLED, on the memory that C++ reads and writes
    active : array of one ACTIVE
    go_on : goes on with the tick from a Stage; returns the one at which it waits, DONE where the order has left
    """

    def __init__(self) -> None:
        starts = accumulate(map(len, GROUPS), initial=0)
        self._places = {
            group: {name: start + place for place, name in enumerate(group)}
            for group, start in zip(GROUPS, starts, strict=False)
        }
        self._at, self._kept = np.zeros(sum(map(len, GROUPS)), np.uintp), dict[int, Any]()
        count, controlled = len(table.GIVEN.rows), new(table.CONTROLLED)
        self.given, self.active = np.zeros(count), new(table.ACTIVE)
        self.done = controlled.view("f8")
        self.take(GIVING, given=self.given, active=self.active)
        self.take(GIVES, controlled=controlled)
        self.take(ACTING, done=controlled["acted"])
        without, whole = (struct.Struct(f"{numbers}d").pack_into for numbers in (OF_WINCH + 1, count))
        self._pack, self._pack_whole = (partial(pack, self.given.data, 0) for pack in (without, whole))
        self.go_on = partial(library().heave_core_tick, self._at.ctypes.data)

    def take(self, group: tuple[str, ...], **records: Any) -> None:
        """Work on these arrays of a `group` from now on, by name; None: there is none."""
        for name, record in records.items():
            place = self._places[group][name]
            self._kept[place], self._at[place] = record, 0 if record is None else record.ctypes.data

    def records(self, group: tuple[str, ...]) -> dict[str, Any]:
        """Return the arrays of a `group`, by name."""
        return {name: self._kept[place] for name, place in self._places[group].items()}

    def address(self, group: tuple[str, ...], name: str) -> int:
        """Return the address of an array of a `group`, by `name`."""
        return int(self._at[self._places[group][name]])

    def begin(self, stage: int, report: Sequence[float] | None, *given: float) -> int:
        """Begin a tick at a `stage`; returns as `go_on` does.

        Parameters
        ----------
        stage : BEGIN or SENSE
        report : of the winch, by the rows of GIVEN from `winch_time` on; None: none came
        given : numbers of GIVEN before it
        """
        if report is None:
            self._pack(*given, 0.0)
        else:
            self._pack_whole(*given, 1.0, *report)
        waits: int = self.go_on(stage)
        return waits
