"""`look` by ctypes: simulated units, the motions at a tick, and the guard's statistics, on the memory that C++ has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heave_core.filter import check_states
from heave_core.filter_table import STATES
from heave_core.library import fill, library, named, new
from heave_core.look_table import (
    GUARD_DESIGN,
    GUARD_STATE,
    LOOK_DESIGN,
    LOOK_INPUTS,
    LOOK_STATE,
    MOTIONS,
    VERDICT,
)
from heave_core.modes_table import ATTEMPT_DESIGN, ATTEMPT_STATE

Array = NDArray[np.float64]

Motions = named(MOTIONS)
"""All motions at a tick."""


Verdict = named(VERDICT)
"""What the guard has found in a tick."""


def padded(row: Array) -> Array:
    """Return a `row` on the states, shape (n,), with zeros up to the states that fit.

    Raises ValueError where there are more.
    """
    check_states(len(row), "loop")
    return np.pad(row, (0, STATES - len(row)))


class Look:
    """All motions at a tick, with the simulated units.

    Parameters
    ----------
    design : values by the names of LOOK_DESIGN

    Attributes
    ----------
    design, state, inputs : structured arrays of one element
    motions : that were found last
    """

    def __init__(self, design: Mapping[str, Any]) -> None:
        core = library()
        self.design, self.state = new(LOOK_DESIGN), new(LOOK_STATE)
        self.inputs, self.motions = new(LOOK_INPUTS), np.zeros(len(MOTIONS.rows))
        self._at = self.design.ctypes.data, self.state.ctypes.data
        self._again = core.heave_core_look_again
        self._begin_share, self._take_unit = core.heave_core_look_begin_share, core.heave_core_look_take_unit
        self._shadow, self._hanging = core.heave_core_look_continue_shadow, core.heave_core_look_continue_hanging
        self.take_design(design)

    def take_design(self, design: Mapping[str, Any]) -> None:
        """Go by another `design` from now on; the units stay where their modes are."""
        fill(self.design[0], design)

    def again(self, estimate: Array, mean_state: Array) -> Any:
        """Return the motions of the tick of `inputs` after the loop has been moved to another state, shapes (n,)."""
        given = [np.ascontiguousarray(state).ctypes.data for state in (estimate, mean_state)]
        self._again(*self._at, self.inputs.ctypes.data, *given, self.motions.ctypes.data)
        return Motions._make(self.motions.tolist())

    def begin_share(self) -> None:
        """Let the unit of a taut cable go on from where the one with the winch locked is."""
        self._begin_share(*self._at)

    def continue_shadow(self, heave: float, rate: float) -> None:
        """Let both units with the winch locked go on from a `heave` [m] and `rate` [m/s]."""
        self._shadow(*self._at, heave, rate)

    def continue_hanging(self, heave: float, rate: float) -> None:
        """Let the hanging unit go on from a `heave` [m] and `rate` [m/s]."""
        self._hanging(*self._at, heave, rate)

    def take_unit(self, heave: float, rate: float) -> None:
        """Go on with a unit elsewhere, at a `heave` [m] and `rate` [m/s], also with the winch locked."""
        self._take_unit(*self._at, heave, rate)

    def forget_waves(self) -> None:
        """Average the power of the boom tip from now on: it was not where it was taken to be."""
        self.state["tip_power"] = 0.0


class Guard:
    """The guard's statistics, and what attempts at compensation have shown, with their memory.

    Parameters
    ----------
    design : values by the names of GUARD_DESIGN
    attempts : values by the names of ATTEMPT_DESIGN

    Attributes
    ----------
    design, state, attempt_design, attempts, found : structured arrays of one element; `found` in the last tick
    """

    def __init__(self, design: Mapping[str, Any], attempts: Mapping[str, Any]) -> None:
        core = library()
        self.design, self.state, self.found = new(GUARD_DESIGN), new(GUARD_STATE), new(VERDICT)
        self.attempt_design, self.attempts = new(ATTEMPT_DESIGN), new(ATTEMPT_STATE)
        self._at = self.design.ctypes.data, self.state.ctypes.data
        self._attempts_at = self.attempt_design.ctypes.data, self.attempts.ctypes.data
        self._verdict_at, self._core = self.found.ctypes.data, core
        fill(self.design[0], design)
        fill(self.attempt_design[0], attempts)
        self.begin()

    def take_design(self, design: Mapping[str, Any]) -> None:
        """Go by another `design` from now on, which another demand of the sea follows from."""
        fill(self.design[0], design)
        self._core.heave_core_guard_demand(*self._at, self._verdict_at)

    @property
    def verdict(self) -> Any:
        """What was found last, as a Verdict."""
        return Verdict._make(self.found[0].item())

    def begin(self) -> None:
        """Begin again: what was seen until now was another sea."""
        self._core.heave_core_guard_begin(self._at[1])
        self.found[0] = np.zeros((), self.found.dtype)
        self._core.heave_core_guard_demand(*self._at, self._verdict_at)

    def release(self) -> None:
        """Let compensation be tried as at first: an operator asks for it."""
        (design, state), (attempt_design, attempts) = self._at, self._attempts_at
        self._core.heave_core_attempts_release(design, attempt_design, state, attempts)

    def explain(self) -> None:
        """Take the last failure back: a wrong belief has just been corrected."""
        self._core.heave_core_attempts_explain(self._attempts_at[1])

    @property
    def largest_residual(self) -> float:
        """Largest residual with which compensation is tried, over the motion with the winch locked."""
        largest: float = self._core.heave_core_attempts_largest(*self._attempts_at)
        return largest

    @property
    def awaits_operator(self) -> bool:
        """Tell whether no authority would gain enough any more."""
        return bool(self._core.heave_core_attempts_awaits(*self._attempts_at))

    def allow_resumption(self) -> None:
        """Do not hold against the loop how drum and unit moved while a sensor was lost."""
        self._core.heave_core_guard_allow_resumption(*self._at)

    def reset_mismatch(self) -> None:
        """Compare depth sensor and estimate again: what was seen until now says nothing of either."""
        self._core.heave_core_guard_reset_mismatch(self._at[1])
