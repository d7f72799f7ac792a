"""From mode and estimate to the order: which law is asked, the mean payout's share, the governor, the set-points."""

from __future__ import annotations

import math

from heave_node.arrays import Array

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.estimation.observation import Observer
from winch_controller_node.interface.readings import WinchOrder
from winch_controller_node.laws.build import Law, make_governor, make_law, make_open_loop
from winch_controller_node.laws.feedback import LawCommand
from winch_controller_node.laws.feedforward import SpeedFeedforward
from winch_controller_node.laws.governor import GovernedCommand
from winch_controller_node.laws.loop_state import AuthorityShift, LoopState, Reference
from winch_controller_node.laws.tension import ConstantTension
from winch_controller_node.model.loop_rows import loop_rows
from winch_controller_node.motion.mean_motion import MeanMotion
from winch_controller_node.supervision.guard import HarmGuard
from winch_controller_node.supervision.modes import Mode, ModeOutput

IDLE = LawCommand(0.0)


class LoopCommand:
    """The command of a tick.

    Parameters
    ----------
    design : whose laws are asked
    motion : of the mean payout
    observer : newest tension and MRU rate
    guard : whether compensation does harm, and whether the estimate is to be trusted

    Attributes
    ----------
    law : of compensation; tension : of constant tension; governor : of both
    settling_loop : brings a lost loop back; None for a first-order winch
    compensating : share of the last command that compensated; reference : that of the mean payout, in model terms
    """

    def __init__(self, design: ControllerDesign, motion: MeanMotion, observer: Observer, guard: HarmGuard) -> None:
        self._motion = motion
        self._observer = observer
        self._guard = guard
        self._sequence = 0
        self._speed_asked = 0.0
        self._total = 0.0
        self.compensating = 0.0
        self._make_laws(design, None)

    def take_design(self, design: ControllerDesign) -> None:
        """Use the laws of another design from now on; the tension that is held stays."""
        self._make_laws(design, self.tension)

    def _make_laws(self, design: ControllerDesign, tension_before: ConstantTension | None) -> None:
        parameters = design.parameters
        self._design = design
        self._winch = parameters.winch
        self._is_first_order = parameters.winch.law == "first_order"
        self._rows = loop_rows(design.model)
        self.law: Law = make_law(design)
        self.governor = make_governor(design)
        self._open_loop = make_open_loop(design)
        self.settling_loop = make_open_loop(design, settles=True)
        self.tension = ConstantTension(design.model, design.cable, parameters.winch, parameters.tension, tension_before)
        self._shift = AuthorityShift(design.model, design.sea_states)

    @property
    def reference(self) -> float:
        """Share of the last command that moved the mean payout, in the terms of the model."""
        return self._total - self.compensating

    def speed(self, estimate: Array) -> float:
        """Return the speed of the winch as commanded [m/s], absolute."""
        if self._is_first_order:
            return abs(float(self._rows.payout_rate @ (estimate + self._motion.state)))
        return abs(self._speed_asked)

    def command(self, mode: ModeOutput, estimate: Array, uncompensated: Array) -> tuple[LawCommand, GovernedCommand]:
        """Return what the law asks for and what the governor lets through, the mean payout's share included.

        Parameters
        ----------
        mode : of the tick
        estimate : of the loop, shape (n,)
        uncompensated : heave and rate of the unit with the winch locked, shape (2,)
        """
        mean_state = self._motion.state
        total_state = estimate + mean_state
        payout, rate = self.governor.predict(total_state)
        reference_command = self._motion.reference_command(self._winch)
        standing = self._standing_command(total_state, payout)
        mean_payout, mean_rate = self.governor.predict(mean_state)
        state = LoopState(
            x=self._law_state(mode, estimate, uncompensated),
            reference=Reference(mean_payout, mean_rate, reference_command),
            static_tension=self._design.cable.static_tension,
        )
        asked = self._ask(mode, state, estimate, standing)
        if mode.brake:
            governed = GovernedCommand(standing, (), standing)
        else:
            tension = self._observer.tension if math.isfinite(self._observer.tension) else state.static_tension
            governed = self.governor.govern(asked.value + reference_command, payout, rate, tension)
        self._total = governed.value
        self._speed_asked = governed.value - standing
        self.compensating = governed.value - reference_command
        return asked, governed

    def order(self, mode: ModeOutput, governed: GovernedCommand) -> WinchOrder:
        """Return the set-points of a governed command, about the mean payout at the end of the tick."""
        self._sequence += 1
        if self._is_first_order:
            return WinchOrder(self._sequence, governed.sent, 0.0, mode.brake)
        payout = self._motion.set_point
        # the model's command counts what the winch's position loop makes of the payout set-point as well
        rate = governed.sent - self._winch.position_gain * payout
        return WinchOrder(self._sequence, payout, rate, mode.brake)

    def _law_state(self, mode: ModeOutput, estimate: Array, uncompensated: Array) -> Array:
        if mode.mode is Mode.CONSTANT_TENSION:
            return estimate
        x = self._shift.shift(estimate, uncompensated, mode.authority)
        rows, mean_state = self._rows, self._motion.state
        # the unit shall follow the mean payout stiffly, not swing after it as it would by itself
        x[rows.unit_states] += mean_state[rows.unit_states] + rows.winch @ mean_state
        left = self._motion.left_over.point.payout
        if left != 0.0:
            x[self._design.model.state("payout")] -= left
            x[self._design.model.state("unit_heave")] += left
        return x

    def _ask(self, mode: ModeOutput, state: LoopState, estimate: Array, standing: float) -> LawCommand:
        if mode.mode is Mode.CONSTANT_TENSION:
            return self.tension.command(LoopState(estimate, state.reference, state.static_tension))
        if mode.mode is Mode.STOPPING or (mode.mode is Mode.FADE_OUT and not self._guard.trusts_estimate):
            return self._slow_down(state, standing)
        if mode.mode is Mode.FADE_OUT and self._guard.is_harming and self.settling_loop is not None:
            return self.settling_loop.command(state)
        if mode.mode is Mode.FADE_OUT and self._open_loop is not None:
            # a sensor was lost: what the unit is believed to do is not to be acted upon any more
            return self._open_loop.command(state)
        if mode.mode in (Mode.COMPENSATING, Mode.FADE_OUT):
            if isinstance(self.law, SpeedFeedforward):
                self.law.reading = mode.authority * self._observer.mru_rate
            return self.law.command(state)
        return IDLE

    def _slow_down(self, state: LoopState, standing: float) -> LawCommand:
        """Return the command that brings the winch to rest at a bounded deceleration; `standing` keeps it there."""
        if self._is_first_order:
            return LawCommand(standing - state.reference.command)
        step = self._design.parameters.modes.stop_deceleration * self._design.tick_period
        slower = math.copysign(max(abs(self._speed_asked) - step, 0.0), self._speed_asked)
        return LawCommand(slower + standing - state.reference.command)

    def _standing_command(self, total_state: Array, payout_ahead: float) -> float:
        """Return the command under which the winch stays where it is: its own payout, or what a servo's position loop
        takes off.
        """
        if self._is_first_order:
            return float(self._rows.payout @ total_state)
        return self._winch.position_gain * payout_ahead
