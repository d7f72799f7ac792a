"""What may be held of sensors, cable and sea, what that costs, and when it is accepted.

One rule accepts: enough nats better than the present beliefs, at once or twice running, clearly better than with any
other culprit, and the record explained.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from heave_node.numerics.arrays import Array

from winch_controller_node.adviser.record import SENSOR_OF, SensorHistory
from winch_controller_node.beliefs.quantities import (
    DEPTH_SCALE,
    ENCODER_SCALE,
    MRU_DELAY,
    MRU_OFFSET,
    MRU_SCALE,
    QUANTITIES,
)
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.model.blocks import CableModel
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

SCALES = (MRU_SCALE, ENCODER_SCALE, DEPTH_SCALE)

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
"""Lead over the beliefs with which a hypothesis is accepted [nats]: at once, or as the best of two looks running."""

CLEARLY = 5.0
"""Lead over the best hypothesis with another culprit that acceptance requires [nats]."""

EXPLAINED, SHARE_LEFT = 4.0, 0.25
"""Largest mean squared normalised innovation of a sensor that is used under what is accepted, or share of before."""

MISFIT = 1.8
"""That above which hypotheses are tried. A damping has to leave less: a motion that is predicted wrongly is predicted
better by less of it, whatever is wrong."""

ENLARGING = {MRU_SCALE: -1.0, ENCODER_SCALE: -1.0, DEPTH_SCALE: -1.0, MRU_DELAY: 1.0}
"""Direction, up or down from nominal, in which a correction of a sensor makes orders larger."""

WITNESSED = 1.2
"""A correction that makes orders larger is accepted where another sensor is so many times nearer to its prediction
under it, mean square; and nothing is where one is so much further."""

TELLING = 3.0
"""Motion over the noise of a sensor that was left out, 1 sigma, in which it shows that it is right."""

TOLERANCE = {MRU_SCALE: 0.02, ENCODER_SCALE: 0.02, DEPTH_SCALE: 0.02, MRU_OFFSET: 0.03, MRU_DELAY: 0.02}
"""Difference from nominal below which a value counts as nominal, in its unit."""

TRIED = {
    INERTIA: (0.7, 0.85, 1.2, 1.45),
    DAMPING: (0.25, 4.0),
    HIGH_PASS: (100.0, 60.0, 40.0, 30.0, 22.0, 16.0),
    DRIFT: (0.005, 0.015),
}
"""Values of a model that are tried first: factors, cut-off periods [s], random walks [m/sqrt(s)]."""

REFINEMENTS = (1.12, 1.05)
"""Factors, up and down, by which the best of them is refined; damping by their cubes."""

SAME = 0.02
"""Values of a model of which the logarithms differ by less are one."""


class Change(NamedTuple):
    """A quantity and the value that a hypothesis gives it."""

    value: float  # in its unit
    sigma: float  # standard deviation, in its unit
    since: int  # first tick that shows it


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """What is held, and how well it explains the record."""

    changes: Mapping[str, Change]  # against the present beliefs, by quantity
    excluded: str  # sensor that is left out; empty: none
    loss: float  # of the record [nats]
    price: float  # of all that is held other than nominal [nats]
    misfits: Mapping[str, float]  # mean squared normalised innovation by measurement
    state: Array = field(repr=False)  # at the end of the record
    covariance: Array = field(repr=False)  # of that state
    state_names: tuple[str, ...] = field(repr=False)  # names of its components
    # that the sensor which is left out should have read over its noise, 1 sigma [-]; NaN: none is
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
    """What a judgement begins with."""

    nominal: WinchControllerParameters  # parameters
    parameters: WinchControllerParameters  # under the present beliefs
    cable: CableModel  # two-state cable of the length that is out, under the present beliefs
    design: ControllerDesign  # the active one: states at the start are as uncertain as its
    values: Mapping[str, float]  # assumed other than nominal, by quantity
    history: SensorHistory  # of the sensors
    excluded: str = ""  # sensor that is left out; empty: none
    # of the winch by the encoder as it reads, over its nominal one [-]; a gain counts as assumed as it is near to
    # nominal
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


def accepted(
    ranked: list[Hypothesis], present: Hypothesis, before: Hypothesis | None, used: Collection[str]
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
    # what speaks for a culprit is what it explains beyond those that are held already, or are acquitted
    held = [one.total for one in ranked if one is not best and one.culprits <= present.culprits]
    gain = min([present.total, *held]) - best.total
    if best.culprits == present.culprits and not best.changes:
        return None
    others = [one.total for one in ranked if not one.culprits >= best.culprits]
    is_clear = not others or min(others) - best.total >= CLEARLY
    news = best.culprits - present.culprits
    # two things at once are seldom, and leave nothing for a third
    left = EXPLAINED if len(news) > 1 else max(EXPLAINED, SHARE_LEFT * present.worst(used))
    is_explained = best.worst(used) <= (MISFIT if DAMPING in best.changes else left) and not worsens(best, present)
    if present.excluded and present.excluded not in best.culprits and not present.motion > TELLING:
        # a sensor that had nothing to see has not shown that it is right
        return None
    is_again = before is not None and before.culprits == best.culprits
    needed = (AGAIN if is_again else ACCEPTED) * max(1, len(news))
    return best if is_clear and is_explained and gain >= needed and is_witnessed(best, present) else None


def worsens(found: Hypothesis, present: Hypothesis) -> bool:
    """Return whether a sensor is further from its prediction under what was `found` than under the `present`."""
    rows = present.misfits.keys() & found.misfits.keys()
    # a delay is made up for by a slope alone, which leaves something
    allowed = math.inf if MRU_DELAY in found.changes else WITNESSED
    return any(found.misfits[row] > allowed * max(present.misfits[row], 1.0) for row in rows)


def is_witnessed(found: Hypothesis, present: Hypothesis) -> bool:
    """Return whether a second sensor speaks for what was `found` and not for the `present`, if orders become larger."""
    larger = {
        QUANTITIES[name].owner
        for name, change in found.changes.items()
        if ENLARGING.get(name, 0.0) * (change.value - QUANTITIES[name].nominal) > 0.0
    }
    return not larger or any(
        SENSOR_OF[row] not in larger and max(present.misfits[row], 1.0) > WITNESSED * max(misfit, 1.0)
        for row, misfit in found.misfits.items()
        if row in present.misfits
    )


def rules_out_encoder(ranked: list[Hypothesis]) -> bool:
    """Return whether the encoder's scale is as assumed: the best of `ranked` with another is worse."""
    with_it = [one.total for one in ranked if "encoder" in one.culprits]
    without = [one.total for one in ranked if "encoder" not in one.culprits]
    return min(with_it, default=math.inf) >= min(without) + CLEARLY
