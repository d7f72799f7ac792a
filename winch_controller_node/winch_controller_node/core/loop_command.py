"""The command and its parts: the law, constant tension, a plan at the limits, a law of somebody else.

From mode and loop to the order all is made in the core (act.cpp); what it asks for first is found here.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from heave_core.law import ACTING, Commander, Control, Place, put
from heave_core.law_table import ACT_SEEN, COMMAND, COMMAND_STATE, Asks, Shaped, Stage
from heave_core.library import new
from heave_node.interface.preview import HeavePreview

from winch_controller_node.core.estimation.loop_tick import CommandShares
from winch_controller_node.core.supervision.modes import SETTLING_LIMIT
from winch_controller_node.core.supervision.rolling_kpi import KpiWindow
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.laws.constant_tension import TRAVEL, ConstantTension
from winch_controller_node.laws.core_law import CoreLaw
from winch_controller_node.laws.law import ControlLaw, LawCommand
from winch_controller_node.laws.outlet_hold import OutletHold
from winch_controller_node.laws.parts.governor import TENSION, GovernedCommand, drum_ahead, shaped_by
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.laws.parts.winch_limits import ActiveWinch, WinchLimits
from winch_controller_node.model.models import loop_rows

GIVING_TIME = 1.0
"""A winch gives way to a tension above the highest one within this time [s], and no quicker than twice its lag."""

COUNT_MARGIN = 0.2
"""Time that an order may take longer than the nominal delay to the drive's position loop [s]: some ticks."""

EASING = 2.0
"""Time after a change of what is assumed in which the order makes no larger step [s]."""

CONSTANTS = {
    "largest_unseen": 0.02,
    "unseen_error": 0.5,
    "minute": 60.0,  # some waves
    "more_travel": 1.2,
    "more_room": 0.1,
    "quicker": 1.5,
    "more_acceleration": 0.3,
}
"""Constants of the command: meanings and units are in the core's table, COMMAND_DESIGN."""

ASKED, COMPENSATING, MEAN = (
    [row.name for row in COMMAND.rows].index(name) for name in ("asked", "compensating", "mean")
)
"""Places in the core's command."""

LEAK = 60.0
"""Time constant with which the place of a speed is drawn to the drum [s]: far slower than the waves."""

REACH = 2.0
"""Furthest that it leads the drum [m]: one second at the largest speed of a winch."""

ENVELOPE, BY_ENVELOPE = "envelope", Shaped.BY_ENVELOPE | Shaped.BY_BOUNDS
"""Name of the bound on what leaves, and its bits: an order that it has replaced, or that was kept within it."""


def commander(
    design: ControllerDesign, winch: ActiveWinch, law: ControlLaw, state: Any, command: Any = None
) -> Commander:
    """Return the command of the core for a `design`, its active `winch` and its `law`.

    `state` is what it remembers, `command` an array of one `Command` that it makes; None: its own.
    """
    model, modes, rows, assumed = design.model, design.parameters.modes, loop_rows(design.model), winch.winch
    core = Commander(winch.record, model.order, law.core if isinstance(law, CoreLaw) else None, state, command)
    payout_ahead, rate_ahead = drum_ahead(model, assumed)
    values = {
        "payout": model.state("payout"),
        "unit": rows.unit_states,
        "sea_states": len(design.sea_states),
        "sea": [model.state(name) for name in design.sea_states],
        "payout_row": rows.payout,
        "payout_ahead": payout_ahead,
        "rate_ahead": rate_ahead,
        "inertia": design.cable.a,
        "damping": design.cable.b,
        "stiffness": design.cable.stiffness,
        "giving_time": max(GIVING_TIME, 2.0 * (assumed.command_delay + assumed.time_constant)),
        "stop_step": modes.stop_deceleration * design.tick_period,
        "longest_fade": modes.fade_out_time + SETTLING_LIMIT,
        **CONSTANTS,
    }
    if assumed.law == "speed_servo":
        values["fade"] = OutletHold(model, assumed, 0.0).row
        values["settling"] = OutletHold(model, assumed, design.cable.a).row
    put(core.design, values)
    return core


class TickCommand(NamedTuple):
    """The command of a tick, in the terms of the model."""

    asked: LawCommand  # by the law, without the mean payout's share
    governed: GovernedCommand  # what left in the end, the mean payout's share included
    standing: float  # command under which the winch would stay where it is, in its unit


class LoopCommand:
    """The acting half of a tick, in the core: from what is to be done to the order that leaves.

    Parameters
    ----------
    design : the active one; law : of it, for compensation
    kpi : window of the figures of merit, which counts by the limits of the winch
    control : of the tick
    """

    def __init__(self, design: ControllerDesign, law: ControlLaw, kpi: KpiWindow, control: Control) -> None:
        self._state, self._command = new(COMMAND_STATE), new(COMMAND)
        self._numbers = self._command.view(np.float64)
        self._elsewhere: LawCommand | None = None
        self._preview: HeavePreview | None = None
        self._kpi, self._control = kpi, control
        control.take(ACTING, seen=new(ACT_SEEN), place=Place(LEAK, REACH).record, **kpi.records)
        self._tension = ConstantTension(self._state["tension"])
        self._core_law: CoreLaw | None = None
        self.take_design(design, law)

    def take_design(self, design: ControllerDesign, law: ControlLaw) -> None:
        """Use a design and its `law` from now on; the tension that is held stays, and how near the limits were."""
        parameters, model = design.parameters, design.model
        self._winch = parameters.winch
        self._law = law
        # of a law of the suite the command shares the winch: limits have one place
        active = law.winch if isinstance(law, CoreLaw) else ActiveWinch(self._winch, design.limits, design.tick_period)
        active.take(self._winch, design.limits)
        before, self._core_law = self._core_law, law if isinstance(law, CoreLaw) else None
        if before is not None and self._core_law is not None:
            self._core_law.core.state[:] = before.core.state
        self._active = active
        damping = None if self._is_first_order else OutletHold(model, self._winch, design.cable.a)
        # swing of the unit at which a fade-out may end [m]; infinite where the law is not asked to damp it
        self.settled_swing = math.inf if damping is None else damping.settled_swing
        self._core = commander(design, active, law, self._state, self._command)
        self._control.take(ACTING, **self._core.records, A=np.ascontiguousarray(model.A), B=model.B[:, 0].copy())
        self._kpi.take_winch(self._winch)
        tension = self._tension.take_design(
            model, design.cable, self._winch, parameters.tension, round_trip=design.wave_round_trip
        )
        put(self._core.design["tension"], tension)

    @property
    def _is_first_order(self) -> bool:
        return self._winch.law == "first_order"

    @property
    def time_of_another_count(self) -> float:
        """Time from a jump of the encoder to the first effect of an order that is in its new count [s].

        Meanwhile a position loop goes by the old order in the new count. Without one there is no such time.
        """
        has_loop = self._is_first_order or self._winch.position_gain > 0.0
        return self._winch.command_delay + COUNT_MARGIN if has_loop else 0.0

    def ease(self) -> None:
        """Let the order make no step for some seconds: something else is assumed."""
        put(self._state, {"easing": EASING})

    def begin_tension(self, measured: float) -> None:
        """Begin constant tension at the measured tension [N]."""
        self._tension.begin(measured)

    def hold_tension(self, tension: float) -> None:
        """Go to another tension [N] from the one that is held."""
        self._tension.hold(tension)

    @property
    def shares(self) -> CommandShares:
        """What was commanded last: what compensates, and what moves the mean payout."""
        return CommandShares(self._numbers.item(COMPENSATING), self._numbers.item(MEAN))

    @property
    def limits(self) -> WinchLimits:
        """The active limits of the winch."""
        return self._active.limits

    def payout_range(self) -> tuple[float, float]:
        """Return the ends of the range that the mean payout may use [m]."""
        limits = self.limits
        return limits.payout_minimum, limits.payout_maximum

    @property
    def is_asked(self) -> bool:
        """Tell whether the law is to be asked before its command is: it sees a preview, or is not of the suite."""
        law = self._core_law
        return law is None or law.preview is not None

    def begin(self) -> None:
        """Begin a tick: no law has been asked elsewhere."""
        self._elsewhere = None

    def see(self, preview: HeavePreview | None, authority: float) -> int:
        """Have a law that plans see what is ahead; return the stage at which the tick goes on.

        Parameters
        ----------
        preview : of the boom tip, seen from this tick; None: there is none
        authority : of compensation
        """
        self._preview = None if preview is None else replace(preview, heave=authority * preview.heave)
        if self._core_law is not None and self._core_law.planner is not None:
            self._core_law.planner.see(self._preview, self._core.x)
        return Stage.ANSWER

    def ask(self, asks: int) -> int:
        """Find what the core `asks` for before it goes on; return the stage at which it does."""
        if asks == Asks.NEEDS_TENSION:
            self._tension.begin_alone(self._payout())
            return Stage.ANSWER
        self._elsewhere = self._asked_elsewhere(asks)
        self._numbers[ASKED] = self._elsewhere.value
        return Stage.MAKE

    def _asked_elsewhere(self, asks: int) -> LawCommand:
        """Return what the core `asks` for: a plan, or another law."""
        if asks & Asks.NEEDS_PLAN:
            assert self._core_law is not None
            return self._core_law.planned()
        asked = self._law.command(self._posed(self._preview))
        if not isinstance(asked, LawCommand):
            raise TypeError(f"law {self._law.name}: command() returned {asked!r}; it must return a LawCommand")
        return asked

    def _payout(self) -> float:
        """Return the payout of the drum [m]."""
        core, row = self._core, self._core.design["payout_row"][0]
        return float(row[: len(core.x)] @ core.x) + float(core.problem["payout"][0])

    def _posed(self, preview: HeavePreview | None) -> LoopState:
        """Return the problem of the tick as a law is given it, with the `preview` of its authority."""
        problem = self._core.problem[0]
        payout, rate, command, static, measured, mru_rate, bounds_tension = problem.item()[:7]
        reference = Reference(payout, rate, command)
        x = np.array(self._core.x)
        return LoopState(x, reference, static, measured, mru_rate, preview, bounds_tension=bool(bounds_tension))

    @property
    def last(self) -> TickCommand:
        """The command of the last tick."""
        made = self._core.made
        if self._elsewhere is not None:
            law = self._elsewhere._replace(value=made.asked)
        elif self._core_law is None:
            law = LawCommand(made.asked)
        else:
            law = self._core_law.commanded(made.asked, by_plan=made.by_plan, has_plan=made.has_plan)
        if made.at_travel:
            law = law._replace(active=(TRAVEL,))
        if made.gives_way:
            law = law._replace(active=(*law.active, TENSION))
        shaped = int(made.shaped)
        active = shaped_by(shaped & ~BY_ENVELOPE, is_first_order=self._is_first_order)
        active += (ENVELOPE,) if shaped & BY_ENVELOPE else ()
        return TickCommand(law, GovernedCommand(made.value, active, made.sent), made.standing)
