"""The winch controller as a component: measurements of a tick in, one winch order out. No ROS, no truth, no clock.

Each tick passes a value down: what is known of the loop (`estimation`), what is to be done (`supervision`), the command
(`loop_command`), the order. The state is split by linearity into the mean payout's own motion (known exactly, it is our
command) and the rest, which is what the estimator and the laws deal with; the two are superposed in the command.
"""

from __future__ import annotations

import math
from functools import partial

from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import REQUESTED, WinchLimit
from heave_node.interface.preview import HeavePreview
from heave_node.parameters import describe

from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.core.beliefs_in_force import BeliefsInForce
from winch_controller_node.core.design_in_force import DesignInForce, PreparedDesign
from winch_controller_node.core.envelope import Asked, OrderEnvelope
from winch_controller_node.core.estimation.loop_estimation import LoopEstimation
from winch_controller_node.core.estimation.loop_tick import LoopTick
from winch_controller_node.core.estimation.observation import Observer
from winch_controller_node.core.estimation.preview_watch import PreviewWatch
from winch_controller_node.core.loop_command import Beside, LoopCommand, Tick
from winch_controller_node.core.state_report import Known, state_report
from winch_controller_node.core.supervision.after_stop import AfterStop
from winch_controller_node.core.supervision.landing import LandingEvent
from winch_controller_node.core.supervision.late_commands import LateCommands
from winch_controller_node.core.supervision.mode_machine import ModeMachine
from winch_controller_node.core.supervision.modes import BRAKED, Mode, ModeError, ModeOutput, loop_words
from winch_controller_node.core.supervision.proofs import Driven, Proofs, Proven
from winch_controller_node.core.supervision.rolling_kpi import KpiWindow
from winch_controller_node.core.supervision.supervisor import Decision, Supervisor, WinchSituation
from winch_controller_node.core.supervision.watch.encoder_reflex import Act, EncoderReflex
from winch_controller_node.core.supervision.watch.load_watch import LoadWatch, rope_strength
from winch_controller_node.core.supervision.watch.winch_watch import WinchWatch
from winch_controller_node.design.design import ControllerDesign, assumed_cable
from winch_controller_node.design.prediction import predict_loop
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.observations import Observations
from winch_controller_node.interface.readings import Measurements, Outputs, Report, RollingKpi, WinchOrder, WinchReading
from winch_controller_node.interface.requests import DEPTH, DESIGN, FACTOR, HOLD, MODE, Request, stated
from winch_controller_node.model.estimator import KalmanEstimator
from winch_controller_node.motion.operator_speed import OperatorRange, OperatorSpeed
from winch_controller_node.motion.programme import Programme, ProgrammeStep
from winch_controller_node.motion.trajectory import MeanPayout
from winch_controller_node.node_parameters import WinchControllerParameters

DYNAMIC_LIMITS = int(~WinchLimit.PAYOUT)
"""Limits of the winch that a sea takes it to."""

OPERATED = (Mode.COMPENSATING, Mode.MANUAL)
"""Modes in which an operator may ask for a speed."""

COMING_TO_REST = (Mode.FADE_OUT, Mode.STOPPING)
"""Modes in which no move begins."""

LEAST_MEAN_TIME = 10.0
"""Time over which a tension is averaged at least before it is held as the mean [s]: about a wave."""

LOST_TIME = 1.0
"""An encoder that is lost for so long is lost indeed [s]; one with play is still for a moment when the drum turns."""

LIFTING_SURPLUS = 0.06
"""Tension above the static one that lifts a unit off, in weights of the unit: more than the load cell may err."""


class WinchController:
    """The controller.

    Parameters
    ----------
    parameters : the assumed plant, winch and sea, and how laws and modes act
    tick_period : [s]
    seed : taken like every component's; the controller itself draws no random number

    Raises DesignError where no controller can be designed from the parameters.
    """

    def __init__(
        self,
        parameters: WinchControllerParameters,
        *,
        tick_period: float,
        seed: int = 0,
    ) -> None:
        del seed
        self._dt = tick_period
        self._in_force = DesignInForce(parameters, tick_period=tick_period)
        design, law = self._in_force.design, self._in_force.law
        self._estimation = LoopEstimation(design)
        self._supervisor = Supervisor(design, law)
        self._winch = WinchWatch(design)
        self.envelope = OrderEnvelope(parameters, design.cable, tick_period)
        self._load = LoadWatch(
            parameters.alarms,
            tick_period=tick_period,
            rope=rope_strength(parameters),
            travel=parameters.tension.travel,
        )
        self._programme = Programme(parameters.programme)
        self._operator = OperatorSpeed(parameters.operator, tick_period=tick_period)
        self._kpi = KpiWindow(parameters.kpi_window, tick_period=tick_period)
        self._command = LoopCommand(design, law, Beside(self._estimation.motion, self.envelope, self._kpi, self._load))
        self._sequence, self._weighed = 0, ((design, math.nan), math.nan)
        self._beliefs = BeliefsInForce(self._in_force, self._estimation, self._winch)
        self._encoder = EncoderReflex(tick_period)
        self._after_stop = AfterStop(tick_period)
        self.proofs = Proofs(parameters, design.cable, tick_period)
        self._has_lost_encoder = 0
        self._alarms: list[Alarm] = []
        self._requests: list[str] = []
        self.preview = PreviewWatch(law.preview, tick_period=tick_period)
        self._previews = False
        self._next_tick = 0

    @property
    def parameters(self) -> WinchControllerParameters:
        """Active parameters."""
        return self._in_force.parameters

    @property
    def design(self) -> ControllerDesign:
        """Active design."""
        return self._in_force.design

    @property
    def modes(self) -> ModeMachine:
        """The mode machine."""
        return self._supervisor.modes

    @property
    def mode(self) -> Mode:
        """Mode after the last tick."""
        return self.modes.mode

    @property
    def mean(self) -> MeanPayout:
        """The mean payout, about which the winch compensates."""
        return self._estimation.motion.mean

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

    @property
    def late_commands(self) -> LateCommands:
        """How many commands the winch took later than modelled."""
        return self._winch.late_commands

    def figures(self) -> RollingKpi:
        """Return the figures of merit of the last window."""
        return self._kpi.figures()

    def predicted_unit_sigma(self) -> float:
        """Standard deviation of the unit's heave that the design promises without limits [m]."""
        gain = self._in_force.law.gain
        return predict_loop(self.design, gain if len(gain) else None).sigma["unit_heave"]

    # what an operator requests

    def set_mode(self, name: str, tension: float = 0.0, *, consent: bool = False) -> str:
        """Request a mode by name, with the tension to hold [N] in constant_tension (0: the present mean).

        `consent`: compensation may begin although nothing has proved the MRU.

        Returns the mode taken in words. Raises ModeError, saying why, where it cannot be taken.
        """
        self._supervisor.timeouts.cancel()
        self._supervisor.guard.release()
        self.envelope.acknowledge()
        self.proofs.ask(consent=consent)
        self.observer.trust()
        self._encoder.restart()
        if self.observer.excluded == "encoder":
            self.observer.exclude("")
        if name == Mode.CONSTANT_TENSION.value:
            measured = self._estimation.filtered_tension
            if not math.isfinite(measured):
                raise ModeError("constant tension needs the load cell: no reading received yet")
            if not math.isfinite(tension) or tension < 0.0:
                raise ModeError(f"a tension must be a number of at least 0; got {tension} N")
            was = self.mode
            held = tension if tension > 0.0 else self._present_tension()
            self.modes.request(name)
            self._supervisor.landing.begin_hold()
            self._hold_tension(held, was=was)
            return self.mode.value
        if name == Mode.COMPENSATING.value and self._supervisor.landing.unit_stands:
            self._lift_off()
            return "lifting off: constant tension until the unit is suspended"
        self.modes.request(name)
        return self.mode.value

    def ask_for_mode(self, name: str, tension: float = 0.0, *, consent: bool = False) -> str:
        """Request a mode by `name`, with a `tension` and `consent`, as `set_mode` does, but only where it is taken now.

        What was refused does not begin later by itself.

        Returns the mode taken in words, and what follows it. Raises ModeError, saying why, where it cannot be taken.
        """
        request = Request(MODE, (name, stated(tension)) if tension else (name,))
        try:
            words = self._asked_mode(name, stated(tension), consent=consent)
        except ModeError:
            self._requests.append(f"{request.words}: refused")
            raise
        self._requests.append(request.words)
        return words

    def _asked_mode(self, name: str, tension: float, *, consent: bool) -> str:
        """Take a mode as `ask_for_mode` does."""
        self.proofs.ask(consent=consent)
        obstacle = self.proofs.left_of(self.modes.obstacle)
        if name == Mode.COMPENSATING.value and self.mode not in (Mode.OFF, Mode.COMPENSATING) and obstacle:
            raise ModeError(f"mode {name} cannot begin now: {obstacle}")
        taken = self.set_mode(name, tension)
        if self.mode is Mode.OFF or taken not in [mode.value for mode in Mode] or taken == name:
            return taken
        fault = self.modes.fault
        held = f"; the winch reports {fault}: it must be cleared there, or the mode ends again" if fault else ""
        return f"{taken}, on the way to {name}{held}"

    def set_factor(self, factor: float) -> None:
        """Ask for another share of compensation (`factor`, 0 to 1): authority goes there over the fade-in time.

        Raises ParameterError for a share that is not allowed.
        """
        (info,) = (info for info in describe(WinchControllerParameters) if info.name == "factor")
        info.check(factor, where="winch_controller")
        self.modes.set_factor(stated(factor))
        self._requests.append(Request(FACTOR, (factor,)).words)

    def move_to_depth(self, depth: float, speed: float = 0.0) -> None:
        """Move the unit to the mean depth [m] at no more than `speed` [m/s] (0: the default).

        Raises ModeError where the depth is not known, the winch does not compensate, or its range does not reach.
        """
        if self.observer.depth_zero is None:
            raise ModeError("a move needs the depth sensor: no reading received yet")
        if self.mode is not Mode.COMPENSATING:
            raise ModeError(f"a move needs mode compensating; the mode is {self.mode.value}")
        if not math.isfinite(depth):
            raise ModeError(f"a depth must be a number; got {depth} m")
        reference = self.envelope.distance_to(stated(depth) + self.carried)
        self.move_to_payout(self._estimation.payout_at(stated(depth)), stated(speed), reference)
        self._requests.append(Request(DEPTH, (depth, speed) if speed > 0.0 else (depth,)).words)

    def move_to_payout(self, payout: float, speed: float = 0.0, reference: float = math.nan) -> None:
        """Move the mean payout to `payout` [m] at no more than `speed` [m/s] (0: the default).

        `reference` is how far that is by the depth sensor [m], where a depth was requested.

        Raises ModeError where the winch's range does not reach.
        """
        lowest, highest = self._payout_range()
        if not lowest <= payout <= highest:
            raise ModeError(f"that needs a payout of {payout:.1f} m; the winch reaches {lowest:g} to {highest:g} m")
        self.mean.move_to(payout, speed, reference)

    @property
    def is_operated(self) -> bool:
        """Return whether an operator asks for a speed of the mean payout."""
        return self._operator.is_asked

    def operate(self, speed: float) -> None:
        """Lower at a `speed` [m/s], negative lifts, for `operator.timeout`; ends a move that is under way.

        Raises ModeError where the winch neither compensates nor is in mode manual.
        """
        if self.mode not in OPERATED:
            raise ModeError(f"an operator's speed needs mode compensating or manual; the mode is {self.mode.value}")
        if not math.isfinite(speed):
            raise ModeError(f"a speed must be a number; got {speed} m/s")
        self._operator.ask(stated(speed))

    def release_speed(self) -> None:
        """Let the operator's speed lapse with the next tick."""
        self._operator.release()

    def _follow_operator(self) -> None:
        """Drive the mean payout as the operator asks, and bring it to rest when that has lapsed."""
        if self._operator.is_asked and self.mode in OPERATED:
            self._drive_mean()
        else:
            self._operator.drop()
        self._requests += self._operator.news(self.mean.point.payout)

    def _drive_mean(self) -> None:
        """Drive the mean payout for a tick as the operator asks."""
        bounds = self._operator_range(*self._payout_range(), self.mean.lag)
        limited = self._operator.limit_news(bounds)
        self._alarms += [limited] if limited else []
        self.mean.drive(self._operator.advance(self.mean.point, bounds), bounds.acceleration)

    def _payout_range(self) -> tuple[float, float]:
        """Return the ends of the range that the mean payout may use, less what it is carried along by [m]."""
        lowest, highest = self._command.payout_range()
        return lowest - self.carried, highest - self.carried

    def _operator_range(self, lowest: float, highest: float, lag: float) -> OperatorRange:
        """Return an operator's share of the winch, from a `lowest` to a `highest` payout [m], with a `lag` [s]."""
        limits, shares = self._command.governor.limits, self.parameters.operator
        return OperatorRange(
            speed=shares.speed_share * limits.speed,
            acceleration=shares.acceleration_share * limits.acceleration,
            payout_minimum=lowest,
            payout_maximum=highest,
            lag=lag,
        )

    @property
    def carried(self) -> float:
        """Payout by which the mean one has been carried along so far, beside its moves [m]."""
        return self._estimation.motion.carried.point.payout

    def carry_mean(self, rate: float, kept: float = 0.0) -> tuple[float, OperatorRange]:
        """Carry the mean payout along in the next tick, beside any move: the place moves about which the tip heaves.

        Depth and depth set-point stay what they are: the unit is where it was.

        Parameters
        ----------
        rate : asked for, positive lowers [m/s]
        kept : room that compensation keeps at the ends of the winch's range [m]

        Returns the rate that is taken [m/s], and the operator's share of the winch within which it is.
        """
        carried, (lowest, highest) = self._estimation.motion.carried, self._command.payout_range()
        kept = min(kept, 0.5 * (highest - lowest))
        bounds = self._operator_range(lowest + kept, highest - kept, carried.lag)
        payout = self.mean.point.payout + carried.point.payout
        taken = bounds.nearest(rate, payout) if self.mode in OPERATED else 0.0
        carried.drive(taken, bounds.acceleration)
        return taken, bounds

    def cancel_move(self) -> None:
        """Bring the mean payout to rest smoothly."""
        if self.mean.has_target:
            self._requests.append(Request(HOLD).words)
        self.mean.stop()

    def skip_programme(self, time: float) -> None:
        """Leave out what the programme had due up to `time` [s]: this controller begins later."""
        self._programme.due(time)

    def _run_programme(self, time: float) -> None:
        """Do what the programme has due; what cannot be done now raises an alarm and is dropped."""
        for due in self._programme.due(time):
            self._do(due)

    def _do(self, due: ProgrammeStep) -> None:
        try:
            if due.mode:
                self.set_mode(due.mode)
            elif self.mode in COMING_TO_REST:
                # the mean payout has just been stopped: a sensor is lost, or compensation does harm
                raise ModeError(
                    f"no move to a payout of {due.payout:.1f} m in mode {self.mode.value}: request it again once the "
                    "winch compensates"
                )
            else:
                before = f", in place of that to {self.mean.target:.1f} m" if self.mean.has_target else ""
                self.move_to_payout(due.payout, due.speed)
                if self.mode in BRAKED:
                    self._alarms.append(
                        ALARMS.alarm(
                            "PROGRAMME_WAITS",
                            time=due.time,
                            payout=due.payout,
                            before=before,
                            mode=self.mode.value,
                        )
                    )
        except (ModeError, ValueError) as error:
            self._alarms.append(ALARMS.alarm("PROGRAMME_REJECTED", time=due.time, cause=str(error)))

    def _present_tension(self) -> float:
        """Return the present mean tension [N].

        At constant tension the winch follows the waves, and what is read is free of them. Raises ModeError where the
        mean is not known yet.
        """
        if self.mode is Mode.CONSTANT_TENSION:
            return self._estimation.filtered_tension
        mean = self._estimation.mean_tension
        wait = LEAST_MEAN_TIME - mean.time
        if wait > 0.0:
            raise ModeError(
                f"averaging the tension for {wait:.0f} s more, with unit and mean payout where they are: request it "
                "again then, or state the tension to hold"
            )
        return mean.value

    def _hold_tension(self, tension: float, *, was: Mode) -> None:
        """Go to a tension [N] from the measured one, or from that held if the mode `was` constant tension already."""
        if was is not Mode.CONSTANT_TENSION:
            self._command.begin_tension(self._estimation.filtered_tension)
        self._command.hold_tension(tension)

    def _lift_off(self) -> None:
        """Raise the tension until the unit hangs."""
        was = self.mode
        self.modes.request(Mode.CONSTANT_TENSION.value)
        self._supervisor.landing.begin_lift_off()
        self._hold_tension(self.design.wet_tension + LIFTING_SURPLUS * self.design.unit_weight, was=was)

    # a tick

    def step(self, tick: int, measurements: Measurements) -> Outputs:
        """Do tick k: take the `measurements` of t_k, return the order for [t_k, t_{k+1}] and what is known."""
        self._alarms = []
        if kept := self._winch.kept:
            self._alarms.append(ALARMS.alarm("TICKS_LEFT_OUT", count=kept, time=kept * self._dt))
        self._run_programme(tick * self._dt)
        self._follow_operator()
        self._follow_beliefs(tick)
        self._watch_encoder(tick)
        loop = self._estimation.step(
            tick, measurements, self._command.shares, unit_stands=not self._supervisor.landing.hangs
        )
        self._alarms += loop.sensed.faults
        decision = self._decide(loop, measurements, self._prove(measurements))
        if decision.mode.before is not None or decision.landing is not None:
            self._change_mode(decision.mode, loop)
            self._act_on(decision.landing, loop)
            loop = self._estimation.refreshed(loop)
        hangs = self._supervisor.landing.hangs
        self._alarms += self._after_stop.step(loop, decision.mode, self.design.cable, hangs=hangs)
        observations = self._observe(loop, measurements.winch, decision.mode)
        preview = self._watch_preview(loop, measurements.preview)
        order = self._act(loop, decision, measurements, preview)
        alarms = self._alarms
        if alarms:
            does = loop_words(decision.mode.mode, is_damped_blind=decision.is_damped and not loop.knows_tip)
            alarms = [alarm.reported(does) for alarm in alarms]
        kpi = self._kpi.figures() if tick % max(1, round(1.0 / self._dt)) == 0 else None
        return Outputs(
            order,
            decision.mode.mode.value,
            decision.mode.authority,
            self._estimation.depth_set_point,
            partial(self._report, loop, decision, order),
            kpi,
            tuple(alarms),
            self._take_requests(),
            observations,
        )

    def _report(self, loop: LoopTick, decision: Decision, order: WinchOrder) -> Report:
        """Return the report of the last tick, made before the next one.

        Raises RuntimeError where that has been done.
        """
        if loop.number != self._next_tick - 1:
            raise RuntimeError(f"the report of tick {loop.number} is to be read before the next tick")
        does = loop_words(decision.mode.mode, is_damped_blind=decision.is_damped and not loop.knows_tip)
        sensors = tuple(state.reported(does) for state in self.observer.states(loop.number))
        known = Known(self.design, self._in_force.law, self.estimator, self._estimation.depth_set_point, sensors)
        return state_report(loop, decision, self._command.last, order, known)

    def _act(
        self, loop: LoopTick, decision: Decision, measurements: Measurements, preview: HeavePreview | None
    ) -> WinchOrder:
        """Return the order that leaves, in the encoder's count, within the envelope; all go by what is sent.

        Parameters
        ----------
        loop, decision : of the tick
        measurements : of the tick
        preview : to be used; None: none is
        """
        motion, winch, command = self._estimation.motion, measurements.winch, self._command
        self.envelope.read(
            measurements, Asked(self.mode, self.mean.request, is_damped_blind=self.modes.is_damped_blind)
        )
        static_tension = self._static_tension(self.mean.point.payout)
        command.act(
            Tick(
                loop,
                decision,
                holds_tension=self.mode is Mode.CONSTANT_TENSION,
                static_tension=static_tension,
                is_at_limit=winch is not None and bool(winch.limits_hit & DYNAMIC_LIMITS),
                stated_payout=self._estimation.stated_payout,
                encoder=self.observer.encoder,
            ),
            preview,
        )
        payout, rate, brake, mean_payout, own_payout, own_rate, _, moved, news, _ = command.leave()
        motion.advanced(int(moved))
        self._alarms += self._load.alarms(int(news), loop.tension, static_tension)
        self._alarms += self.envelope.news()
        self._sequence += 1
        self._winch.give(WinchOrder(self._sequence, own_payout, own_rate, bool(brake)))
        order = WinchOrder(self._sequence, payout, rate, bool(brake), mean_payout)
        self.proofs.note(order)
        return order

    def leave_out(self, tick: int) -> tuple[str, ...]:
        """Let tick k pass, predicted: no readings were taken and no order was given, so the winch has kept the last.

        What was measured meanwhile is given to the next `step`, which reports how many ticks were left out. Returns
        what an operator has requested since the tick before, in words.
        """
        shares, stands = self._command.shares, not self._supervisor.landing.hangs
        self._estimation.step(tick, Measurements(), shares, unit_stands=stands)
        self._estimation.advance_mean(shares.mean, is_braked=self.modes.brake)
        self._winch.keep()
        self.envelope.leave_out()
        self._estimation.log.break_record()
        self._next_tick = tick + 1
        return self._take_requests()

    def _take_requests(self) -> tuple[str, ...]:
        requests, self._requests = tuple(self._requests), []
        return requests

    def _observe(self, loop: LoopTick, winch: WinchReading | None, mode: ModeOutput) -> Observations | None:
        """Note the tick for the adviser; return the batch that it completes."""
        log, observer = self._estimation.log, self.observer
        is_compensating = mode.mode is Mode.COMPENSATING
        log.add(loop, observer, self._winch.given, winch, authority=mode.authority, compensates=is_compensating)
        return log.batch(
            self._beliefs.beliefs.number,
            excluded=observer.excluded,
            is_trusted=self._supervisor.guard.trusts_estimate,
            restated=self._beliefs.restated,
        )

    def _prove(self, measurements: Measurements) -> Proven:
        """Return what nominal values and the `measurements` of the tick prove."""
        modes, reason = self.modes, self.envelope.reason
        waits = modes.mode is Mode.STANDBY and modes.wants_compensation
        driven = Driven(waits, self._supervisor.landing.hangs, "" if reason is None else reason.code)
        proven = self.proofs.step(measurements, driven)
        self._alarms += proven.alarms
        return proven

    def _decide(self, loop: LoopTick, measurements: Measurements, proven: Proven) -> Decision:
        """Have winch and loop supervised."""
        transport = self._winch.watch(
            measurements.winch,
            None if math.isnan(loop.encoder_payout) else loop.encoder_payout,
            loop.tension,
            self.parameters,
        )
        decision = self._supervisor.decide(
            loop,
            WinchSituation(
                fault=self._winch.fault,
                fault_cause=self._winch.fault_cause(measurements.lateness),
                speed=math.inf if self.envelope.moves_winch else self._command.speed(loop),
                envelope="" if self.envelope.reason is None else self.envelope.reason.brief,
                mean_payout=self.mean.point.payout,
                mean_acceleration=self.mean.point.acceleration,
                settled_swing=self._command.settled_swing,
                share=min(self._winch.share, self._beliefs.beliefs.authority)
                if self.parameters.identifies_winch
                else 1.0,
                inhibition=transport.inhibition or self._encoder.inhibition,
                is_reversed=self._encoder.is_unresolved,
                proven=proven,
            ),
        )
        self._alarms += [transport.alarm] if transport.alarm else []
        self._alarms += decision.alarms
        return decision

    def _watch_preview(self, loop: LoopTick, delivered: HeavePreview | None) -> HeavePreview | None:
        """Return the preview that is to be used; say when one is used no more, or again."""
        boom_tip = None if "mru" in loop.sensed.lost else loop.motions.tip
        preview = self.preview.step(loop.number * round(self._dt * 1e9), delivered, boom_tip)
        is_used = preview is not None
        if is_used != self._previews:
            self._alarms.append(
                ALARMS.alarm("PREVIEW_USED")
                if is_used
                else ALARMS.alarm("PREVIEW_REJECTED", fault=self.preview.fault or "none came")
            )
        self._previews = is_used
        return preview

    def _static_tension(self, payout: float) -> float:
        """Return the tension at rest about a mean `payout` [m], found again where that has moved [N]."""
        known = self.design, payout
        if known != self._weighed[0]:
            self._weighed = known, self.design.static_tension_at(self.parameters.length + payout)
        return self._weighed[1]

    # changes of mode, without a step in the motion

    def _change_mode(self, mode: ModeOutput, loop: LoopTick) -> None:
        """Let mean payout, estimate and law go on from where they are in another mode."""
        before = mode.before
        if before is None:
            return
        if before is Mode.STOPPED and mode.mode is Mode.STANDBY:
            # what has stopped the winch may have left the unit elsewhere than the estimate has it: found again first
            self._estimation.find_drum(loop.number)
        if Mode.CONSTANT_TENSION in (before, mode.mode):
            # the winch made the tension until now, or does so from now on
            self._estimation.restart_tension()
        if self.mean.has_target and mode.mode not in OPERATED:
            cause = f": {mode.reason}" if mode.reason else ""
            code = "MOVE_ENDED" if mode.reason.endswith(REQUESTED) else "MOVE_LOST"
            ended = ALARMS.alarm(code, target=self.mean.target, payout=self.mean.point.payout, cause=cause)
            self._alarms.append(ended)
        if mode.mode in BRAKED:
            self._estimation.motion.stand()
        elif mode.mode is not Mode.COMPENSATING:
            self.mean.stop()
            self._estimation.motion.carried.stop()
        if mode.mode is Mode.COMPENSATING:
            self._estimation.begin_share()
        starts = mode.mode is Mode.COMPENSATING and before is not Mode.FADE_OUT
        if starts and before is Mode.CONSTANT_TENSION:
            self._hand_over(loop, unit_stood=False)
        elif starts or (mode.mode is Mode.FADE_OUT and before is Mode.CONSTANT_TENSION):
            self._estimation.return_to_mean(loop)
            # what follows the sea is not leftover payout
            self._estimation.motion.return_from(loop.motions.payout - mode.authority * loop.motions.tip)
            self._in_force.law.reset()

    def _act_on(self, landing: LandingEvent | None, loop: LoopTick) -> None:
        """Hold the tension of a unit that has landed, compensate one that hangs again."""
        if landing is None:
            return
        parameters = self.parameters.tension
        if landing is LandingEvent.TOUCHDOWN:
            was = self.mode
            self.modes.touch_down()
            self.mean.halt(self.parameters.modes.stop_deceleration)
            relief = (1.0 - parameters.landing_ratio) * self.design.unit_weight
            self._hold_tension(self.design.wet_tension - relief, was=was)
        else:
            self.modes.lift_off()
            self._hand_over(loop, unit_stood=True)
            self.mean.move_to(self.mean.point.payout - parameters.lift_height)
        self._alarms.append(ALARMS.alarm(landing.value))

    def _hand_over(self, loop: LoopTick, *, unit_stood: bool) -> None:
        """Make the present depth of the unit the mean and go on from there."""
        self._estimation.hand_over(loop, unit_stood=unit_stood)
        self._in_force.law.reset()

    # another design

    def under(self, nominal: WinchControllerParameters) -> WinchControllerParameters:
        """Return the parameters under the active beliefs, were others `nominal`; the sea is as those say."""
        return self._beliefs.under(nominal)

    def prepare_redesign(self, parameters: WinchControllerParameters) -> PreparedDesign:
        """Design again from other nominal `parameters` and change nothing yet: this may be done beside the ticks.

        Beliefs about winch, cable and sensors stay; the sea is as they say. Raises DesignError; states must be
        the same.
        """
        return self._in_force.prepared(self._beliefs.under(parameters), self.mean.point.payout)

    def take_redesign(self, prepared: PreparedDesign, nominal: WinchControllerParameters) -> ControllerDesign:
        """Go on with a design that was `prepared` from other `nominal` parameters; called between two ticks."""
        matrix, added = self._in_force.take(prepared)
        self._beliefs.renew(nominal)
        self.envelope.take_nominal(nominal)
        self.proofs.take_nominal(nominal, assumed_cable(nominal, nominal.length))
        self._estimation.carry(self.design, matrix, added)
        self._estimation.reset_readings()
        self._estimation.reset_sea()
        self._take_law()
        sea = nominal.sea.significant_wave_height, nominal.sea.peak_period
        self._requests.append(Request(DESIGN, (*sea, nominal.length)).words)
        return self.design

    def redesign(self, parameters: WinchControllerParameters) -> ControllerDesign:
        """Design again from other nominal `parameters` and go on with the new design at once.

        Raises DesignError; the old design then stays.
        """
        return self.take_redesign(self.prepare_redesign(parameters), parameters)

    # beliefs

    @property
    def nominal(self) -> WinchControllerParameters:
        """Parameters as an operator has stated them."""
        return self._beliefs.nominal

    @property
    def beliefs(self) -> Beliefs:
        """Active beliefs."""
        return self._beliefs.beliefs

    @property
    def refused_beliefs(self) -> int:
        """Answers of the adviser that came too late, so far."""
        return self._beliefs.refused

    def take(self, beliefs: Beliefs) -> bool:
        """Take `beliefs` of the adviser, active LATENCY after they were asked for; return whether they came in time."""
        return self._beliefs.offer(beliefs, self._next_tick)

    def _follow_beliefs(self, tick: int) -> None:
        """Activate what is due, and give it to law, guard and gates."""
        self._next_tick = tick + 1
        before = self.design
        self._alarms += self._beliefs.follow(tick)
        if self.design is not before:
            self._take_law()
        if self._beliefs.has_moved_tip:
            self._supervisor.reset_sea()
        if self._beliefs.corrected:
            self._command.ease()
        for owner in self._beliefs.corrected:
            self._supervisor.guard.allow_correction(owner)
        if "encoder" in self._beliefs.corrected:
            self._encoder.restart()
            self._winch.drum.restart()

    def _watch_encoder(self, tick: int) -> None:
        """Set a reversed encoder aside; one that was lost says where the drum is once it is back."""
        observer, lasting = self.observer, round(LOST_TIME / self._dt)
        is_lost = observer.gates["encoder"].is_lost
        before, self._has_lost_encoder = self._has_lost_encoder, self._has_lost_encoder + 1 if is_lost else 0
        if before >= lasting:
            # where the drum is was not known: the depth sensor is not held against the estimate
            self._supervisor.guard.reset_mismatch()
            if not is_lost:
                self._estimation.find_drum(tick - 1)
        if tick * self._dt - observer.encoder.jumped_at < self._command.time_of_another_count:
            self._estimation.reset_readings()
            self._winch.drum.restart()
        self._separate(tick, is_frozen=is_lost and observer.gates["encoder"].reason == "frozen")
        moves = self.mode in (Mode.COMPENSATING, Mode.FADE_OUT)
        if not moves or not self.parameters.identifies_winch or observer.excluded not in ("", "encoder"):
            return
        ordered = self._winch.drum.ordered() if self._encoder.is_due(tick) else None
        is_aside = observer.excluded == "encoder"
        act = self._encoder.look(tick, ordered, is_aside=is_aside)
        if act is Act.USE_AGAIN:
            observer.exclude("")
        elif act is Act.SET_ASIDE and self._winch.drum.does_as_nominal(observer.encoder.scale):
            self._beliefs.contradict("the drum does what a nominal winch was ordered", tick)
            self._encoder.restart()
        elif act is Act.SET_ASIDE and ordered is not None:
            self._estimation.compare_count(tick - 1)
            self._estimation.set_encoder_aside(ordered.payout, tick - 1)
            self._supervisor.guard.allow_correction("encoder")
            self._alarms.append(self._encoder.alarm)

    def _separate(self, tick: int, *, is_frozen: bool) -> None:
        """Name drive or encoder before a `tick`, once a third sensor shows which; `is_frozen`: the count."""
        estimation, reflex = self._estimation, self._encoder
        if not (is_frozen or self.observer.excluded == "encoder"):
            estimation.drop_by_count()
            reflex.agrees()
        elif estimation.by_count is not None:
            if named := reflex.separate(estimation.by_count):
                self._alarms.append(named)
                estimation.drop_by_count()
        elif is_frozen and not reflex.is_separated and self.mode not in BRAKED:
            estimation.compare_count(tick - 1)

    def _take_law(self) -> None:
        """Command and supervise with the active design and law; mode and mean payout stay."""
        design, law = self._in_force.design, self._in_force.law
        self._command.take_design(design, law)
        self._supervisor.take_design(design, law)
