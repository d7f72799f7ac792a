"""What is known of the loop: gates, estimator, sea, the mean payout's own motion, and the uncompensated unit, by ticks.

The estimator sees the loop without the mean payout's own motion, see `mean_motion`.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import Any

from heave_core.look import Look, padded
from heave_node.numerics.arrays import Array

from winch_controller_node.beliefs.beliefs import LATENCY, Adopted, EncoderScale
from winch_controller_node.core.estimation.consistency import ENCODER_ROW, Consistency
from winch_controller_node.core.estimation.handover import followed, hand_over, hand_over_seen, hand_over_standing
from winch_controller_node.core.estimation.loop_tick import CommandShares, LoopTick, Sensed
from winch_controller_node.core.estimation.observation import Observed, Observer
from winch_controller_node.core.estimation.observation_log import ObservationLog
from winch_controller_node.core.estimation.second_filter import SecondFilter
from winch_controller_node.core.estimation.tension import MEMORY, MeanTension, TensionFilter
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.seas import FIRST_WAVES, SeaTracker
from winch_controller_node.interface.readings import Measurements, WinchReading
from winch_controller_node.interface.sensors import DEPTH_BIAS
from winch_controller_node.model.estimator import Measurement, RecordedTick, begin_anew
from winch_controller_node.model.loop_rows import loop_rows
from winch_controller_node.model.simulated_unit import hanging_cable
from winch_controller_node.motion.mean_motion import MeanMotion

NOISE_SWING = 4.0
"""Motion of the boom tip that may be noise, for a unit that swings freely, over the error of its estimate."""

BACK_TIME = 1.0
"""Time for which a sensor that was lost must deliver again [s]: before the boom tip counts as measured, and before a
fade-out ends that its loss has caused."""

TAUT_TIME = 20.0
"""Time in which a unit that had a taut cable goes over to one that had not [s]: near the resonance of the cable it
would swing by far more than any unit does, and what the law refers to with it."""

NEAR = 0.1
"""A drum that stands so near to a payout of 0 at first [m] returns to it, as it does after a stop."""


def look_design(design: ControllerDesign) -> dict[str, Any]:
    """Return the values of the core's LookDesign, of a `design`.

    Raises ValueError for a model with more states than fit.
    """
    rows, dt = loop_rows(design.model), design.tick_period
    unit, unit_rate = rows.unit_states
    return {
        "order": design.model.order,
        "unit": unit,
        "unit_rate": unit_rate,
        "tip": padded(rows.tip[0]),
        "tip_rate": padded(rows.tip[1]),
        "payout": padded(rows.payout),
        "payout_rate": padded(rows.payout_rate),
        "through": rows.payout_rate_through,
        "tick_period": dt,
        "tip_memory": MEMORY,
        "noise_swing": NOISE_SWING,
        "taut_time": TAUT_TIME,
        "cable": hanging_cable(design.cable, dt),
        "taut_cable": hanging_cable(replace(design.cable, unit_weight=math.inf), dt),
    }


class TipWatch:
    """Whether the boom tip is known: its sensor is there, or has been lost for no longer than it is predicted.

    Parameters
    ----------
    tick_period : [s]

    Attributes
    ----------
    knows_tip : the boom tip is measured by a sensor that is not excluded, or can be predicted still
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._lost, self._back = 0.0, BACK_TIME
        self.knows_tip = True

    def update(self, coast_time: float, *, is_lost: bool, is_excluded: bool) -> None:
        """Take in a tick.

        Parameters
        ----------
        coast_time : for which it is predicted [s]
        is_lost : the sensor gives nothing to read
        is_excluded : it is excluded: its readings contradict all others, and from then on nothing is predicted
        """
        if is_excluded or is_lost:
            self._lost, self._back = math.inf if is_excluded else self._lost + self._dt, 0.0
        else:
            self._back += self._dt
            self._lost = 0.0 if self._back > BACK_TIME else self._lost
        self.knows_tip = self._lost <= coast_time


class LoopEstimation:
    """Estimate of the loop, and of what the unit would do with the winch locked.

    Parameters
    ----------
    design : model, measurements and noise

    Attributes
    ----------
    estimator, observer : the filter and the gates in front of it
    motion : mean payout and what it brings about
    log : of what is observed, for the adviser
    consistency : consistency of the readings with their predictions
    mean_tension : over the waves
    second : filter that explains the readings by nominal values alone; None: the active one does
    by_count : filter that takes the drum to be where it is counted, while the active one goes by what it was
        commanded; None: the two agree
    """

    def __init__(self, design: ControllerDesign) -> None:
        parameters, dt = design.parameters, design.tick_period
        self.motion = MeanMotion(parameters.move, design.model.order, tick_period=dt)
        self.estimator = design.make_estimator()
        self.observer = Observer(design, parameters.health)
        self._look = Look(look_design(design))
        self._tension = TensionFilter(parameters.tension.time_constant, tick_period=dt)
        self.mean_tension = MeanTension(tick_period=dt)
        self._has_begun, self._first_payout = False, math.nan
        self._sea = SeaTracker(design)
        self._tip_watch = TipWatch(dt)
        self.log, self.consistency = ObservationLog(dt), Consistency(dt)
        self.second: SecondFilter | None = None
        self.by_count: SecondFilter | None = None
        self._recent: deque[tuple[int, float, tuple[Observed, ...]]] = deque(maxlen=2 * round(LATENCY / dt))
        self._refer_to(design)

    def _refer_to(self, design: ControllerDesign) -> None:
        """Refer to a design from now on, whose model the estimator has already."""
        self._design = design
        self.observer.terms.take_design(design)
        self._rows = loop_rows(design.model)
        self._look.take_design(look_design(design))
        self._sea.refer_to(design)

    # another design

    def take_limits(self, design: ControllerDesign) -> None:
        """Go by the limits and gain of the winch of a `design` whose model is the present one."""
        self._design = design

    def carry(self, design: ControllerDesign, matrix: Array, added: Array | float = 0.0) -> None:
        """Go on with a design whose states are `matrix`, shape (n_new, n), times the present ones.

        `added`, shape (n_new, n_new), is the covariance that this adds.
        """
        estimate = matrix @ self.estimator.estimate
        covariance = matrix @ self.estimator.covariance @ matrix.T + added
        streams, tick = self.estimator.streams, self.estimator.tick
        self.estimator = design.make_estimator()
        self.estimator.reset(estimate, covariance, streams)
        if tick is not None:
            self.estimator.step(tick, 0.0, [])
        self.motion.carry(matrix)
        self.observer.terms.reset_shares()
        self._refer_to(design)

    def adopt(self, design: ControllerDesign, matrix: Array | None, adopted: Adopted, tick: int) -> None:
        """Go on after `tick` with the adviser's estimate of some time ago, followed up to now.

        Parameters
        ----------
        design : to go on with
        matrix : its states are this, shape (n_new, n), times the present ones; None: they are the same
        adopted : the adviser's
        tick : the last one
        """
        streams = self.estimator.streams
        self.estimator = design.make_estimator()
        self.estimator.continue_at(adopted.tick, adopted.estimate, adopted.covariance, streams)
        self.estimator.follow(
            [
                RecordedTick(
                    number,
                    command,
                    [self.observer.as_assumed(one) for one in observed if self.observer.is_taken(one.reading)],
                )
                for number, command, observed in self._recent
                if adopted.tick < number <= tick
            ]
        )
        if matrix is not None:
            self.motion.carry(matrix)
            self.observer.terms.reset_shares()
        self.consistency.restart()
        self._refer_to(design)
        # the boom tip was another one, and so is what it does to a unit that no winch moves
        self._look.take_unit(*self._unit)

    def begin_second(self, nominal: ControllerDesign, tick: int) -> None:
        """Run the filter of the `nominal` design beside from after `tick` on: the active one goes by beliefs."""
        self.second = SecondFilter(nominal, self._design, self.estimator, tick)

    def compare_count(self, tick: int) -> None:
        """Have a filter go by the count from after `tick` on, beside the active one, which goes by the commands."""
        self.by_count = SecondFilter(self._design, self._design, self.estimator, tick, settling=0.0)

    def drop_second(self) -> None:
        """Go by the active filter alone: the second one is not needed any more."""
        self.second = None

    def drop_by_count(self) -> None:
        """End the filter that takes the drum to be where it is counted."""
        self.by_count = None

    def _step_by_count(self, number: int, command: CommandShares, readings: list[Measurement]) -> None:
        """Have the filter that goes by the count take in a tick; all but the count says who is right."""
        if self.by_count is None:
            return
        count = self.observer.count
        if count is not None:
            others = [one for one in readings if one.name != count.name]
            readings = [
                *others,
                self.observer.terms.corrected(count, self.observer.terms.share_of(count, self.estimator)),
            ]
        self.by_count.step(number, command.compensating, readings, self.estimator.innovations, unjudged=(ENCODER_ROW,))

    def _step_second(self, number: int, command: CommandShares, *, excluded: str) -> None:
        """Have the second filter take in a tick: readings as read, the command as a nominal winch takes it."""
        if self.second is None:
            return
        readings = [
            one.reading._replace(value=one.value - one.share)
            for one in self.observer.observed
            if one.is_used or excluded not in ("", "encoder")
        ]
        assumed, nominal = self._design.parameters.winch, self.second.design.parameters.winch
        total = self.motion.state + self.estimator.estimate
        stands = assumed.position_gain * float(self._rows.payout @ total)
        speed = nominal.speed_of(assumed.set_point_of(command.total - stands))
        self.second.step(number, speed + stands - command.mean, readings, self.estimator.innovations)

    def set_encoder_aside(self, payout: float, tick: int) -> None:
        """Go on after `tick` without the encoder, the drum being at a `payout` [m]."""
        self.observer.exclude("encoder")
        moved = payout - float(self._rows.payout @ self.motion.state)
        self._go_on(tick, payout=moved)

    @property
    def _unit(self) -> Array:
        """Estimated heave [m] and rate [m/s] of the unit, shape (2,)."""
        return self.estimator.estimate[self._rows.unit_states]

    def find_drum(self, tick: int) -> None:
        """Go on after `tick` with an encoder that has been lost: the drum may be elsewhere than it was taken to be.

        The depth sensor's mean was compared with that; how far it is off is not known any more.
        """
        model, estimator = self._design.model, self.estimator
        if model.has_state(DEPTH_BIAS):
            bias, covariance = model.state(DEPTH_BIAS), estimator.covariance.copy()
            begin_anew(covariance, bias, self._design.parameters.sensors.depth.bias_sigma)
            estimator.continue_at(tick, estimator.estimate, covariance)
        self.reset_readings()

    def rescale_encoder(self, encoder: EncoderScale, tick: int, *, is_adopted: bool) -> None:
        """Go on after `tick` with an `encoder` of another scale; no other state `is_adopted`: the drum is elsewhere."""
        gate = self.observer.encoder
        payout = encoder.payout + (gate.as_read - encoder.reading) / encoder.scale
        gate.rescale(encoder.scale / gate.scale, payout)
        if not is_adopted:
            self._go_on(tick, payout=payout - float(self._rows.payout @ self.motion.state))

    def _go_on(self, tick: int, *, payout: float) -> None:
        """Go on after `tick` with the drum at a `payout` [m], without what the mean payout does of it."""
        unit = self._unit
        now = (self._design.model, self.estimator.estimate, self.estimator.covariance)
        self.estimator.continue_at(tick, *hand_over_seen(*now, payout=payout, unit=unit))
        self._look.continue_hanging(*unit)

    def reset_sea(self) -> None:
        """Look at the sea again: the boom tip was not where it was taken to be."""
        self._sea = SeaTracker(self._design)
        self._look.forget_waves()

    def begin_share(self) -> None:
        """Let the uncompensated unit of a cable that stays taut go on from where it is: the cable is, from now on."""
        self._look.begin_share()

    def reset_readings(self) -> None:
        """Discard the readings of the past: they hold nothing about the state from now on."""
        self.log.break_record()
        self._recent.clear()
        self.consistency.restart()

    # a tick

    def step(self, number: int, measurements: Measurements, command: CommandShares, *, unit_stands: bool) -> LoopTick:
        """Gate, take the mean payout's share off, estimate.

        Parameters
        ----------
        number : of the tick
        measurements : delivered at it
        command : of the last tick
        unit_stands : the unit stands on the seabed: what rides on it says nothing of a hanging one
        """
        if not self._begin(measurements.winch):
            measurements = replace(measurements, winch=None)
        mean_state, estimator = self.motion.state, self.estimator
        self.observer.terms.remember_share(number, mean_state)
        rows = self._rows
        rate = float(rows.payout_rate @ (estimator.estimate + mean_state)) + rows.payout_rate_through * command.total
        readings = self.observer.observe(number, measurements, estimator, rate, unit_stands=unit_stands)
        estimate = estimator.step(number, command.compensating, readings)
        self._recent.append((number, command.compensating, tuple(self.observer.observed)))
        self._step_second(number, command, excluded=self.observer.excluded)
        self._step_by_count(number, command, readings)
        self.consistency.add(estimator.innovations)
        self.observer.learn(estimator, self.consistency)
        self._note_tension(is_new=bool(measurements.of("load_cell")), unit_stands=unit_stands)
        before, shows_sea = self.knows_tip, self._shows_sea
        self._watch_tip()
        motions = self._look.step(
            estimate,
            estimator.covariance,
            mean_state,
            command=command,
            knows_tip=self.knows_tip,
            # what the winch would have left of a boom tip that was not known is not known: it goes on from now
            takes_unit=self.knows_tip and not before,
        )
        if shows_sea:
            self._follow_sea(motions.tip, motions.tip_rate)
        return LoopTick(
            number=number,
            sensed=self._sensed(readings),
            rows=rows,
            command=command,
            estimate=estimate,
            mean_state=mean_state,
            mean_command=self.motion.reference_command(self._design.parameters.winch),
            left_over=self.motion.left_over.point.payout,
            motions=motions,
            knows_sea=self.knows_sea,
            is_sea_refuted=self._sea.is_refuted,
            inconsistency=self.consistency.words,
            knows_tip=self.knows_tip,
            mean_tension=self.mean_tension.mean,
            missing_push=self.estimator.missing_push,
        )

    def _begin(self, winch: WinchReading | None) -> bool:
        """Take the payout at which the drum stands when the encoder is first read for the mean one.

        Drum and unit may hang anywhere: cable has been paid out by hand, or a controller is restarted. A payout
        that is not near 0 must be read twice. Returns whether what the `winch` reports may be used.
        """
        if self._has_begun or winch is None or not math.isfinite(winch.encoder_payout):
            return True
        before, payout = self._first_payout, winch.encoder_payout
        self._first_payout = payout
        is_near = abs(payout) <= NEAR
        self._has_begun = is_near or abs(payout - before) <= NEAR
        if self._has_begun and not is_near:
            self.motion.begin_at(payout, self._design.model, self._design.parameters.winch)
            self.observer.terms.begin_at(payout)
        return self._has_begun

    def _note_tension(self, *, is_new: bool, unit_stands: bool) -> None:
        """Average the tension, of which a reading `is_new` in this tick; the unit may stand on the seabed."""
        tension, gate = self.observer.tension, self.observer.gates.get("load_cell")
        if not math.isfinite(tension):
            return
        if is_new:
            self._tension.add(tension)
        if gate is None or not gate.is_lost:
            self.mean_tension.add(tension, self.motion.set_point, unit_stands=unit_stands)

    def _sensed(self, readings: list[Measurement]) -> Sensed:
        observer = self.observer
        depth = self.estimator.innovations.get("unit_heave")
        is_compared = depth is not None and math.isfinite(depth.nis)
        has_depth = "unit_heave" in self.estimator.measurements and not observer.gates["depth"].is_lost
        return Sensed(
            payout=observer.payout,
            mru_rate=observer.mru_rate,
            tension=observer.tension,
            filtered_tension=self._tension.value,
            depths=tuple(observer.depths),
            depth_heave=next((r.value for r in reversed(readings) if r.name == "unit_heave"), None),
            depth_noise=observer.depth_noise,
            depth_innovation=depth.value / depth.sigma if depth is not None and is_compared else None,
            has_depth=has_depth,
            sees_landing=has_depth and observer.excluded != "depth",
            innovations=self.estimator.innovations,
            has_encoder=observer.gates["encoder"].state(0.0).accepted > 0,
            lost=observer.lost(),
            faults=(*observer.new_faults(), *self.consistency.news()),
        )

    @property
    def knows_tip(self) -> bool:
        """Return whether the boom tip is measured by a sensor that is not excluded, or was a moment ago."""
        return self._tip_watch.knows_tip

    def _watch_tip(self) -> None:
        gate, coast_time = self.observer.gates.get("mru"), self._design.parameters.modes.coast_time
        is_excluded = self.observer.excluded == "mru"
        self._tip_watch.update(coast_time, is_lost=gate is not None and gate.is_lost, is_excluded=is_excluded)

    def _follow_sea(self, tip: float, tip_rate: float) -> None:
        """Let the estimator's driving noise follow the sea that moves the boom tip, heave [m] and rate [m/s]."""
        innovation = self.estimator.innovations.get("mru_heave_rate")
        if innovation is not None and math.isfinite(innovation.nis):
            self._sea.note_innovation(innovation.nis, innovation.sigma)
        noise = self._sea.update(tip, tip_rate)
        if noise is not None:
            self.estimator.set_process_noise(noise)

    @property
    def _shows_sea(self) -> bool:
        """Return whether the sea is followed: its sensor, of the boom tip's motion, delivers and is not excluded."""
        is_seen = self.knows_tip and self.observer.excluded != "mru"
        return self._design.parameters.estimator.sea_adaptation and is_seen

    @property
    def knows_sea(self) -> bool:
        """Tell whether some waves have been seen, where the sea is followed."""
        return not self._design.parameters.estimator.sea_adaptation or self._sea.waves >= FIRST_WAVES

    def advance_mean(self, command: float, *, is_braked: bool) -> None:
        """Advance the mean payout by a tick with `command` as its share; a brake (`is_braked`) holds it."""
        self.motion.advance(self._design.model, command, is_braked=is_braked)

    # going on from another place

    def refreshed(self, tick: LoopTick) -> LoopTick:
        """Return the tick after the loop has been moved to another state."""
        estimate, mean_state = self.estimator.estimate, self.motion.state
        return tick._replace(
            estimate=estimate,
            mean_state=mean_state,
            motions=self._look.again(estimate, mean_state),
            mean_command=self.motion.reference_command(self._design.parameters.winch),
            left_over=self.motion.left_over.point.payout,
        )

    def return_to_mean(self, tick: LoopTick) -> None:
        """Count the payout that is out at `tick` as left over: it goes away slowly.

        With the winch locked it would stay, and the unit go on swinging as it does now, whatever has set it going.
        """
        motions, (unit, unit_rate) = tick.motions, tick.estimate[tick.rows.unit_states]
        self.motion.return_from(motions.payout)
        self._look.continue_shadow(motions.unit + motions.payout, motions.unit_rate + motions.payout_rate)
        self._look.continue_hanging(unit, unit_rate)

    def hand_over(self, tick: LoopTick, *, unit_stood: bool) -> None:
        """Make the present depth of the unit the mean and go on from `tick`; `unit_stood` on the seabed until now.

        See `handover`.
        """
        now = (self._design.model, self.estimator.estimate, self.estimator.covariance, self.motion.state)
        if unit_stood:
            pull = (tick.sensed.filtered_tension - self._design.wet_tension) / self._design.cable.stiffness
            mean_state = followed(self._design.model, self.motion.state)
            heave = self.observer.unit_heave_reading(mean_state, tick.rows.unit_states[0])
            after = hand_over_standing(*now, pull=pull, heave=heave)
        else:
            after = hand_over(*now)
        self.motion.continue_at(after.mean_state, after.lowered)
        self.reset_readings()
        # readings of this tick that are late are held against the state as it is counted from now on
        self.observer.terms.reset_shares()
        self.observer.terms.remember_share(tick.number, after.mean_state)
        self.estimator.continue_at(tick.number, after.estimate, after.covariance, {})
        self._look.continue_hanging(*self._unit)

    # depth

    @property
    def set_point(self) -> float:
        """Payout about which the winch works [m]; before that is known the one that was read."""
        return self._known(self.motion.set_point)

    @property
    def depth_set_point(self) -> float:
        """The part of it that takes the unit to another depth [m]."""
        return self._known(self.motion.depth_set_point)

    @property
    def stated_payout(self) -> float:
        """Payout that was read before it is known to be the mean one [m]; NaN: it is known, or none was read."""
        return math.nan if self._has_begun else self._first_payout

    def _known(self, payout: float) -> float:
        return payout if math.isnan(self.stated_payout) else self.stated_payout

    @property
    def filtered_tension(self) -> float:
        """Low-passed reading of the load cell [N]; NaN before the first."""
        return self._tension.value

    @property
    def mean_depth(self) -> float:
        """Estimated mean depth of the unit, positive down [m]; NaN before the first depth reading."""
        zero = self.observer.terms.depth_zero
        if zero is None:
            return math.nan
        motion = self.motion
        payout = float(self._rows.payout @ motion.state) + motion.left_over.point.payout - motion.carried.point.payout
        return zero + self._depth_bias() + payout * (1.0 + self.observer.terms.stretch_per_payout)

    def payout_at(self, depth: float) -> float:
        """Return the mean payout [m] that brings the unit to a mean depth [m]; NaN before the first depth reading."""
        zero = self.observer.terms.depth_zero
        if zero is None:
            return math.nan
        return (depth - zero - self._depth_bias()) / (1.0 + self.observer.terms.stretch_per_payout)

    def _depth_bias(self) -> float:
        """Return how much deeper the mean is than the first reading [m]."""
        model = self._design.model
        return -float(self.estimator.estimate[model.state(DEPTH_BIAS)]) if model.has_state(DEPTH_BIAS) else 0.0
