"""Seas other than nominal: those there are and in which one lifts."""

from __future__ import annotations

import math

from heave_node.numerics.constants import STANDARD_GRAVITY

from tests.campaigns.draws.chance import Chance
from tests.campaigns.draws.deviation import BELIEF, Deviation, Nominal, Row

STEEPEST, FLATTEST = (8.0, 1.0 / 15.0), (15.0, 1.0 / 25.0)
"""Peak period [s] up to which, and from which on, a sea is at most so steep, 2 pi Hs / (g Tp^2): DNV-RP-C205, 3.5.5."""

HIGHEST, LOWEST = 4.5, 0.3
"""Significant wave heights in which one lifts, and below which nothing moves [m]."""


def highest(period: float) -> float:
    """Return the significant height [m] of the steepest sea of a peak `period` [s]."""
    (short, steep), (long, flat) = STEEPEST, FLATTEST
    share = min(max((period - short) / (long - short), 0.0), 1.0)
    return (steep + share * (flat - steep)) * STANDARD_GRAVITY * period**2 / (2.0 * math.pi)


def sea_of(chance: Chance) -> tuple[float, float]:
    """Return significant height [m] and peak period [s] of a sea that there is and in which one lifts."""
    period = chance.between(4.0, 16.0)
    return chance.spread(LOWEST, min(highest(period), HIGHEST)), period


def _other_sea(chance: Chance, _: Nominal) -> Deviation:
    height, period = sea_of(chance)
    values = {"significant_wave_height": height, "peak_period": period}
    return Deviation(
        "",
        {f"wave_vessel.{name}": value for name, value in values.items()},
        {f"{BELIEF}.sea.{name}": value for name, value in values.items()},
    )


def _swell(chance: Chance, nominal: Nominal) -> Deviation:
    """Draw a swell beside the wind sea of the scenario."""
    values = {
        "spectrum": "ochi_hubble",
        "significant_wave_height": nominal.height,
        "peak_period": nominal.period,
        "swell.significant_wave_height": chance.between(0.5, 2.0),
        "swell.peak_period": chance.between(max(11.0, 1.3 * nominal.period), 19.0),
    }
    told = {f"{BELIEF}.sea.{name}": value for name, value in values.items()}
    return Deviation(
        "",
        {f"wave_vessel.{name}": value for name, value in values.items()},
        {**told, f"{BELIEF}.sea.filter_states": 10},
    )


def _peaked(chance: Chance, nominal: Nominal) -> Deviation:
    if nominal.has_swell:
        return _swell(chance, nominal)
    values = {"spectrum": "jonswap", "peak_enhancement": chance.between(2.0, 7.0)}
    return Deviation(
        "",
        {f"wave_vessel.{name}": value for name, value in values.items()},
        {f"{BELIEF}.sea.{name}": value for name, value in values.items()},
    )


SEAS = (
    Row("sea", (), _other_sea, slot="sea", weight=3.0),
    Row("swell beside", (), _swell, slot="sea"),
    Row("peaked sea", (), _peaked, slot="sea", weight=0.5),
)
"""Seas other than nominal; none is a reason to blame anything."""
