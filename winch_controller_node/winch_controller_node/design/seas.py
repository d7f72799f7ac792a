"""Adaptation to the sea that is there: height and period of the boom tip's motion against those of the design.

Height alone scales the estimator's driving noise: no state changes its meaning, nothing jumps, and gains do not depend
on the height of a sea at all. Another period makes another design. Both are known from the motion reference unit alone,
through the estimated boom tip, from standby on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from heave_core.library import fill, library, new
from heave_core.sense_table import SEA_DESIGN, SEA_STATE
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import STANDARD_GRAVITY

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.feasibility import boom_tip_moments
from winch_controller_node.parameters.model import SeaModelParameters, VesselModelParameters

MEMORY = 600.0
"""Time constant of the running variances [s]: about 60 waves, a height good to 10 %."""

GROUP_MEMORY = 20.0
"""Time constant of the variance that sees a sea grow [s]: two waves."""

GROUP_SHARE = 0.8
"""A few waves may be so much lower than the group that they belong to."""

PATIENCE = 200.0
"""Time of observation before a sea may be assumed lower than at first [s]."""

STEP = 0.15
"""The noise is changed when the height has changed by this share since the last time."""

CONSTANTS = {
    "memory": MEMORY,
    "group_memory": GROUP_MEMORY,
    "group_share": GROUP_SHARE,
    "patience": PATIENCE,
    "step": STEP,
    "smallest": 0.05,  # beyond it the fault hypothesis is the sensor's, not the sea's
    "largest": 20.0,
    "innovation_memory": 5.0,
    "largest_nis": 30.0,
    "least_error": 0.01,  # a perfect instrument sees what no model has
    "least_heave": 0.03,  # noise has a period as well
}
"""Constants of the sea that is seen: meanings and units are in the core's table, SEA_DESIGN."""

FIRST_WAVES, JUDGED_AGAIN = 2.0, 1.3
"""Waves after which the period is judged for the first time, and by what factor more for the next."""

ASSUMED_WAVES = 2.0
"""Weight of the assumed period, in waves."""

REFUTED_WAVES = 0.3
"""Weight of the assumed period where the assumed sea is refuted, in waves."""

REFUTED = 3.0
"""Mean of the normalised innovations squared of the heave rate from which on the sea is refuted; it is 1 in its own."""

REFUTED_PERIOD = 3.0
"""Time from one judgement to the next while the sea is refuted [s]."""

LEAST_CHANGE = 0.1
"""Change of the period that is worth a design, relative."""

LONGEST = 2.5
"""Largest factor of the period that is concluded from the height alone."""

SCATTER = 0.9
"""Three standard deviations of the logarithm of the period as estimated from one wave, growing seas included."""

LIKELY = SCATTER / 3.0
"""One standard deviation of the logarithm of the period as estimated from one wave."""

PERIODS = (2.0, 30.0)
"""Peak periods that a sea may have [s]."""

LONGEST_SWELL = 40.0
"""Longest peak period of a swell [s]."""

LOWEST_WIND_SEA, HIGHEST, STEEPEST = 0.01, 25.0, 0.09
"""Range of the significant wave heights of a sea [m]; steepness 2 pi Hs / (g Tp^2) above which waves break."""


@dataclass(frozen=True)
class SeaSeen:
    """A sea as it was seen."""

    waves: float  # number of waves that were seen [-]
    heave: float  # standard deviation of the boom tip's heave [m]
    frequency: float  # mean frequency of the boom tip [rad/s]
    is_settled: bool = True  # it was seen for so long that it does not grow any more
    is_refuted: bool = False  # the sea of the design cannot be the one that is there


@dataclass(frozen=True)
class PossibleSeas:
    """Seas that may be there."""

    seen: SeaSeen  # what all of them must explain
    assumed: SeaModelParameters  # the sea assumed at first
    in_force: SeaModelParameters  # that of the design, as high as was seen
    # that assumed at first, as long and as high as was seen; None: the active one is as good
    stretched: SeaModelParameters | None
    # of which one part, swell or wind sea, is as assumed, and that move the boom tip as was seen
    parts: list[SeaModelParameters]

    @property
    def others(self) -> list[SeaModelParameters]:
        """All but the active one."""
        return [*([] if self.stretched is None else [self.stretched]), *self.parts]


def sea_design(design: ControllerDesign) -> dict[str, float]:
    """Return the values of the core's SeaDesign, of a `design`."""
    return {"variance": design.sigma["boom_tip_heave"] ** 2, **CONSTANTS}


class SeaTracker:
    """Running estimate of the boom-tip motion against that of the design, made by the core (sea.cpp).

    Parameters
    ----------
    design : what the ratios refer to
    record : array of one SeaSeen of the core that it goes by; None: it has its own
    """

    def __init__(self, design: ControllerDesign, record: Any = None) -> None:
        self._record, self._against = new(SEA_STATE) if record is None else record, new(SEA_DESIGN)
        self._at = self._against.ctypes.data, design.tick_period, self._record.ctypes.data
        self._core = library()
        self._update, self._note = self._core.heave_core_sea, self._core.heave_core_sea_innovation
        self._waves_judged = FIRST_WAVES / JUDGED_AGAIN
        self._core.heave_core_sea_begin(self._record.ctypes.data)
        self.refer_to(design)

    def refer_to(self, design: ControllerDesign) -> None:
        """Refer to another design from now on."""
        fill(self._against[0], sea_design(design))
        self._quiet = design.model.noise_covariance - design.sea_noise
        self._sea_noise = design.sea_noise
        self._record["applied"] = 1.0

    def update(self, heave: float, rate: float = 0.0) -> Array | None:
        """Take in the estimated heave [m] and heave rate [m/s] of the boom tip at a tick.

        Returns the covariance of the process noise to use from now on, shape (n, n), when the sea has changed enough;
        else None.
        """
        return self.noise if self._update(*self._at, heave, rate) else None

    @property
    def noise(self) -> Array:
        """Covariance of the process noise in the sea that is seen, shape (n, n)."""
        return np.asarray(self._quiet + float(self._record["applied"][0]) ** 2 * self._sea_noise)

    def newly_seen(self) -> SeaSeen | None:
        """Return the sea as seen so far, each time that twice as many waves have been seen; else None."""
        waves, record = self.waves, self._record[0]
        if waves == 0.0:
            return None
        is_due = waves >= JUDGED_AGAIN * self._waves_judged or record["since_judged"] >= MEMORY
        if not is_due and not (self.is_refuted and record["since_judged"] >= REFUTED_PERIOD):
            return None
        self._waves_judged = waves
        record["since_judged"] = 0.0
        is_settled = bool(record["seen"] >= PATIENCE)
        variance = float(record["variance"])
        heave = math.sqrt(variance if is_settled else max(variance, float(record["group_variance"])))
        frequency = math.sqrt(float(record["rate_variance"]) / variance)
        return SeaSeen(waves, heave, frequency, is_settled, self.is_refuted)

    def note_innovation(self, nis: float, sigma: float) -> None:
        """Take in a heave rate of the MRU: the normalised square of its innovation, `nis`, and its `sigma` [m/s]."""
        self._note(*self._at, nis, sigma)

    @property
    def is_refuted(self) -> bool:
        """Tell whether the sea of the design cannot be the one that is there: it predicts the heave rate badly."""
        return bool(self._record["mean_nis"][0] > REFUTED)

    @property
    def waves(self) -> float:
        """Waves in the fading memory; in a sea that has just grown only the last ones count."""
        return float(self._core.heave_core_sea_waves(self._at[0], self._at[2]))


def sigma_and_frequency(sea: SeaModelParameters, vessel: VesselModelParameters) -> tuple[float, float]:
    """Return standard deviation [m] and mean frequency [rad/s] of the boom tip of a `vessel` in a `sea`.

    They are those of its spectrum, not of a filter.
    """
    heave, rate, _ = boom_tip_moments(sea, vessel)
    return math.sqrt(heave), math.sqrt(rate / heave)


def sea_that_was_seen(
    seen: SeaSeen, assumed: SeaModelParameters, in_force: SeaModelParameters, vessel: VesselModelParameters
) -> SeaModelParameters | None:
    """Return the sea that moves the boom tip as was seen, or None where the active one is as good.

    All its periods and heights are those assumed at first times one factor each, so that wind sea and swell stay
    what they are to each other. A few waves carry little information: the assumed period counts for some waves as well.

    Parameters
    ----------
    seen : what was seen
    assumed, in_force : seas assumed at first, and of the active design
    vessel : assumed
    """
    weight = seen.waves / (seen.waves + (REFUTED_WAVES if seen.is_refuted else ASSUMED_WAVES))
    # a higher sea than assumed is most likely as steep, and so longer
    higher = max(seen.heave / sigma_and_frequency(assumed, vessel)[0], 1.0)
    expected = sigma_and_frequency(_changed(assumed, min(math.sqrt(higher), LONGEST), 1.0), vessel)[1]
    wanted = expected * (seen.frequency / expected) ** weight
    off = math.log(wanted / sigma_and_frequency(in_force, vessel)[1])
    if abs(off) < LEAST_CHANGE or (not seen.is_refuted and abs(off) < weight * SCATTER / math.sqrt(seen.waves)):
        return None
    return as_high_as_seen(_changed(assumed, _period_factor(wanted, assumed, _changed, vessel), 1.0), seen, vessel)


def possible_seas(
    seen: SeaSeen, assumed: SeaModelParameters, in_force: SeaModelParameters, vessel: VesselModelParameters
) -> PossibleSeas:
    """Return the seas that may be there; `seen`, `assumed`, `in_force`, `vessel` : see `sea_that_was_seen`."""
    stretched = sea_that_was_seen(seen, assumed, in_force, vessel)
    parts = _of_two_parts(seen, assumed, vessel)
    return PossibleSeas(seen, assumed, as_high_as_seen(in_force, seen, vessel), stretched, parts)


def neighbours(
    sea: SeaModelParameters, factor: float, seen: SeaSeen, vessel: VesselModelParameters
) -> list[SeaModelParameters]:
    """Return seas whose wind sea is a `factor` longer and shorter, and its cube higher and lower than beside the swell.

    Those whose mean frequency was not seen are none: a sea more regular than any model of it is predicted best by the
    longest of all.

    Parameters
    ----------
    sea, factor : the hypothesis, and its factor on all periods
    seen : what all of them must explain
    vessel : assumed
    """
    changes = [(factor, 1.0), (1.0 / factor, 1.0)]
    changes += [(1.0, factor**3), (1.0, factor**-3)] if _has_swell(sea) else []
    changed = [_changed_wind(sea, *change) for change in changes]
    likely = LIKELY / math.sqrt(seen.waves)
    return [
        as_high_as_seen(one, seen, vessel)
        for one in changed
        if abs(math.log(sigma_and_frequency(one, vessel)[1] / seen.frequency)) < likely
    ]


def distance(one: SeaModelParameters, other: SeaModelParameters) -> float:
    """Return the logarithms of the ratios of the periods of `one` and the `other` sea, of wind sea and swell, added."""
    off = abs(math.log(one.peak_period / other.peak_period))
    return off + (abs(math.log(one.swell.peak_period / other.swell.peak_period)) if _has_swell(one) else 0.0)


def as_high_as_seen(sea: SeaModelParameters, seen: SeaSeen, vessel: VesselModelParameters) -> SeaModelParameters:
    """Return a `sea` with the height that was `seen` of the boom tip of a `vessel`."""
    return _changed(sea, 1.0, seen.heave / sigma_and_frequency(sea, vessel)[0])


def no_lower_while_it_grows(sea: SeaModelParameters, seas: PossibleSeas) -> SeaModelParameters:
    """Return a `sea` of the possible `seas`, no lower than assumed at first while it may still grow."""
    if seas.seen.is_settled:
        return sea
    return _changed(sea, 1.0, max(seas.assumed.significant_wave_height / sea.significant_wave_height, 1.0))


def _of_two_parts(
    seen: SeaSeen, assumed: SeaModelParameters, vessel: VesselModelParameters
) -> list[SeaModelParameters]:
    """Return the seas that move the boom tip as was seen and of which one part, swell or wind sea, is as assumed."""
    if not _has_swell(assumed):
        return []
    wind_alone, swell_alone = _changed_swell(assumed, 1.0, 0.0), _changed_wind(assumed, 1.0, 0.0)
    found = []
    for changed, alone, kept in (
        (_changed_wind, wind_alone, swell_alone),
        (_changed_swell, swell_alone, wind_alone),
    ):
        heave, rate, _ = boom_tip_moments(kept, vessel)
        variance, rate_variance = seen.heave**2 - heave, (seen.heave * seen.frequency) ** 2 - rate
        if min(variance, rate_variance) <= 0.0:
            continue
        period = _period_factor(math.sqrt(rate_variance / variance), alone, changed, vessel)
        height = math.sqrt(variance) / sigma_and_frequency(changed(alone, period, 1.0), vessel)[0]
        found.append(changed(assumed, period, height))
    return found


Change = Callable[[SeaModelParameters, float, float], SeaModelParameters]
"""Returns a sea with factors of its periods and of its heights."""


def _has_swell(sea: SeaModelParameters) -> bool:
    return sea.spectrum == "ochi_hubble" and sea.swell.significant_wave_height > 0.0


def _changed_wind(sea: SeaModelParameters, period: float, height: float) -> SeaModelParameters:
    period = min(max(period * sea.peak_period, PERIODS[0]), PERIODS[1])
    highest = min(HIGHEST, STEEPEST * STANDARD_GRAVITY * period**2 / (2.0 * math.pi))
    height = min(max(height * sea.significant_wave_height, LOWEST_WIND_SEA), max(highest, sea.significant_wave_height))
    return replace(sea, significant_wave_height=height, peak_period=period)


def _changed_swell(sea: SeaModelParameters, period: float, height: float) -> SeaModelParameters:
    swell = sea.swell
    height = min(height * swell.significant_wave_height, HIGHEST)
    period = min(max(period * swell.peak_period, PERIODS[0]), LONGEST_SWELL)
    return replace(sea, swell=replace(swell, significant_wave_height=height, peak_period=period))


def _changed(sea: SeaModelParameters, period: float, height: float) -> SeaModelParameters:
    return _changed_wind(_changed_swell(sea, period, height), period, height)


def _period_factor(frequency: float, sea: SeaModelParameters, changed: Change, vessel: VesselModelParameters) -> float:
    """Return the factor of the periods of a `sea` as `changed` for a mean `frequency` of the boom tip [rad/s]."""
    low, high = (limit / sea.peak_period for limit in PERIODS)
    for _ in range(24):
        factor = math.sqrt(low * high)
        slower = sigma_and_frequency(changed(sea, factor, 1.0), vessel)[1] < frequency
        low, high = (low, factor) if slower else (factor, high)
    return factor
