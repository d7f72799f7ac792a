"""From mode and loop to the order: which law is asked, the mean payout's share, the governor, the set-points.

The command itself is made in the core, one call a tick; a law of somebody else and a plan at the limits are asked here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from heave_core.law import Commander, LoopNow, put
from heave_core.law_table import COMMAND_STATE, Asks, Shaped, Way
from heave_core.library import new
from heave_node.interface.preview import HeavePreview

from winch_controller_node.core.estimation.loop_tick import CommandShares, LoopTick
from winch_controller_node.core.supervision.modes import SETTLING_LIMIT, Mode, ModeOutput
from winch_controller_node.core.supervision.supervisor import Decision
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.readings import WinchOrder
from winch_controller_node.laws.constant_tension import TRAVEL, ConstantTension
from winch_controller_node.laws.core_law import CoreLaw
from winch_controller_node.laws.law import ControlLaw, LawCommand
from winch_controller_node.laws.outlet_hold import OutletHold
from winch_controller_node.laws.parts.governor import TENSION, CommandGovernor, GovernedCommand, drum_ahead, shaped_by
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.laws.parts.winch_limits import ActiveWinch
from winch_controller_node.model.loop_rows import loop_rows

IDLE = LawCommand(0.0)

GIVING_TIME = 1.0
"""A winch gives way to a tension above the highest one within this time [s], and no quicker than twice its lag."""

LARGEST_UNSEEN, UNSEEN_ERROR = 0.02, 0.5
"""Largest swing for which compensation corrects a unit that no depth sensor sees [m], and swing of which it corrects
what is above it: up to there all of it may be error."""

COUNT_MARGIN = 0.2
"""Time that an order may take longer than the nominal delay to the drive's position loop [s]: some ticks."""

MINUTE = 60.0
"""Time over which speeds and travel are remembered [s]: some waves."""

MORE, ROOM = 1.2, 0.1
"""Travel that a fade-out may take: so many times the largest of the last minute, and so much more [m]."""

EASING, QUICKER, MORE_ACCELERATION = 2.0, 1.5, 0.3
"""Time after a change of what is assumed in which the order makes no larger step [s]: so many times the largest of the
last minute, and so much more [m/s^2]."""

BY_LAW = (Mode.COMPENSATING, Mode.FADE_OUT)
"""Modes in which a winch that gives way to more than compensation can keep would be too late for the next wave."""

WAYS = {
    Mode.COMPENSATING: Way.BY_LAW,
    Mode.CONSTANT_TENSION: Way.BY_TENSION,
    Mode.MANUAL: Way.BY_PLACE,
    Mode.STOPPING: Way.BY_SLOWING,
}
"""By what the command is made in a mode without its brake."""

ENVELOPE = "envelope"
"""Name of the bound on what leaves."""


def commander(design: ControllerDesign, winch: ActiveWinch, law: ControlLaw, state: Any) -> Commander:
    """Return the command of the core for a `design`, its active `winch` and its `law`; `state` is what it remembers."""
    model, modes, rows, assumed = design.model, design.parameters.modes, loop_rows(design.model), winch.winch
    core = Commander(winch.record, model.order, law.core if isinstance(law, CoreLaw) else None, state)
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
        "stiffness": design.cable.stiffness,
        "giving_time": max(GIVING_TIME, 2.0 * (assumed.command_delay + assumed.time_constant)),
        "largest_unseen": LARGEST_UNSEEN,
        "unseen_error": UNSEEN_ERROR,
        "stop_step": modes.stop_deceleration * design.tick_period,
        "longest_fade": modes.fade_out_time + SETTLING_LIMIT,
        "minute": MINUTE,
        "more_travel": MORE,
        "more_room": ROOM,
        "quicker": QUICKER,
        "more_acceleration": MORE_ACCELERATION,
    }
    if assumed.law == "speed_servo":
        values["fade"] = OutletHold(model, assumed, 0.0).row
        values["settling"] = OutletHold(model, assumed, design.cable.a).row
    put(core.design, values)
    return core


class TickCommand(NamedTuple):
    """The command of a tick, in the terms of the model.

    Attributes
    ----------
    asked : by the law, without the mean payout's share
    governed : what the governor lets through, the mean payout's share included
    standing : command under which the winch would stay where it is
    shares : of the governed command
    """

    asked: LawCommand
    governed: GovernedCommand
    standing: float
    shares: CommandShares


NO_COMMAND = TickCommand(IDLE, GovernedCommand(0.0, (), 0.0), 0.0, CommandShares())
"""Command before the first tick."""


class LoopCommand:
    """The command of a tick.

    Parameters
    ----------
    design : the active one; law : of it, for compensation

    Attributes
    ----------
    governor : of all commands
    last : command of the last tick
    """

    def __init__(self, design: ControllerDesign, law: ControlLaw) -> None:
        self._sequence = 0
        self.last = NO_COMMAND
        self._ahead = 0.0
        self._state = new(COMMAND_STATE)
        self._tension = ConstantTension(self._state["tension"])
        self.take_design(design, law)

    def take_design(self, design: ControllerDesign, law: ControlLaw) -> None:
        """Use a design and its `law` from now on; the tension that is held stays."""
        parameters, model = design.parameters, design.model
        self._winch = parameters.winch
        self._law = law
        # of a law of the suite the command shares the winch: limits have one place
        active = law.winch if isinstance(law, CoreLaw) else ActiveWinch(self._winch, design.limits, design.tick_period)
        active.take(self._winch, design.limits)
        self._core_law = law if isinstance(law, CoreLaw) else None
        self.governor = CommandGovernor(model, active)
        damping = None if self._is_first_order else OutletHold(model, self._winch, design.cable.a)
        self._settled_swing = math.inf if damping is None else damping.settled_swing
        self._core = commander(design, active, law, self._state)
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

    @property
    def settled_swing(self) -> float:
        """Swing of the unit at which a fade-out may end [m]; infinite where the law is not asked to damp it."""
        return self._settled_swing

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
    def tension_asked(self) -> float:
        """Tension that was last asked for [N]; NaN before the first."""
        return self._tension.target

    @property
    def is_half_travelled(self) -> bool:
        """Tell whether constant tension has used half of the travel that it may."""
        return self._tension.is_half_travelled

    def speed(self, tick: LoopTick) -> float:
        """Return the speed of the winch as last commanded at `tick` [m/s], absolute."""
        return math.fabs(
            tick.motions.total_payout_rate if self._is_first_order else self.last.governed.value - self.last.standing
        )

    def payout_range(self) -> tuple[float, float]:
        """Return the ends of the range that the mean payout may use [m]."""
        limits = self.governor.limits
        return limits.payout_minimum, limits.payout_maximum

    def command(self, tick: LoopTick, decision: Decision, preview: HeavePreview | None = None) -> TickCommand:
        """Return the command of a tick: the law's and the mean payout's share, governed.

        Parameters
        ----------
        tick : what is known of the loop
        decision : what is to be done
        preview : of the boom tip, seen from this tick; None: there is none
        """
        core, law = self._core, self._core_law
        core.estimate[:], core.mean_state[:] = tick.estimate, tick.mean_state
        loop = self._loop(tick, decision)
        if preview is not None:
            preview = replace(preview, heave=decision.mode.authority * preview.heave)
        if law is not None and law.preview is None:
            asks = core.act(loop)
        else:
            core.pose(loop)
            if law is not None and law.planner is not None:
                law.planner.see(preview, core.x)
            asks = core.answer()
        if asks == Asks.NEEDS_TENSION:
            self._tension.begin_alone(self._payout())
            asks = core.answer()
        elsewhere = self._asked_elsewhere(asks, preview) if asks else None
        if elsewhere is not None:
            core.make(elsewhere.value)
        self.last = self._made(elsewhere)
        return self.last

    def _loop(self, tick: LoopTick, decision: Decision) -> LoopNow:
        """Return what the core must know of the loop."""
        mode, sensed = decision.mode, tick.sensed
        is_held = tick.knows_tip and mode.mode is Mode.COMPENSATING
        heave, rate = 0.0, 0.0  # where the boom tip is not known the unit is to come to rest
        if tick.knows_tip:
            motions = tick.motions
            heave = motions.taut if is_held else motions.released
            rate = motions.taut_rate if is_held else motions.released_rate
        tip_rate = tick.motions.tip_rate if math.isnan(sensed.mru_rate) else sensed.mru_rate
        return LoopNow(
            way=self._way(decision),
            share=mode.authority if tick.knows_tip else 0.0,
            heave=heave,
            rate=rate,
            swing=tick.motions.mean_heave,
            swing_rate=tick.motions.mean_rate,
            is_unseen=is_held and not sensed.has_depth,
            left_over=tick.left_over,
            mean_command=tick.mean_command,
            mru_rate=mode.authority * tip_rate,
            tension=sensed.tension,
            filtered_tension=sensed.filtered_tension,
            gives_way=decision.bounds_tension or mode.mode not in BY_LAW,
            bounds_tension=decision.bounds_tension,
            fades=mode.mode is Mode.FADE_OUT,
            # while the unit is damped because the boom tip is not known a fade-out goes on for longer
            is_held=decision.is_damped and not tick.knows_tip,
            follows_tip="mru" not in sensed.lost,
            unit_stands=decision.unit_stands,
        )

    def _way(self, decision: Decision) -> Way:
        """Return by what the command of a tick is made."""
        if decision.mode.brake:
            return Way.BY_BRAKE
        if decision.mode.mode is not Mode.FADE_OUT:
            return WAYS.get(decision.mode.mode, Way.BY_NOTHING)
        if not decision.trusts_estimate:
            return Way.BY_SLOWING
        if self._is_first_order:  # it has no rate to command: its law fades out by itself
            return Way.BY_LAW
        if decision.is_damped:
            return Way.BY_SETTLING
        # where a sensor was lost the estimated motion of the unit is not to be acted upon
        return Way.BY_LAW if decision.fades_by_law else Way.BY_FADE

    def _asked_elsewhere(self, asks: int, preview: HeavePreview | None) -> LawCommand:
        """Return what the core `asks` for: a plan, or another law."""
        if asks & Asks.NEEDS_PLAN:
            assert self._core_law is not None
            return self._core_law.planned()
        return self._law.command(self._posed(preview))

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

    def _made(self, elsewhere: LawCommand | None) -> TickCommand:
        """Return the command that the core has made, of what was asked for `elsewhere` where it was."""
        made = self._core.made
        self._ahead = made.payout
        if elsewhere is not None:
            law = elsewhere._replace(value=made.asked)
        elif self._core_law is None:
            law = LawCommand(made.asked)
        else:
            law = self._core_law.commanded(made.asked, by_plan=made.by_plan, has_plan=made.has_plan)
        if made.at_travel:
            law = law._replace(active=(TRAVEL,))
        if made.gives_way:
            law = law._replace(active=(*law.active, TENSION))
        active = shaped_by(int(made.shaped), is_first_order=self._is_first_order)
        governed = GovernedCommand(made.value, active, made.sent)
        return TickCommand(law, governed, made.standing, CommandShares(made.compensating, made.mean))

    def speed_of(self, order: WinchOrder, count_at: Callable[[float], float]) -> float:
        """Return the rate at which a speed servo is to turn under an `order` [m/s]; NaN for a first-order winch.

        `count_at` gives the count of the drive's position loop at a payout.
        """
        if self._is_first_order:
            return math.nan
        held = order.payout - count_at(self._ahead)
        return order.payout_rate if order.brake else order.payout_rate + self._winch.position_gain * held

    def with_payout(self, order: WinchOrder, payout: float) -> WinchOrder:
        """Return an `order` that asks for the same speed, by another `payout` [m]."""
        held = 0.0 if order.brake else self._winch.position_gain * (order.payout - payout)
        return order._replace(payout=payout, payout_rate=order.payout_rate + held)

    def order(self, command: TickCommand, mode: ModeOutput, mean_payout: float) -> WinchOrder:
        """Return the set-points of a command.

        Parameters
        ----------
        command : of the tick
        mode : of the tick
        mean_payout : about which the winch works at the end of the tick [m]
        """
        self._sequence += 1
        sent, gain = command.governed.sent, self._winch.position_gain
        if self._is_first_order:
            return WinchOrder(self._sequence, sent, 0.0, mode.brake)
        if mode.brake:  # a servo on its brake is asked for no speed
            return WinchOrder(self._sequence, sent / gain if gain > 0.0 else mean_payout, 0.0, True)
        # the model's command counts what the winch's position loop makes of the payout set-point as well
        return WinchOrder(self._sequence, mean_payout, sent - gain * mean_payout, False)

    def take_sent(self, asked: WinchOrder, sent: WinchOrder) -> None:
        """Take what was `sent` in place of what this tick `asked`: estimate, adviser and the next stop go by it."""
        last, mean = self.last, self.last.shares.mean
        shaped = 0
        if sent.brake:
            governed = GovernedCommand(last.standing, (), last.standing)
        else:
            is_whole = math.isfinite(asked.payout) and math.isfinite(asked.payout_rate)
            more = sent.payout - asked.payout if self._is_first_order else sent.payout_rate - asked.payout_rate
            before = last.governed.value if is_whole else last.standing
            value = before + (more * self._winch.gain_at(more) if is_whole else sent.payout_rate)
            governed = last.governed._replace(value=value, active=(*last.governed.active, ENVELOPE))
            shaped = int(self._state["shaped"][0]) | Shaped.BY_ENVELOPE
        shares = CommandShares(governed.value - mean, mean)
        self.last = last._replace(governed=governed, shares=shares)
        put(self._state, {"value": governed.value, "sent": governed.sent, "shaped": float(shaped)})
