"""What happens to a controller beside its ticks: another mode, landing, design, beliefs, encoder."""

from __future__ import annotations

from heave_node.interface.codes import REQUESTED

from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.core.design_in_force import PreparedDesign
from winch_controller_node.core.estimation.loop_tick import LoopTick
from winch_controller_node.core.operator_requests import OPERATED, OperatorRequests
from winch_controller_node.core.restarts import Event, restart
from winch_controller_node.core.supervision.landing import LandingEvent
from winch_controller_node.core.supervision.modes import BRAKED, Mode, ModeOutput
from winch_controller_node.core.supervision.watch.encoder_reflex import Act
from winch_controller_node.design.design import ControllerDesign, assumed_cable
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.requests import DESIGN, Request
from winch_controller_node.node_parameters import WinchControllerParameters

LOST_TIME = 1.0
"""An encoder that is lost for so long is lost indeed [s]; one with play is still for a moment when the drum turns."""


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

    def _follow_beliefs(self, tick: int) -> None:
        """Activate what is due, and give it to law, guard and gates."""
        self._next_tick = tick + 1
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

    def _watch_encoder(self, tick: int) -> None:
        """Set a reversed encoder aside; one that was lost says where the drum is once it is back."""
        observer, lasting = self.observer, round(LOST_TIME / self._dt)
        is_lost = observer.gates["encoder"].is_lost
        before, self._has_lost_encoder = self._has_lost_encoder, self._has_lost_encoder + 1 if is_lost else 0
        if before >= lasting:
            # where the drum is was not known: the depth sensor is not held against the estimate
            restart(self, Event.ENCODER_LOST)
            if not is_lost:
                self._estimation.find_drum(tick - 1)
        if tick * self._dt - observer.encoder.jumped_at < self._command.time_of_another_count:
            restart(self, Event.COUNT_JUMPED)
        excluded = observer.excluded
        is_aside, is_frozen = excluded == "encoder", is_lost and observer.gates["encoder"].reason == "frozen"
        self._separate(tick, is_frozen=is_frozen, is_aside=is_aside)
        moves = self.mode in (Mode.COMPENSATING, Mode.FADE_OUT)
        if not moves or not self.parameters.identifies_winch or (excluded and not is_aside):
            return
        ordered = self._winch.drum.ordered() if self._encoder.is_due(tick) else None
        act = self._encoder.look(tick, ordered, is_aside=is_aside)
        if not act.value:
            return
        if act is Act.USE_AGAIN:
            observer.exclude("")
        elif act is Act.SET_ASIDE and self._winch.drum.does_as_nominal(observer.encoder.scale):
            self._beliefs.contradict("the drum does what a nominal winch was ordered", tick)
            self._encoder.restart()
        elif act is Act.SET_ASIDE and ordered is not None:
            self._estimation.compare_count(tick - 1)
            self._estimation.set_encoder_aside(ordered.payout, tick - 1)
            self._supervisor.guard.allow_correction("encoder", (tick - 1) * self._dt)
            self._alarms.append(self._encoder.alarm)

    def _separate(self, tick: int, *, is_frozen: bool, is_aside: bool) -> None:
        """Name drive or encoder before a `tick`, once a third sensor shows which.

        `is_frozen`, `is_aside` : the count stands, or is set aside
        """
        estimation, reflex = self._estimation, self._encoder
        if not (is_frozen or is_aside):
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
