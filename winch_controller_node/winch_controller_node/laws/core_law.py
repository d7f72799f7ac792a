"""A law whose command the core makes: what the laws of the suite have in common."""

from __future__ import annotations

import math
from typing import Any, Protocol

from heave_core.law import Law, put
from heave_core.law_table import LawKind
from heave_node.interface.preview import HeavePreview
from heave_node.numerics.arrays import Array

from winch_controller_node.laws.law import ControlLaw, LawCommand, LawDesign
from winch_controller_node.laws.parts.loop_state import LoopState
from winch_controller_node.laws.parts.winch_limits import ActiveWinch, WinchLimits
from winch_controller_node.model.lqr import DesignError

FREE = "free"
"""Status of a command that no limit shapes."""


class PlanMaker(Protocol):
    """Makes plans at the limits of the winch: see `laws.mpc.Planner`."""

    last: LawCommand  # command of the last plan, but for its value

    def restart(self) -> None:
        """Discard the plan."""

    def see(self, preview: HeavePreview | None, x: Array) -> None:
        """Take in a `preview` of the boom tip, where one is used and given, beside the state `x`, shape (n,)."""

    def prepare(self) -> None:
        """Make ready, between two ticks, what `restart` takes."""

    def plan_again(self) -> LawCommand:
        """Solve, and have it followed; return the command but for its value."""

    def bounds(self) -> tuple[Array, Array]:
        """Return lower and upper bounds of the rows as the core has found them, shape (r,) each."""


class CoreLaw(ControlLaw):
    """A law that the core knows.

    Parameters
    ----------
    design : what the law is made for
    kind : how it makes its command
    values : fields of `Law` in the core

    Raises DesignError for a model that does not fit.

    Attributes
    ----------
    winch : the active one, with its limits
    core : the law with its memory
    planner : makes plans at the limits; None: it has none
    """

    planner: PlanMaker | None = None

    def __init__(self, design: LawDesign, kind: LawKind, **values: Any) -> None:
        super().__init__(design, None)
        assert design.model.dt is not None
        self.winch = ActiveWinch(design.winch, design.limits, design.model.dt)
        try:
            self.core = Law(self.winch.record, design.model.order)
        except ValueError as error:
            raise DesignError(str(error)) from error
        unit = [design.model.state("unit_heave"), design.model.state("unit_heave_rate")]
        put(self.core.law, {"kind": kind, "unit": unit, **values})

    def take_limits(self, limits: WinchLimits) -> None:
        """Keep other limits from now on."""
        self.winch.take_limits(limits)

    def reset(self) -> None:
        """Start again."""
        self.core.restart()
        if self.planner is not None:
            self.planner.restart()

    def prepare(self) -> None:
        """See ControlLaw."""
        if self.planner is not None:
            self.planner.prepare()

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""
        self._pose(state)
        if self.core.ask():
            return self.planned()
        memory = self.core.state[0]
        return self.commanded(float(memory["command"]), by_plan=memory["by_plan"], has_plan=memory["has_plan"])

    def planned(self) -> LawCommand:
        """Return the command where limits shape it: a plan is made, and followed."""
        assert self.planner is not None
        found = self.planner.plan_again()
        self.core.follow_plan()
        return found._replace(value=float(self.core.state["command"][0]))

    def commanded(self, value: float, *, by_plan: float, has_plan: float) -> LawCommand:
        """Return a command of which no plan was needed in this tick: a `value` that the core has made.

        `by_plan` : not 0: the constrained law has; `has_plan` : not 0: it follows a plan of a tick before
        """
        if not by_plan:
            return LawCommand(value)
        if not has_plan:
            return LawCommand(value, FREE)
        assert self.planner is not None
        return self.planner.last._replace(value=value)

    def _pose(self, state: LoopState) -> None:
        tensions = state.static_tension, state.measured_tension
        self.core.pose((*state.reference, *tensions, state.mru_rate, float(state.bounds_tension), math.inf), state.x)
        if self.planner is not None:
            self.planner.see(state.preview, state.x)


class StateFeedback(CoreLaw):
    """u = -gain x, with the share of the unit's own error bounded. For the estimator's input, see `governor`.

    A large error of the unit would ask a winch at its limits for a bang-bang motion that, late as it is, swings the
    unit up instead of down. Less feedback of the unit only takes damping away from a plant that is stable by itself: a
    bounded share cannot do that, whatever the error.

    Parameters
    ----------
    design : what the law is made for
    gain : shape (n,)
    unit_share : share of the largest speed that the unit's error may ask for
    """

    def __init__(self, design: LawDesign, gain: Array, unit_share: float) -> None:
        super().__init__(design, LawKind.FEEDBACK_LAW, gain=gain, unit_share=unit_share)
        self.gain = gain

    def stay_linear(self) -> None:
        """Leave out what takes over near the limits of the winch."""
        put(self.core.law, {"plans": 0})
