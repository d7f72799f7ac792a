"""Beliefs: the assumed winch, sensors, cable and sea. The one home of what differs from nominal.

Nominal is what the parameters say (an operator's redesign is another nominal). `Beliefs` names what is assumed
otherwise, with the evidence, and brings the design for it. What it does not name is nominal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import NamedTuple

from heave_node.numerics.arrays import Array

from winch_controller_node.beliefs.quantities import (
    ACCELERATION_IN,
    ACCELERATION_OUT,
    DEPTH_SCALE,
    MRU_DELAY,
    MRU_OFFSET,
    MRU_SCALE,
    POWER_LIMIT,
    QUANTITIES,
    SPEED_IN,
    SPEED_OUT,
    with_value,
)
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.node_parameters import WinchControllerParameters

CAUTIOUS = 0.3
"""Authority while winch or sea are not known: they are predicted badly, or may as well be a sensor with an error."""

LATENCY = 1.0
"""Time from the observations of a tick until the answer is active [s]: in lockstep, campaigns and real time alike."""

USED = 0.97
"""Share that is used of a limit that was identified."""


class Belief(NamedTuple):
    """A quantity that is assumed to be other than nominal."""

    quantity: str  # name in `QUANTITIES`
    value: float  # in its unit
    sigma: float = math.nan  # standard deviation of the value, in its unit; NaN: not known
    nats: float = math.nan  # by how much likelier the record is than with the nominal value, price taken off [nats]
    since: int = 0  # tick since which it is so


class Finding(NamedTuple):
    """Something to be reported to a person; `report` turns it into a sentence."""

    code: str  # of the kind of finding, a row of its table
    quantity: str  # that it is about, or the owner alone ("depth", "cable")
    value: float = math.nan  # what was found, in its unit; NaN where there is no number
    unit: str = ""  # of the value
    nominal: float = math.nan  # what the parameters say, in its unit; NaN where there is no number
    nats: float = math.nan  # evidence [nats]
    since: int = 0  # tick


class Adopted(NamedTuple):
    """State of the loop as the adviser's filter has it under these beliefs; the core goes on from there."""

    tick: int  # to which it belongs
    estimate: Array  # of the states of the design, shape (n,)
    covariance: Array  # of that estimate, shape (n, n)


class EncoderScale(NamedTuple):
    """Scale of the encoder from a tick on: payout + (what it reads - reading) / scale."""

    since: int = 0  # tick
    scale: float = 1.0  # reading over payout [-]
    reading: float = 0.0  # one reading of the encoder [m]
    payout: float = 0.0  # payout that belongs to that reading [m]


@dataclass(frozen=True)
class Beliefs:
    """An answer of the adviser."""

    asked: int  # last tick of the observations that it answers; active from LATENCY later on
    number: int = 0  # grows with each answer that differs from the one before
    # assumed other than nominal, by quantity
    values: MappingProxyType[str, Belief] = field(default_factory=lambda: MappingProxyType({}))
    encoder: EncoderScale | None = None  # scale of the encoder, and from where on; None: it has always been nominal
    # sensor that is in use and contradicts all others: its readings are a cross-check only; empty: none
    excluded: str = ""
    authority: float = 1.0  # largest authority allowed with what is known [-]
    findings: tuple[Finding, ...] = ()  # new in this answer
    # for these beliefs; None: the active one stays (limits and gains of the winch need none)
    design: ControllerDesign | None = None
    adopted: Adopted | None = None  # None: the core carries its own estimate over

    def value(self, quantity: str, nominal: WinchControllerParameters) -> float:
        """Return the assumed value of a `quantity` whose `nominal` value the parameters say."""
        belief = self.values.get(quantity)
        return QUANTITIES[quantity].nominal_in(nominal) if belief is None else belief.value


def parameters_under(beliefs: Beliefs, nominal: WinchControllerParameters) -> WinchControllerParameters:
    """Return the parameters under `beliefs`: the `nominal` ones, with the assumed values in their place.

    Of a limit that was identified a little less is used, and the weaker direction counts.
    """
    parameters = nominal
    for name in beliefs.values:
        path = QUANTITIES[name].path
        if path and name not in LIMITS:
            parameters = with_value(parameters, path, beliefs.values[name].value)
    for names in LIMIT_GROUPS:
        identified = [beliefs.values[name].value for name in names if name in beliefs.values]
        if identified:
            parameters = with_value(parameters, QUANTITIES[names[0]].path, USED * min(identified))
    return parameters


def without_sea(beliefs: Beliefs) -> Beliefs:
    """Return `beliefs` with nothing but the nominal sea."""
    values = {name: belief for name, belief in beliefs.values.items() if QUANTITIES[name].owner != "sea"}
    return replace(beliefs, values=MappingProxyType(values), design=None, adopted=None)


LIMIT_GROUPS = ((SPEED_OUT, SPEED_IN), (ACCELERATION_OUT, ACCELERATION_IN), (POWER_LIMIT,))
"""Limits of the winch that are one parameter each; of two directions the weaker counts."""

LIMITS = tuple(name for group in LIMIT_GROUPS for name in group)


def latency_ticks(tick_period: float) -> int:
    """Return after how many ticks of `tick_period` [s] an answer is active: LATENCY, and two ticks at least.

    In the first the observations are on their way, in the second the answer.
    """
    return max(2, round(LATENCY / tick_period))


class Correction(NamedTuple):
    """What a sensor reads is taken as (reading - offset) / scale at its stamp less delay.

    A rate is taken without the offset.
    """

    scale: float = 1.0  # reading over truth [-]
    offset: float = 0.0  # of a reading [in its unit]
    delay: float = 0.0  # of its stamp behind the truth [s]


AS_READ = Correction()
"""Nothing is corrected."""


def corrections(beliefs: Beliefs, nominal: WinchControllerParameters) -> dict[str, Correction]:
    """Return the corrections of MRU and depth sensor under `beliefs` about the `nominal`, not of the encoder."""
    return {
        "mru": Correction(
            beliefs.value(MRU_SCALE, nominal), beliefs.value(MRU_OFFSET, nominal), beliefs.value(MRU_DELAY, nominal)
        ),
        "depth": Correction(beliefs.value(DEPTH_SCALE, nominal)),
    }
