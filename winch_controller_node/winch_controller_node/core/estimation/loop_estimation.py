"""What is known of the loop: gates, estimator, sea, the mean payout's own motion, and the uncompensated unit, by ticks.

A tick is the sensing half of the core's (`heave_core`, sense.cpp); what is here fills in what was delivered, and says
what is new in words. The estimator sees the loop without the mean payout's own motion, see `mean_motion`.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import Any

import numpy as np
from heave_core.filter import KalmanFilter
from heave_core.law import SENSING, Control
from heave_core.library import library
from heave_core.look import Look, padded
from heave_core.sense_table import OBSERVED, News
from heave_node.numerics.arrays import Array

from winch_controller_node.beliefs.beliefs import LATENCY, Adopted, EncoderScale
from winch_controller_node.core.estimation.core_tick import CoreTick
from winch_controller_node.core.estimation.handover import followed, hand_over, hand_over_seen, hand_over_standing
from winch_controller_node.core.estimation.loop_tick import FIELDS, TENSION_MEMORY, CommandShares, LoopTick, TensionMean
from winch_controller_node.core.estimation.observation import Observer
from winch_controller_node.core.estimation.observation_log import ObservationLog
from winch_controller_node.core.estimation.second_filter import SecondFilter
from winch_controller_node.core.estimation.sense_design import ENCODER_ROW, ROWS
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.seas import SeaTracker
from winch_controller_node.interface.readings import Measurements, WinchReading
from winch_controller_node.interface.sensors import DEPTH_BIAS, LEVER_ARM_X, LEVER_ARM_Y
from winch_controller_node.model.estimator import NO_REGRESSORS, Measurement, RecordedTick, begin_anew
from winch_controller_node.model.models import loop_rows
from winch_controller_node.model.simulated_unit import hanging_cable
from winch_controller_node.motion.mean_motion import MeanMotion

NOISE_SWING = 4.0
"""Motion of the boom tip that may be noise, for a unit that swings freely, over the error of its estimate."""

TAUT_TIME = 20.0
"""Time in which a unit that had a taut cable goes over to one that had not [s]: near the resonance of the cable it
would swing by far more than any unit does, and what the law refers to with it."""

NEAR = 0.1
"""A drum that stands so near to a payout of 0 at first [m] returns to it, as it does after a stop."""


NO_READINGS = np.zeros((0, len(OBSERVED.rows)))
"""Of a tick in which none was observed."""

NOTHING: dict[str, str] = {}
"""No sensor is lost."""

PLACES = tuple(FIELDS.index(name) for name in ("number", "lost_sensors", "depth_count", "disagree_time"))
"""Places in a tick of what is made words of."""


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
        "tip_memory": TENSION_MEMORY,
        "noise_swing": NOISE_SWING,
        "taut_time": TAUT_TIME,
        "cable": hanging_cable(design.cable, dt),
        "taut_cable": hanging_cable(replace(design.cable, unit_weight=math.inf), dt),
    }


class LoopEstimation:
    """Estimate of the loop, and of what the unit would do with the winch locked.

    Parameters
    ----------
    design : model, measurements and noise
    control : of the tick
    """

    def __init__(self, design: ControllerDesign, control: Control) -> None:
        parameters, dt = design.parameters, design.tick_period
        # mean payout and what it brings about
        self.motion = MeanMotion(parameters.move, design.model.order, tick_period=dt)
        self.estimator = design.make_estimator()  # the filter
        self.observer = Observer(design, self.estimator)  # the gates in front of it
        self._look = Look(look_design(design))
        self._has_begun, self._first_payout = False, math.nan
        self.observed = NO_READINGS  # in the last tick, by rows of OBSERVED
        self._sea = SeaTracker(design, self.observer.state["sea"])
        self.log = ObservationLog(dt)  # of what is observed, for the adviser
        # filter that explains the readings by nominal values alone; None: the active one does
        self.second: SecondFilter | None = None
        # filter that takes the drum to be where it is counted, while the active one goes by what it was commanded;
        # None: the two agree
        self.by_count: SecondFilter | None = None
        self._recent: deque[tuple[int, float, Array]] = deque(maxlen=2 * round(LATENCY / dt))
        self._core, self._now = CoreTick(control), (0, CommandShares())
        self._is_noted = True
        self._made: LoopTick | None = None
        self._bound: KalmanFilter | None = None
        look = self._look
        control.take(SENSING, look=look.design, look_state=look.state)
        # of the core, by the names that supervision has for them
        self.records = {"sense": self.observer.design, "sense_state": self.observer.state, "tick": self._core.memory}
        control.take(SENSING, **self.records)
        self._refer_to(design)

    def _refer_to(self, design: ControllerDesign) -> None:
        """Refer to a design from now on, whose model the estimator has already."""
        self._design = design
        self.observer.take_design(design, self.estimator)
        self._rows = loop_rows(design.model)
        self._look.take_design(look_design(design))
        self._sea.refer_to(design)

    # another design

    def take_limits(self, design: ControllerDesign) -> None:
        """Go by the limits and gain of the winch of a `design` whose model is the present one."""
        self._design = design
        self.observer.take_design(design, self.estimator)

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
        if self.by_count is not None:
            self.by_count.carry(design, matrix, added)
        self.motion.carry(matrix)
        self.observer.reset_shares()
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
                RecordedTick(number, command, self._as_assumed(observed))
                for number, command, observed in self._recent
                if adopted.tick < number <= tick
            ]
        )
        if matrix is not None:
            if self.by_count is not None:
                self.by_count.carry(design, matrix)
            self.motion.carry(matrix)
            self.observer.reset_shares()
        self._restart_consistency()
        self._refer_to(design)
        # the boom tip was another one, and so is what it does to a unit that no winch moves
        self._look.take_unit(*self._unit)

    def begin_second(self, nominal: ControllerDesign, tick: int) -> None:
        """Run the filter of the `nominal` design beside from after `tick` on: the active one goes by beliefs."""
        self.second = SecondFilter(nominal, self._design, self.estimator, tick)

    def compare_count(self, tick: int) -> None:
        """Have a filter go by the count from after `tick` on, beside the active one, which goes by the commands."""
        self.by_count = SecondFilter(self._design, self._design, self.estimator, tick, by_count=True)

    def drop_second(self) -> None:
        """Go by the active filter alone: the second one is not needed any more."""
        self.second = None

    def drop_by_count(self) -> None:
        """End the filter that takes the drum to be where it is counted."""
        self.by_count = None

    def readings_of(self, observed: Array) -> list[Measurement]:
        """Return those of the readings that were `observed` in a tick, rows of OBSERVED, that the filter has taken."""
        return [self.observer.corrected(_reading(row, float(row[11])), float(row[4])) for row in observed if row[7]]

    def _as_assumed(self, observed: Array) -> list[Measurement]:
        """Return readings of the last seconds that are taken, by the corrections assumed now."""
        taken = []
        for row in observed:
            index = int(row[2])
            if self.observer.is_taken(index):
                gated = self.observer.encoder.payout_at(row[3]) if ROWS[index] == ENCODER_ROW else float(row[11])
                taken.append(self.observer.corrected(_reading(row, gated), float(row[4])))
        return taken

    def _step_second(self, second: SecondFilter, number: int, command: CommandShares) -> None:
        """Have the second filter take in a tick: readings as read, the command as a nominal winch takes it."""
        assumed, nominal = self._design.parameters.winch, second.design.parameters.winch
        total = self.motion.state + self.estimator.estimate
        stands = assumed.position_gain * float(self._rows.payout @ total)
        speed = nominal.speed_of(assumed.set_point_of(command.total - stands))
        second.step(self._core, number, speed + stands - command.mean, self.motion.address)

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
        self._sea = SeaTracker(self._design, self.observer.state["sea"])
        self._look.forget_waves()

    def begin_share(self) -> None:
        """Let the uncompensated unit of a cable that stays taut go on from where it is: the cable is, from now on."""
        self._look.begin_share()

    def reset_readings(self) -> None:
        """Discard the readings of the past: they hold nothing about the state from now on."""
        self.log.break_record()
        self._recent.clear()
        self._restart_consistency()

    def _restart_consistency(self) -> None:
        """Begin again: something else is assumed from now on."""
        library().heave_core_restart_consistency(self.observer.addresses[1])

    def restart_tension(self) -> None:
        """Average the tension from now on: the situation is another one."""
        library().heave_core_restart_tension(self.observer.addresses[1])

    # a tick

    def deliver(self, number: int, measurements: Measurements, command: CommandShares) -> int:
        """Fill in what came at a tick; return how many readings that are.

        Parameters
        ----------
        number : of the tick
        measurements : delivered at it
        command : of the last tick
        """
        self._now, self._is_noted, self._made = (number, command), False, None
        if not self._has_begun:
            active = self._core.control.active
            active["has_begun"], active["stated_payout"] = self._begin(measurements.winch), self.stated_payout
        self.bind()
        return self._core.deliver(measurements)

    def bind(self) -> None:
        """Have the tick work on the filter as it is now."""
        kalman = self.estimator.kalman
        if kalman is not self._bound:
            self._bound = kalman
            self._core.control.take(SENSING, filter=kalman.design, filter_state=kalman.state)

    @property
    def waits(self) -> bool:
        """Tell whether a filter beside is to take the tick in before it goes on."""
        return self.second is not None or self.by_count is not None

    def note(self, observed: int, news: int) -> None:
        """Note the tick, once it has been sensed: so many readings `observed`, and bits of `news` of the sensors."""
        if self._is_noted:
            return
        self._is_noted, (number, command) = True, self._now
        self.observed = self._core.observed[:observed].copy()
        self._recent.append((number, command.compensating, self.observed))
        if self.second is not None:
            self._step_second(self.second, number, command)
        if self.by_count is not None:
            self.by_count.step(self._core, number, command.compensating, self.motion.address)
        if news & News.SEA_CHANGED:
            for one in (self.estimator, self.by_count):
                if one is not None:
                    one.set_process_noise(self._sea.noise)

    @property
    def tick(self) -> LoopTick:
        """The tick, once it has been sensed; what has not changed since it was last asked for is not made again."""
        if self._made is not None:
            return self._made
        core, observer, row = self._core, self.observer, self._core.tick.tolist()
        number, lost, depths, disagrees = (int(row[place]) for place in PLACES)
        self._made = LoopTick._make(
            (
                number,  # a count, as messages need it
                *row[1:],
                self._rows,
                self.estimator.estimate,
                self.motion.state,
                core.said[: len(self.estimator.measurements)].copy(),
                observer.lost() if lost or observer.is_aside else NOTHING,
                tuple(map(tuple, core.depths[:depths].tolist())) if depths else (),
                self.observed,
                observer.inconsistency if disagrees else "",
            )
        )
        return self._made

    def _begin(self, winch: WinchReading | None) -> bool:
        """Take the payout at which the drum stands when the encoder is first read for the mean one.

        Drum and unit may hang anywhere: cable has been paid out by hand, or a controller is restarted. A payout
        that is not near 0 must be read twice. Returns whether what the `winch` reports may be used.
        """
        if winch is None or not math.isfinite(winch.encoder_payout):
            return True
        before, payout = self._first_payout, winch.encoder_payout
        self._first_payout = payout
        is_near = abs(payout) <= NEAR
        self._has_begun = is_near or abs(payout - before) <= NEAR
        if self._has_begun and not is_near:
            self.motion.begin_at(payout, self._design.model, self._design.parameters.winch)
            self.observer.begin_at(payout)
        return self._has_begun

    def advance_mean(self, command: float, *, is_braked: bool) -> None:
        """Advance the mean payout by a tick with `command` as its share; a brake (`is_braked`) holds it."""
        self.motion.advance(self._design.model, command, is_braked=is_braked)

    # going on from another place

    def refresh(self) -> None:
        """Have the motions of the tick as they are after the loop has been moved to another state."""
        self.bind()
        row, now = self._core.record, self.tick
        row["mean_command"] = self.motion.reference_command(self._design.parameters.winch)
        row["left_over"] = self.motion.left_over.point.payout
        self._look.inputs[0] = (now.compensating, now.mean, now.knows_tip, 0.0)
        row["motions"] = tuple(self._look.again(self.estimator.estimate, self.motion.state))
        self._made = None

    def return_to_mean(self, tick: LoopTick) -> None:
        """Count the payout that is out at `tick` as left over: it goes away slowly.

        With the winch locked it would stay, and the unit go on swinging as it does now, whatever has set it going.
        """
        unit, unit_rate = tick.estimate[tick.rows.unit_states]
        self.motion.return_from(tick.payout)
        self._look.continue_shadow(tick.unit + tick.payout, tick.unit_rate + tick.payout_rate)
        self._look.continue_hanging(unit, unit_rate)

    def hand_over(self, tick: LoopTick, *, unit_stood: bool) -> None:
        """Make the present depth of the unit the mean and go on from `tick`; `unit_stood` on the seabed until now.

        See `handover`.
        """
        now = (self._design.model, self.estimator.estimate, self.estimator.covariance, self.motion.state)
        if unit_stood:
            pull = (tick.filtered_tension - self._design.wet_tension) / self._design.cable.stiffness
            mean_state = followed(self._design.model, self.motion.state)
            heave = self.observer.unit_heave_reading(mean_state, tick.rows.unit_states[0])
            after = hand_over_standing(*now, pull=pull, heave=heave)
        else:
            after = hand_over(*now)
        self.motion.continue_at(after.mean_state, after.lowered)
        self.reset_readings()
        # readings of this tick that are late are held against the state as it is counted from now on
        self.observer.reset_shares()
        self.observer.restart_with(tick.number, after.mean_state)
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
        return float(self.observer.state["mean_tension"]["filtered"][0])

    @property
    def mean_tension(self) -> TensionMean:
        """Mean tension at the top, over the waves since the unit and the mean payout are where they are."""
        mean = self.observer.state[0]["mean_tension"]
        return TensionMean(
            float(mean["value"]), math.sqrt(mean["variance"]), float(mean["count"]) * self._design.tick_period
        )

    @property
    def mean_depth(self) -> float:
        """Estimated mean depth of the unit, positive down [m]; NaN before the first depth reading."""
        zero = self.observer.depth_zero
        if zero is None:
            return math.nan
        motion = self.motion
        payout = float(self._rows.payout @ motion.state) + motion.left_over.point.payout - motion.carried.point.payout
        return zero + self._depth_bias() + payout * (1.0 + self.observer.stretch_per_payout)

    def payout_at(self, depth: float) -> float:
        """Return the mean payout [m] that brings the unit to a mean depth [m]; NaN before the first depth reading."""
        zero = self.observer.depth_zero
        if zero is None:
            return math.nan
        return (depth - zero - self._depth_bias()) / (1.0 + self.observer.stretch_per_payout)

    def _depth_bias(self) -> float:
        """Return how much deeper the mean is than the first reading [m]."""
        model = self._design.model
        return -float(self.estimator.estimate[model.state(DEPTH_BIAS)]) if model.has_state(DEPTH_BIAS) else 0.0


def _reading(observed: Array, value: float) -> Measurement:
    """Return a row of OBSERVED as a reading for a filter, of a `value`."""
    _, tick, row, _, _, offset, sigma, _, _, lever_x, lever_y, _ = observed.tolist()
    weights = {LEVER_ARM_X: lever_x, LEVER_ARM_Y: lever_y} if lever_x or lever_y else NO_REGRESSORS
    return Measurement(ROWS[int(row)], value, int(tick), None if math.isnan(sigma) else sigma, offset, weights)
