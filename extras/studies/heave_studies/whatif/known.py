"""What a record shows: the same law again, cable, unit, MRU, winch, and what no model explains."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from winch_controller_node.beliefs.beliefs import Beliefs, parameters_under
from winch_controller_node.beliefs.corrections import corrections
from winch_controller_node.beliefs.quantities import DEPTH_SCALE, ENCODER_SCALE
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.answer import COVERED, MODEL_LEAST, MODEL_MOST, unit_motion
from heave_studies.whatif.identify.cable import CableFit, fit_cable
from heave_studies.whatif.identify.evidence import STIFFNESS, Evidence
from heave_studies.whatif.signals.record import SensorRecord, bridged, without_move
from heave_studies.whatif.signals.smoother import Disturbance, disturbance
from heave_studies.whatif.signals.tip import HighPass, tip_source
from heave_studies.whatif.twin.core import Again, observed_again
from heave_studies.whatif.twin.plant import (
    Drive,
    Follow,
    PlantFactors,
    PlantMotion,
    driven,
    followed,
    nominal_line,
    scaled_line,
)
from heave_studies.whatif.twin.replay import Past, Replayed, locked
from heave_studies.whatif.twin.winch import past_winch, winch_under
from heave_studies.whatif.work import HERE, Work

OFF = Mode.OFF.value
"""Law with which the winch is locked."""

MOVES = 1e-3
"""Standard deviation of the payout rate from which on a winch has shown how it answers [m/s]."""

WINCH_SPREAD = (0.2, 0.03, 0.02)
"""Spread of a winch that has not moved, 1 sigma, as a data sheet leaves it: logarithm of lag, delay [s], logarithm of
its gain."""

PLANTS = 12
"""Number of other plants on which the motion of a loop is tried: enough for a spread to a fifth."""


@dataclass(frozen=True)
class Known:
    """What a record has shown."""

    nominal: WinchControllerParameters  # parameters of the controller in the run
    again: Again  # the same law again
    fit: CableFit  # cable and unit
    past: Past  # the record with its twins
    unexplained: Disturbance  # motion of the unit
    left: float  # standard deviation of the motion that the twin does not explain [m]
    set_point: Array  # mean payout at each tick [m]
    off: Replayed  # the winch locked
    window: slice  # ticks that are judged
    by_tip: float  # standard deviation of the unit's motion by what is not known of the boom tip [m]
    evidence: Evidence = field(repr=False)  # of the record

    def sigma(self, motion: Array) -> float:
        """Return the standard deviation of a `motion` of the unit in the window [m].

        `motion` is that of the twin and the unexplained one at each tick [m]. The noise that the depth sensor left in
        it is taken off; what is not known of the boom tip is added.
        """
        square = float(np.var(motion[self.window])) - self.unexplained.left**2
        return math.hypot(math.sqrt(max(square, 0.0)), self.by_tip)

    def sigma_ends(self, motion: Array) -> tuple[float, float]:
        """Return the least and the largest that `sigma` can be of the record's own `motion` (n,) [m]."""
        with_noise, error = float(np.std(motion[self.window])), COVERED * self.model
        least = math.sqrt(max(with_noise**2 - self.unexplained.left**2, 0.0))
        return (1.0 - error) * least, (1.0 + error) * math.hypot(with_noise, self.by_tip)

    def under(self, fits: Sequence[CableFit], follow: Follow) -> list[Known]:
        """Return what is known under each of other `fits`, the winch as it is; `follow` returns motions of plants."""
        return _known(self.evidence, self.again, fits, float(self.past.record.time[self.window.start]), follow)

    @property
    def model(self) -> float:
        """Relative error of the twins in what they add to the record: what they left of it over what they explained."""
        moved = without_move(self.past.record.time, self.past.plant.unit + self.set_point, self.set_point)
        explained = float(np.std(moved[self.window]))
        left = math.sqrt(max(self.left**2 - self.by_tip**2, 0.0))
        return min(max(left / max(explained, 1e-9), MODEL_LEAST), MODEL_MOST)


def learn(
    record: SensorRecord,
    nominal: WinchControllerParameters,
    *,
    start: float,
    work: Work = HERE,
) -> Known:
    """Return what a `record` shows.

    Parameters
    ----------
    record : that can carry an answer, see `fitness`
    nominal : parameters of its controller
    start : of the window that is judged [s]
    work : that does independent parts
    """
    again = observed_again(record, nominal)
    beliefs = again.beliefs
    winch = past_winch(record, winch_under(beliefs, nominal), beliefs.value(ENCODER_SCALE, nominal))
    source = tip_source(record, corrections(beliefs, nominal)["mru"], assumed_high_pass(beliefs, nominal))
    evidence = Evidence(record, nominal, nominal_line(nominal), source, winch, beliefs.value(DEPTH_SCALE, nominal))
    work.show("the same law again, cable and unit", 0.0)
    follow = partial(work.done, "cable and unit", driven)
    return _known(evidence, again, [fit_cable(evidence, follow)], start, follow)[0]


def assumed_high_pass(beliefs: Beliefs, nominal: WinchControllerParameters) -> HighPass:
    """Return the high-pass that the MRU has under `beliefs` about the `nominal` parameters."""
    mru = parameters_under(beliefs, nominal).sensors.mru
    return HighPass(mru.high_pass_period, mru.high_pass_damping)


def _known(evidence: Evidence, again: Again, fits: Sequence[CableFit], start: float, follow: Follow) -> list[Known]:
    """Return what is known under each of some `fits` of one source.

    `start` is that of the window that is judged [s]; `follow` returns the motions of plants.
    """
    if evidence.source is not fits[0].source:
        evidence = replace(evidence, source=fits[0].source)
    record, winch, dt = evidence.record, evidence.winch, evidence.record.tick_period
    recorded, still = [], []
    for fit in fits:
        tip = evidence.tip(fit.values)
        line = scaled_line(evidence.line(fit.values), PlantFactors(stiffness=fit.values[STIFFNESS]))
        set_point = set_point_of(record)
        recorded.append(Drive(line, evidence.nominal.length, tip, winch.payout, winch.rate, dt))
        still.append(recorded[-1]._replace(payout=set_point, rate=np.gradient(set_point, dt)))
    motions = follow([*recorded, *still])
    offs = map(partial(locked, record), still, motions[len(fits) :])
    return [
        _under(evidence, again, fit, start, drive, plant, off)
        for fit, drive, plant, off in zip(fits, recorded, motions, offs, strict=False)
    ]


def set_point_of(record: SensorRecord) -> Array:
    """Return the mean payout at each tick of a `record` (n,) [m]; in ticks left out that between those beside them."""
    return bridged(record.set_points)


def _under(
    evidence: Evidence, again: Again, fit: CableFit, start: float, drive: Drive, plant: PlantMotion, off: Replayed
) -> Known:
    """Return what is known under a `fit`, whose `plant` moved so by its `drive`, and was so with the winch locked.

    `start` is that of the window that is judged [s].
    """
    record, nominal, set_point = evidence.record, evidence.nominal, off.payout
    heave = np.column_stack(evidence.readings[0])
    unexplained = disturbance(heave, record.time, plant.unit, nominal.sensors.depth.noise)
    past = Past(
        record,
        drive.line,
        drive.length,
        drive.tip,
        evidence.winch,
        winch_under(again.beliefs, nominal),
        plant,
        again.beliefs.value(ENCODER_SCALE, nominal),
        evidence.depth_scale,
    )
    window = slice(int(np.searchsorted(record.time, start)), record.ticks)
    left = float(np.std(without_move(record.time, unexplained.heave, set_point)[record.time >= evidence.start]))
    by_tip = evidence.by_tip(fit.values)
    return Known(nominal, again, fit, past, unexplained, left, set_point, off, window, by_tip, evidence)


def drawn(known: Known, seed: int, number: int, follow: Follow = followed) -> Known:
    """Return what is `known` with plant and winch of draw `number` of a `seed`; `follow` returns motions of plants."""
    random = random_stream(seed, f"whatif/{number}")
    (other,) = known.under([known.fit.drawn(random)], follow)
    if winch_moved(known):
        return other
    lag, delay, gain = (spread * float(random.standard_normal()) for spread in WINCH_SPREAD)
    winch = known.past.winch_parameters
    winch = replace(
        winch,
        time_constant=winch.time_constant * math.exp(lag),
        command_delay=max(winch.command_delay + delay, 0.0),
        speed_gain=winch.speed_gain * math.exp(gain),
    )
    return replace(other, past=replace(other.past, winch_parameters=winch))


def other_plants(known: Known, seed: int) -> list[CableFit]:
    """Return `PLANTS` other plants that the record allows by what is `known`, of a `seed`."""
    random = random_stream(seed, "whatif/plants")
    return [known.fit.drawn(random) for _ in range(PLANTS)]


def winch_moved(known: Known) -> bool:
    """Return whether the winch of what is `known` has moved in the window by orders, so that its answer was seen."""
    return float(np.std(known.past.winch.rate[known.window])) > MOVES


def off_sigma(known: Known) -> float:
    """Return the standard deviation of the unit with the winch locked, by what is `known` [m]."""
    return known.sigma(unit_motion(known.off, known.unexplained))
