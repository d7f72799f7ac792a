"""The adviser as a component: observations of a second in, beliefs out. No ROS, no clock, nothing shared with the core.

Each second the drum is identified from what it was ordered and what its encoder read; every few seconds the last minute
of all sensors is judged; now and then the sea is. What is found becomes one `Beliefs` value with the design for it. A
design is made for the length of cable that is out, too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import scipy.optimize  # noqa: F401  # the first design would load it, within a tick

from winch_controller_node.adviser.filter_pass import SETTLING
from winch_controller_node.adviser.hypothesis import (
    AGAIN,
    MISFIT,
    SEA,
    Assumed,
    Change,
    Hypothesis,
    accepted,
    rules_out_encoder,
)
from winch_controller_node.adviser.judge import ENCODER_ROW, LEAST_READ, Judge
from winch_controller_node.adviser.record import NIS, ROW, TICK, Excerpt, Record, SensorHistory
from winch_controller_node.adviser.report import Report
from winch_controller_node.adviser.sea import SeaLooks, likeliest_sea
from winch_controller_node.adviser.winch import CHECKED, WinchAnswer, WinchIdentifier
from winch_controller_node.beliefs.beliefs import (
    CAUTIOUS,
    Adopted,
    Belief,
    Beliefs,
    Correction,
    EncoderScale,
    corrections,
    latency_ticks,
    parameters_under,
    without_sea,
)
from winch_controller_node.beliefs.quantities import ENCODER_SCALE, QUANTITIES, out_of_range, with_value
from winch_controller_node.design.design import ControllerDesign, assumed_cable, design_controller, length_followed
from winch_controller_node.design.seas import possible_seas
from winch_controller_node.interface.observations import TICK_COLUMNS, Observations
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters

MINUTE = 60.0
"""Record that is judged [s]."""

SHORTEST = 25.0
"""Shortest record that is judged [s]: its first part settles the state."""

DRIVING = ("mru", "encoder")
"""Sensors of what moves the load, boom tip and drum: where one of them is not read, no other is predicted."""

BREAK = 1.0
"""Longest time without a reading of these in the last `LEAST_READ`, or that of `health.stale_samples` of them [s]."""

WORSE = 1.3
"""Hypotheses that explained nothing are tried again when the misfit is so many times larger, or on another minute."""

UNCERTAIN_GAIN = 0.25
"""Logarithm of a gain over the nominal one from which on it may as well be the encoder's scale."""


class Looks:
    """When hypotheses are tried: where the sensors read otherwise than predicted, and something is new about it."""

    def __init__(self) -> None:
        self._before: Hypothesis | None = None
        self._best_since, self._tried, self._misfit = 0, -MINUTE, 1.0

    def is_due(self, misfit: float, second: int, *, is_asked: bool) -> bool:
        """Tell whether hypotheses are tried in a `second` with a `misfit`, or where that `is_asked`; note that."""
        is_news = misfit > WORSE * self._misfit or second >= self._tried + MINUTE
        if not (is_news or self._before is not None or is_asked):
            return False
        self._tried, self._misfit = second, misfit
        return True

    def held_before(self, best: Hypothesis, second: int) -> Hypothesis | None:
        """Return that of the last look, where the `best` in this `second` blames the same as it for long enough."""
        if self._before is None or self._before.culprits != best.culprits:
            self._best_since = second
        return self._before if second - self._best_since >= CHECKED else None

    def note(self, best: Hypothesis | None) -> None:
        """Remember the best hypothesis of this look that was not accepted; None: the present beliefs were the best."""
        self._before = best


class Adviser:
    """Answers observations with beliefs.

    Parameters
    ----------
    parameters : nominal
    tick_period : [s]
    """

    def __init__(self, parameters: WinchControllerParameters, *, tick_period: float) -> None:
        self._dt = tick_period
        self._first = parameters
        self._restated: tuple[tuple[str, float], ...] = ()
        self._record = Record(tick_period)
        self._history = SensorHistory()
        self._drum_gain, self._seconds = 1.0, 0
        self._judged = 0.0  # duration of the record that is judged [s]
        self._begin(parameters, Beliefs(asked=-1))

    def _begin(self, nominal: WinchControllerParameters, beliefs: Beliefs) -> None:
        """Go by `nominal` parameters under the present beliefs, for another sea or length of cable."""
        self._nominal = nominal
        self._beliefs, self._changed = beliefs, beliefs.asked
        plain = design_controller(nominal, tick_period=self._dt)
        self._nominal_cable = plain.cable
        self._design = self._designed(self.parameters, plain.length) if beliefs.values else plain
        self._winch = WinchIdentifier(nominal, self._dt)
        self._sea, self._looks = SeaLooks(self._design), Looks()
        self._gain_is_winch = self._drum_gain_is_open = False
        self._leads_to: Hypothesis | None = None
        self._length_since = 0
        self._report = Report(nominal)

    @property
    def parameters(self) -> WinchControllerParameters:
        """Parameters under the present beliefs."""
        return parameters_under(self._beliefs, self._nominal)

    def advise(self, observations: Observations) -> Beliefs:
        """Return the beliefs after a batch of `observations`; active LATENCY after its last tick."""
        if observations.restated != self._restated:
            self._restated = observations.restated
            nominal = self._first
            for path, value in self._restated:
                nominal = with_value(nominal, path, value)
            self._begin(nominal, without_sea(self._beliefs))
        before = self._beliefs
        is_due = observations.last >= before.asked + latency_ticks(self._dt)
        if is_due and observations.beliefs < 0 and (before.values or before.encoder or before.excluded):
            # the core has dropped what was found here: it is looked for again from now on
            self._history, self._record = SensorHistory(), Record(self._dt)
            before = Beliefs(before.asked, before.number)
            self._begin(self._nominal, before)
        self._beliefs = replace(before, asked=observations.last, findings=(), design=None, adopted=None)
        self._leads_to = None
        self._record.add(observations)
        self._judged = self._to_be_judged()
        self._seconds += 1
        if is_due and 0 <= observations.beliefs < before.number:
            # the answer before came too late: what it changed is sent again
            self._beliefs = replace(self._beliefs, design=self._design)
            self._adopt_present()
        self._follow_exclusion(observations)
        self._follow_length(observations)
        self._look_at_winch()
        if self._judged >= SHORTEST:
            # each second while a sensor is set aside, or not trusted
            is_urgent = bool(observations.excluded) or not observations.is_trusted
            if is_urgent or self._seconds % CHECKED == 0:
                self._judge(is_urgent=is_urgent)
        self._look_at_sea(observations)
        self._adopt()
        findings = self._report.news(self._beliefs, observations.last * self._dt)
        changed = replace(before, asked=self._beliefs.asked, findings=(), design=None, adopted=None) != self._beliefs
        self._beliefs = replace(self._beliefs, findings=findings, number=before.number + int(changed or bool(findings)))
        if self._beliefs.number != before.number:
            self._changed = observations.last + latency_ticks(self._dt)
        return self._beliefs

    def _follow_length(self, observations: Observations) -> None:
        """Design for the length of cable that is out in the mean of the `observations`, once it is another one."""
        payout = float(np.mean(observations.ticks[:, TICK_COLUMNS.index("order_payout")]))
        length = length_followed(self._nominal, payout, self._design.length)
        if length == self._design.length:
            return
        self._nominal_cable = assumed_cable(self._nominal, length)
        self._design = self._designed(self.parameters, length).with_own_gains()
        self._sea.tracker.refer_to(self._design)
        self._length_since, self._judged = observations.last, 0.0
        self._beliefs = replace(self._beliefs, design=self._design)

    @property
    def _record_of_length(self) -> float:
        """Duration of the record with the present length of cable [s]."""
        since = self._dt * (self._beliefs.asked - self._length_since) if self._length_since else math.inf
        return min(self._record.duration, since)

    def _to_be_judged(self) -> float:
        """Return the duration of the record that is judged [s]: none while it is not known what moves the load."""
        excerpt, known = self._record.last(LEAST_READ), self._nominal.sensors.in_use()
        for name in known.keys() & DRIVING:
            stale = self._nominal.health.stale_samples * known[name].period(self._dt)
            if excerpt.longest_break(name) > max(BREAK, stale):
                return 0.0
        return min(MINUTE, self._record_of_length)

    # the winch

    def _look_at_winch(self) -> None:
        if not self._nominal.identifies_winch:
            return
        excerpt = self._record.last(min(self._winch.length, self._record.duration))
        assumed = {name: belief.value for name, belief in self._beliefs.values.items()}
        answer = self._winch.look(excerpt, self._history, assumed)
        if answer is None:
            return
        if answer.factor is not None:
            self._take_encoder(*answer.factor, answer.nats)
        self._drum_gain = answer.gain * self._history.encoder_scale
        # an encoder that is set aside says nothing of the winch
        if answer.factor is None and self._beliefs.excluded != "encoder":
            self._take_winch(answer)

    def _take_winch(self, answer: WinchAnswer) -> None:
        """Accept what was found of the winch; a gain far off only once it cannot be the encoder's scale."""
        changed = dict(answer.changed)
        gain = changed.get("winch.speed_gain")
        nominal = QUANTITIES["winch.speed_gain"].nominal_in(self._nominal)
        is_uncertain = gain is not None and abs(math.log(gain.value / nominal)) > UNCERTAIN_GAIN
        self._drum_gain_is_open, self._gain_is_winch = is_uncertain, False
        if is_uncertain and self._judged >= SHORTEST:
            self._judge()
        if is_uncertain and not self._gain_is_winch:
            self._beliefs = replace(self._beliefs, authority=CAUTIOUS)
            return
        self._beliefs = replace(self._beliefs, authority=1.0)
        if changed or answer.nominal:
            values = {n: b for n, b in self._beliefs.values.items() if n not in answer.nominal} | changed
            self._assume(values)

    def _take_encoder(self, since: int, factor: float, sigma: float, step: float, nats: float) -> None:
        """Accept that the encoder has read `factor` times as much as assumed `since` a tick, after a `step` [m]."""
        held = self._history, self._beliefs
        self._rescale(since, factor * self._history.encoder_scale, step)
        belief = Belief(ENCODER_SCALE, self._history.encoder_scale, sigma, nats, since)
        if self._assume({**self._beliefs.values, ENCODER_SCALE: belief}, excluded=""):
            self._adopt_present()
        else:
            self._history, self._beliefs = held

    def _rescale(self, since: int, scale: float, step: float = 0.0) -> None:
        """Note that the encoder has another scale since a tick; in the first seconds it has had it from the start.

        `step` is by how much its reading jumped there, as payout under the scale before [m].
        """
        excerpt = self._record.last(self._record.duration)
        ticks = np.arange(excerpt.first, excerpt.last + 1)
        read = excerpt.tick_column("encoder")
        known = np.flatnonzero(np.isfinite(read) & (ticks >= since - 1))
        place = int(known[0]) if len(known) else len(ticks) - 1
        reading = float(read[place]) if math.isfinite(read[place]) else 0.0
        old = self._history.encoder[-1] if self._history.encoder else EncoderScale()
        payout = old.payout + (reading - old.reading) / old.scale
        begun = EncoderScale(max(since, int(ticks[place])), scale, reading + step * old.scale, payout)
        self._history = self._history._replace(encoder=(*self._history.encoder, begun))
        self._beliefs = replace(self._beliefs, encoder=begun)

    def _follow_exclusion(self, observations: Observations) -> None:
        """Go by what a reflex of the core has set aside; the encoder is set aside and used again by the core alone."""
        excluded = observations.excluded
        if "encoder" in (excluded, self._beliefs.excluded) or excluded:
            self._beliefs = replace(self._beliefs, excluded=excluded)

    # the sensors and the cable

    def _assumed(self) -> Assumed:
        values = {name: belief.value for name, belief in self._beliefs.values.items()}
        return Assumed(
            nominal=self._nominal,
            parameters=self.parameters,
            cable=self._design.cable,
            design=self._design,
            values=values,
            history=self._history,
            excluded=self._beliefs.excluded if self._beliefs.excluded != "encoder" else "",
            drum_gain=self._drum_gain,
        )

    def _is_predicted(self, excerpt: Excerpt) -> bool:
        """Tell whether the core's own filter, under the present beliefs, has predicted all readings of an `excerpt`.

        Its innovations are those that a judge would find.
        """
        if self._beliefs.excluded or excerpt.first <= self._changed:
            return False
        in_use = self.parameters.sensors.in_use().values()
        readings = excerpt.of(
            tuple(row.name for one in in_use for row in one.rows() if row.name != ENCODER_ROW)
        ).readings
        late = readings[readings[:, TICK] >= excerpt.first + round(SETTLING / self._dt)]
        which = late[:, ROW].astype(np.int64)
        mean = np.bincount(which, late[:, NIS]) / np.maximum(np.bincount(which), 1)
        return bool(np.all(mean < MISFIT / WORSE))

    def _judge(self, *, is_urgent: bool = True) -> None:
        """Look for the sensor, or the cable, that differs from what is assumed, where not all is as predicted."""
        excerpt, looks = self._record.last(self._judged), self._looks
        is_off = abs(math.log(abs(self._drum_gain / self._history.encoder_scale))) > UNCERTAIN_GAIN
        if not is_urgent and not is_off and self._is_predicted(excerpt):
            looks.note(None)
            return
        judge = Judge(excerpt, self._assumed())
        present, used = judge.present, judge.used
        worst = present.worst(used)
        # an encoder that is set aside is the drum's record to judge
        is_off |= worst > MISFIT or self._beliefs.excluded not in ("", "encoder")
        if not is_off:
            looks.note(None)
            return
        if not looks.is_due(worst, self._seconds, is_asked=bool(self._beliefs.excluded) or self._drum_gain_is_open):
            return
        ranked = judge.best()
        if not ranked:
            # what was read is beyond every model
            return
        self._gain_is_winch = rules_out_encoder(ranked)
        found = accepted(ranked, present, looks.held_before(ranked[0], self._seconds), used)
        looks.note(ranked[0] if ranked[0].changes or ranked[0].excluded != present.excluded else None)
        # while the encoder is set aside what it reads makes others look wrong
        if found is not None and (self._beliefs.excluded != "encoder" or "encoder" in found.culprits):
            looks.note(None)
            self._take_hypothesis(found, present)

    def _take_hypothesis(self, found: Hypothesis, present: Hypothesis) -> None:
        """Accept a hypothesis, and continue from the state that it leads to.

        A sensor that would have to be corrected by what cannot be is excluded.
        """
        beyond = beyond_range(found, self._nominal)
        if beyond is not None:
            if beyond.excluded in ("", self._beliefs.excluded):
                return
            found = beyond
        held = self._history, self._beliefs
        values = {name: one for name, one in self._beliefs.values.items() if QUANTITIES[name].owner != found.excluded}
        nats = present.total - found.total
        for name, change in found.changes.items():
            if change.value == QUANTITIES[name].nominal_in(self._nominal):
                values.pop(name, None)
            else:
                values[name] = Belief(name, change.value, change.sigma, nats, change.since)
            if name == ENCODER_SCALE:
                self._rescale(change.since, change.value)
        self._note_corrections(found.changes, values)
        if not self._assume(values, excluded=found.excluded):
            self._history, self._beliefs = held
            return
        if "mru" in found.culprits:
            # the boom tip was not where it was taken to be
            self._sea = SeaLooks(self._design)
        self._leads_to = found

    def _note_corrections(self, changes: Mapping[str, Change], values: Mapping[str, Belief]) -> None:
        """Add what has changed of MRU and depth sensor to their history."""
        after = corrections(Beliefs(0, values=MappingProxyType(dict(values))), self._nominal)
        since = {QUANTITIES[name].owner: change.since for name, change in changes.items()}
        added: list[tuple[str, int, Correction]] = []
        for sensor, correction in after.items():
            if correction != self._history.correction(sensor):
                added.append((sensor, since.get(sensor, 0), correction))
        self._history = self._history._replace(corrections=(*self._history.corrections, *added))

    def _adopt_present(self) -> None:
        """Have the core continue from the state that the last minute leads to under the present beliefs."""
        if self._judged >= SHORTEST:
            self._leads_to = Judge(self._record.last(self._judged), self._assumed()).present

    def _adopt(self) -> None:
        """Have the core continue from the state at the end of the record that the present beliefs lead to, if any."""
        found, model = self._leads_to, self._design.model
        if found is None:
            return
        among = [found.state_names.index(name) for name in model.state_names if name in found.state_names]
        own = [model.state(name) for name in model.state_names if name in found.state_names]
        estimate, covariance = np.zeros(model.order), self._design.initial_covariance.copy()
        estimate[own] = found.state[among]
        covariance[own, :] = covariance[:, own] = 0.0
        covariance[np.ix_(own, own)] = found.covariance[np.ix_(among, among)]
        self._beliefs = replace(self._beliefs, adopted=Adopted(self._beliefs.asked, estimate, covariance))

    # the sea

    def _look_at_sea(self, observations: Observations) -> None:
        """Follow the sea that is seen, where that is another one and predicts the readings better."""
        parameters = self.parameters
        if not parameters.sea.follows_spectrum:
            return
        if self._beliefs.excluded == "mru" or "mru" not in parameters.sensors.use:
            return
        self._sea.add(observations, self._nominal.sensors.mru.rate_noise)
        if self._judged < SHORTEST:
            return
        seen = self._sea.news(observations.last * self._dt, parameters.sensors.mru.rate_noise)
        if seen is None:
            return
        seas = possible_seas(seen, self._nominal.sea, parameters.sea, parameters.vessel)
        found = likeliest_sea(parameters, self._design, seas, self._record.last(self._record_of_length), self._history)
        if found is None:
            return
        whole, swell = found, found.swell
        heights_and_periods = (
            *(whole.significant_wave_height, whole.peak_period),
            *(swell.significant_wave_height, swell.peak_period),
        )
        sea = dict(zip(SEA, heights_and_periods, strict=True))
        if not self._is_sea(sea):
            return
        self._sea.has_changed()
        values = {name: belief for name, belief in self._beliefs.values.items() if name not in SEA}
        values |= {
            name: Belief(name, value, since=observations.last)
            for name, value in sea.items()
            if value != QUANTITIES[name].nominal_in(self._nominal)
        }
        self._assume(values)

    def _is_sea(self, sea: Mapping[str, float]) -> bool:
        """Tell whether no other culprit would explain the last minute better than another `sea`."""
        judge = Judge(self._record.last(self._judged), self._assumed())
        others = [one.total for one in judge.best() if one.culprits - {"sea"} != judge.present.culprits]
        other = min(others, default=math.inf)
        return other > judge.present.total - AGAIN or judge.total_with(sea) < other

    # beliefs

    def _assume(self, values: Mapping[str, Belief], *, excluded: str | None = None) -> bool:
        """Take over other `values`, and design for them where the model is another one; return whether that succeeds.

        Where it does not, or a value cannot be, the beliefs stay as they are.
        """
        if out_of_range({name: belief.value for name, belief in values.items()}, self._nominal):
            return False
        before = self.parameters
        beliefs = replace(
            self._beliefs,
            values=MappingProxyType(dict(values)),
            excluded=self._beliefs.excluded if excluded is None else excluded,
        )
        after = parameters_under(beliefs, self._nominal)
        try:
            design = (
                self._designed(after, self._design.length).with_own_gains() if _needs_design(before, after) else None
            )
        except DesignError:
            for name in {*values, *self._beliefs.values}:
                if values.get(name) != self._beliefs.values.get(name):
                    self._report.refuse(QUANTITIES[name].owner)
            return False
        if design is not None:
            self._design = design
            self._sea.tracker.refer_to(design)
        self._beliefs = replace(beliefs, design=design if design is not None else self._beliefs.design)
        return True

    def _designed(self, parameters: WinchControllerParameters, length: float) -> ControllerDesign:
        """Return the design for `parameters` on a `length` [m] of the nominal cable, its damping as assumed."""
        nominal, cable = self._nominal.cable_model, self._nominal_cable
        inertia = parameters.cable_model.inertia_factor / nominal.inertia_factor
        damping = parameters.cable_model.damping_factor / nominal.damping_factor
        cable = replace(cable, a=inertia * cable.a, b=damping * cable.b, drag=damping * cable.drag)
        return design_controller(parameters, tick_period=self._dt, length=length, cable=cable)


def _needs_design(before: WinchControllerParameters, after: WinchControllerParameters) -> bool:
    """Tell whether the model changes: limits and gain of the winch are not in it."""
    return replace(after, winch=after.winch.with_limits_of(before.winch)) != before


def beyond_range(found: Hypothesis, nominal: WinchControllerParameters) -> Hypothesis | None:
    """Return what was `found` with the sensor excluded that it corrects by what cannot be with `nominal` parameters.

    It names no sensor where it is no sensor's value, or the encoder's, which a reflex of the core sets aside. None: all
    of it can be.
    """
    owners = {QUANTITIES[name].owner for name, one in found.changes.items() if out_of_range({name: one.value}, nominal)}
    if not owners:
        return None
    changes = {name: change for name, change in found.changes.items() if QUANTITIES[name].owner not in owners}
    sensor = next(iter(owners & {"mru", "depth"}), "") if len(owners) == 1 else ""
    return replace(found, changes=changes, excluded=sensor)
