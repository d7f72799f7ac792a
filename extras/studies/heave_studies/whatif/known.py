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
from heave_studies.whatif.identify.evidence import BEGINS, Evidence
from heave_studies.whatif.identify.prior import STIFFNESS, Prior, prior_of
from heave_studies.whatif.signals.disturbance import Disturbance, disturbance
from heave_studies.whatif.signals.record import SensorRecord, bridged, shortened, without_move
from heave_studies.whatif.signals.tip import HighPass
from heave_studies.whatif.signals.tip_source import tip_source
from heave_studies.whatif.twin.again import Again, observed_again
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
from heave_studies.whatif.work import HERE, Work, show_some

OFF = Mode.OFF.value
"""Law with which the winch is locked."""

MOVES = 1e-3
"""Standard deviation of the payout rate from which on a winch has shown how it answers [m/s]."""

WINCH_SPREAD = (0.2, 0.03, 0.02)
"""Spread of a winch that has not moved, 1 sigma, as a data sheet leaves it: logarithm of lag, delay [s], logarithm of
its gain."""

AS_RECORDED = 1e-3
"""A payout that is nowhere further from that of the record is the same [m]."""

AFTER_SNAP = 1.0
"""Time before the cable is first slack, up to which the record is taken as taut [s]."""

LEAST_TAUT = 40.0
"""Taut record that is judged at least [s]."""

PLANTS = 12
"""Number of other plants on which the motion of a loop is tried: enough for a spread to a fifth."""

DRAWN = 300.0
"""Longest part of what is judged over which a loop is closed again for the bands [s]: 30 waves."""

USUAL = 100
"""Number of twins that a search for cable and unit usually tries, to show how far it is."""

LOOKS = 3
"""Number of searches for the time at which the cable is first slack."""


@dataclass(frozen=True)
class Known:
    """What a record has shown."""

    nominal: WinchControllerParameters  # parameters of the controller in the run
    again: Again  # the same law again
    fit: CableFit  # cable and unit
    past: Past  # the record with its twins
    unexplained: Disturbance  # motion of the unit
    # share of that from the time on at which the cable was first slack: another loop does not have it (n,) [m]
    snapped: Array
    left: float  # standard deviation of the motion that the twin does not explain under a taut cable [m]
    set_point: Array  # mean payout at each tick [m]
    off: Replayed  # the winch locked
    window: slice  # ticks that are judged
    by_tip: float  # standard deviation of the unit's motion by what is not known of the boom tip [m]
    evidence: Evidence = field(repr=False)  # of the record

    def unexplained_in(self, payout: Array) -> Disturbance:
        """Return the motion that the twin of a loop does not explain, whose `payout` at each tick is given [m]."""
        if float(np.abs(payout - self.past.winch.payout).max()) < AS_RECORDED:
            return self.unexplained
        return self.unexplained._replace(heave=self.unexplained.heave - self.snapped)

    def sigma(self, motion: Array, unexplained: Disturbance) -> float:
        """Return the standard deviation of a `motion` of the unit in the window [m].

        `motion` is that of the twin and the `unexplained` one at each tick [m]. The noise that the depth sensor left
        in it is taken off; what is not known of the boom tip is added.
        """
        square = float(np.var(motion[self.window])) - unexplained.left**2
        return math.hypot(math.sqrt(max(square, 0.0)), self.by_tip)

    def sigma_ends(self, motion: Array) -> tuple[float, float]:
        """Return the least and the largest that `sigma` can be of the record's own `motion` (n,) [m]."""
        with_noise, error = float(np.std(motion[self.window])), COVERED * self.model
        least = math.sqrt(max(with_noise**2 - self.unexplained.left**2, 0.0))
        return (1.0 - error) * least, (1.0 + error) * math.hypot(with_noise, self.by_tip)

    @property
    def enough(self) -> int:
        """Number of ticks, from the first on, over which a loop is closed again for the bands."""
        return min(int(self.window.start) + round(DRAWN / self.past.record.tick_period), self.past.record.ticks)

    def part(self, count: int) -> Known:
        """Return what is known of the first `count` ticks."""
        ticks = self.past.record.ticks
        of_ticks = ("past", "unexplained", "snapped", "set_point", "off")
        cut = {name: shortened(getattr(self, name), ticks, count) for name in of_ticks}
        return replace(self, **cut, window=slice(self.window.start, count))

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
    prior: Prior | None = None,
    work: Work = HERE,
) -> Known:
    """Return what a `record` shows.

    Parameters
    ----------
    record : that can carry an answer, see `fitness`
    nominal : parameters of its controller
    start : of the window that is judged [s]
    prior : what is known of cable, unit and MRU before; None: what the parameters say
    work : that does independent parts
    """
    again = observed_again(record, nominal, partial(show_some, work.show, "the same law again", record.ticks))
    beliefs = again.beliefs
    winch = past_winch(record, winch_under(beliefs, nominal), beliefs.value(ENCODER_SCALE, nominal))
    source = tip_source(record, corrections(beliefs, nominal)["mru"], assumed_high_pass(beliefs, nominal))
    depth_scale, end = beliefs.value(DEPTH_SCALE, nominal), float(record.time[-1])
    evidence = Evidence(record, nominal, nominal_line(nominal), source, winch, depth_scale, end)
    follow = work.in_batches("cable and unit", driven, USUAL)
    return _known(evidence, again, [identified(evidence, prior or prior_of(nominal), follow)], start, follow)[0]


def identified(evidence: Evidence, prior: Prior, follow: Follow = followed) -> CableFit:
    """Return cable and unit by the part of the `evidence` in which the cable is taut, and the `prior`.

    A slack cable is not seen at its top; `follow` returns motions of twins, which show it along the whole cable.
    """
    fit = fit_cable(evidence, prior, None, follow)
    for _ in range(LOOKS):
        end = max(taut_until(evidence, fit), float(evidence.record.time[0]) + BEGINS + LEAST_TAUT)
        if abs(end - fit.end) < AFTER_SNAP:
            break
        fit = fit_cable(replace(evidence, end=end), prior, fit.values, follow)
    return fit


def taut_until(evidence: Evidence, fit: CableFit) -> float:
    """Return the time up to which the cable is taut by a `fit` of some `evidence` [s]: its end, or before a snap."""
    slack = np.flatnonzero(driven(*evidence.drive(fit.values, slice(None))).least_tension <= 0.0)
    return evidence.end if slack.size == 0 else float(evidence.record.time[slack[0]]) - AFTER_SNAP


def assumed_high_pass(beliefs: Beliefs, nominal: WinchControllerParameters) -> HighPass:
    """Return the high-pass that the MRU has under `beliefs` about the `nominal` parameters."""
    mru = parameters_under(beliefs, nominal).sensors.mru
    return HighPass(mru.high_pass_period, mru.high_pass_damping)


def _known(evidence: Evidence, again: Again, fits: Sequence[CableFit], start: float, follow: Follow) -> list[Known]:
    """Return what is known under each of some `fits` of one source and end.

    `start` is that of the window that is judged [s]; `follow` returns the motions of plants.
    """
    if evidence.source is not fits[0].source or evidence.end != fits[0].end:
        evidence = replace(evidence, source=fits[0].source, end=fits[0].end)
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
    heave, *cell = (np.column_stack(one) for one in evidence.readings)
    unexplained = disturbance(heave, record.time, plant.unit, nominal.sensors.depth.noise)
    is_shaken = record.time > fit.end
    snapped = np.where(is_shaken, unexplained.heave, 0.0)
    pulled = disturbance(cell[0], record.time, plant.tension, math.inf).heave if cell else np.zeros(record.ticks)
    moved = PlantMotion(
        plant.unit + snapped,
        plant.velocity + np.gradient(snapped, record.tick_period),
        plant.tension + np.where(is_shaken, pulled, 0.0),
        plant.least_tension,
    )
    past = Past(
        record,
        drive.line,
        drive.length,
        drive.tip,
        evidence.winch,
        winch_under(again.beliefs, nominal),
        plant,
        moved,
        again.beliefs.value(ENCODER_SCALE, nominal),
        evidence.depth_scale,
    )
    window = slice(int(np.searchsorted(record.time, start)), record.ticks)
    taut = (record.time >= evidence.start) & ~is_shaken
    left = float(np.std(without_move(record.time, unexplained.heave, set_point)[taut]))
    by_tip = evidence.by_tip(fit.values)
    return Known(nominal, again, fit, past, unexplained, snapped, left, set_point, off, window, by_tip, evidence)


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
    unexplained = known.unexplained_in(known.off.payout)
    return known.sigma(unit_motion(known.off, unexplained), unexplained)
