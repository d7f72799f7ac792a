"""What happens to a controller beside its ticks: another mode, landing, design, beliefs, encoder."""

from __future__ import annotations

from heave_core.law_table import CONTROLLED, GIVEN, Stage, Stop
from heave_core.watch_table import ReflexNews
from heave_node.interface.codes import REQUESTED

from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.core.design_in_force import PreparedDesign
from winch_controller_node.core.estimation.loop_tick import LoopTick
from winch_controller_node.core.operator_requests import OPERATED, OperatorRequests
from winch_controller_node.core.restarts import Event, restart
from winch_controller_node.core.supervision.landing import LandingEvent
from winch_controller_node.core.supervision.modes import BRAKED, Mode, ModeOutput
from winch_controller_node.design.design import ControllerDesign, assumed_cable
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.requests import DESIGN, Request
from winch_controller_node.node_parameters import WinchControllerParameters

ENCODER_NEWS, STOPS = (
    [row.name for row in kind.rows].index(name) for kind, name in ((CONTROLLED, "encoder_news"), (GIVEN, "stops"))
)
"""Places in what a tick gives and is given."""


class ControllerEvents(OperatorRequests):
    """The jumps of a controller: all of them go on from where loop and winch are, without a step in the motion."""

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
            restart(self, Event.TENSION_HELD)
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
            self._estimation.motion.return_from(loop.payout - mode.authority * loop.tip)
            restart(self, Event.FOLLOWS)

    def _act_on(self, landing: LandingEvent | None, loop: LoopTick) -> None:
        """Hold the tension of a unit that has landed, compensate one that hangs again.

        Without the load cell no tension can be held: the winch goes on compensating, as if the unit hung.
        """
        if landing is None:
            return
        parameters, is_weighed = self.parameters.tension, self._supervisor.landing.is_weighed
        if landing is LandingEvent.TOUCHDOWN:
            self.mean.halt(self.parameters.modes.stop_deceleration)
        if is_weighed and landing is LandingEvent.TOUCHDOWN:
            was = self.mode
            self.modes.touch_down()
            relief = (1.0 - parameters.landing_ratio) * self.design.unit_weight
            self._hold_tension(self.design.wet_tension - relief, was=was)
        elif is_weighed:
            self.modes.lift_off()
            self._hand_over(loop, unit_stood=True)
            self.mean.move_to(self.mean.point.payout - parameters.lift_height)
        name = f"{landing.value}: weighed" if is_weighed else f"{landing.value}: by depth alone"
        self._alarms.append(ALARMS.alarm(name))

    def _hand_over(self, loop: LoopTick, *, unit_stood: bool) -> None:
        """Make the present depth of the unit the mean and go on from there."""
        self._estimation.hand_over(loop, unit_stood=unit_stood)
        restart(self, Event.FOLLOWS)

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
        restart(self, Event.REDESIGNED)
        self._take_law()
        sea = nominal.sea.significant_wave_height, nominal.sea.peak_period
        self._requests.append(Request(DESIGN, (*sea, nominal.length)).words)
        return self.design

    def redesign(self, parameters: WinchControllerParameters) -> ControllerDesign:
        """Design again from other nominal `parameters` and go on with the new design at once.

        Raises DesignError; the old design then stays.
        """
        return self.take_redesign(self.prepare_redesign(parameters), parameters)

    def take(self, beliefs: Beliefs) -> bool:
        """Take `beliefs` of the adviser, active LATENCY after they were asked for; return whether they came in time."""
        return self._beliefs.offer(beliefs, self._next_tick)

    def settle(self) -> None:
        """Do what is due before the next tick, beside the ticks: none of them waits for it then."""
        self._run_programme(self._next_tick * self._dt)
        self._follow_beliefs(self._next_tick)
        self._in_force.law.prepare()

    def _follow_beliefs(self, tick: int) -> None:
        """Activate what is due before a `tick`, and give it to law, guard and gates."""
        before = self.design
        self._alarms += self._beliefs.follow(tick)
        if self.design is not before:
            self._take_law()
        if self._beliefs.has_moved_tip:
            restart(self, Event.TIP_MOVED)
        if self._beliefs.corrected:
            restart(self, Event.CORRECTED)
        for owner in self._beliefs.corrected:
            self._supervisor.guard.allow_correction(owner, (tick - 1) * self._dt)
        if "encoder" in self._beliefs.corrected:
            restart(self, Event.ENCODER_CORRECTED)

    def _follow_encoder(self) -> int:
        """Do what the reflex about the encoder has found before the tick; return the stage at which that goes on."""
        news, tick = int(self._control.done[ENCODER_NEWS]), self._next_tick - 1
        estimation, reflex = self._estimation, self._encoder
        if news & ReflexNews.ENCODER_FOUND:
            estimation.find_drum(tick - 1)
        if news & ReflexNews.COUNT_STEPPED:
            restart(self, Event.COUNT_JUMPED)
        if news & ReflexNews.COUNT_JUDGED and estimation.by_count is not None:
            self._alarms.append(reflex.judge(estimation.by_count))
        if news & (ReflexNews.COUNT_JUDGED | ReflexNews.COUNT_AGREES):
            estimation.drop_by_count()
        if news & (ReflexNews.COUNT_DISPUTED | ReflexNews.ENCODER_REFUTED):
            estimation.compare_count(tick - 1)
        if news & ReflexNews.BELIEFS_REFUTED:
            self._beliefs.contradict("the drum does what a nominal winch was ordered", tick)
            reflex.restart()
        if news & ReflexNews.ENCODER_REFUTED:
            estimation.set_encoder_aside(float(reflex.state["payout"][0]), tick - 1)
            self._supervisor.guard.allow_correction("encoder", (tick - 1) * self._dt)
            self._alarms.append(reflex.alarm)
        estimation.bind()
        if estimation.waits:
            self._control.given[STOPS] = int(self._control.given[STOPS]) | Stop.AFTER_SENSE
        return Stage.SENSE

    def _take_law(self) -> None:
        """Command and supervise with the active design and law; mode and mean payout stay."""
        design, law = self._in_force.design, self._in_force.law
        self._command.take_design(design, law)
        self._supervisor.take_design(design, law)
