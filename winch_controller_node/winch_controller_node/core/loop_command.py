"""From mode and loop to the order: which law is asked, the mean payout's share, the governor, the set-points."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from heave_node.interface.preview import HeavePreview
from heave_node.numerics.arrays import Array

from winch_controller_node.core.estimation.loop_tick import CommandShares, LoopTick, free_swing
from winch_controller_node.core.supervision.modes import SETTLING_LIMIT, Mode, ModeOutput
from winch_controller_node.core.supervision.supervisor import Decision
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.readings import WinchOrder
from winch_controller_node.laws.constant_tension import ConstantTension, TensionSetPoint, Travel
from winch_controller_node.laws.law import ControlLaw, LawCommand
from winch_controller_node.laws.outlet_hold import OutletHold
from winch_controller_node.laws.parts.governor import TENSION, GovernedCommand
from winch_controller_node.laws.parts.loop_state import AuthorityShift, LoopState, Reference
from winch_controller_node.laws.parts.order_minute import OrderMinute
from winch_controller_node.model.loop_rows import loop_rows

IDLE = LawCommand(0.0)

GIVING_TIME = 1.0
"""A winch gives way to a tension above the highest one within this time [s], and no quicker than twice its lag."""

LARGEST_UNSEEN, UNSEEN_ERROR = 0.02, 0.5
"""Largest swing for which compensation corrects a unit that no depth sensor sees [m], and swing of which it corrects
what is above it: up to there all of it may be error."""

COUNT_MARGIN = 0.2
"""Time that an order may take longer than the nominal delay to the drive's position loop [s]: some ticks."""

BY_LAW = (Mode.COMPENSATING, Mode.FADE_OUT)
"""Modes in which a winch that gives way to more than compensation can keep would be too late for the next wave."""


ENVELOPE = "envelope"
"""Name of the bound on what leaves."""


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
        self._minute = OrderMinute(design.tick_period)
        self._tension = TensionSetPoint(design.parameters.tension, tick_period=design.tick_period)
        self._travel = Travel(tick_period=design.tick_period)
        self.take_design(design, law)

    def take_design(self, design: ControllerDesign, law: ControlLaw) -> None:
        """Use a design and its `law` from now on; the tension that is held stays."""
        parameters, model = design.parameters, design.model
        self._winch = parameters.winch
        self._static_tension = design.cable.static_tension
        self._rows = loop_rows(model)
        self._dt = design.tick_period
        self._longest_fade = parameters.modes.fade_out_time + SETTLING_LIMIT
        self._stop_step = parameters.modes.stop_deceleration * self._dt
        self._law = law
        self.governor = design.make_governor()
        # a first-order winch has no rate to command: its law fades out by itself
        rate_driven = not self._is_first_order
        self._fade_out = OutletHold(model, parameters.winch, 0.0) if rate_driven else None
        self._settling = OutletHold(model, parameters.winch, design.cable.a) if rate_driven else None
        self._constant_tension = ConstantTension(
            model,
            design.cable,
            parameters.winch,
            parameters.tension,
            self._tension,
            self._travel,
            round_trip=design.wave_round_trip,
        )
        self._stiffness, self._travel_bound = design.cable.stiffness, parameters.tension.travel
        self._giving_time = max(GIVING_TIME, 2.0 * (parameters.winch.command_delay + parameters.winch.time_constant))
        self._shift = AuthorityShift(model, design.sea_states)
        self._inertia = design.cable.a
        self._left_over_states = model.state("payout"), model.state("unit_heave")

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
        return math.inf if self._settling is None else self._settling.settled_swing

    def ease(self) -> None:
        """Let the order make no step for some seconds: something else is assumed."""
        self._minute.ease()

    def begin_tension(self, measured: float) -> None:
        """Begin constant tension at the measured tension [N]."""
        self._tension.begin(measured)

    def hold_tension(self, tension: float) -> None:
        """Go to another tension [N] from the one that is held."""
        self._travel.begin(self._travel_bound, abs(tension - self._tension.value) / self._stiffness)
        self._tension.hold(tension)

    @property
    def tension_asked(self) -> float:
        """Tension that was last asked for [N]; NaN before the first."""
        return self._tension.target

    @property
    def is_half_travelled(self) -> bool:
        """Tell whether constant tension has used half of the travel that it may."""
        return self._travel.is_half_used

    def speed(self, tick: LoopTick) -> float:
        """Return the speed of the winch as last commanded at `tick` [m/s], absolute."""
        return abs(tick.motions.total_payout_rate) if self._is_first_order else abs(self._speed_asked)

    @property
    def _speed_asked(self) -> float:
        """Speed that was last asked of a speed servo [m/s]."""
        return self.last.governed.value - self.last.standing

    def payout_range(self) -> tuple[float, float]:
        """Return the ends of the range that the mean payout may use [m]."""
        return self.governor.limits.payout_minimum, self.governor.limits.payout_maximum

    def command(self, tick: LoopTick, decision: Decision, preview: HeavePreview | None = None) -> TickCommand:
        """Return the command of a tick: the law's and the mean payout's share, governed.

        Parameters
        ----------
        tick : what is known of the loop
        decision : what is to be done
        preview : of the boom tip, seen from this tick; None: there is none
        """
        mode = decision.mode
        if preview is not None:
            preview = replace(preview, heave=mode.authority * preview.heave)
        payout, rate = self.governor.predict(tick.total_state)
        self._ahead = payout
        standing = self._standing_command(tick.total_state, payout)
        mean_payout, mean_rate = self.governor.predict(tick.mean_state)
        state = LoopState(
            x=self._law_state(tick, mode),
            reference=Reference(mean_payout, mean_rate, tick.mean_command),
            static_tension=self._static_tension,
            measured_tension=tick.sensed.filtered_tension,
            mru_rate=mode.authority
            * (tick.motions.tip_rate if math.isnan(tick.sensed.mru_rate) else tick.sensed.mru_rate),
            preview=preview,
            bounds_tension=decision.bounds_tension,
        )
        if mode.brake:
            asked, governed = IDLE, GovernedCommand(standing, (), standing)
        elif comes_to_rest(decision):
            asked, governed, standing = self._slow_down(tick)
        else:
            asked = self._ask(tick, state, standing, decision)
            if decision.bounds_tension or mode.mode not in BY_LAW:
                asked = self._give_way(asked, tick, mode)
            tension = tick.sensed.tension if math.isfinite(tick.sensed.tension) else state.static_tension
            within = self._within(decision, knows_tip=tick.knows_tip)
            governed = self.governor.govern(asked.value + tick.mean_command, payout, rate, tension, within)
            if beyond := self._minute.beyond(governed.sent):
                less = governed.value - beyond * self._winch.gain_at(beyond)
                governed = governed._replace(value=less, sent=governed.sent - beyond)
        compensating = governed.value - tick.mean_command
        shares = CommandShares(compensating, governed.value - compensating)
        self.last = TickCommand(asked, governed, standing, shares)
        self._minute.note(self._speed_asked, governed.sent)
        return self.last

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
        sent = command.governed.sent
        if mode.brake and not self._is_first_order:
            return WinchOrder(self._sequence, self._place_held(command, mean_payout), 0.0, True)
        if self._is_first_order:
            return WinchOrder(self._sequence, sent, 0.0, mode.brake)
        # the model's command counts what the winch's position loop makes of the payout set-point as well
        return WinchOrder(self._sequence, mean_payout, sent - self._winch.position_gain * mean_payout, mode.brake)

    def take_sent(self, asked: WinchOrder, sent: WinchOrder) -> None:
        """Take what was `sent` in place of what this tick `asked`: estimate, adviser and the next stop go by it."""
        last, mean = self.last, self.last.shares.mean
        if sent.brake:
            governed = GovernedCommand(last.standing, (), last.standing)
        else:
            is_whole = math.isfinite(asked.payout) and math.isfinite(asked.payout_rate)
            more = sent.payout - asked.payout if self._is_first_order else sent.payout_rate - asked.payout_rate
            before = last.governed.value if is_whole else last.standing
            value = before + (more * self._winch.gain_at(more) if is_whole else sent.payout_rate)
            governed = last.governed._replace(value=value, active=(*last.governed.active, ENVELOPE))
        shares = CommandShares(governed.value - mean, mean)
        self.last = last._replace(governed=governed, shares=shares)

    def _place_held(self, command: TickCommand, mean_payout: float) -> float:
        """Return the payout set-point [m] under which a servo on its brake asks for no speed."""
        gain = self._winch.position_gain
        return command.governed.sent / gain if gain > 0.0 else mean_payout

    def _law_state(self, tick: LoopTick, mode: ModeOutput) -> Array:
        """Return the state that the law acts on; constant tension follows the whole sea and acts on the estimate."""
        if mode.mode is Mode.CONSTANT_TENSION:
            return tick.estimate
        if tick.knows_tip:
            is_held = mode.mode is Mode.COMPENSATING
            uncompensated = tick.taut_uncompensated if is_held else tick.released_motion
            x = self._shift.shift(tick.estimate, uncompensated, mode.authority)
        else:  # the unit is to come to rest
            is_held = False
            x = self._shift.shift(tick.estimate, np.zeros(2), 0.0)
        # the unit shall follow the mean payout stiffly, not swing after it as it would by itself
        x[self._rows.unit_states] += tick.mean_swing
        if is_held and not tick.sensed.has_depth:
            self._bound_unseen(x)
        if tick.left_over != 0.0:
            payout, unit = self._left_over_states
            x[payout] -= tick.left_over
            x[unit] += tick.left_over
        return x

    def _bound_unseen(self, x: Array) -> None:
        """Bound, in place, how far off a unit is taken to be that no depth sensor sees.

        Its estimate is then no better than the assumed MRU, load cell and cable: fed back in full it sends
        the drum after the errors of all three. What is more than those may be is there, and is to be damped.
        """
        unit = self._rows.unit_states
        swing = free_swing(float(x[unit[0]]), float(x[unit[1]]), self._inertia)
        if swing > LARGEST_UNSEEN:
            x[unit] *= (LARGEST_UNSEEN + max(swing - UNSEEN_ERROR, 0.0)) / swing

    def _give_way(self, asked: LawCommand, tick: LoopTick, mode: ModeOutput) -> LawCommand:
        """Pay out more than is asked for where the tension is above the highest one."""
        over = tick.sensed.filtered_tension - self.governor.limits.maximum_tension
        if mode.brake or self._is_first_order or not over > 0.0:
            return asked
        more = over / (self._stiffness * self._giving_time)
        return asked._replace(value=asked.value + more, active=(*asked.active, TENSION))

    def _ask(self, tick: LoopTick, state: LoopState, standing: float, decision: Decision) -> LawCommand:
        """Ask the law that the mode calls for."""
        mode = decision.mode.mode
        if mode is Mode.CONSTANT_TENSION:
            tension = tick.sensed.tension if math.isfinite(tick.sensed.tension) else state.measured_tension
            return self._constant_tension.command(
                state, tension, follows_tip="mru" not in tick.sensed.lost, unit_stands=decision.unit_stands
            )
        if mode is Mode.COMPENSATING:
            return self._law.command(state)
        if mode is Mode.MANUAL:
            # the drum stays where it is about the mean payout, which the operator moves
            gain = 1.0 if self._is_first_order else self._winch.position_gain
            return LawCommand(standing - gain * state.reference.payout)
        if mode is Mode.FADE_OUT:
            return self._ask_fade_out(state, decision)
        return IDLE

    def _ask_fade_out(self, state: LoopState, decision: Decision) -> LawCommand:
        """Ask for a fade-out that uses no more of the estimate than can be trusted."""
        if decision.is_damped and self._settling is not None:
            return self._settling.command(state)
        if self._fade_out is not None and not decision.fades_by_law:
            # a sensor was lost: the estimated motion of the unit is not to be acted upon
            return self._fade_out.command(state)
        return self._law.command(state)

    def _slow_down(self, tick: LoopTick) -> tuple[LawCommand, GovernedCommand, float]:
        """Return the last order, slower by a step: the winch comes to rest whatever is estimated.

        Where the drum stands under a position loop is the way of the orders since the last one that was given by the
        estimate. Returns what is asked, the command, and that under which the winch would stay where it is.
        """
        last = self.last
        if self._is_first_order:  # it goes to its last set-point, and stays
            return LawCommand(last.governed.value - tick.mean_command), last.governed, last.governed.value
        sent = last.governed.sent - last.standing
        # of an order that the envelope has replaced its own part goes on
        speed = self._winch.gain_at(sent) * sent if ENVELOPE in last.governed.active else self._speed_asked
        slower = math.copysign(max(abs(speed) - self._stop_step, 0.0), speed)
        stands = last.standing + self._winch.position_gain * slower * self._dt
        # what is sent falls with it: a servo that needs more than its speed gets less of that too
        sent *= slower / speed if speed != 0.0 else 0.0
        governed = GovernedCommand(slower + stands, (), sent + stands)
        return LawCommand(governed.value - tick.mean_command), governed, stands

    def _within(self, decision: Decision, *, knows_tip: bool) -> tuple[float, float] | None:
        """Return the speeds of a fade-out [m/s]; None: of any other mode they are as the law wants.

        While the unit is damped because the boom tip is not known it goes on for longer, and they stay what they are.
        """
        if decision.mode.mode is not Mode.FADE_OUT:
            self._minute.restart()
            return None
        self._minute.fade(self._longest_fade, is_held=decision.is_damped and not knows_tip)
        return self._minute.bounds(self.governor.limits.acceleration, self._winch.time_constant, self._stop_step)

    def _standing_command(self, total_state: Array, payout_ahead: float) -> float:
        """Return the command under which the winch stays where it is.

        It is its own payout, or what a servo's position loop takes off.
        """
        if self._is_first_order:
            return float(self._rows.payout @ total_state)
        return self._winch.position_gain * payout_ahead


def comes_to_rest(decision: Decision) -> bool:
    """Tell whether by a `decision` the winch comes to rest from its last order, whatever is estimated."""
    mode = decision.mode.mode
    return mode is Mode.STOPPING or (mode is Mode.FADE_OUT and not decision.trusts_estimate)
