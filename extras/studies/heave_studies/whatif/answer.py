"""What a record shows, and the figures of what would have been in its sea, each with its band."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from heave_bags.analyse.events import words
from heave_bringup.errors import CommandError
from heave_node.interface.codes import COMPENSATION_LOST, MODE_CHANGED, WinchLimit
from heave_node.kpi import efficiency, significant
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from winch_controller_node.beliefs.beliefs import corrections, parameters_under
from winch_controller_node.beliefs.quantities import DEPTH_SCALE, ENCODER_SCALE
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.study.workers import FAILURE, Job, Run, run_here
from heave_studies.whatif.identify import STIFFNESS, CableFit, Evidence, fit_cable
from heave_studies.whatif.record import Flags, SensorRecord, without_move
from heave_studies.whatif.spectra import Disturbance, HighPass, TipSource, disturbance, smoothed_tip
from heave_studies.whatif.twin import (
    Asked,
    Drive,
    Past,
    PlantFactors,
    Replayed,
    driven,
    locked,
    nominal_line,
    past_winch,
    replay,
    scaled_line,
    speeds_shown,
    winch_under,
)

COVERED = 1.645
"""Half the width of a band of 90 % over a standard deviation."""

MODEL_LEAST, MODEL_MOST = 0.004, 0.04
"""Relative error of the twin in what it adds to a record: at least that of its mesh and drag; at most as stated."""

COUNTED = int(~WinchLimit.PAYOUT)
"""Limits of the winch that count as such: not the ends of its cable."""

POSSIBLE = {"unit_efficiency": (-math.inf, 1.0), "time_at_limit_percent": (0.0, 100.0)}
"""Least and largest that a figure can be; 0 and infinity for the others."""


@dataclass(frozen=True)
class Figures:
    """Figures of one loop, by their names as figures of merit."""

    values: Mapping[str, float]  # as predicted
    bands: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # of 90 %, lower and upper end
    lost_at: float = math.inf  # time at which compensation was given up [s]; infinite: never
    cause: str = ""  # alarm with which it was


def limit_words(flags: Flags) -> str:
    """Return the limits of the winch that acted in any of some ticks, given as sums of `flags`; empty: none."""
    acted = int(np.bitwise_or.reduce(flags, initial=0)) & COUNTED
    return " and ".join(words(one) for one in WinchLimit if one & acted)


def lost(done: Replayed) -> tuple[float, str]:
    """Return when a loop, as `done`, gave up compensation unrequested [s], and by which alarm; infinite: never.

    One that never began has given up at its first alarm.
    """
    for time, alarm in done.alarms:
        if alarm.code == COMPENSATION_LOST:
            return time, str(alarm.values["reason"])
    if Mode.COMPENSATING.value in done.modes or set(done.modes) <= {Mode.OFF.value, ""}:
        return math.inf, ""
    causes = [(time, f"it never began: {one.brief}") for time, one in done.alarms if one.code != MODE_CHANGED]
    return causes[0] if causes else (float(done.time[0]), "it never began")


@dataclass(frozen=True)
class Spread:
    """What bands are made of."""

    # what changes in the figures where the loop is closed over other plants and winches that the record allows
    loops: Sequence[Mapping[str, float]]
    added: float  # standard deviation of the motion that the twins add to the record [m]
    locked: float  # the same of the winch locked [m]
    model: float  # relative error of the twins in both [-]

    def half(self, key: str) -> float:
        """Return half the width of a band of the figure `key`, by what the record allows."""
        # a t distribution of so few draws is wider than a normal one
        factor = COVERED * (1.0 + 1.5 / max(len(self.loops), 1))
        return factor * float(np.sqrt(np.mean(np.square([one[key] for one in self.loops] or [0.0]))))


def with_bands(base: Figures, spread: Spread, uncompensated: float, by_tip: float = 0.0) -> Figures:
    """Return figures with their bands: the spread of what is not known, and the twin's own error.

    What is not known of the boom tip was added to the motion; it may as well be nothing.

    Parameters
    ----------
    base : as predicted
    spread : of it
    uncompensated : standard deviation of the unit with the winch locked [m]
    by_tip : the same of what is not known of the boom tip, in the figures [m]
    """
    bands = {}
    for key, value in base.values.items():
        half = spread.half(key)
        bands[key] = (value - half, value + half)
    sigma, error = base.values["unit_sigma_m"], COVERED * spread.model * spread.added
    without_tip = math.sqrt(max(sigma**2 - by_tip**2, 0.0))
    above = math.hypot(sigma, error) - sigma + 0.5 * error
    below = math.hypot(min(0.5 * error, 0.5 * sigma), sigma - without_tip)
    half = spread.half("unit_sigma_m")
    low, high = sigma - math.hypot(half, below), sigma + math.hypot(half, above)
    bands["unit_sigma_m"], bands["significant_residual_m"] = (low, high), (significant(low), significant(high))
    value = base.values["unit_efficiency"]
    if uncompensated > 0.0:
        half = spread.half("unit_efficiency")
        by_off = COVERED * spread.model * spread.locked * (1.0 - value) / uncompensated
        less, more = (math.hypot(half, end / uncompensated, by_off) for end in (above, below))
        bands["unit_efficiency"] = (value - less, value + more)
    ends = {key: POSSIBLE.get(key, (0.0, math.inf)) for key in bands}
    possible = {key: (max(low, ends[key][0]), min(high, ends[key][1])) for key, (low, high) in bands.items()}
    return replace(base, bands=possible)


OFF = Mode.OFF.value
"""Law with which the winch is locked."""

MOVES = 1e-3
"""Standard deviation of the payout rate from which on a winch has shown how it answers [m/s]."""

WINCH_SPREAD = (0.2, 0.03, 0.02)
"""Spread of a winch that has not moved, 1 sigma, as a data sheet leaves it: logarithm of lag, delay [s], logarithm of
its gain."""


@dataclass(frozen=True)
class Known:
    """What a record has shown."""

    evidence: Evidence = field(repr=False)  # of the record
    fit: CableFit  # cable and unit
    past: Past  # the record with its twins
    unexplained: Disturbance  # motion of the unit
    left: float  # standard deviation of the motion that the twin does not explain [m]
    set_point: Array  # mean payout at each tick [m]
    off: Replayed  # the winch locked
    window: slice  # ticks that are judged
    by_tip: float  # standard deviation of the unit's motion by what is not known of the boom tip [m]

    def sigma(self, done: Replayed) -> float:
        """Return the standard deviation of the unit in the window [m], of the twin as `done` and what it leaves open.

        The noise that the depth sensor left in it is taken off; what is not known of the boom tip is added.
        """
        motion = without_move(done.time, done.unit + done.set_point + self.unexplained.heave, done.set_point)
        square = float(np.var(motion[self.window])) - self.unexplained.left**2
        return math.hypot(math.sqrt(max(square, 0.0)), self.by_tip)

    @property
    def model(self) -> float:
        """Relative error of the twins in what they add to the record: what they left of it over what they explained."""
        moved = without_move(self.past.record.time, self.past.plant.unit + self.set_point, self.set_point)
        left = math.sqrt(max(self.left**2 - self.by_tip**2, 0.0))
        return min(max(left / max(float(np.std(moved[self.window])), 1e-9), MODEL_LEAST), MODEL_MOST)


def learn(record: SensorRecord, nominal: WinchControllerParameters, *, start: float) -> Known:
    """Return what a `record` shows.

    Parameters
    ----------
    record : that can carry an answer, see `fitness`
    nominal : parameters of its controller
    start : of the window that is judged [s]
    """
    beliefs = record.beliefs
    scale = beliefs.value(ENCODER_SCALE, nominal)
    winch = past_winch(record, winch_under(beliefs, nominal, speeds_shown(record, scale)), scale)
    depth_scale = beliefs.value(DEPTH_SCALE, nominal)
    evidence = Evidence(record, nominal, nominal_line(nominal), tip_source(record, nominal), winch, depth_scale)
    return _known(evidence, fit_cable(evidence), start)


def tip_source(record: SensorRecord, nominal: WinchControllerParameters) -> TipSource:
    """Return what the MRU of a `record` has read, as its adviser has corrected it about the `nominal` parameters."""
    beliefs = record.beliefs
    mru = parameters_under(beliefs, nominal).sensors.mru
    high_pass = HighPass(mru.high_pass_period, mru.high_pass_damping)
    return TipSource(record.time, smoothed_tip(record, corrections(beliefs, nominal)["mru"], high_pass), high_pass)


def _known(evidence: Evidence, fit: CableFit, start: float) -> Known:
    """Return what is known under a `fit`; `start` is that of the window that is judged [s]."""
    record, winch, nominal = evidence.record, evidence.winch, evidence.nominal
    line = scaled_line(evidence.line(fit.values), PlantFactors(stiffness=fit.values[STIFFNESS]))
    set_point, tip = record.set_points, evidence.tip(fit.values)
    drive = Drive(line, nominal.length, tip, winch.payout, winch.rate, record.tick_period)
    off = locked(record, drive._replace(payout=set_point, rate=np.gradient(set_point, record.tick_period)))
    plant = driven(drive)
    unexplained = disturbance(
        np.column_stack(evidence.readings[0]), record.time, plant.unit, nominal.sensors.depth.noise
    )
    encoder_scale = record.beliefs.value(ENCODER_SCALE, nominal)
    past = Past(record, drive, winch, winch.parameters, plant, encoder_scale, evidence.depth_scale)
    window = slice(int(np.searchsorted(record.time, start)), record.ticks)
    left = float(np.std(without_move(record.time, unexplained.heave, set_point)[record.time >= evidence.start]))
    by_tip = evidence.by_tip(fit.values)
    return Known(evidence, fit, past, unexplained, left, set_point, off, window, by_tip)


def drawn(known: Known, seed: int, number: int) -> Known:
    """Return what is `known` with plant and winch of draw `number` of a `seed`."""
    random = random_stream(seed, f"whatif/{number}")
    start = float(known.past.record.time[known.window.start])
    other = _known(known.evidence, known.fit.drawn(random), start)
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


def winch_moved(known: Known) -> bool:
    """Return whether the winch of what is `known` has moved in the window by orders, so that its answer was seen."""
    return float(np.std(known.past.winch.rate[known.window])) > MOVES


def off_sigma(known: Known) -> float:
    """Return the standard deviation of the unit with the winch locked, by what is `known` [m]."""
    return known.sigma(known.off)


@dataclass(frozen=True)
class Answer:
    """What one loop would have done."""

    asked: Asked  # for it
    figures: Figures  # with their bands
    done: Replayed = field(repr=False)  # motions
    plants: int  # number of plants over which it was closed
    lost: int  # number of them on which it gives up compensation, or never begins
    cause: str  # the alarm with which it does; empty: it does not

    @property
    def is_refused(self) -> bool:
        """Whether its figures are withheld: it gives up compensation on the likeliest plant, or on half of all.

        Which second that is hangs on a threshold: in a trial of `industrial` at the limits of its winch the payout was
        right to 2 cm until then, and the efficiency 36 points off after it.
        """
        return math.isfinite(self.figures.lost_at) or 2 * self.lost >= self.plants

    @property
    def shown(self) -> Figures:
        """Its figures, none of which is known where they are withheld."""
        unknown = dict.fromkeys(self.figures.values, math.nan)
        return replace(self.figures, values=unknown, bands={}) if self.is_refused else self.figures


def answers(
    known: Known, wanted: Sequence[Asked], others: Sequence[Known] = (), *, run: Run = run_here
) -> list[Answer]:
    """Return what the loops that are asked for would have done.

    Parameters
    ----------
    known : by the record
    wanted : controllers and winches
    others : draws of what the record allows, over which each loop is closed again, for the bands
    run : closes loops

    Raises CommandError where a process ends without a result.
    """
    tasks = [(one, asked) for asked in wanted for one in (known, *others)]
    done = {n: one.off for n, (one, asked) in enumerate(tasks) if asked.law == OFF}
    jobs = [
        Job(n, asked.law, partial(replay, one.past, asked)) for n, (one, asked) in enumerate(tasks) if n not in done
    ]
    for job, result in run(jobs):
        if isinstance(result, dict):
            raise CommandError(str(result[FAILURE]))
        done[job.number] = result
    count = 1 + len(others)
    loops = [[done[number + n] for n in range(count)] for number in range(0, len(tasks), count)]
    return [_answer(known, asked, of_law, others) for asked, of_law in zip(wanted, loops, strict=True)]


def _answer(known: Known, asked: Asked, loops: Sequence[Replayed], others: Sequence[Known]) -> Answer:
    """Return what the loop that is `asked` for would have done: `loops` are over what is `known`, and over `others`."""
    done, *drawn = loops
    base = figures_of(known, done)
    draws = [figures_of(one, what) for one, what in zip(others, drawn, strict=True)]
    past, window = known.past, known.window
    spread = Spread(
        loops=[{key: value - base.values[key] for key, value in one.values.items()} for one in draws],
        added=float(np.std((done.unit + done.set_point - past.plant.unit - known.set_point)[window])),
        locked=float(np.std((known.off.unit - past.plant.unit)[window])),
        model=known.model,
    )
    found = with_bands(base, spread, off_sigma(known), known.by_tip)
    if asked.law == OFF:
        # it is the reference of the efficiency
        found = replace(found, bands={**found.bands, "unit_efficiency": (0.0, 0.0)})
    lost = [one for one in (base, *draws) if math.isfinite(one.lost_at)]
    return Answer(asked, found, done, len(loops), len(lost), lost[0].cause if lost else "")


def figures_of(known: Known, done: Replayed) -> Figures:
    """Return the figures of a loop, as `done` over what is `known`, without bands."""
    record, window = known.past.record, known.window
    sigma, off = known.sigma(done), off_sigma(known)
    # the record's tension with what the loop changes in it, where it was read
    read = record.tension + done.tension - known.past.plant.tension
    tension = np.maximum(np.where(np.isfinite(read), read, done.tension), 0.0)[window]
    values = {
        "unit_efficiency": efficiency(sigma, off),
        "unit_sigma_m": sigma,
        "significant_residual_m": significant(sigma),
        "tension_max_n": float(tension.max()),
        "winch_speed_max_mps": float(np.abs(done.rate[window]).max()),
        "time_at_limit_percent": 100.0 * float(np.mean((done.limits_hit[window] & COUNTED) != 0)),
    }
    return Figures(values, {}, *lost(done))


def recorded(known: Known) -> Figures:
    """Return the figures of the record itself, by what is `known` of it."""
    past, record = known.past, known.past.record
    done = replace(
        known.off,
        payout=past.winch.payout,
        rate=past.winch.rate,
        unit=past.plant.unit,
        tension=past.plant.tension,
        modes=record.modes,
        limits_hit=record.limits_hit,
    )
    return figures_of(known, done)
