"""The winch controller as a component: measurements of a tick in, one winch order out. No ROS, no truth, no clock.

Each tick: gates, estimator, shadow of the uncompensated unit, guard, mode, mean payout, law, governor. The state is
split by linearity into the mean payout's own motion (known exactly, it is our command) and the rest, which is what the
estimator and the laws deal with; the two are superposed in the command.
"""

from __future__ import annotations

import math

import numpy as np
from cable_sim_node.drive import LIMIT_PAYOUT, LIMIT_POWER

from winch_controller_node.design import ControllerDesign, carry_by_name, carry_over, design_controller
from winch_controller_node.guard import HarmGuard, Seen
from winch_controller_node.handover import hand_over, hand_over_standing
from winch_controller_node.laws.build import Law, effort_of, limits_of, make_governor, make_law, make_open_loop
from winch_controller_node.laws.feedback import LawCommand
from winch_controller_node.laws.feedforward import SpeedFeedforward
from winch_controller_node.laws.governor import GovernedCommand
from winch_controller_node.laws.loop_state import AuthorityShift, LoopState, Reference
from winch_controller_node.laws.tension import ConstantTension
from winch_controller_node.linear_model import Array
from winch_controller_node.models import DEPTH_BIAS, shadow_model
from winch_controller_node.modes import BRAKED, Mode, ModeError, ModeMachine, ModeOutput, Situation
from winch_controller_node.observation import Observer
from winch_controller_node.parameters import WinchControllerParameters
from winch_controller_node.prediction import predict_loop
from winch_controller_node.programme import Programme, ProgrammeStep
from winch_controller_node.readings import Measurements, Outputs, Report, RollingKpi, WinchOrder, WinchReading
from winch_controller_node.rolling_kpi import KpiWindow
from winch_controller_node.schedule import FOLLOW, design_schedule, is_scheduled
from winch_controller_node.sea_adaptation import SeaTracker
from winch_controller_node.trajectory import MeanPayout
from winch_controller_node.winch_identification import LateCommands, WinchIdentifier

LIFTING_SURPLUS = 0.06
"""Tension above the static one that lifts a unit off, in weights of the unit: more than the load cell may err."""

RETURN_SPEED = 0.05
"""Speed at which a payout left over from before a stop returns to the mean [m/s]."""

STANDING_SURPRISE = 3.0
"""Standard deviations by which the depth sensor sees a landed unit above a hanging one, at least."""

IDLE = LawCommand(0.0)

LEARNING_PERIOD, CHECKING_PERIOD = 2.0, 10.0
"""Time from one look at the record of the winch to the next [s], while it grows and when it is full."""

BEARABLE_SHARE = 0.5
"""Further delay that is tried, over lag and delay believed in, where they are not learnt."""

UNLEARNT_LIMITS = LIMIT_PAYOUT | LIMIT_POWER
"""Limits of a winch that its identification does not know."""


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
        self.parameters = parameters
        self._dt = tick_period
        self._is_first_order = parameters.winch.law == "first_order"
        self.mean = MeanPayout(parameters.move, tick_period=tick_period)
        self._left_over = MeanPayout(parameters.move, tick_period=tick_period)
        self.modes = ModeMachine(
            parameters.modes, law=parameters.law, factor=parameters.factor, tick_period=tick_period
        )
        self.programme = Programme(parameters.programme)
        self._schedule = design_schedule(parameters, tick_period=tick_period) if is_scheduled(parameters) else None
        design = self._design_for(parameters, 0.0)
        self.estimator = design.make_estimator()
        self.observer = Observer(design, parameters.health)
        self.guard = HarmGuard(
            parameters.guard,
            limits_of(design),
            tick_period=tick_period,
            depth_noise=parameters.sensors.depth.noise,
        )
        self._kpi = KpiWindow(parameters.kpi_window, parameters.winch, tick_period=tick_period)
        self._mean_state: Array = np.zeros(design.model.order)
        self._shadow_state: Array = np.zeros(2)
        self._sea = SeaTracker(design)
        self._winch = WinchIdentifier(parameters.lag, design)
        self._late_commands = LateCommands(tick_period)
        self._tension_law: ConstantTension | None = None
        self._take_design(design)
        self._sequence = 0
        self._order_given: WinchOrder | None = None
        self._tick = 0
        self._mode_before = self.modes.mode
        self._harm_before = ""
        self._authority_before = 0.0
        self._depth_surprise = 0.0
        self._depth_reading: float | None = None
        self._compensating_command = 0.0
        self._total_command = 0.0
        self._speed_asked = 0.0
        self._last_rate = 0.0
        self._has_landed = False
        self._is_lifting = False
        self._alarms: list[str] = []

    @property
    def mode(self) -> Mode:
        """Mode after the last tick."""
        return self.modes.mode

    @property
    def depth(self) -> float:
        """Estimated mean depth of the unit, positive down [m]; NaN before the first depth reading."""
        zero = self.observer.depth_zero
        if zero is None:
            return math.nan
        payout = float(self._payout_row @ self._mean_state) + self._left_over.point.payout
        return zero + self._depth_bias() + payout * (1.0 + self.observer.stretch_per_payout)

    def set_mode(self, name: str, tension: float = 0.0) -> str:
        """Ask for a mode by name, with the tension to hold [N] in constant_tension (0: the present mean).

        Returns the mode taken in words. Raises ModeError, saying why, where it cannot be taken.
        """
        if name == Mode.CONSTANT_TENSION.value:
            measured = self._tension.measured
            if not math.isfinite(measured):
                raise ModeError("constant tension needs the load cell: no reading has come yet")
            if not math.isfinite(tension) or tension < 0.0:
                raise ModeError(f"a tension of {tension} N cannot be held")
            self.modes.request(name)
            self.mean.stop()
            self._tension.hold(tension if tension > 0.0 else measured)
            return self.modes.mode.value
        if name == Mode.COMPENSATING.value and self._has_landed:
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
        per_payout = 1.0 + self.observer.stretch_per_payout
        self.move_to_payout((depth - self.observer.depth_zero - self._depth_bias()) / per_payout, speed)

    def move_to_payout(self, payout: float, speed: float = 0.0) -> None:
        """Move the mean payout to `payout` [m]. Raises ModeError where the winch's range does not reach."""
        limits = self._governor.limits
        if not limits.payout_minimum <= payout <= limits.payout_maximum:
            raise ModeError(
                f"that needs a payout of {payout:.1f} m; the winch reaches {limits.payout_minimum:g} to "
                f"{limits.payout_maximum:g} m"
            )
        self.mean.move_to(payout, speed)

    def cancel_move(self) -> None:
        """Bring the mean payout to rest smoothly."""
        self.mean.stop()

    def predicted_unit_sigma(self) -> float:
        """Standard deviation of the unit's heave that the design promises without limits [m]."""
        return predict_loop(self.design, self._law.gain if len(self._law.gain) else None).sigma["unit_heave"]

    def redesign(self, parameters: WinchControllerParameters) -> ControllerDesign:
        """Design again from `parameters` and go on with the new design; states must be the same.

        Raises DesignError or ValueError, the old design then stays.
        """
        schedule = design_schedule(parameters, tick_period=self._dt) if is_scheduled(parameters) else None
        before, self._schedule = self._schedule, schedule
        try:
            design = self._design_for(parameters, self.mean.point.payout)
            self.estimator.set_model(design.model, design.measurements, carry_over(self.design, design))
        except ValueError:
            self._schedule = before
            raise
        self.parameters = parameters
        self._take_design(design)
        return design

    def _design_for(self, parameters: WinchControllerParameters, payout: float) -> ControllerDesign:
        """Return the design at the mean payout [m], scheduled over length where there is a schedule."""
        if self._schedule is None:
            return design_controller(parameters, tick_period=self._dt)
        return self._schedule.design_at(parameters.length + payout)

    def _follow_length(self) -> None:
        """Take the scheduled design of the length that is out, when it has changed enough."""
        if self._schedule is None:
            return
        length = max(self.parameters.length + self.mean.point.payout, 1.0)
        if abs(length / self.design.length - 1.0) < FOLLOW:
            return
        design = self._schedule.design_at(length)
        self.estimator.set_model(design.model, design.measurements)
        self._take_design(design)

    def _follow_winch(self) -> None:
        """Design anew where the winch is found to follow its set-points otherwise than believed."""
        if not self._learns_winch or self.modes.mode is not Mode.COMPENSATING:
            return
        period = CHECKING_PERIOD if self._winch.is_full else LEARNING_PERIOD
        if self._tick % max(1, round(period / self._dt)) == 0:
            better = self._winch.better_belief(self.parameters)
            if better is not None:
                self._believe(better)

    @property
    def _learns_winch(self) -> bool:
        return self.parameters.lag.adaptation and self._schedule is None and not self._is_first_order

    def _watch_winch(self, winch: WinchReading | None) -> None:
        """Put the set-points of the last tick and what the encoder made of them on record; notice late commands."""
        given = self._order_given
        if given is not None and winch is not None:
            self._watch_transport(given.sequence, winch.command_sequence)
        if given is None or given.brake:
            self._winch.reset(0.0 if given is None else given.payout)
            return
        if winch is not None and winch.limits_hit & UNLEARNT_LIMITS:
            self._winch.add(given.payout, given.payout_rate, None)
            self._winch.restart()
        else:
            self._winch.add(given.payout, given.payout_rate, self.observer.payout)

    def _watch_transport(self, given: int, taken: int) -> None:
        """Notice late commands; no feedback of the unit is tried with more delay than can be learnt or borne."""
        winch = self.parameters.winch
        words = self._late_commands.update(given, taken, winch.command_delay)
        if words:
            self._alarms.append(words)
            self._winch.restart()
        lag = winch.command_delay + winch.time_constant
        bearable = self.parameters.lag.largest if self._learns_winch else BEARABLE_SHARE * lag
        overdue = self._late_commands.overdue
        if overdue > bearable:
            self.guard.hold_off(f"winch takes commands {overdue:.2f} s later than believed: no loop bears that")

    def _believe(self, parameters: WinchControllerParameters) -> None:
        """Go on with a design of another winch: every state keeps its meaning, the chain of commands its newest."""
        design = design_controller(parameters, tick_period=self._dt, cable=self.design.cable)
        carry = carry_by_name(self.design, design)
        estimate, covariance = carry @ self.estimator.estimate, carry @ self.estimator.covariance @ carry.T
        self.estimator = design.make_estimator()
        self.estimator.reset(estimate, covariance)
        self.estimator.step(self._tick - 1, 0.0, [])
        self._mean_state = carry @ self._mean_state
        self.observer.forget_shares()
        self.parameters = parameters
        self._take_design(design)
        winch = parameters.winch
        self._alarms.append(
            f"winch now believed to have a servo of {winch.time_constant:.3f} s and a delay of "
            f"{winch.command_delay:.3f} s"
        )

    def _follow_sea(self, estimate: Array) -> None:
        """Let the estimator's driving noise follow the sea that is there."""
        if not self.parameters.estimator.sea_adaptation:
            return
        tip, rate = self._tip_rows @ estimate
        noise = self._sea.update(float(tip), float(rate))
        if noise is not None:
            self.estimator.set_process_noise(noise)

    def step(self, tick: int, measurements: Measurements) -> Outputs:
        """Do tick k: take the readings delivered at t_k, return the order for [t_k, t_{k+1}] and what is believed."""
        self._alarms = []
        self._tick = tick
        self._run_programme(tick * self._dt)
        self._follow_winch()
        self._follow_length()
        estimate = self._estimate(tick, measurements)
        self._follow_sea(estimate)
        uncompensated = self._advance_shadow(estimate)
        fault = 0 if measurements.winch is None else measurements.winch.fault
        mode = self._step_mode(estimate, uncompensated, fault)
        self._watch_landing(mode)
        asked, governed = self._command(mode, estimate, uncompensated)
        self._advance_mean()
        order = self._order(mode, governed)
        self._note_kpi(tick, estimate, uncompensated)
        report = self._report(tick, mode, asked, governed, order, estimate)
        kpi = self._kpi.figures() if tick % max(1, round(1.0 / self._dt)) == 0 else None
        return Outputs(order, report, kpi, tuple(self._alarms))

    def _take_design(self, design: ControllerDesign) -> None:
        """Use a design from now on; estimate, mode and mean payout stay."""
        self.design = design
        self._law: Law = make_law(design)
        self.guard.effort = effort_of(design, self._law)
        self._governor = make_governor(design)
        self._open_loop = make_open_loop(design)
        self._settling_loop = make_open_loop(design, settles=True)
        self._tension_law = ConstantTension(
            design.model, design.cable, self.parameters.winch, self.parameters.tension, self._tension_law
        )
        self.observer.stretch_per_payout = design.cable.static_tension / (design.cable.stiffness * design.length)
        self._shift = AuthorityShift(design.model, design.sea_states)
        self._shadow = shadow_model(design.cable, self._dt)
        self._unit_weight = design.unit_weight
        model = design.model
        self._unit_row, self._payout_row = model.row("unit_heave"), model.row("payout")
        self._rate_row = model.row("payout_rate")
        self._winch_rows = np.array([self._payout_row, self._rate_row])
        self._tip_rows = np.array([model.row("boom_tip_heave"), model.row("boom_tip_heave_rate")])
        self._unit_states = [model.state("unit_heave"), model.state("unit_heave_rate")]
        self._sea.refer_to(design)

    @property
    def _tension(self) -> ConstantTension:
        assert self._tension_law is not None
        return self._tension_law

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

    def _estimate(self, tick: int, measurements: Measurements) -> Array:
        """Gate, take the mean payout's share off, estimate; return the estimate."""
        self.observer.remember_share(tick, self._mean_state)
        rate = float(self._rate_row @ (self.estimator.estimate + self._mean_state))
        readings = self.observer.observe(tick, measurements, self.estimator, rate)
        if measurements.load_cell and math.isfinite(self.observer.tension):
            self._tension.observe(self.observer.tension)
        estimate = self.estimator.step(tick, self._compensating_command, readings)
        self._depth_reading = next((r.value for r in reversed(readings) if r.name == "unit_heave"), None)
        depth = self.estimator.innovations.get("unit_heave")
        if depth is not None and math.isfinite(depth.nis):
            self._depth_surprise = depth.value / depth.sigma
        self.observer.learn(self.estimator)
        self._alarms += self.observer.new_faults()
        self._watch_winch(measurements.winch)
        return estimate

    def _advance_shadow(self, estimate: Array) -> Array:
        """Advance what the unit would do with the winch locked; return its heave and rate, shape (2,)."""
        self._shadow_state = self._shadow.A @ self._shadow_state + self._shadow.B @ (self._tip_rows @ estimate)
        return self._shadow_state

    def _step_mode(self, estimate: Array, uncompensated: Array, fault: int) -> ModeOutput:
        is_judged = not self._has_landed and self.modes.mode is not Mode.CONSTANT_TENSION
        authority = self.modes.authority if is_judged else 0.0
        self.guard.update(
            self._seen(estimate, uncompensated, authority),
            authority,
            self.modes.target,
            inertia=self.design.cable.a,
            has_feedback=self.parameters.law != "feedforward",
        )
        if self.modes.brake and self.guard.reason and self.guard.reason != self._harm_before:
            self._alarms.append(self.guard.reason)
        self._harm_before = self.guard.reason
        situation = Situation(
            lost=self.observer.lost(self._vital()),
            has_estimate=bool(self.observer.gates["encoder"].state(0.0).accepted),
            winch_fault=fault,
            harm=self.guard.reason,
            speed=self._commanded_speed(estimate),
            authority_limit=1.0 if self.parameters.law == "mpc" else self.guard.authority_limit,
            is_settled=self._is_settled(estimate, uncompensated),
        )
        mode = self.modes.step(situation)
        if mode.mode is not self._mode_before:
            self._enter(mode.mode, self._mode_before, estimate)
            self._mode_before = mode.mode
        return mode

    def _seen(self, estimate: Array, uncompensated: Array, authority: float) -> Seen:
        """Return what the guard is told of a tick; the mean payout's own motion is no harm."""
        mean = self._winch_rows @ self._mean_state + self._mean_state[self._unit_states]
        residual = mean + estimate[self._unit_states]
        tip, tip_rate = (float(value) for value in self._tip_rows @ estimate)
        # while authority A moves, the unit goes over to (1 - A) of the uncompensated motion: by Eq. 6.2 that asks for
        # payout = A tip + 2 a A' z_off' (b and A'' left out), with a z_off'' = tip - z_off
        change, self._authority_before = authority - self._authority_before, authority
        modes = self.parameters.modes
        largest = self._dt / min(modes.fade_in_time, modes.fade_out_time)
        change = min(max(change, -largest), largest) / self._dt
        meant = authority * tip_rate + change * (3.0 * tip - 2.0 * float(uncompensated[0]))
        return Seen(
            residual=(float(residual[0]), float(residual[1])),
            uncompensated=(float(uncompensated[0]), float(uncompensated[1])),
            tip_rate=tip_rate,
            drum_error=float(self._rate_row @ estimate) - meant,
            depth=None if self._depth_reading is None else self._depth_reading + float(mean[0]),
        )

    def _is_settled(self, estimate: Array, uncompensated: Array) -> bool:
        """Tell whether a lost loop has been brought back: the winch may stop, and the unit will not swing on."""
        if not (self.guard.is_harming and self.guard.trusts_estimate) or self._settling_loop is None:
            return True
        error = estimate[self._unit_states] + self._winch_rows @ estimate - uncompensated
        swing = math.hypot(error[0], math.sqrt(self.design.cable.a) * error[1])
        return bool(swing < self._settling_loop.settled)

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
            self._left_over.jump_to(float(self._payout_row @ estimate))
            self._left_over.move_to(0.0, RETURN_SPEED)
            self._shadow_state = estimate[self._unit_states] + self._winch_rows @ estimate
            self._law.reset()

    def _watch_landing(self, mode: ModeOutput) -> None:
        """Notice touchdown while lowering, and that the unit hangs again after lift-off."""
        measured, static = self._tension.measured, self.design.cable.static_tension
        if not math.isfinite(measured):
            return
        share = (measured - static) / self._unit_weight + 1.0
        parameters = self.parameters.tension
        if not self._has_landed:
            lowering = mode.mode is Mode.COMPENSATING and self.mean.point.rate > RETURN_SPEED
            if lowering and mode.authority > 0.5 and share < parameters.touchdown_ratio and self._stands():
                self._land(static - (1.0 - parameters.landing_ratio) * self._unit_weight)
        elif self._is_lifting and share > parameters.lift_off_ratio:
            self._hang()

    def _stands(self) -> bool:
        """Tell whether the depth sensor sees the unit stand, above where a hanging one would have fallen.

        A unit that swings unloads the cable too, but falls as the model says, and falls in any case. Without a depth
        sensor the tension alone tells.
        """
        if "unit_heave" not in self.estimator.measurements or self.observer.gates["depth"].reason == "stale":
            return True
        return self._depth_surprise > STANDING_SURPRISE and self.observer.standing.stands(self.mean.point.rate)

    def _land(self, tension: float) -> None:
        """Go over to constant tension on the seabed."""
        self._has_landed, self._is_lifting = True, False
        self.observer.uses_unit = False
        self.set_mode(Mode.CONSTANT_TENSION.value, tension)
        self._alarms.append("touchdown")

    def _lift_off(self) -> None:
        """Raise the tension until the unit hangs."""
        self._is_lifting = True
        self._tension.hold(self.design.cable.static_tension + LIFTING_SURPLUS * self._unit_weight)

    def _hang(self) -> None:
        """Compensate again: the unit hangs, where it stands; raise it off the seabed."""
        self._has_landed, self._is_lifting = False, False
        self.observer.uses_unit = True
        self.modes.request(Mode.COMPENSATING.value)
        self._mode_before = Mode.COMPENSATING
        self._hand_over(stood=True)
        self.mean.move_to(self.mean.point.payout - self.parameters.tension.lift_height)
        self._alarms.append("unit hangs")

    def _hand_over(self, *, stood: bool) -> None:
        """Make the present depth of the unit the mean and go on from there; see `handover`."""
        now = (self.design.model, self.estimator.estimate, self.estimator.covariance, self._mean_state)
        if stood:
            cable = self.design.cable
            pull = (self._tension.measured - cable.static_tension) / cable.stiffness
            heave = self.observer.unit_heave_reading(self._mean_state, self._unit_states[0])
            after = hand_over_standing(*now, pull=pull, heave=heave)
        else:
            after = hand_over(*now)
        self.mean.jump_to(self.mean.point.payout + after.lowered)
        self._mean_state = after.mean_state
        self.estimator.reset(after.estimate, after.covariance)
        self.estimator.step(self._tick, 0.0, [])
        self._left_over.jump_to(0.0)
        self._law.reset()

    def _command(self, mode: ModeOutput, estimate: Array, uncompensated: Array) -> tuple[LawCommand, GovernedCommand]:
        """Return what the law asks for and what the governor lets through, the mean payout's share included."""
        total_state = estimate + self._mean_state
        payout, rate = self._governor.predict(total_state)
        reference_command = self._reference_command()
        standing = self._standing_command(total_state, payout)
        mean_payout, mean_rate = self._governor.predict(self._mean_state)
        state = LoopState(
            x=self._law_state(mode, estimate, uncompensated),
            reference=Reference(mean_payout, mean_rate, reference_command),
            static_tension=self.design.cable.static_tension,
        )
        asked = self._ask(mode, state, estimate, standing)
        if mode.brake:
            governed = GovernedCommand(standing, (), standing)
        else:
            tension = self.observer.tension if math.isfinite(self.observer.tension) else state.static_tension
            governed = self._governor.govern(asked.value + reference_command, payout, rate, tension)
        self._total_command = governed.value
        self._speed_asked = governed.value - standing
        self._compensating_command = governed.value - reference_command
        return asked, governed

    def _law_state(self, mode: ModeOutput, estimate: Array, uncompensated: Array) -> Array:
        if mode.mode is Mode.CONSTANT_TENSION:
            return estimate
        x = self._shift.shift(estimate, uncompensated, mode.authority)
        # the unit shall follow the mean payout stiffly, not swing after it as it would by itself
        x[self._unit_states] += self._mean_state[self._unit_states] + self._winch_rows @ self._mean_state
        left = self._left_over.point.payout
        if left != 0.0:
            x[self.design.model.state("payout")] -= left
            x[self.design.model.state("unit_heave")] += left
        return x

    def _ask(self, mode: ModeOutput, state: LoopState, estimate: Array, standing: float) -> LawCommand:
        if mode.mode is Mode.CONSTANT_TENSION:
            return self._tension.command(LoopState(estimate, state.reference, state.static_tension))
        if mode.mode is Mode.STOPPING or (mode.mode is Mode.FADE_OUT and not self.guard.trusts_estimate):
            return self._slow_down(state, standing)
        if mode.mode is Mode.FADE_OUT and self.guard.is_harming and self._settling_loop is not None:
            return self._settling_loop.command(state)
        if mode.mode is Mode.FADE_OUT and self._open_loop is not None:
            # a sensor was lost: what the unit is believed to do is not to be acted upon any more
            return self._open_loop.command(state)
        if mode.mode in (Mode.COMPENSATING, Mode.FADE_OUT):
            if isinstance(self._law, SpeedFeedforward):
                self._law.reading = mode.authority * self.observer.mru_rate
            return self._law.command(state)
        return IDLE

    def _slow_down(self, state: LoopState, standing: float) -> LawCommand:
        """Return the command that brings the winch to rest at a bounded deceleration; `standing` keeps it there."""
        if self._is_first_order:
            return LawCommand(standing - state.reference.command)
        step = self.parameters.modes.stop_deceleration * self._dt
        slower = math.copysign(max(abs(self._speed_asked) - step, 0.0), self._speed_asked)
        return LawCommand(slower + standing - state.reference.command)

    def _standing_command(self, total_state: Array, payout_ahead: float) -> float:
        """Return the command under which the winch stays where it is: its own payout, or what a servo's position loop
        takes off.
        """
        if self._is_first_order:
            return float(self._payout_row @ total_state)
        return self.parameters.winch.position_gain * payout_ahead

    def _commanded_speed(self, estimate: Array) -> float:
        if self._is_first_order:
            return abs(float(self._rate_row @ (estimate + self._mean_state)))
        return abs(self._speed_asked)

    def _reference_command(self) -> float:
        """Return the share of the command that moves the mean payout: its rate, and the servo's lag ahead."""
        point = self.mean.point
        if self._is_first_order:
            return point.payout + point.rate / self.parameters.winch.position_rate
        winch = self.parameters.winch
        return point.rate + winch.time_constant * point.acceleration + winch.position_gain * point.payout

    def _advance_mean(self) -> None:
        """Advance the mean payout and the loop's known answer to it by a tick."""
        share = self._total_command - self._compensating_command
        self._mean_state = self.design.model.A @ self._mean_state + self.design.model.B[:, 0] * share
        if not self.modes.brake:
            self.mean.advance()
            self._left_over.advance()

    def _order(self, mode: ModeOutput, governed: GovernedCommand) -> WinchOrder:
        self._sequence += 1
        payout = self.mean.point.payout + self._left_over.point.payout
        # the model's command counts what the winch's position loop makes of the payout set-point as well
        rate = governed.sent - self.parameters.winch.position_gain * payout
        order = WinchOrder(self._sequence, payout, rate, mode.brake)
        if self._is_first_order:
            order = WinchOrder(self._sequence, governed.sent, 0.0, mode.brake)
        self._order_given = order
        return order

    def _unit_heave(self, estimate: Array) -> float:
        """Return the unit's heave about where the mean payout would have it at rest [m]."""
        return float(self._unit_row @ (estimate + self._mean_state) + self._payout_row @ self._mean_state)

    def _depth_bias(self) -> float:
        """Return how much deeper the mean is than the first reading [m]."""
        model = self.design.model
        return -float(self.estimator.estimate[model.state(DEPTH_BIAS)]) if model.has_state(DEPTH_BIAS) else 0.0

    def _note_kpi(self, tick: int, estimate: Array, uncompensated: Array) -> None:
        del tick
        rate = float(self._rate_row @ (estimate + self._mean_state))
        self._kpi.add(
            unit=self._unit_heave(estimate),
            uncompensated=float(uncompensated[0]),
            tip=float(self._tip_rows[0] @ estimate),
            payout=float(self._payout_row @ estimate),
            rate=rate,
            acceleration=(rate - self._last_rate) / self._dt,
            tension=self.observer.tension,
        )
        self._last_rate = rate

    def figures(self) -> RollingKpi:
        """Return the figures of merit of the last window."""
        return self._kpi.figures()

    def _report(
        self,
        tick: int,
        mode: ModeOutput,
        asked: LawCommand,
        governed: GovernedCommand,
        order: WinchOrder,
        estimate: Array,
    ) -> Report:
        innovations = self.estimator.innovations
        names = tuple(self.estimator.measurements)
        rows = [innovations.get(name) for name in names]
        tip = float(self._tip_rows[0] @ estimate)
        return Report(
            mode=mode.mode.value,
            law=self.parameters.law,
            reason=mode.reason,
            state_names=self.design.model.state_names,
            estimate=tuple(estimate.tolist()),
            covariance_diagonal=tuple(np.diagonal(self.estimator.covariance).tolist()),
            measurement_names=names,
            innovation=tuple(math.nan if row is None else row.value for row in rows),
            innovation_sigma=tuple(math.nan if row is None else row.sigma for row in rows),
            nis=tuple(math.nan if row is None else row.nis for row in rows),
            gain=tuple(self._law.gain.tolist()),
            predicted_unit_heave=self._unit_heave(estimate),
            predicted_boom_tip_heave=tip,
            predicted_uncompensated_heave=float(self._shadow_state[0]),
            payout_set_point=order.payout,
            payout_rate_set_point=order.payout_rate,
            depth_set_point=self.mean.point.payout + self._left_over.point.payout,
            authority=mode.authority,
            active_limits=tuple(dict.fromkeys(governed.active + asked.active)),
            solver_status=asked.status,
            solver_iterations=asked.iterations,
            sensors=self.observer.states(tick),
        )
