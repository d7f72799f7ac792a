"""The winch controller as a component: measurements of a tick in, one winch order out. No ROS, no truth, no clock.

A tick is one call of the core (`heave_core`, tick.cpp), which waits where something has happened: another mode, an
alarm, a plan. What takes longer than a tick may is done between two of them (`settle`). The state is split by linearity
into the mean payout's own motion (known exactly, it is our command) and the rest, which is what the estimator and the
laws deal with; the two are superposed in the command.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property, partial

from heave_core.law_table import CONTROLLED, NOTED, Stage, Stop
from heave_node.interface.alarm import Alarm
from heave_node.interface.preview import HeavePreview

from winch_controller_node.core.events import ControllerEvents
from winch_controller_node.core.supervision.modes import Mode, loop_words
from winch_controller_node.design.prediction import predict_loop
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.observations import Observations
from winch_controller_node.interface.readings import (
    Measurements,
    Outputs,
    Report,
    RollingKpi,
    WinchOrder,
)

AFTER_SENSE, BEFORE_ACT, BEFORE_ANSWER = (int(stop) for stop in Stop)
"""Where a tick waits in any case."""

NEWS, OBSERVED, PROOF_NEWS, ASKS, LOGGED = (
    [row.name for row in CONTROLLED.rows].index(name) for name in ("news", "observed", "proof_news", "asks", "noted")
)
ACTED = LOGGED + len(NOTED.rows)
"""Places in what a tick gives."""


class WinchController(ControllerEvents):
    """The controller: measurements in, orders out. Its parts, requests and events are in the modules of its bases."""

    @cached_property
    def _goes_on(self) -> Mapping[int, Callable[[], int]]:
        """What is done where the core's tick waits, by stage; each returns the stage at which it goes on."""
        return {
            Stage.SENSE: self._follow_encoder,
            Stage.DECIDE: self._note_sensed,
            Stage.POSE: self._decide,
            Stage.ANSWER: self._see,
            Stage.MAKE: self._ask,
        }

    def figures(self) -> RollingKpi:
        """Return the figures of merit of the last window."""
        return self._kpi.figures()

    def predicted_unit_sigma(self) -> float:
        """Standard deviation of the unit's heave that the design promises without limits [m]."""
        gain = self._in_force.law.gain
        return predict_loop(self.design, gain if len(gain) else None).sigma["unit_heave"]

    def step(self, tick: int, measurements: Measurements) -> Outputs:
        """Do tick k: take the `measurements` of t_k, return the order for [t_k, t_{k+1}] and what is known."""
        if kept := self._winch.take_kept():
            self._alarms.append(ALARMS.alarm("TICKS_LEFT_OUT", count=kept, time=kept * self._dt))
        self._run_programme(tick * self._dt)
        self._follow_operator()
        self._next_tick = tick + 1
        self._follow_beliefs(tick)
        self.envelope.see(measurements, self.mean.request)
        stage, goes_on = self._begin(tick, measurements), self._goes_on
        while stage:
            stage = self._control.go_on(goes_on[stage]())
        done = self._control.done.tolist()
        payout, rate, brake, mean_payout, own_payout, own_rate, _, depth_set_point, moved, load_news, _ = done[ACTED:]
        sequence, authority, news, observed, *_ = done
        self._given = WinchOrder(int(sequence), own_payout, own_rate, bool(brake))
        mode = self._end(int(observed), int(news), int(moved), int(load_news))
        self._estimation.log.add(tick, done[LOGGED:ACTED], self._estimation.observed)
        alarms, self._alarms = self._alarms, []
        if alarms:
            does = self._does(mode)
            alarms = [alarm.reported(does) for alarm in alarms]
        order = WinchOrder(self._given.sequence, payout, rate, self._given.brake, mean_payout)
        return Outputs(
            order,
            mode.value,
            authority,
            depth_set_point,
            partial(self._report, tick, mode, order),
            self.figures if tick % self._second == 0 else None,
            tuple(alarms),
            self._take_requests(),
            self._batch(),
        )

    def _begin(self, tick: int, measurements: Measurements, stage: int = Stage.BEGIN, stops: int = 0) -> int:
        """Begin the core's tick at a `stage` with its `measurements`, and bits of `stops`; return where it waits."""
        estimation, command = self._estimation, self._command
        self._measurements, self._situated, self._decided, self._preview = measurements, None, None, None
        readings = estimation.deliver(tick, measurements, command.shares)
        command.begin()
        self._tell()
        stops |= AFTER_SENSE if estimation.waits else 0
        stops |= BEFORE_ACT if self.preview.is_wanted(measurements.preview) else 0
        stops |= BEFORE_ANSWER if command.is_asked else 0
        given = tick, readings, stops, self.envelope.cause
        return self._control.begin(stage, measurements.winch, *given)

    def _note_sensed(self) -> int:
        """Note what has been sensed; return the stage at which the tick goes on."""
        done = self._control.done
        self._estimation.note(int(done[OBSERVED]), int(done[NEWS]))
        self._encoder.take_evidence(self._estimation.by_count)
        return Stage.DECIDE

    def _decide(self) -> int:
        """Do what follows from what has happened, in words and in the loop; return where the tick goes on."""
        done, winch = self._control.done, self._measurements.winch
        self._tell_sensed(int(done[OBSERVED]), int(done[NEWS]))
        self._alarms += self.proofs.alarms(int(done[PROOF_NEWS]), winch)
        transport = self._winch.transport()
        self._alarms += [transport.alarm] if transport.alarm else []
        decision = self._supervisor.decided()
        self._alarms += [alarm for alarm in decision.alarms if alarm not in self._alarms]
        if decision.mode.before is not None or decision.landing is not None:
            # the tick is reported by the reason for which it began
            decision = decision._replace(mode=decision.mode._replace(reason=self.modes.reason))
            loop = self._estimation.tick
            self._change_mode(decision.mode, loop)
            self._act_on(decision.landing, loop)
            self._estimation.refresh()
            self.envelope.see(self._measurements, self.mean.request)
            self._tell()
        self._decided = decision
        self._alarms += self._swing_left(decision.mode.mode, decision.mode.before)
        self._preview = self._watch_preview()
        return Stage.POSE

    def _tell_sensed(self, observed: int, news: int) -> None:
        """Note what has been sensed, readings that were `observed`, with what is new of the sensors."""
        self._estimation.note(observed, news)
        self._alarms += self.observer.alarms(news) if news else ()

    def _see(self) -> int:
        """Have the law see what is ahead; return the stage at which the tick goes on."""
        return self._command.see(self._preview, self._supervisor.authority)

    def _ask(self) -> int:
        """Find what the core asks for; return the stage at which the tick goes on."""
        return self._command.ask(int(self._control.done[ASKS]))

    def _end(self, observed: int, news: int, moved: int, load_news: int) -> Mode:
        """Take in what has been found in the tick; return its mode.

        Parameters
        ----------
        observed : readings
        news : of the sensors
        moved : which payouts have
        load_news : of load and winch
        """
        if self._decided is None:
            self._tell_sensed(observed, news)
            self._supervisor.go_on()
            mode = self.mode
            self._alarms += self._swing_left(mode)
        else:
            mode = self._decided.mode.mode
        self._estimation.motion.advanced(moved)
        if load_news:
            tension, at_rest = self._estimation.tick.tension, float(self._control.active["static_tension"][0])
            self._alarms += self._load.alarms(load_news, tension, at_rest, self.mean.point.rate, self.mode)
        self._alarms += self.envelope.news()
        return mode

    def _swing_left(self, mode: Mode, before: Mode | None = None) -> tuple[Alarm, ...]:
        """Return that a stop has left a swing, in a `mode`, and the one `before` where that has changed."""
        if not self._after_stop.is_due(mode, before):
            return ()
        return self._after_stop.alarms(self._estimation.tick, self.design.cable, hangs=self._supervisor.landing.hangs)

    def _report(self, number: int, mode: Mode, order: WinchOrder) -> Report:
        """Return the report of the last tick, made once and before the next one.

        Raises RuntimeError where that has been done.
        """
        if self._reported is not None and self._reported[0] == number:
            return self._reported[1]
        if number != self._next_tick - 1:
            raise RuntimeError(f"the report of tick {number} is to be read before the next tick")
        loop, decision = self._estimation.tick, self._decided or self._supervisor.decided_in(mode)
        does, named = self._does(mode), self._encoder.named
        states = [
            # of drum and encoder one was found at fault: that is what stands
            state._replace(alarm=named) if state.sensor == "encoder" and state.alarm and named else state
            for state in self.observer.states(number)
        ]
        sensors = tuple(state.reported(does) for state in states)
        reason = self.modes.reason if self.mode is decision.mode.mode else decision.mode.reason
        command, law, estimator = self._command.last, self._in_force.law, self.estimator
        innovation, innovation_sigma, nis, _ = loop.said.T.tolist()
        report = Report(
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
        self._reported = number, report
        return report

    def _does(self, mode: Mode) -> str:
        """Return what the loop does in a `mode`, in words."""
        decision = self._decided or self._supervisor.decided_in(mode)
        blind = decision.is_damped and not self._estimation.tick.knows_tip
        coasts = self.parameters.modes.coast_time if self.modes.coasts else 0.0
        return loop_words(mode, is_damped_blind=blind, coasts=coasts)

    def leave_out(self, tick: int) -> tuple[str, ...]:
        """Let tick k pass, predicted: no readings were taken and no order was given, so the winch has kept the last.

        What was measured meanwhile is given to the next `step`, which reports how many ticks were left out. Returns
        what an operator has requested since the tick before, in words.
        """
        self._begin(tick, Measurements(), Stage.SENSE, AFTER_SENSE)
        self._note_sensed()
        self._estimation.advance_mean(self._command.shares.mean, is_braked=self.modes.brake)
        self._winch.keep(self._given)
        self.envelope.leave_out()
        self._estimation.log.break_record()
        self._next_tick = tick + 1
        return self._take_requests()

    def _take_requests(self) -> tuple[str, ...]:
        requests, self._requests = tuple(self._requests), []
        return requests

    def _batch(self) -> Callable[[], Observations] | None:
        """Return what makes the batch for the adviser that the tick completes; None: it completes none."""
        log = self._estimation.log
        if not log.is_complete:
            return None
        return log.batch(
            self._beliefs.beliefs.number,
            excluded=self.observer.excluded,
            is_trusted=self._supervisor.guard.trusts_estimate,
            restated=self._beliefs.restated,
        )

    def _watch_preview(self) -> HeavePreview | None:
        """Return the preview that is to be used; say when one is used no more, or again."""
        loop, delivered = self._estimation.tick, self._measurements.preview
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
