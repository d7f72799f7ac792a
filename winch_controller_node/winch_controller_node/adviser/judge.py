"""The judge: which sensor, or the cable, differs from what is assumed, by the likelihood of one record.

A hypothesis is a correction of what one sensor has read, another model, or both; each thing that it holds otherwise
than nominal has its price in nats. One rule accepts: enough nats better than the present beliefs, at once or twice
running, clearly better than with any other culprit, and the record explained.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel, state_covariance

from winch_controller_node.adviser.columns import DELAY, FACTOR, ONSETS, STEP, in_columns
from winch_controller_node.adviser.evidence import FACTORS, Fitted, evidence
from winch_controller_node.adviser.filter_pass import SETTLING, PassModel, PassResult, run_pass
from winch_controller_node.adviser.record import TICK, Excerpt, SensorHistory
from winch_controller_node.beliefs.quantities import (
    DEPTH_SCALE,
    ENCODER_SCALE,
    MRU_DELAY,
    MRU_OFFSET,
    MRU_SCALE,
    QUANTITIES,
    with_value,
)
from winch_controller_node.design.design import ControllerDesign, measurement_models, model_inputs
from winch_controller_node.interface.sensors import MRU_BIAS
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.models import augmented_model
from winch_controller_node.model.simulated_unit import cable_slack, unit_drag
from winch_controller_node.node_parameters import WinchControllerParameters

HIGH_PASS, DRIFT, DRIFT_SIGMA = "mru.high_pass_period", "mru.bias_drift", "mru.bias_sigma"
INERTIA, DAMPING = "cable.inertia_factor", "cable.damping_factor"
SEA = ("sea.significant_wave_height", "sea.peak_period", "sea.swell.significant_wave_height", "sea.swell.peak_period")
SEA_PERIOD, SWELL_PERIOD = SEA[1::2]

PRICES = {
    INERTIA: 6.0,
    DAMPING: 8.0,
    HIGH_PASS: 10.0,
    MRU_SCALE: 12.0,
    MRU_OFFSET: 12.0,
    MRU_DELAY: 14.0,
    ENCODER_SCALE: 12.0,
    DEPTH_SCALE: 16.0,
    DRIFT: 24.0,
    SEA_PERIOD: 3.0,
    SWELL_PERIOD: 3.0,
}
"""Prior of a quantity that differs from nominal [nats]: how seldom that is."""

SPREAD, PERIOD_SPREAD = 0.4, 0.3
"""Standard deviation of the logarithm of a scale that is not nominal: one of 2.5 is less likely than one of 1.2; and of
a period of the sea over the nominal one."""

USUAL = {MRU_OFFSET: 0.5, MRU_DELAY: 0.2}
"""Standard deviation of what is not a ratio and not nominal, in its unit."""

REVERSED = 4.0
"""Further price of a sign error [nats]."""

RADIUS_SPREAD, GAIN, IMPOSSIBLE = 0.03, 12.0, 100.0
"""Standard deviation of the logarithm of a winch's gain over the nominal one, as by another radius of the drum; the
price of another gain, which is then as likely as a scale; and of a reversed one."""

EXCLUSION = 18.0
"""Prior of excluding a sensor [nats]: an exclusion explains nothing."""

ONSET = 3.0
"""Prior of an onset within the record [nats]: there are some moments at which it may be."""

ACCEPTED, AGAIN = 48.0, 8.0
"""A hypothesis is accepted that is so many nats better than the beliefs: at once, or where it was the best a look
before as well."""

CLEARLY = 5.0
"""Lead over the best hypothesis with another culprit that acceptance requires [nats]."""

EXPLAINED, SHARE_LEFT = 4.0, 0.25
"""Largest mean squared normalised innovation of a sensor that is used under what is accepted, or share of before."""

TOLERANCE = {MRU_SCALE: 0.02, ENCODER_SCALE: 0.02, DEPTH_SCALE: 0.02, MRU_OFFSET: 0.03, MRU_DELAY: 0.02}
"""Difference from nominal below which a value counts as nominal, in its unit."""

HIGH_PASSES = (100.0, 60.0, 40.0, 30.0, 22.0, 16.0)
INERTIAS, DAMPINGS = (0.7, 0.85, 1.2, 1.45), (0.25, 4.0)
DRIFTS = (0.005, 0.015)
"""Values of a model that are tried first; cut-off periods [s], factors, random walks [m/sqrt(s)]."""

REFINEMENTS = (1.12, 1.05)
"""Factors, up and down, by which the best of them is refined; damping by their cubes."""

JUDGED = {FACTOR: {"mru": MRU_SCALE, "encoder": ENCODER_SCALE, "depth": DEPTH_SCALE}, STEP: {"mru": MRU_OFFSET}}
JUDGED[DELAY] = {"mru": MRU_DELAY}
"""Quantity of each kind of column of each sensor."""

SCALES = (MRU_SCALE, ENCODER_SCALE, DEPTH_SCALE)

STARTS = {
    FACTOR: 1.0 / FACTORS - 1.0,
    STEP: np.array([-1.0, -0.3, 0.0, 0.3, 1.0]),
    DELAY: np.array([-0.2, -0.1, 0.0, 0.1, 0.2, 0.3]),
}
"""First values tried: factors less 1, offsets [m], further delays [s]."""

LEAST_FACTOR = 0.1
"""A sensor that is to read ten times as much as it should has another fault."""

NEAR = (0.75, 0.83, 0.9, 0.95, 0.98, 1.02, 1.05, 1.1, 1.2, 1.35)
"""Onsets that are tried about the best one, over its time before the end of the record."""

SAME = 0.02
"""Values of a model of which the logarithms differ by less are one."""

ENCODER_ROW = "payout"
"""Measurement of the encoder, which is not judged here: the winch is identified by it, and it is right where the
model of the winch is not."""

LARGEST_DELAY = 0.4
"""A delay beyond which a reading cannot be corrected by its slope [s]."""

LEAST_READ = 10
"""Seconds in which a sensor must have been read for a correction of it, or its acquittal."""

TELLING = 3.0
"""Motion over the noise of a sensor that was left out, 1 sigma, in which it shows that it is right."""


class Change(NamedTuple):
    """A quantity and the value that a hypothesis gives it.

    Attributes
    ----------
    value, sigma : in its unit
    since : first tick that shows it
    """

    value: float
    sigma: float
    since: int


@dataclass(frozen=True)
class Hypothesis:
    """What is held, and how well it explains the record.

    Attributes
    ----------
    changes : against the present beliefs, by quantity
    excluded : sensor that is left out; empty: none
    loss, price : of the record, and of all that is held other than nominal [nats]
    misfits : mean squared normalised innovation by measurement
    motion : that the sensor which is left out should have read over its noise, 1 sigma; NaN: none is
    state, covariance, state_names : at the end of the record
    """

    changes: Mapping[str, Change]
    excluded: str
    loss: float
    price: float
    misfits: Mapping[str, float]
    state: Array = field(repr=False)
    covariance: Array = field(repr=False)
    state_names: tuple[str, ...] = field(repr=False)
    motion: float = math.nan

    @property
    def total(self) -> float:
        """Loss and price [nats]."""
        return self.loss + self.price

    @property
    def culprits(self) -> frozenset[str]:
        """What is at fault under it and was not before."""
        return frozenset(QUANTITIES[name].owner for name in self.changes) | ({self.excluded} - {""})

    def worst(self, used: Iterable[str]) -> float:
        """Return the largest misfit of the measurements `used`."""
        return max((self.misfits[name] for name in used if name in self.misfits), default=1.0)


@dataclass(frozen=True)
class Assumed:
    """What a judgement begins with.

    Attributes
    ----------
    nominal : parameters
    parameters : under the present beliefs
    cable : two-state cable of the length that is out, under the present beliefs
    design : the active one: states at the start are as uncertain as its
    values : assumed other than nominal, by quantity
    history : of the sensors
    excluded : sensor that is left out; empty: none
    drum_gain : of the winch by the encoder as it reads, over its nominal one; a gain counts as assumed
        as it is near to nominal
    """

    nominal: WinchControllerParameters
    parameters: WinchControllerParameters
    cable: CableModel
    design: ControllerDesign
    values: Mapping[str, float]
    history: SensorHistory
    excluded: str = ""
    drum_gain: float = 1.0

    def value(self, quantity: str) -> float:
        """Return the assumed value of a `quantity`."""
        nominal = QUANTITIES[quantity].nominal_in(self.nominal)
        return self.values.get(quantity, nominal)

    def price(self, changes: Mapping[str, Change], excluded: str) -> float:
        """Return the price of the present beliefs with some `changes` and the sensor `excluded` [nats]."""
        held = {**self.values, **{name: change.value for name, change in changes.items()}}
        price = EXCLUSION if excluded else 0.0
        for name, value in held.items():
            nominal = QUANTITIES[name].nominal_in(self.nominal)
            if value != nominal:
                price += PRICES.get(name, 0.0)
                if name in SCALES:
                    price += 0.5 * (math.log(abs(value)) / SPREAD) ** 2 + (REVERSED if value < 0.0 else 0.0)
                if name in (SEA_PERIOD, SWELL_PERIOD):
                    price += 0.5 * (math.log(value / nominal) / PERIOD_SPREAD) ** 2
                # far off is seldom, not impossible
                price += math.log1p(0.5 * ((value - nominal) / USUAL.get(name, math.inf)) ** 2)
        scale = held.get(ENCODER_SCALE, 1.0)
        # what the encoder reads otherwise than the winch was sent is either's
        share = self.drum_gain / scale
        if share <= 0.0:
            return price + IMPOSSIBLE
        off = abs(math.log(share))
        return price + min(0.5 * (off / RADIUS_SPREAD) ** 2, GAIN) + 0.5 * (off / SPREAD) ** 2


class Judge:
    """Judges a record.

    Parameters
    ----------
    excerpt : the last minute
    assumed : the beliefs so far
    onsets : times before its end from which on something may be wrong [s]

    Attributes
    ----------
    present : the present beliefs, judged
    """

    def __init__(self, excerpt: Excerpt, assumed: Assumed, onsets: tuple[float, ...] = ONSETS) -> None:
        self._assumed = assumed
        self._parameters = _linear(assumed.parameters)
        plain, model = pass_model(self._parameters, assumed.cable, assumed.design)
        measurements = measurement_models(self._parameters, model, assumed.cable)
        self._names = tuple(known.name for known in measurements)
        self._sensors = tuple(known.sensor for known in measurements)
        self._excerpt = excerpt.of(self._names)
        self._columns = in_columns(self._excerpt, measurements, assumed.history, onsets)
        self._first_judged = excerpt.first + round(SETTLING / excerpt.dt)
        late = self._excerpt.readings[:, TICK] >= self._first_judged
        seconds = np.floor(self._excerpt.readings[:, TICK] * excerpt.dt)
        self._read_for = {
            sensor: len(np.unique(seconds[late & self._excerpt.is_of(sensor)])) for sensor in self._sensors
        }
        alone = self._columns.data.among(np.array([0]))
        used = np.array([sensor != assumed.excluded for sensor in self._sensors])
        self._shows_unit = self._unit_is_shown(run_pass(plain, alone, used))
        self.present = self._of_model({}, assumed.excluded, corrections=False)[0]

    def _unit_is_shown(self, result: PassResult) -> bool:
        """Tell whether the unit has moved by more than the noise of the depth sensor, as it reads or as is expected.

        One that is held still says nothing of the cable, nor of the sensor that sees it.
        """
        data = self._columns.data
        mine = np.array(self._sensors)[data.which] == "depth"
        mine &= self._excerpt.readings[:, TICK] >= self._first_judged
        if not np.any(mine):
            return True
        read = data.values[mine, 0]
        expected = read - result.innovations[mine, 0] * np.sqrt(result.variances[mine])
        noise = np.sqrt(np.mean(data.variances[mine]))
        return bool(max(np.std(read), np.std(expected)) > TELLING * noise)

    @property
    def used(self) -> tuple[str, ...]:
        """Measurements that are judged."""
        return self._names

    # what is asked

    @staticmethod
    def rules_out_encoder(ranked: list[Hypothesis]) -> bool:
        """Return whether the encoder's scale is as assumed: the best of `ranked` with another is worse."""
        with_it = [one.total for one in ranked if "encoder" in one.culprits]
        without = [one.total for one in ranked if "encoder" not in one.culprits]
        return min(with_it, default=math.inf) >= min(without) + CLEARLY

    def total_with(self, values: Mapping[str, float]) -> float:
        """Return the total of the present beliefs with other `values`, as of another sea [nats]."""
        return self._of_model(values, self._assumed.excluded, corrections=False)[0].total

    def best(self) -> list[Hypothesis]:
        """Return the best hypothesis of each set of culprits, the best of all first; the present beliefs are one."""
        found = self._of_model({}, self._assumed.excluded)
        for sensor in ("mru", "depth"):
            if sensor in self._sensors and sensor != self._assumed.excluded:
                found += self._of_model({}, sensor, corrections=False)
        if self._assumed.excluded:
            found += self._of_model({}, "")
        found += self._of_models()
        found += self._refined(min(found, key=lambda one: one.total))
        least: dict[frozenset[str], Hypothesis] = {}
        for one in (one for one in found if math.isfinite(one.total)):
            if one.culprits not in least or one.total < least[one.culprits].total:
                least[one.culprits] = one
        return sorted(least.values(), key=lambda one: one.total)

    def _refined(self, best: Hypothesis) -> list[Hypothesis]:
        """Return the `best` hypothesis with onsets near its own: a wrong one makes a wrong size."""
        excerpt, onset = self._excerpt, max((change.since for change in best.changes.values()), default=0)
        if onset <= excerpt.first:
            return []
        before = (excerpt.last - onset) * excerpt.dt
        near = tuple(before * share for share in NEAR)
        return Judge(excerpt, self._assumed, near)._of_model({}, best.excluded)

    def _of_models(self) -> list[Hypothesis]:
        """Return hypotheses with another model: first values, then the best of each kind refined."""
        found: list[Hypothesis] = []
        families = self._shows_unit * [
            (INERTIA, tuple(self._assumed.value(INERTIA) * factor for factor in INERTIAS), 1),
            (DAMPING, tuple(self._assumed.value(DAMPING) * factor for factor in DAMPINGS), 3),
        ]
        uses_mru = "mru" in self._sensors and self._assumed.excluded != "mru"
        if uses_mru:
            families.append((HIGH_PASS, HIGH_PASSES, 1))
        for quantity, values, power in families:
            found += self._of_family(quantity, values, power)
        stated = {name: QUANTITIES[name].nominal_in(self._assumed.nominal) for name in SEA}
        if any(name in self._assumed.values for name in SEA):
            found += self._of_model(stated, self._assumed.excluded, since=self._excerpt.first)
        if uses_mru:
            for drift in DRIFTS:
                if drift > self._parameters.sensors.mru.bias_drift:
                    found += self._of_model({DRIFT: drift, DRIFT_SIGMA: 1.0}, "", corrections=False)
        return found

    def _of_family(self, quantity: str, values: tuple[float, ...], power: int) -> list[Hypothesis]:
        """Return hypotheses with other `values` of a `quantity`, and the nominal one, and refinements of the best."""
        nominal, assumed = QUANTITIES[quantity].nominal_in(self._assumed.nominal), self._assumed.value(quantity)
        excluded = self._assumed.excluded
        tried: dict[float, list[Hypothesis]] = {}

        def attempt(value: float) -> None:
            value = nominal if nominal > 0.0 and abs(math.log(value / nominal)) < SAME else value
            if value != assumed and value not in tried:
                tried[value] = self._of_model({quantity: value}, excluded, since=self._excerpt.first)

        for value in values:
            attempt(value)
        if assumed != nominal:
            tried[nominal] = self._of_model({quantity: nominal}, excluded, since=self._excerpt.first)
        for factor in REFINEMENTS:
            best = min(tried, key=lambda value: min(one.total for one in tried[value]))
            if best != nominal:
                attempt(best * factor**power)
                attempt(best / factor**power)
        return [one for ones in tried.values() for one in ones]

    # a model

    def _of_model(
        self, values: Mapping[str, float], excluded: str, *, corrections: bool = True, since: int | None = None
    ) -> list[Hypothesis]:
        """Return what holds with other `values` of the model and a sensor left out: plain, and with each correction.

        `since` : onset of the corrections; None: any
        """
        parameters, cable = self._parameters, self._assumed.cable
        for name, value in values.items():
            parameters = with_value(parameters, QUANTITIES[name].path, value)
            share = value / self._assumed.value(name) if name in (INERTIA, DAMPING) else 1.0
            if name == INERTIA:
                cable = replace(cable, a=cable.a * share)
            if name == DAMPING:
                cable = replace(cable, b=cable.b * share, drag=cable.drag * share)
        model, _ = pass_model(parameters, cable, self._assumed.design)
        keys = [key for key in self._columns.index if key[0] != excluded and since in (None, key[2])]
        keys = [key for key in keys if self._read_for[key[0]] >= LEAST_READ and (key[0] != "depth" or self._shows_unit)]
        if any(one.since > self._excerpt.first for one in self._assumed.history.encoder):
            # it has changed within the record, and from then on it is known
            keys = [key for key in keys if key[0] != "encoder"]
        keys = keys if corrections else []
        columns = np.array([0, *(self._columns.index[key] for key in keys)])
        used = np.array([sensor != excluded for sensor in self._sensors])
        result = run_pass(model, self._columns.data.among(columns), used)
        late = self._excerpt.readings[:, TICK] >= self._first_judged
        which = self._columns.data.which
        which = np.where(np.array(self._names)[which] == ENCODER_ROW, -1, which)
        seconds = np.floor(self._excerpt.readings[late, TICK] * self._excerpt.dt)
        proof = evidence(result.innovations[late], result.variances[late], which[late], len(self._names), seconds)
        changes = {name: Change(value, math.nan, self._excerpt.first) for name, value in values.items()}
        found = [self._hypothesis(changes, excluded, proof.plain(), 0, result, model)]
        for kind, starts in STARTS.items():
            mine = [place for place, key in enumerate(keys, start=1) if key[1] == kind]
            if mine:
                tick = self._excerpt.dt if kind == DELAY else 1.0
                factors = self._shares([keys[place - 1] for place in mine]) if kind == FACTOR else None
                fits = list(zip(mine, proof.fit(np.array(mine), starts / tick, factors), strict=True))
                # the encoder reads all that the drum does otherwise than nominal, or what fits best
                whole = self._assumed.value(ENCODER_SCALE) / self._assumed.drum_gain - 1.0
                fits += [(place, proof.at(place, whole)) for place in mine if keys[place - 1][0] == "encoder"]
                for place, fitted in fits:
                    changed = self._changed(changes, keys[place - 1], fitted)
                    if changed is not None:
                        found.append(self._hypothesis(changed, excluded, fitted, place, result, model))
        return found

    def _shares(self, keys: Sequence[tuple[str, str, int]]) -> Array:
        """Return the share of what is judged of each measurement that columns of `keys` change, (k, len(keys))."""
        last, first = self._excerpt.last, self._first_judged
        shares = [(last - max(since, first)) / max(last - first, 1) for _, _, since in keys]
        is_of = [[known == sensor for sensor, _, _ in keys] for known in self._sensors]
        return np.where(is_of, shares, 0.0)

    def _changed(
        self, changes: Mapping[str, Change], key: tuple[str, str, int], fitted: Fitted
    ) -> dict[str, Change] | None:
        """Return `changes` with the correction of a column of a `key`; None: it cannot be, or is none."""
        sensor, kind, since = key
        quantity, weight, sigma = JUDGED[kind][sensor], fitted.weight, fitted.sigma
        assumed, nominal = self._assumed.value(quantity), QUANTITIES[quantity].nominal
        if kind == FACTOR:
            value = assumed / (1.0 + weight) if abs(1.0 + weight) > LEAST_FACTOR else math.inf
        elif kind == STEP:
            value = assumed - weight
        else:
            value, sigma = assumed + weight * self._excerpt.dt, sigma * self._excerpt.dt
        if not math.isfinite(value) or (kind == DELAY and abs(value) > LARGEST_DELAY):
            return None
        value = nominal if abs(value - nominal) < TOLERANCE[quantity] else value
        return None if value == assumed else {**changes, quantity: Change(value, sigma, since)}

    def _hypothesis(
        self,
        changes: Mapping[str, Change],
        excluded: str,
        fitted: Fitted,
        column: int,
        result: PassResult,
        model: PassModel,
    ) -> Hypothesis:
        state = result.state[:, 0] + (fitted.weight * result.state[:, column] if column > 0 else 0.0)
        late = any(change.since > self._excerpt.first for change in changes.values())
        misfits = {
            name: float(misfit)
            for name, sensor, misfit in zip(self._names, self._sensors, fitted.misfits, strict=True)
            if sensor != excluded and name != ENCODER_ROW
        }
        return Hypothesis(
            changes=changes,
            excluded=excluded,
            loss=fitted.loss,
            price=self._assumed.price(changes, excluded) + (ONSET if late else 0.0),
            misfits=misfits,
            state=state,
            covariance=result.covariance,
            state_names=model.state_names,
            motion=self._motion_of(excluded, result),
        )

    def _motion_of(self, excluded: str, result: PassResult) -> float:
        """Return how far the sensor `excluded` should have seen move what it reads, over its noise; NaN: none is."""
        data = self._columns.data
        mine = np.array([sensor == excluded for sensor in self._sensors])[data.which]
        mine &= self._excerpt.readings[:, TICK] >= self._first_judged
        if not np.any(mine) or self._read_for[excluded] < LEAST_READ:
            return math.nan
        expected = data.values[mine, 0] - result.innovations[mine, 0] * np.sqrt(result.variances[mine])
        return float(np.std(expected) / np.sqrt(np.mean(data.variances[mine])))


START = {
    "payout": 10.0,
    "payout_rate": 1.0,
    "unit_heave": 10.0,
    "unit_heave_rate": 1.0,
    "depth_bias": 10.0,
    "mru_offset": 0.5,
    "mru_offset_rate": 0.5,
}
"""Standard deviation of a state at the start of a record, which may begin anywhere, in its unit."""

OTHER = 0.3
"""Standard deviation at the start of a record of a state that the active design does not have, in its unit."""


def pass_model(
    parameters: WinchControllerParameters,
    cable: CableModel,
    design: ControllerDesign,
    boom_tip: LinearModel | None = None,
) -> tuple[PassModel, LinearModel]:
    """Return the model of `parameters` with a two-state `cable` for a pass, and as it is sampled.

    The state at the start is as uncertain as in the active `design`, or as START says. `boom_tip` is another white
    noise to boom tip than that of the sea and vessel of the parameters, as of a sea that is tried; None: it is that.
    """
    inputs = replace(model_inputs(parameters, cable), boom_tip=boom_tip)
    model = augmented_model(inputs, design.tick_period)
    measurements = measurement_models(parameters, model, cable)
    rows = np.array([known.row for known in measurements])
    change = rows @ model.A - rows
    start = np.diag([START.get(name, OTHER) ** 2 for name in model.state_names])
    known = [name for name in model.state_names if design.model.has_state(name) and name not in START]
    new, old = [model.state(name) for name in known], [design.model.state(name) for name in known]
    start[np.ix_(new, new)] = design.initial_covariance[np.ix_(old, old)]
    if model.has_state(MRU_BIAS):
        # as large as assumed: a larger one would explain what is an offset
        bias = model.state(MRU_BIAS)
        start[bias, :] = start[:, bias] = 0.0
        start[bias, bias] = parameters.sensors.mru.bias_sigma**2
    if boom_tip is not None:
        of_tip = [model.state(name) for name in boom_tip.state_names]
        start[of_tip, :] = start[:, of_tip] = 0.0
        start[np.ix_(of_tip, of_tip)] = state_covariance(boom_tip)
    tables = np.array([rows, change, change @ model.A - change])
    drag, slack = unit_drag(model, cable), cable_slack(model, cable, measurements)
    noise = model.noise_covariance
    return PassModel(model.A, model.B[:, 0], noise, start, tables, drag, slack, model.state_names), model


def accepted(
    ranked: list[Hypothesis], present: Hypothesis, before: Hypothesis | None, used: Iterable[str]
) -> Hypothesis | None:
    """Return the hypothesis to accept from now on; None: the present beliefs stay.

    Parameters
    ----------
    ranked : the best of each culprit, the best first
    present : the present beliefs
    before : the best of the looks of the last seconds; None: there was none, or it was the present beliefs
    used : measurements that are used
    """
    # what is as good with fewer culprits is better; one more beside them is no other explanation
    within = [one for one in ranked if one.culprits <= ranked[0].culprits and one.total < ranked[0].total + CLEARLY]
    best = min(within, key=lambda one: len(one.culprits))
    gain = present.total - best.total
    if best.culprits == present.culprits and not best.changes:
        return None
    others = [one.total for one in ranked if not one.culprits >= best.culprits]
    is_clear = not others or min(others) - best.total >= CLEARLY
    names = list(used)
    is_explained = best.worst(names) <= max(EXPLAINED, SHARE_LEFT * present.worst(names))
    if present.excluded and present.excluded not in best.culprits and not present.motion > TELLING:
        # a sensor that had nothing to see has not shown that it is right
        return None
    is_again = before is not None and before.culprits == best.culprits
    return best if is_clear and is_explained and gain >= (AGAIN if is_again else ACCEPTED) else None


def _linear(parameters: WinchControllerParameters) -> WinchControllerParameters:
    """Return `parameters` whose model is linear in what is read: scale and lever arm of the MRU are known."""
    mru = replace(parameters.sensors.mru, scale_sigma=0.0, lever_arm_sigma=0.0)
    return replace(parameters, sensors=replace(parameters.sensors, mru=mru))
