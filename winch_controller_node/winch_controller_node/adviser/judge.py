"""The judge: which sensor, or the cable, differs from what is assumed, by the likelihood of one record.

A hypothesis is a correction of what one sensor has read, another model, or both; each thing that it holds otherwise
than nominal has its price in nats, see `hypothesis`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from winch_controller_node.adviser.columns import DELAY, FACTOR, JUDGED, ONSETS, STEP, Columns, in_columns
from winch_controller_node.adviser.evidence import FACTORS, Fitted, evidence
from winch_controller_node.adviser.filter_pass import SETTLING, PassModel, PassResult, linear, pass_model, run_pass
from winch_controller_node.adviser.hypothesis import (
    DAMPING,
    DRIFT,
    DRIFT_SIGMA,
    HIGH_PASS,
    INERTIA,
    ONSET,
    REFINEMENTS,
    SAME,
    SEA,
    TELLING,
    TOLERANCE,
    TRIED,
    Assumed,
    Change,
    Hypothesis,
)
from winch_controller_node.adviser.record import TICK, Excerpt
from winch_controller_node.beliefs.quantities import ENCODER_SCALE, QUANTITIES, out_of_range, with_value
from winch_controller_node.design.design import measurement_models

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

ENCODER_ROW = "payout"
"""Measurement of the encoder, not judged here: the winch is identified by it, and it is right where that is not."""

LEAST_READ = 10
"""Seconds in which a sensor must have been read for a correction of it, or its acquittal."""


class Judge:
    """Judges a record.

    Parameters
    ----------
    excerpt : the last minute
    assumed : the beliefs so far
    onsets : times before its end from which on something may be wrong [s]
    """

    def __init__(self, excerpt: Excerpt, assumed: Assumed, onsets: tuple[float, ...] = ONSETS) -> None:
        self._assumed = assumed
        self._parameters = linear(assumed.parameters)
        plain, model = pass_model(self._parameters, assumed.cable, assumed.design)
        measurements = measurement_models(self._parameters, model, assumed.cable)
        self.used = tuple(known.name for known in measurements)  # measurements that are judged
        self._sensors = tuple(known.sensor for known in measurements)
        self._excerpt = excerpt.of(self.used)
        self._measurements, self._onsets = measurements, onsets
        self._alone = in_columns(self._excerpt, measurements, assumed.history, judged={}).data
        self._first_judged = excerpt.first + round(SETTLING / excerpt.dt)
        self._late = self._excerpt.readings[:, TICK] >= self._first_judged
        seconds = np.floor(self._excerpt.readings[:, TICK] * excerpt.dt)
        self._read_for = {
            sensor: len(np.unique(seconds[self._late & self._excerpt.is_of(sensor)])) for sensor in self._sensors
        }
        result = run_pass(plain, self._alone, self._taken_without(assumed.excluded))
        self._shows_unit = self._unit_is_shown(result)
        self.present = self._hypotheses({}, assumed.excluded, [], plain, result)[0]  # the present beliefs, judged

    @cached_property
    def _columns(self) -> Columns:
        """The record with the columns of all that may be corrected."""
        return in_columns(self._excerpt, self._measurements, self._assumed.history, self._onsets)

    def _taken_without(self, excluded: str) -> NDArray[np.bool_]:
        """Tell of each measurement whether the filter takes it where a sensor is `excluded`."""
        return np.array([sensor != excluded for sensor in self._sensors])

    def _unit_is_shown(self, result: PassResult) -> bool:
        """Tell whether the unit has moved by more than the noise of the depth sensor, as it reads or as is expected.

        One that is held still says nothing of the cable, nor of the sensor that sees it.
        """
        moved = self._motions("depth", result)
        return moved is None or max(moved) > TELLING

    def _motions(self, sensor: str, result: PassResult) -> tuple[float, float] | None:
        """Return how far a `sensor` saw move what it reads, and should have, over its noise; None: it was not read."""
        data = self._alone
        mine = np.array([known == sensor for known in self._sensors])[data.which] & self._late
        if not np.any(mine):
            return None
        read = data.values[mine, 0]
        expected = read - result.innovations[mine, 0] * np.sqrt(result.variances[mine])
        noise = np.sqrt(np.mean(data.variances[mine]))
        return float(np.std(read) / noise), float(np.std(expected) / noise)

    # what is asked

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
            (INERTIA, tuple(self._assumed.value(INERTIA) * factor for factor in TRIED[INERTIA]), 1),
            (DAMPING, tuple(self._assumed.value(DAMPING) * factor for factor in TRIED[DAMPING]), 3),
        ]
        uses_mru = "mru" in self._sensors and self._assumed.excluded != "mru"
        if uses_mru:
            families.append((HIGH_PASS, TRIED[HIGH_PASS], 1))
        for quantity, values, power in families:
            found += self._of_family(quantity, values, power)
        stated = {name: QUANTITIES[name].nominal_in(self._assumed.nominal) for name in SEA}
        if any(name in self._assumed.values for name in SEA):
            found += self._of_model(stated, self._assumed.excluded, since=self._excerpt.first)
        if uses_mru:
            for drift in TRIED[DRIFT]:
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
            if value != assumed and value not in tried and not out_of_range({quantity: value}, self._assumed.nominal):
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
        keys = self._keys(excluded, since) if corrections else []
        data = self._alone
        if keys:
            data = self._columns.data.among(np.array([0, *(self._columns.index[key] for key in keys)]))
        return self._hypotheses(values, excluded, keys, model, run_pass(model, data, self._taken_without(excluded)))

    def _keys(self, excluded: str, since: int | None) -> list[tuple[str, str, int]]:
        """Return the columns of corrections that may be tried with a sensor left out, from an onset or from any."""
        keys = [key for key in self._columns.index if key[0] != excluded and since in (None, key[2])]
        keys = [key for key in keys if self._read_for[key[0]] >= LEAST_READ and (key[0] != "depth" or self._shows_unit)]
        if any(one.since > self._excerpt.first for one in self._assumed.history.encoder):
            # it has changed within the record, and from then on it is known
            keys = [key for key in keys if key[0] != "encoder"]
        return keys

    def _hypotheses(
        self,
        values: Mapping[str, float],
        excluded: str,
        keys: Sequence[tuple[str, str, int]],
        model: PassModel,
        result: PassResult,
    ) -> list[Hypothesis]:
        """Return what a pass of a `model` says: plain, and with the correction of each column of `keys`."""
        late, which = self._late, self._alone.which
        which = np.where(np.array(self.used)[which] == ENCODER_ROW, -1, which)
        seconds = np.floor(self._excerpt.readings[late, TICK] * self._excerpt.dt)
        proof = evidence(result.innovations[late], result.variances[late], which[late], len(self.used), seconds)
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
        quantity, weight, sigma = JUDGED[sensor][kind], fitted.weight, fitted.sigma
        assumed, nominal = self._assumed.value(quantity), QUANTITIES[quantity].nominal
        if kind == FACTOR:
            # one outside its range is found as well: the sensor is then excluded
            value = assumed / (1.0 + weight) if abs(1.0 + weight) > LEAST_FACTOR else math.inf
        elif kind == STEP:
            value = assumed - weight
        else:
            value, sigma = assumed + weight * self._excerpt.dt, sigma * self._excerpt.dt
        if not math.isfinite(value) or (kind != FACTOR and out_of_range({quantity: value}, self._assumed.nominal)):
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
            for name, sensor, misfit in zip(self.used, self._sensors, fitted.misfits, strict=True)
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
        moved = self._motions(excluded, result)
        return math.nan if moved is None or self._read_for[excluded] < LEAST_READ else moved[1]
