"""What a figure of a ship, a sea or a cable can plausibly be: one table, which every reader of files asks.

A figure beyond its range is not proved to be wrong, but a wrong unit, a fill value or a wrong column is far more
likely. A reader refuses it, with the likely cause, unless the user accepts it.

>>> question("significant wave height", 2625.0)
'significant wave height is 2625 m, plausible is 0 to 25 m: a fill value such as -9999, or centimetres?'
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from heave_node.numerics.constants import STANDARD_GRAVITY


@dataclass(frozen=True)
class Plausible:
    """The range of a quantity, ends included."""

    unit: str  # of the ends
    least: float  # lower end of the range, in `unit`
    most: float  # upper end of the range, in `unit`
    above: str  # likely cause of a larger figure
    below: str = "another unit?"  # likely cause of a smaller figure


def _size(unit: str, most: float, above: str) -> Plausible:
    """Return the range of a size, which has no least value but 0."""
    return Plausible(unit, 0.0, most, above)


_LENGTH_CAUSE = "a fill value such as 99 or -9999, or centimetres or millimetres?"

PLAUSIBLE: Mapping[str, Plausible] = {
    # the highest significant wave height that a buoy has measured is 19 m (World Meteorological Organization, 2013)
    "significant wave height": _size("m", 25.0, "a fill value such as -9999, or centimetres?"),
    "peak period": Plausible("s", 1.0, 40.0, "frequencies in another unit?", "frequencies in rad/s?"),
    # waves break: 2 pi Hs/(g Tz^2) is at most 1/10 (DNV-RP-C205, 3.5.5), and half as much again for what is uncertain
    "significant steepness": _size(
        "",
        0.15,
        "directions or r1, r2 in the form of densities, densities in another unit, frequencies in rad/s, or time in "
        "another unit?",
    ),
    "heave": _size("m", 30.0, _LENGTH_CAUSE),
    "four standard deviations of heave": _size("m", 25.0, _LENGTH_CAUSE),
    "roll": _size("rad", 1.2, "degrees, or a fill value?"),
    "pitch": _size("rad", 1.2, "degrees, or a fill value?"),
    "mean vertical acceleration": Plausible("m/s^2", -20.0, 20.0, "mm/s^2?"),
    "heave over the integral of heave rate": Plausible("", 0.5, 2.0, "another unit?", "another unit, or sign?"),
    "payout over the integral of payout rate": Plausible("", 0.5, 2.0, "another unit?", "another unit, or sign?"),
    "depth by pressure over the cable that is out": Plausible("", 0.05, 1.2, "another unit?"),
    # half of it by a load cell in one of two falls
    "tension over the weight of cable and unit": Plausible("", 0.4, 2.0, "another unit?", "another unit, or tared?"),
    "sample interval": Plausible("s", 2e-4, 2.0, "milliseconds?", "days, or microseconds?"),
    # of response amplitude operators: in long waves a ship follows the surface
    "heave in long waves": Plausible(
        "m/m", 0.2, 5.0, "millimetres or centimetres?", "columns exchanged, or kilometres?"
    ),
    "surge response": _size("m/m", 50.0, "millimetres?"),
    "sway response": _size("m/m", 50.0, "millimetres?"),
    "heave response": _size("m/m", 10.0, "millimetres or centimetres?"),
    "roll response": _size("rad/m", 1.0, "degrees?"),
    "pitch response": _size("rad/m", 0.5, "degrees?"),
    "yaw response": _size("rad/m", 5.0, "degrees?"),
    "phase": Plausible("rad", -4.0 * math.pi, 4.0 * math.pi, "degrees?", "degrees?"),
    "lowest wave frequency": _size("rad/s", 1.5, "periods, or columns exchanged?"),
    "highest wave frequency": Plausible("rad/s", 0.8, 12.0, "periods, or degrees per second?", "hertz?"),
}
"""Range of each quantity."""


def is_plausible(quantity: str, value: float) -> bool:
    """Return whether a `value` of a `quantity` of PLAUSIBLE is in its range; NaN is not."""
    known = PLAUSIBLE[quantity]
    return known.least <= value <= known.most


def question(quantity: str, value: float, where: str = "") -> str:
    """Return what is implausible about a figure, in one line; "" where it is plausible.

    Parameters
    ----------
    quantity : name in PLAUSIBLE
    value : in its unit
    where : opens the line, such as a column and a line
    """
    if is_plausible(quantity, value):
        return ""
    known = PLAUSIBLE[quantity]
    unit = f" {known.unit}" if known.unit else ""
    cause = known.below if value < known.least else known.above
    place = f"{where}: " if where else ""
    return f"{place}{quantity} is {value:.4g}{unit}, plausible is {known.least:g} to {known.most:.4g}{unit}: {cause}"


def sea_question(significant_wave_height: float, zero_crossing_period: float, peak_period: float) -> str:
    """Return what is implausible about a sea, in one line; "" where it is plausible.

    Parameters
    ----------
    significant_wave_height : [m]
    zero_crossing_period, peak_period : [s]
    """
    steepness = 2.0 * math.pi * significant_wave_height / (STANDARD_GRAVITY * zero_crossing_period**2)
    steep = f"significant wave height {significant_wave_height:.3g} m at a zero-crossing period of "
    return (
        question("significant wave height", significant_wave_height)
        or question("significant steepness", steepness, f"{steep}{zero_crossing_period:.3g} s")
        or question("peak period", peak_period)
    )


HIGHEST_OF_LENGTH = 0.142
"""Largest height of a wave in deep water as a share of its length, Michell's limit (DNV-RP-C205, 3.4.6)."""


def breaking_words(significant_wave_height: float, peak_period: float) -> str:
    """Return in words that a sea cannot be, as a single wave of its peak would break; "" where it can.

    Many waves of a sea are higher than its significant wave height, so the limit is generous.

    Parameters
    ----------
    significant_wave_height : [m]
    peak_period : [s], above 0
    """
    least = math.sqrt(2.0 * math.pi * significant_wave_height / (STANDARD_GRAVITY * HIGHEST_OF_LENGTH))
    if peak_period >= least:
        return ""
    least = math.ceil(10.0 * least) / 10.0
    return (
        f"waves this steep break: a height of {significant_wave_height:g} m needs a peak period of {least:.1f} s or "
        f"more, got {peak_period:g} s"
    )


def refusal(questions: Sequence[str], option: str) -> str:
    """Return the one line with which a reader refuses implausible figures.

    Parameters
    ----------
    questions : of `question`, one or more
    option : with which the user accepts them
    """
    more = f" (and {len(questions) - 1} more such figures)" if len(questions) > 1 else ""
    return f"{questions[0]}{more} {option} takes the figures as they are"


ACCEPT = "--set system.accept_implausible=true"
"""Option that takes them as they are; see `heave_node.files.plausible`."""
