"""Effective mass and drag area of the load from a record of sensors: the reverse problem of thesis 6.4.

The search of `whatif.identify` on the nominal cable, with wide priors on the load: depth and load cell of the record
judge what boom tip (MRU) and payout (encoder) make of each load, with slack and quadratic drag. Stiffness and drag of
the cable, scale and delay of the MRU have their usual priors, so that the bands allow for them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from cable_sim_node.vertical.axial_line import AxialLine
from cable_sim_node.vertical.axial_stepper import AxialError
from heave_node.numerics.arrays import Array, ComplexArray
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.identification import Fitted, IdentificationError
from heave_studies.whatif.answer import tip_source
from heave_studies.whatif.identify import (
    BEGINS,
    BEST,
    CABLE_DRAG,
    DAMPING,
    EARLY,
    FIRST,
    INDEPENDENT,
    INERTIA,
    LATE,
    LONGEST,
    USUAL,
    WIDER,
    CableFit,
    Evidence,
    Search,
    Values,
    point_of,
    prior_of,
    settled,
    values_at,
)
from heave_studies.whatif.record import NOMINAL, SensorRecord
from heave_studies.whatif.twin import (
    Drive,
    PlantFactors,
    driven,
    nominal_line,
    past_winch,
    scaled_line,
    winch_under,
)

UNKNOWN = {INERTIA: 1.0, DAMPING: 2.0, EARLY: 1.0, LATE: 1.0}
"""Standard deviations before the record: of the logarithms of effective mass and drag area, next to nothing is known;
of the pulses [m] that make the motion in which the record begins."""
MASSES = np.linspace(-1.2, 1.2, 17)
"""Logarithms of the effective mass over the nominal one that are tried first: a resonance is narrow."""
SHORTEST = 60.0
"""Least time that is judged [s]: half a dozen waves."""
LEAST_MOTION = 5.0
"""Motion of the cable's top over what is not known of it, below which the record shows nothing of the load [-]."""
LEAST_FIT = 0.9
"""Fit below which noise, or another cable than the nominal one, is too much of the load's motion."""
BAND = 1.96
"""Half width of a 95 % band of a logarithm [standard deviations]."""


@dataclass(frozen=True)
class Banded:
    """A quantity of the load."""

    name: str  # of it
    unit: str  # its SI unit
    value: float  # most likely one [SI]
    low: float  # lower end of its 95 % band [SI]
    high: float  # upper end of its 95 % band [SI]
    nominal: float  # as the parameters state it [SI]
    is_shown: bool  # the record shows more than was known before

    def __str__(self) -> str:
        """Return it in words."""
        known = f"{self.value:.4g} {self.unit} (95 %: {self.low:.4g} to {self.high:.4g})"
        return f"{self.name}: {known if self.is_shown else 'not shown by this record'}, nominal {self.nominal:.4g}"


@dataclass(frozen=True)
class LoadIdentification(Fitted):
    """What a record shows of the load; `fit` is that of the depth where waves are."""

    mass: Banded  # mass and vertical added mass [kg]
    area: Banded  # C_D S of vertical motion [m^2]

    def summary(self) -> str:
        """Return both quantities with their bands, and the fit."""
        return f"{self.mass}\n{self.area}\nfit {100.0 * self.fit:.2f} %"

    def values(self) -> dict[str, object]:
        """Return the numbers for a machine."""
        of_both = {
            f"{name}_{key}": {part: getattr(one, part) for part in ("value", "low", "high", "nominal", "is_shown")}
            for name, key, one in (("effective_mass", "kg", self.mass), ("drag_area", "m2", self.area))
        }
        return {**of_both, "fit": self.fit}


class LoadEvidence(Evidence):
    """Evidence in which inertia and damping are those of the load alone, and the record begins in any motion.

    Two pulses of the cable's top, a quarter of the load's own period apart, make that motion before it is judged.
    """

    names = (*USUAL, EARLY, LATE)

    @cached_property
    def radian(self) -> float:
        """Time of a radian of the nominal load's own motion [s]."""
        softness = sum(piece.length / piece.axial_stiffness for piece in self.assumed.pieces(self.nominal.length))
        return math.sqrt(softness * self.assumed.unit.inertia)

    @property
    def start(self) -> float:
        """See Evidence: after the pulses."""
        return max(float(self.record.time[0]) + max(BEGINS, 8.0 * self.radian), self.end - LONGEST)

    def line(self, values: Values) -> AxialLine:
        """Return the nominal cable with the load under `values`."""
        unit = self.assumed.unit
        load = replace(unit, inertia=unit.inertia * values[INERTIA], drag=unit.drag * values[DAMPING])
        return replace(scaled_line(self.assumed, PlantFactors(cable_drag=values[CABLE_DRAG])), unit=load)

    def gap(self, values: Values) -> ComplexArray:
        """See Evidence: NaN where the cable has no solution."""
        try:
            return super().gap(values)
        except AxialError:
            return np.full_like(self.seen, np.nan)

    def drive(self, values: Values, ticks: slice) -> Drive:
        """See Evidence: with the pulses."""
        plain = super().drive(values, ticks)
        heave, rate = plain.tip.heave, plain.tip.rate
        for name, place in ((EARLY, 3.0), (LATE, 3.0 + 0.5 * math.pi)):
            s = plain.tick_period * np.arange(len(heave)) / self.radian - place
            bell = values[name] * np.exp(-0.5 * s**2)
            heave, rate = heave + bell, rate - s / self.radian * bell
        return plain._replace(tip=plain.tip._replace(heave=heave, rate=rate))


def identify_load(record: SensorRecord, nominal: WinchControllerParameters) -> LoadIdentification:
    """Find effective mass and drag area of the load from depth, load cell, MRU and encoder.

    Parameters
    ----------
    record : of the sensors, with the cable's top in motion
    nominal : parameters of its controller, which state the cable

    Raises
    ------
    IdentificationError : a record that is too short or without motion, or that does not show the effective mass.
    """
    evidence = _evidence(record, nominal)
    prior, noise = {**prior_of(nominal), **UNKNOWN}, evidence.noise
    loss = partial(_loss, evidence, prior)
    place = np.eye(len(evidence.names))[evidence.names.index(INERTIA)]
    starts = sorted((one * place for one in MASSES), key=loss)[:BEST]
    begun = [Search(evidence, prior, x, noise).followed(x, FIRST) for x in starts]
    fit = min((settled(evidence, prior, one) for one in begun), key=lambda one: loss(point_of(one.values)))
    unit, area = evidence.assumed.unit, 2.0 / nominal.water_density
    mass = _banded("effective mass", "kg", fit, INERTIA, unit.inertia)
    motion = driven(evidence.drive(fit.values, evidence.ticks))
    explained = 1.0 - float(np.linalg.norm(evidence.gap(fit.values)[0]) / np.linalg.norm(evidence.seen[0]))
    if explained < LEAST_FIT or not mass.is_shown:
        raise IdentificationError(
            f"the record does not show the effective mass: the nominal cable explains {100.0 * explained:.0f} % of the "
            f"load's motion ({100.0 * LEAST_FIT:.0f} % are needed). Check length, cable and sensors, or record with "
            "the winch locked in a rougher sea"
        )
    drag = _banded("drag area C_D S", "m2", fit, DAMPING, area * unit.drag)
    times, depth = evidence.readings[0]
    inside = times >= evidence.start
    heave = np.interp(times[inside], record.time[evidence.ticks], motion.unit)
    seen = depth[inside] - depth[inside].mean()
    return LoadIdentification("quadratic", explained, times[inside], seen, heave - heave.mean(), mass, drag)


def _loss(evidence: Evidence, prior: Values, x: Array) -> float:
    """Return minus the log-likelihood of a point `x` [nats], the error of the boom tip as it is at its resonance."""
    covariance = evidence.covariance(values_at(x, evidence.names), evidence.noise)
    loss = Search(evidence, prior, x, evidence.noise).loss(x)
    loss += INDEPENDENT * float(np.linalg.slogdet(covariance)[1].sum())
    return loss if math.isfinite(loss) else math.inf


def _banded(name: str, unit: str, fit: CableFit, key: str, nominal: float) -> Banded:
    value, wide = nominal * fit.values[key], math.exp(BAND * WIDER * fit.sigma(key))
    return Banded(name, unit, value, value / wide, value * wide, nominal, fit.tells(key))


def _evidence(record: SensorRecord, nominal: WinchControllerParameters) -> LoadEvidence:
    """Return what judges the load; raises IdentificationError where there is too little of it."""
    record = replace(record, beliefs=NOMINAL)
    source, winch = tip_source(record, nominal), past_winch(record, winch_under(NOMINAL, nominal))
    line = nominal_line(nominal)
    if not line.unit.drag > 0.0:
        line = replace(line, unit=replace(line.unit, drag=0.5 * nominal.water_density))
    evidence = LoadEvidence(record, nominal, line, source, winch, 1.0)
    if evidence.end - evidence.start < SHORTEST:
        raise IdentificationError(f"{record.duration:.0f} s are too little: record {SHORTEST + BEGINS:.0f} s or more")
    inside = record.time >= evidence.start
    moved = float(np.std((source.plain.heave - winch.payout)[inside]))
    if moved < LEAST_MOTION * source.plain.sigma or moved < 1e-3:
        raise IdentificationError(
            f"the top of the cable moved by {100.0 * moved:.2g} cm (sigma), of which {100.0 * source.plain.sigma:.2g} "
            "cm are not known: this record shows nothing of the load; record with the winch locked, in a rougher sea"
        )
    return evidence
