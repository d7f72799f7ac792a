"""The winch controller as a component: measurements of a tick in, one winch order out. No ROS, no truth, no clock.

Each tick passes a value down: what is known of the loop (`estimation`), what is to be done (`supervision`), the command
(`loop_command`), the order. The state is split by linearity into the mean payout's own motion (known exactly, it is our
command) and the rest, which is what the estimator and the laws deal with; the two are superposed in the command.
"""

from __future__ import annotations

import math
from functools import partial

from heave_node.interface.codes import WinchLimit
from heave_node.interface.preview import HeavePreview

from winch_controller_node.core.envelope import Asked
from winch_controller_node.core.estimation.loop_tick import LoopTick
from winch_controller_node.core.events import ControllerEvents
from winch_controller_node.core.loop_command import Tick
from winch_controller_node.core.supervision.modes import Mode, ModeOutput, loop_words
from winch_controller_node.core.supervision.proofs import Driven, Proven
from winch_controller_node.core.supervision.supervisor import Decision, WinchSituation
from winch_controller_node.design.prediction import predict_loop
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.observations import Observations
from winch_controller_node.interface.readings import (
    Measurements,
    Outputs,
    Report,
    RollingKpi,
    WinchOrder,
    WinchReading,
)

DYNAMIC_LIMITS = int(~WinchLimit.PAYOUT)
"""Limits of the winch that a sea takes it to."""


class WinchController(ControllerEvents):
    """The controller: measurements in, orders out. Its parts, requests and events are in the modules of its bases."""

    def figures(self) -> RollingKpi:
        """Return the figures of merit of the last window."""
        return self._kpi.figures()

    def predicted_unit_sigma(self) -> float:
        """Standard deviation of the unit's heave that the design promises without limits [m]."""
        gain = self._in_force.law.gain
        return predict_loop(self.design, gain if len(gain) else None).sigma["unit_heave"]

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
            tick, measurements, self._command.shares, unit_stands=not self._supervisor.landing.shows_hanging
        )
        self._alarms += loop.faults
        decision = self._decide(loop, measurements, self._prove(measurements, loop))
        if decision.mode.before is not None or decision.landing is not None:
            # the tick is reported by the reason for which it began
            decision = decision._replace(mode=decision.mode._replace(reason=self.modes.reason))
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
            does = self._does(loop, decision)
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
        does, named = self._does(loop, decision), self._encoder.named
        states = [
            # of drum and encoder one was found at fault: that is what stands
            state._replace(alarm=named) if state.sensor == "encoder" and state.alarm and named else state
            for state in self.observer.states(loop.number)
        ]
        sensors = tuple(state.reported(does) for state in states)
        reason = self.modes.reason if self.mode is decision.mode.mode else decision.mode.reason
        command, law, estimator = self._command.last, self._in_force.law, self.estimator
        innovation, innovation_sigma, nis, _ = loop.said.T.tolist()
        return Report(
            mode=decision.mode.mode.value,
            law=law.name,
            reason=reason,
            state_names=self.design.model.state_names,
            estimate=tuple(loop.estimate.tolist()),
            covariance_diagonal=tuple(estimator.covariance.diagonal().tolist()),
            measurement_names=tuple(estimator.measurements),
            innovation=tuple(innovation),
            innovation_sigma=tuple(innovation_sigma),
            nis=tuple(nis),
            gain=tuple(law.gain.tolist()),
            predicted_unit_heave=loop.unit,
            predicted_boom_tip_heave=loop.tip,
            predicted_uncompensated_heave=loop.free,
            payout_set_point=order.payout,
            payout_rate_set_point=order.payout_rate,
            depth_set_point=self._estimation.depth_set_point,
            authority=decision.mode.authority,
            active_limits=tuple(dict.fromkeys(command.governed.active + command.asked.active)),
            solver_status=command.asked.status,
            solver_iterations=command.asked.iterations,
            sensors=sensors,
            is_inhibited=decision.is_inhibited,
        )

    def _does(self, loop: LoopTick, decision: Decision) -> str:
        """Return what the loop does, in words."""
        blind = decision.is_damped and not loop.knows_tip
        coasts = self.parameters.modes.coast_time if self.modes.coasts else 0.0
        return loop_words(decision.mode.mode, is_damped_blind=blind, coasts=coasts)

    def _act(
        self, loop: LoopTick, decision: Decision, measurements: Measurements, preview: HeavePreview | None
    ) -> WinchOrder:
        """Return the order that leaves, in the encoder's count, within the envelope; all go by what is sent.

        `preview` : to be used; None: none is
        """
        motion, winch, command = self._estimation.motion, measurements.winch, self._command
        blind, time = self.modes.is_damped_blind, loop.number * self._dt
        self.envelope.read(measurements, Asked(self.mode, self.mean.request, is_damped_blind=blind, time=time))
        static_tension = self._static_tension(self.mean.point.payout)
        command.act(
            Tick(
                loop,
                decision,
                static_tension=static_tension,
                is_at_limit=winch is not None and bool(winch.limits_hit & DYNAMIC_LIMITS),
                stated_payout=self._estimation.stated_payout,
                encoder=self.observer.encoder,
            ),
            preview,
        )
        payout, rate, brake, mean_payout, own_payout, own_rate, _, moved, news, _ = command.leave()
        motion.advanced(int(moved))
        self._alarms += self._load.alarms(int(news), loop.tension, static_tension, self.mean.point.rate, self.mode)
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
        shares, stands = self._command.shares, not self._supervisor.landing.shows_hanging
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

    def _prove(self, measurements: Measurements, loop: LoopTick) -> Proven:
        """Return what nominal values and the `measurements` of the tick prove, whose lost sensors `loop` has."""
        modes, reason = self.modes, self.envelope.reason
        waits = modes.mode is Mode.STANDBY and modes.wants_compensation
        latest = (self._next_tick - 1) * self._dt + self.parameters.health.stamp_tolerance
        hangs, taken_over = self._supervisor.landing.hangs, "" if reason is None else reason.name
        driven = Driven(waits, hangs, taken_over, latest, has_mru="mru" not in loop.lost)
        proven = self.proofs.step(measurements, driven, self._estimation.core_tick.delivered)
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
                share=self._beliefs.beliefs.authority if self.parameters.identifies_winch else 1.0,
                drum_error=self._winch.drum_error if self.parameters.identifies_winch else 0.0,
                inhibition=transport.inhibition or self._encoder.inhibition,
                is_reversed=self._encoder.is_unresolved,
                proven=proven,
                cell_jumped=self.envelope.cell_jumped,
            ),
        )
        self._alarms += [transport.alarm] if transport.alarm else []
        self._alarms += [alarm for alarm in decision.alarms if alarm not in self._alarms]
        return decision

    def _watch_preview(self, loop: LoopTick, delivered: HeavePreview | None) -> HeavePreview | None:
        """Return the preview that is to be used; say when one is used no more, or again."""
        boom_tip = None if "mru" in loop.lost else loop.tip
        preview = self.preview.step(loop.number * round(self._dt * 1e9), delivered, boom_tip)
        is_used = preview is not None
        if is_used != self._previews:
            self._alarms.append(
                ALARMS.alarm("PREVIEW_USED")
                if is_used
                else ALARMS.alarm("PREVIEW_REJECTED", fault=self.preview.fault or "none received")
            )
        self._previews = is_used
        return preview

    def _static_tension(self, payout: float) -> float:
        """Return the tension at rest about a mean `payout` [m], found again where that has moved [N]."""
        known = self.design, payout
        if known != self._weighed[0]:
            self._weighed = known, self.design.static_tension_at(self.parameters.length + payout)
        return self._weighed[1]
