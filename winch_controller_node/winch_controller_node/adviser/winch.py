"""Identification of the winch: the drum's record against the assumed winch, second by second."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from heave_core.watch import Drum
from heave_node.numerics.arrays import Array

from winch_controller_node.adviser.drum.drum_fit import (
    ACCELERATION_IN,
    ACCELERATION_OUT,
    DELAY,
    FLOOR,
    GAIN,
    LAG,
    LIMITS,
    SPEED_IN,
    SPEED_OUT,
    DrumFit,
    fit_drum,
    prior_of,
)
from winch_controller_node.adviser.drum.drum_record import FACTOR, FIELDS, drum_record
from winch_controller_node.adviser.drum.drum_search import PRICES, begun, identify, needs, price_of, shown_limits
from winch_controller_node.adviser.hypothesis import SHARE_LEFT
from winch_controller_node.adviser.record import Excerpt, SensorHistory
from winch_controller_node.beliefs.beliefs import Belief
from winch_controller_node.beliefs.drum import QUANTITY_OF, drum_of
from winch_controller_node.node_parameters import WinchControllerParameters

SHORTEST = 4.0
"""Record [s] from which on the winch is identified."""

TURNS_WITHIN = 2.0
"""A drum that has not turned for so long says nothing of how it turns: it may be its encoder that stands [s]."""

WORTH = 6.0
"""Least gain in likelihood of a new model of the winch over the present one [nats]."""

EXPLAINED = 6e-3
"""A record of which no more is left is explained [m]; where more is, and no such share of before, nothing is learnt."""

STEPS = {
    "lag": 0.008,
    "delay": 0.008,
    "gain": 0.015,
    "hauling": 0.015,
    "creep": 1e-3,
    "deadband": 3e-3,
    "backlash": 1e-3,
}
"""Least changes that are worth it; of gains and limits relative."""

LIMIT_STEP = 0.03
"""Least change of a limit that is worth it, and first step by which one that no record needs is raised, relative."""

OTHER_DIRECTION = {
    SPEED_OUT: SPEED_IN,
    SPEED_IN: SPEED_OUT,
    ACCELERATION_OUT: ACCELERATION_IN,
    ACCELERATION_IN: ACCELERATION_OUT,
}
"""Limits that are alike in most winches."""

PATIENCE = 60.0
"""Time for which a limit that is not reached and that no record needs stands before it is raised [s]."""

LONGEST_WAIT = 16
"""Most by which that time grows: it doubles each time when the limit is found again."""

OFF = 2e-3
"""Residual under the present beliefs [m]; a record that leaves less is evaluated every CHECKED seconds only."""

CHECKED = 5
"""Seconds from one look to the next, of a record that is near to its prediction; at the sensors as well."""


@dataclass(frozen=True)
class WinchAnswer:
    """What a look at the drum has found."""

    # beliefs by quantity; empty: the present beliefs are as good
    changed: Mapping[str, Belief] = field(default_factory=dict)
    nominal: frozenset[str] = frozenset()  # quantities that are as nominal again
    # tick since which the encoder reads otherwise, its factor on its assumed scale, the standard deviation of that, and
    # by how much it has jumped there [m]; None: as assumed
    factor: tuple[int, float, float, float] | None = None
    gain: float = 1.0  # of the drum by the encoder's assumed scale, over the nominal one [-]
    nats: float = 0.0  # by how much better the record is explained [nats]


@dataclass
class LimitProbe:
    """When a limit that no record needs is raised, and by how much: false and past ones heal so.

    The controller keeps below the limit that it assumes, and so never learns that it is gone. Where the drum has been
    at it and the record does as well without, each step is twice the last one.
    """

    step: float = LIMIT_STEP  # by which it is raised next, relative [-]
    wait: int = 1  # times the usual time for which it stands first
    _stood: float = 0.0
    _is_raised: bool = False

    def factor(self, elapsed: float, patience: float, *, is_needed: bool, is_reached: bool) -> float:
        """Return the factor on the limit after a record; 1: it stands.

        Parameters
        ----------
        elapsed : since the last record [s]
        patience : usual time for which it stands [s]
        is_needed : the record is explained worse without it
        is_reached : the drum has been at it
        """
        if is_needed:
            self.wait = min(2 * self.wait, LONGEST_WAIT) if self._is_raised else self.wait
            self.step, self._stood, self._is_raised = LIMIT_STEP, 0.0, False
            return 1.0
        self._stood += elapsed
        if self._stood < self.wait * patience:
            return 1.0
        raised = 1.0 + (self.step if is_reached else LIMIT_STEP)
        self.step = 2.0 * self.step if is_reached else self.step
        self._stood, self._is_raised = 0.0, True
        return raised


class WinchIdentifier:
    """Identifies the winch.

    Parameters
    ----------
    parameters : nominal
    tick_period : [s]
    """

    def __init__(self, parameters: WinchControllerParameters, tick_period: float) -> None:
        self._dt = tick_period
        self._winch, self._lag = parameters.winch, parameters.lag
        self._prior = prior_of(parameters)
        self._ahead = math.ceil((parameters.winch.command_delay + parameters.lag.largest) / tick_period) + 3
        self._looks = 0
        self._probes = {index: LimitProbe() for index in LIMITS}
        self._last_look = 0

    @property
    def length(self) -> float:
        """Record that is needed [s]."""
        return self._lag.window + self._ahead * self._dt + 2.0

    def look(self, excerpt: Excerpt, history: SensorHistory, assumed: Mapping[str, float]) -> WinchAnswer | None:
        """Return what the last seconds say of the winch; None: too little.

        `excerpt` is of `length`, or what there is; `history` has the encoder's assumed scales over the record,
        `assumed` is the winch by quantity.
        """
        record = drum_record(excerpt, self._lag.window, self._ahead, history, self._winch.position_gain)
        if record is None or record.duration < SHORTEST or record.duration < 0.5 * len(record.readings) * self._dt:
            return None
        if not math.isfinite(record.readings[-1]):
            # an encoder that is lost, or has just jumped, says nothing of the drum
            return None
        newest = record.readings[-round(TURNS_WITHIN / self._dt) :]
        newest = newest[np.isfinite(newest)]
        if len(newest) == 0 or np.ptp(newest) <= FLOOR:
            return None
        held = np.array([*drum_of(self._winch, assumed), 1.0])
        self._looks += 1
        enough = OFF if self._looks % CHECKED else 0.0
        present = fit_drum(record, self._prior, begun(record, held), (), enough=enough)
        if present.residual < enough:
            return None
        found = identify(record, self._prior, held)
        if not np.all(np.isfinite(found.theta)):
            return None
        return self._answer(present, found, held, excerpt)

    def _answer(self, present: DrumFit, found: DrumFit, held: Array, excerpt: Excerpt) -> WinchAnswer:
        gain = float(found.theta[GAIN] / self._prior.nominal[GAIN])
        is_explained = found.residual <= max(EXPLAINED, SHARE_LEFT * present.residual)
        # at the end of what can be, alone or with a gain that was not there before, it is no scale but another fault
        factor, prior = float(found.theta[FACTOR]), self._prior
        reads = factor, factor * found.theta[GAIN] / held[GAIN]
        is_scale = all(prior.lowest[FACTOR] < one < prior.highest[FACTOR] for one in reads)
        if FACTOR in found.free and not (is_scale and is_explained):
            return WinchAnswer(gain=gain)
        if FACTOR in found.free:
            tick = excerpt.last + 1 - (len(found.record.readings) - found.record.onset)
            nats = present.loss - found.loss - PRICES[(FACTOR,)]
            return WinchAnswer(
                factor=(tick, factor, self._sigma(found, FACTOR), found.record.step(found.theta)),
                gain=gain,
                nats=nats,
            )
        new = {i for i in found.free if held[i] == self._prior.nominal[i]}
        nats = present.loss - found.loss - price_of(new)
        values = self._worth_it(held, found)
        values |= self._raised(found, held, excerpt.last)
        is_better = nats >= WORTH and is_explained
        values = values if is_better else {i: value for i, value in values.items() if i in self._let_up}
        alike = self._alike(values, held, found)
        values |= alike
        changed = {
            QUANTITY_OF[Drum._fields[i]]: Belief(
                QUANTITY_OF[Drum._fields[i]],
                value,
                self._sigma(found, i),
                0.0 if i in alike or i in self._let_up else nats,  # assumed, or on trial: no record says so
                excerpt.last,
            )
            for i, value in values.items()
            if value != self._prior.nominal[i]
        }
        nominal = frozenset(QUANTITY_OF[Drum._fields[i]] for i, v in values.items() if v == self._prior.nominal[i])
        return WinchAnswer(changed, nominal, None, gain, nats)

    @staticmethod
    def _sigma(found: DrumFit, index: int) -> float:
        return float(found.sigmas[found.free.index(index)]) if index in found.free else math.nan

    def _worth_it(self, held: Array, found: DrumFit) -> dict[int, float]:
        """Return what is found and differs enough from what is held, by field."""
        values = {}
        for index in found.free:
            value, before = float(found.theta[index]), float(held[index])
            name = Drum._fields[index] if index < FIELDS else ""
            step = LIMIT_STEP * before if index in LIMITS else STEPS[name] * (before if "gain" in name else 1.0)
            if abs(value - before) < step:
                continue
            values[index] = value
        lags = {LAG, DELAY} & set(values)
        if lags:
            # servo and delay make up for one another: they go together
            values |= {index: float(found.theta[index]) for index in (LAG, DELAY)}
        # a limit that was held and is not needed any more
        for index in LIMITS:
            if index in found.free or held[index] >= self._prior.nominal[index]:
                continue
            if found.theta[index] != held[index]:
                values[index] = float(found.theta[index])
        return values

    def _alike(self, values: Mapping[int, float], held: Array, found: DrumFit) -> dict[int, float]:
        """Return limits of the other direction, as yet unknown: most winches have the same."""
        shown, assumed = shown_limits(found.record), {}
        for index, other in OTHER_DIRECTION.items():
            value = values.get(index, self._prior.nominal[index])
            is_unknown = other not in values and held[other] == self._prior.nominal[other]
            if value < held[index] and is_unknown and shown[other] < value:
                assumed[other] = min(value, float(self._prior.nominal[other]))
        return assumed

    def _raised(self, found: DrumFit, held: Array, tick: int) -> dict[int, float]:
        """Return limits that no record has needed for long, a little higher."""
        self._let_up: set[int] = set()
        shown, values = shown_limits(found.record), {}
        elapsed, self._last_look = min((tick - self._last_look) * self._dt, float(CHECKED)), tick
        for index in LIMITS:
            if held[index] >= self._prior.nominal[index]:
                self._probes[index] = LimitProbe()
                continue
            is_reached = shown[index] > (1.0 - 2.0 * LIMIT_STEP) * held[index]
            factor = self._probes[index].factor(
                elapsed,
                self._lag.window if is_reached else PATIENCE,
                is_needed=needs(self._prior, found, index),
                is_reached=is_reached,
            )
            if factor > 1.0:
                self._let_up.add(index)
                values[index] = min(factor * float(held[index]), float(self._prior.nominal[index]))
        return values
