"""The winch controller as a component: measurements of a tick in, one winch order out. No ROS, no truth, no clock.

Each tick: gates, estimator, shadow of the uncompensated unit (`loop_estimation`), guard, mode, landing, law, governor
(`loop_command`), mean payout (`mean_motion`). The state is split by linearity into the mean payout's own motion (known
exactly, it is our command) and the rest, which is what the estimator and the laws deal with; the two are superposed in
the command.
"""

from __future__ import annotations

import math

from heave_node.arrays import Array

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.prediction import predict_loop
from winch_controller_node.design_in_force import DesignInForce
from winch_controller_node.estimation.loop_estimation import LoopEstimation
from winch_controller_node.estimation.observation import Observer
from winch_controller_node.interface.readings import Measurements, Outputs, RollingKpi
from winch_controller_node.laws.build import effort_of, limits_of
from winch_controller_node.loop_command import LoopCommand
from winch_controller_node.model.estimator import KalmanEstimator
from winch_controller_node.motion.mean_motion import MeanMotion
from winch_controller_node.motion.programme import Programme, ProgrammeStep
from winch_controller_node.motion.trajectory import MeanPayout
from winch_controller_node.parameters.controller import WinchControllerParameters
from winch_controller_node.state_report import state_report
from winch_controller_node.supervision.guard import HarmGuard
from winch_controller_node.supervision.guard_inputs import GuardInputs, swing_left
from winch_controller_node.supervision.landing import LandingWatch
from winch_controller_node.supervision.modes import BRAKED, Mode, ModeError, ModeMachine, ModeOutput, Situation
from winch_controller_node.supervision.rolling_kpi import KpiWindow
from winch_controller_node.supervision.winch_watch import WinchWatch, learns_winch

LIFTING_SURPLUS = 0.06
"""Tension above the static one that lifts a unit off, in weights of the unit: more than the load cell may err."""


class WinchController:
    """The controller.

    Parameters
    ----------
    parameters : what it believes and how it works
    tick_period : [s]
    seed : taken like every component's; the controller itself draws no random number

    Raises DesignError where no controller can be designed from the parameters.
    """

    def __init__(self, parameters: WinchControllerParameters, *, tick_period: float, seed: int = 0) -> None:
        del seed
        self._dt = tick_period
        self.modes = ModeMachine(
            parameters.modes, law=parameters.law, factor=parameters.factor, tick_period=tick_period
        )
        self.programme = Programme(parameters.programme)
        self._in_force = DesignInForce(parameters, tick_period=tick_period)
        design = self.design
        self._motion = MeanMotion(parameters.move, design.model.order, tick_period=tick_period)
        self._estimation = LoopEstimation(design, self._motion)
        self.guard = HarmGuard(
            parameters.guard,
            limits_of(design),
            tick_period=tick_period,
            depth_noise=parameters.sensors.depth.noise,
        )
        self._guard_inputs = GuardInputs(parameters.modes, tick_period=tick_period)
        self._command = LoopCommand(design, self._motion, self.observer, self.guard)
        self._winch = WinchWatch(design, self.guard)
        self._landing = LandingWatch(self.observer)
        self._kpi = KpiWindow(parameters.kpi_window, parameters.winch, tick_period=tick_period)
        self.guard.effort = effort_of(design, self._command.law)
        self._tick = 0
        self._mode_before = self.modes.mode
        self._harm_before = ""
        self._last_rate = 0.0
        self._alarms: list[str] = []

    @property
    def parameters(self) -> WinchControllerParameters:
        """Parameters in force."""
        return self._in_force.parameters

    @property
    def design(self) -> ControllerDesign:
        """Design in force."""
        return self._in_force.design

    @property
    def mode(self) -> Mode:
        """Mode after the last tick."""
        return self.modes.mode

    @property
    def mean(self) -> MeanPayout:
        """The mean payout, about which the winch compensates."""
        return self._motion.mean

    @property
    def estimator(self) -> KalmanEstimator:
        """The estimator of the loop, without the mean payout's own motion."""
        return self._estimation.estimator

    @property
    def observer(self) -> Observer:
        """The gates in front of the estimator."""
        return self._estimation.observer

    @property
    def depth(self) -> float:
        """Estimated mean depth of the unit, positive down [m]; NaN before the first depth reading."""
        return self._estimation.mean_depth

    def figures(self) -> RollingKpi:
        """Return the figures of merit of the last window."""
        return self._kpi.figures()

    def predicted_unit_sigma(self) -> float:
        """Standard deviation of the unit's heave that the design promises without limits [m]."""
        gain = self._command.law.gain
        return predict_loop(self.design, gain if len(gain) else None).sigma["unit_heave"]

    # what an operator asks for

    def set_mode(self, name: str, tension: float = 0.0) -> str:
        """Ask for a mode by name, with the tension to hold [N] in constant_tension (0: the present mean).

        Returns the mode taken in words. Raises ModeError, saying why, where it cannot be taken.
        """
        if name == Mode.CONSTANT_TENSION.value:
            measured = self._command.tension.measured
            if not math.isfinite(measured):
                raise ModeError("constant tension needs the load cell: no reading has come yet")
            if not math.isfinite(tension) or tension < 0.0:
                raise ModeError(f"a tension of {tension} N cannot be held")
            self.modes.request(name)
            self.mean.stop()
            self._command.tension.hold(tension if tension > 0.0 else measured)
            return self.modes.mode.value
        if name == Mode.COMPENSATING.value and self._landing.has_landed:
            self._lift_off()
            return "lifting off: constant tension until the unit hangs"
        self.modes.request(name)
        return self.modes.mode.value

    def move_to_depth(self, depth: float, speed: float = 0.0) -> None:
        """Move the unit to the mean depth [m] at no more than `speed` [m/s] (0: the default).

        Raises ModeError where the depth is not known, the winch does not compensate, or its range does not reach.
        """
        if self.observer.depth_zero is None:
            raise ModeError("a move needs the depth sensor: no reading has come yet")
        if self.modes.mode is not Mode.COMPENSATING:
            raise ModeError(f"a move needs mode compensating; the mode is {self.modes.mode.value}")
        if not math.isfinite(depth):
            raise ModeError(f"a depth of {depth} m cannot be reached")
        self.move_to_payout(self._estimation.payout_at(depth), speed)

    def move_to_payout(self, payout: float, speed: float = 0.0) -> None:
        """Move the mean payout to `payout` [m]. Raises ModeError where the winch's range does not reach."""
        limits = self._command.governor.limits
        if not limits.payout_minimum <= payout <= limits.payout_maximum:
            raise ModeError(
                f"that needs a payout of {payout:.1f} m; the winch reaches {limits.payout_minimum:g} to "
                f"{limits.payout_maximum:g} m"
            )
        self.mean.move_to(payout, speed)

    def cancel_move(self) -> None:
        """Bring the mean payout to rest smoothly."""
        self.mean.stop()

    def _run_programme(self, time: float) -> None:
        """Do what the programme has due; what cannot be done now is said and left."""
        for due in self.programme.due(time):
            self._do(due)

    def _do(self, due: ProgrammeStep) -> None:
        try:
            if due.mode:
                self.set_mode(due.mode)
            else:
                self.move_to_payout(due.payout, due.speed)
        except (ModeError, ValueError) as error:
            self._alarms.append(f"programme at {due.time:g} s: {error}")

    # a tick

    def step(self, tick: int, measurements: Measurements) -> Outputs:
        """Do tick k: take the readings delivered at t_k, return the order for [t_k, t_{k+1}] and what is believed."""
        self._alarms = []
        self._tick = tick
        self._run_programme(tick * self._dt)
        self._follow_winch()
        self._follow_length()
        estimate = self._estimate(tick, measurements)
        uncompensated = self._estimation.advance_shadow(estimate)
        fault = 0 if measurements.winch is None else measurements.winch.fault
        mode = self._step_mode(estimate, uncompensated, fault)
        self._watch_landing(mode)
        asked, governed = self._command.command(mode, estimate, uncompensated)
        self._motion.advance(self.design.model, self._command.reference, is_braked=self.modes.brake)
        order = self._command.order(mode, governed)
        self._winch.give(order)
        self._note_kpi(estimate, uncompensated)
        report = state_report(
            tick,
            mode,
            asked,
            governed,
            order,
            estimate,
            design=self.design,
            gain=self._command.law.gain,
            estimation=self._estimation,
            mean_set_point=self._motion.set_point,
        )
        kpi = self._kpi.figures() if tick % max(1, round(1.0 / self._dt)) == 0 else None
        return Outputs(order, report, kpi, tuple(self._alarms))

    def _estimate(self, tick: int, measurements: Measurements) -> Array:
        """Estimate the loop; tell the watches what the sensors say of it."""
        estimate = self._estimation.step(tick, measurements, self._command.compensating)
        if measurements.of("load_cell") and math.isfinite(self.observer.tension):
            self._command.tension.observe(self.observer.tension)
        self._landing.note_depth(self.estimator)
        self._alarms += self.observer.new_faults()
        self._alarms += self._winch.watch(measurements.winch, self.observer.payout, self.parameters)
        return estimate

    def _note_kpi(self, estimate: Array, uncompensated: Array) -> None:
        rows = self._estimation.rows
        rate = float(rows.payout_rate @ (estimate + self._motion.state))
        self._kpi.add(
            unit=self._estimation.unit_heave(estimate),
            uncompensated=float(uncompensated[0]),
            tip=float(rows.tip[0] @ estimate),
            payout=float(rows.payout @ estimate),
            rate=rate,
            acceleration=(rate - self._last_rate) / self._dt,
            tension=self.observer.tension,
        )
        self._last_rate = rate

    # modes

    def _step_mode(self, estimate: Array, uncompensated: Array, fault: int) -> ModeOutput:
        self._update_guard(estimate, uncompensated)
        situation = Situation(
            lost=self.observer.lost(self._vital()),
            has_estimate=bool(self.observer.gates["encoder"].state(0.0).accepted),
            winch_fault=fault,
            harm=self.guard.reason,
            speed=self._command.speed(estimate),
            authority_limit=1.0 if self.parameters.law == "mpc" else self.guard.authority_limit,
            is_settled=self._is_settled(estimate, uncompensated),
        )
        mode = self.modes.step(situation)
        if mode.mode is not self._mode_before:
            self._enter(mode.mode, self._mode_before, estimate)
            self._mode_before = mode.mode
        return mode

    def _update_guard(self, estimate: Array, uncompensated: Array) -> None:
        """Have the guard judge the tick; say its reason when the brake is on and no mode would."""
        is_judged = not self._landing.has_landed and self.modes.mode is not Mode.CONSTANT_TENSION
        authority = self.modes.authority if is_judged else 0.0
        seen = self._guard_inputs.seen(
            self._estimation.rows,
            estimate,
            self._motion.state,
            uncompensated,
            authority=authority,
            depth_reading=self._estimation.depth_reading,
        )
        self.guard.update(
            seen,
            authority,
            self.modes.target,
            inertia=self.design.cable.a,
            has_feedback=self.parameters.law != "feedforward",
        )
        if self.modes.brake and self.guard.reason and self.guard.reason != self._harm_before:
            self._alarms.append(self.guard.reason)
        self._harm_before = self.guard.reason

    def _is_settled(self, estimate: Array, uncompensated: Array) -> bool:
        """Tell whether a lost loop has been brought back: the winch may stop, and the unit will not swing on."""
        loop = self._command.settling_loop
        if not (self.guard.is_harming and self.guard.trusts_estimate) or loop is None:
            return True
        return swing_left(self._estimation.rows, estimate, uncompensated, self.design.cable.a) < loop.settled

    def _vital(self) -> tuple[str, ...]:
        if self.modes.mode is Mode.CONSTANT_TENSION:
            return ("mru", "encoder", "load_cell")
        return ("mru", "encoder")

    def _enter(self, mode: Mode, before: Mode, estimate: Array) -> None:
        """Make the change of mode without a step."""
        self._alarms.append(f"mode {mode.value}: {self.modes.reason}")
        if mode in BRAKED:
            self.mean.jump_to(self.mean.point.payout)
        elif mode is not Mode.COMPENSATING:
            self.mean.stop()
        is_returning = mode is Mode.COMPENSATING and before is not Mode.FADE_OUT
        if mode is Mode.COMPENSATING and before is Mode.FADE_OUT:
            self.guard.excuse_drum()
        if before is Mode.CONSTANT_TENSION and mode is Mode.COMPENSATING:
            self._hand_over(stood=False)
        elif is_returning or (mode is Mode.FADE_OUT and before is Mode.CONSTANT_TENSION):
            # what was left over is the new mean, and goes away slowly; with the winch locked the unit would go on so
            self._motion.return_from(float(self._estimation.rows.payout @ estimate))
            self._estimation.restart_shadow(estimate)
            self._command.law.reset()

    # landing and lift-off

    def _watch_landing(self, mode: ModeOutput) -> None:
        """Notice touchdown while lowering, and that the unit hangs again after lift-off."""
        measured, static = self._command.tension.measured, self.design.cable.static_tension
        if not math.isfinite(measured):
            return
        weight = self.design.unit_weight
        share = (measured - static) / weight + 1.0
        parameters = self.parameters.tension
        if self._landing.touches_down(share, mode, self.mean.point.rate, parameters, self.estimator):
            self._land(static - (1.0 - parameters.landing_ratio) * weight)
        elif self._landing.hangs(share, parameters):
            self._hang()

    def _land(self, tension: float) -> None:
        """Go over to constant tension on the seabed."""
        self._landing.land()
        self.set_mode(Mode.CONSTANT_TENSION.value, tension)
        self._alarms.append("touchdown")

    def _lift_off(self) -> None:
        """Raise the tension until the unit hangs."""
        self._landing.is_lifting = True
        self._command.tension.hold(self.design.cable.static_tension + LIFTING_SURPLUS * self.design.unit_weight)

    def _hang(self) -> None:
        """Compensate again: the unit hangs, where it stands; raise it off the seabed."""
        self._landing.hang()
        self.modes.request(Mode.COMPENSATING.value)
        self._mode_before = Mode.COMPENSATING
        self._hand_over(stood=True)
        self.mean.move_to(self.mean.point.payout - self.parameters.tension.lift_height)
        self._alarms.append("unit hangs")

    def _hand_over(self, *, stood: bool) -> None:
        """Make the present depth of the unit the mean and go on from there."""
        self._estimation.hand_over(self._tick, tension=self._command.tension.measured if stood else None)
        self._command.law.reset()

    # another design

    def redesign(self, parameters: WinchControllerParameters) -> ControllerDesign:
        """Design again from `parameters` and go on with the new design; states must be the same.

        Raises DesignError or ValueError, the old design then stays.
        """
        self._in_force.redesign(parameters, self.mean.point.payout, self.estimator)
        self._take_design()
        return self.design

    def _follow_winch(self) -> None:
        """Design anew where the winch is found to follow its set-points otherwise than believed."""
        if not learns_winch(self.parameters) or self.modes.mode is not Mode.COMPENSATING:
            return
        better = self._winch.better_belief(self._tick, self.parameters)
        if better is None:
            return
        self._in_force.believe(better, self._estimation, self._tick - 1)
        self._take_design()
        self._alarms.append(
            f"winch now believed to have a servo of {better.winch.time_constant:.3f} s and a delay of "
            f"{better.winch.command_delay:.3f} s"
        )

    def _follow_length(self) -> None:
        """Follow the gain schedule, where there is one."""
        if self._in_force.follow_length(self.mean.point.payout, self.estimator):
            self._take_design()

    def _take_design(self) -> None:
        """Use the design in force from now on; estimate, mode and mean payout stay."""
        self._command.take_design(self.design)
        self.guard.effort = effort_of(self.design, self._command.law)
        self._estimation.take_design(self.design)
