"""From a record to answers: what it tells of plant and winch, then each loop that is asked for, with its bands."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from winch_controller_node.beliefs.beliefs import Beliefs, parameters_under
from winch_controller_node.beliefs.corrections import Correction, corrections
from winch_controller_node.beliefs.quantities import DEPTH_SCALE, ENCODER_SCALE
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.supervision.modes import Mode

from heave_bringup.whatif.answer import MODEL_LEAST, MODEL_MOST, Figures, figures, with_bands
from heave_bringup.whatif.identify.cable import (
    DAMPING,
    DELAY,
    INERTIA,
    PRIOR,
    SCALE,
    CableFit,
    CableLikelihood,
    fit_cable,
)
from heave_bringup.whatif.identify.refine import refine
from heave_bringup.whatif.signals.disturbance import Disturbance, disturbance
from heave_bringup.whatif.signals.record import SensorRecord
from heave_bringup.whatif.signals.tip import HighPass, smoothed_tip
from heave_bringup.whatif.twin.again import Again, observed_again
from heave_bringup.whatif.twin.plant import PlantFactors, driven, nominal_line, scaled_line
from heave_bringup.whatif.twin.replay import Asked, Past, Replayed, locked, replay
from heave_bringup.whatif.twin.winch import PastWinch, past_winch, tension_at_ticks, winch_under

OFF = Mode.OFF.value
"""Law with which the winch is locked."""

STIFFNESS_PRIOR = 0.1
"""Standard deviation of the logarithm of a factor on EA at the same a: by the load cell."""

Show = Callable[[str, float], None]


def quiet(words: str, share: float) -> None:
    """Show nothing of how far the work is, in `words`, by its `share`."""


@dataclass(frozen=True)
class Known:
    """What a record has told.

    Attributes
    ----------
    nominal : parameters of the controller in the run
    again : the same law again
    fit : cable and unit
    past : the record with its twins
    unexplained : motion of the unit
    set_point : mean payout at each tick [m]
    off : the winch locked
    window : ticks that are judged
    model : relative error of the twins in what they add to the record [-]
    """

    nominal: WinchControllerParameters
    again: Again
    fit: CableFit
    past: Past
    unexplained: Disturbance
    set_point: Array
    off: Replayed
    window: slice
    model: float


@dataclass(frozen=True)
class Answer:
    """What one loop would have done.

    Attributes
    ----------
    asked : for it
    figures : with their bands
    done : motions
    fade_out : probability that it gives up compensation [-]
    cause : the alarm with which it does; empty: it does not
    """

    asked: Asked
    figures: Figures
    done: Replayed = field(repr=False)
    fade_out: float
    cause: str


def learn(
    record: SensorRecord,
    nominal: WinchControllerParameters,
    *,
    start: float,
    told: tuple[Mapping[str, float], Mapping[str, float]] = (PRIOR, {}),
    show: Show = quiet,
) -> Known:
    """Return what a `record` tells.

    Parameters
    ----------
    record : that can carry an answer, see `fitness`
    nominal : parameters of its controller
    start : of the window that is judged [s]
    told : spread and centre of what is known of cable, unit and MRU before, see `CableLikelihood`
    show : called with what is done, and the share of it
    """
    ticks = record.ticks
    again = observed_again(record, nominal, lambda done: _show_some(show, "the same law again", done, ticks))
    show("cable and unit", 0.0)
    winch = past_winch(record, winch_under(again.beliefs, nominal), again.beliefs.value(ENCODER_SCALE, nominal))
    likelihood = CableLikelihood(
        record,
        nominal,
        winch,
        corrections(again.beliefs, nominal)["mru"],
        again.beliefs.value(DEPTH_SCALE, nominal),
        *told,
    )
    fit = fit_cable(likelihood, believed_high_pass(again.beliefs, nominal))
    show("cable and unit", 0.3)
    tip = smoothed_tip(record, fit.mru, HighPass(fit.high_pass_period, nominal.sensors.mru.high_pass_damping))
    fit = refine(fit, record, nominal, tip, winch, again.beliefs.value(DEPTH_SCALE, nominal))
    show("cable and unit", 1.0)
    return _known(record, nominal, again, fit, winch, start)


def believed_high_pass(beliefs: Beliefs, nominal: WinchControllerParameters) -> HighPass:
    """Return the high-pass that the MRU has under `beliefs` about the `nominal` parameters."""
    mru = parameters_under(beliefs, nominal).sensors.mru
    return HighPass(mru.high_pass_period, mru.high_pass_damping)


def _known(
    record: SensorRecord,
    nominal: WinchControllerParameters,
    again: Again,
    fit: CableFit,
    winch: PastWinch,
    start: float,
) -> Known:
    tip = smoothed_tip(record, fit.mru, HighPass(fit.high_pass_period, nominal.sensors.mru.high_pass_damping))
    encoder, depth = (again.beliefs.value(name, nominal) for name in (ENCODER_SCALE, DEPTH_SCALE))
    factors = PlantFactors(fit.values[INERTIA], fit.values[DAMPING])
    plain, dt = nominal_line(nominal), record.tick_period
    for _ in range(2):
        line = scaled_line(plain, factors)
        plant = driven(line, nominal.length, tip, winch.payout, winch.rate, tick_period=dt)
        ratio = stiffness_ratio(record, plant.tension)
        if ratio is None or abs(math.log(ratio)) < 0.005:
            break
        factors = replace(factors, stiffness=factors.stiffness * ratio)
    unexplained = disturbance(record, plant.unit, depth, nominal.sensors.depth.noise)
    past = Past(record, line, nominal.length, tip, winch, winch_under(again.beliefs, nominal), plant, encoder, depth)
    set_point = np.where(np.isfinite(record.set_points), record.set_points, _slow(winch.payout, dt))
    window = slice(int(np.searchsorted(record.time, start)), record.ticks)
    off = locked(past, set_point)
    return Known(
        nominal, again, fit, past, unexplained, set_point, off, window, model_error(past, unexplained, off, window)
    )


def model_error(past: Past, unexplained: Disturbance, off: Replayed, window: slice) -> float:
    """Return the relative error of the twins in what they add: what they left of a record over what they explained.

    Parameters
    ----------
    past : the record and its twins
    unexplained : motion that they left
    off : the winch locked
    window : ticks that are judged
    """
    explained = float(np.std(past.plant.unit[window]))
    by_tip = past.tip.sigma * float(np.std(off.unit[window])) / max(float(np.std(past.tip.heave[window])), 1e-6)
    left = math.sqrt(max(unexplained.waves**2 - by_tip**2, 0.0))
    return min(max(left / max(explained, 1e-9), MODEL_LEAST), MODEL_MOST)


def stiffness_ratio(record: SensorRecord, tension: Array) -> float | None:
    """Return the factor on the swing of the twin's `tension` [N] by the load cell of a `record`; None: there is none.

    The cable's mass and stiffness at the same a: tension is inertia times acceleration, so both go with it.
    """
    cell = record.scalar("load_cell")
    if len(cell) < 100:
        return None
    read = cell[:, 1] - cell[:, 1].mean()
    twin = np.interp(cell[:, 0], record.time, tension)
    twin = twin - twin.mean()
    power = float(twin @ twin)
    ratio = float(read @ twin) / max(power, 1e-9)
    variance = float(np.var(read - ratio * twin)) / max(power, 1e-9)
    weight = STIFFNESS_PRIOR**2 / (STIFFNESS_PRIOR**2 + variance)
    return math.exp(weight * math.log(min(max(ratio, 0.3), 3.0)))


def drawn(known: Known, seed: int, number: int) -> Known:
    """Return what is known with another plant that the record allows: draw `number` of a `seed`."""
    random = random_stream(seed, f"whatif/{number}")
    moves = random.multivariate_normal(np.zeros(len(known.fit.values)), known.fit.covariance)
    values = {
        name: value + move if name == DELAY else value * math.exp(move)
        for (name, value), move in zip(known.fit.values.items(), moves, strict=True)
    }
    held, was = known.fit.mru, known.fit.values
    mru = Correction(held.scale * values[SCALE] / was[SCALE], held.offset, held.delay + values[DELAY] - was[DELAY])
    fit = replace(known.fit, values=values, mru=mru)
    past, start = known.past, float(known.past.record.time[known.window.start])
    return _known(past.record, known.nominal, known.again, fit, past.winch, start)


def answer(known: Known, asked: Asked, others: Sequence[Known] = (), *, show: Show = quiet) -> Answer:
    """Return what the loop that is `asked` for would have done.

    Parameters
    ----------
    known : by the record
    asked : controller and winch
    others : draws of what the record allows, for the bands
    show : called with what is done, and the share of it
    """
    ticks = known.past.record.ticks
    count = 1 + len(others)
    results = []
    for number, one in enumerate((known, *others)):
        on_tick = partial(_show_of, show, asked.name, number * ticks, count * ticks)
        done = _done(one, asked, on_tick)
        results.append((done, _figures(one, done)))
    (done, base), *draws = results
    added = float(np.std((done.unit + done.set_point - known.past.plant.unit - known.set_point)[known.window]))
    off = off_sigma(known)
    spread = math.hypot(
        float(np.sqrt(np.mean([(off_sigma(one) - off) ** 2 for one in others]))) if others else 0.0,
        known.model * float(np.std((known.off.unit - known.past.plant.unit)[known.window])),
    )
    found = with_bands(base, [one for _, one in draws], added=added, model=known.model, uncompensated=(off, spread))
    if asked.controller.law == OFF:
        # it is the reference of the efficiency
        found = replace(found, bands={**found.bands, "unit_efficiency": (0.0, 0.0)})
    lost = [one for _, one in results if math.isfinite(one.lost_at)]
    return Answer(asked, found, done, len(lost) / count, lost[0].cause if lost else "")


def _done(known: Known, asked: Asked, on_tick: Callable[[int], None]) -> Replayed:
    if asked.controller.law == OFF:
        return known.off
    return replay(known.past, asked, on_tick=on_tick)


def off_sigma(known: Known) -> float:
    """Return the standard deviation of the unit with the winch locked, by what is `known` [m]."""
    motion = known.off.unit + known.off.set_point + known.unexplained.heave
    return math.hypot(float(np.std(motion[known.window])), known.unexplained.left)


def _figures(known: Known, done: Replayed) -> Figures:
    record = known.past.record
    read = tension_at_ticks(record)
    tension = read + done.tension - known.past.plant.tension if np.isfinite(read).any() else done.tension
    return figures(
        done,
        known.unexplained,
        np.maximum(np.where(np.isfinite(tension), tension, done.tension), 0.0),
        window=known.window,
        uncompensated=off_sigma(known),
        tick_period=record.tick_period,
    )


def _slow(payout: Array, tick_period: float) -> Array:
    """Return the mean payout of a record whose controller did not say it: its mean over a minute."""
    half = max(1, round(30.0 / tick_period))
    about = np.ones(2 * half + 1)
    return np.asarray(np.convolve(payout, about, "same") / np.convolve(np.ones_like(payout), about, "same"))


def _show_of(show: Show, words: str, before: int, of: int, done: int) -> None:
    """Show how far a part of the work is, `before` which so much was done."""
    _show_some(show, words, before + done, of)


def _show_some(show: Show, words: str, done: int, of: int) -> None:
    """Show how far the work is, not at every tick."""
    if done % 200 == 0 or done == of:
        show(words, done / max(of, 1))


def recorded(known: Known) -> Figures:
    """Return the figures of the record itself, by what is `known` of it."""
    past, record = known.past, known.past.record
    done = replace(
        known.off,
        payout=past.winch.payout,
        rate=past.winch.rate,
        unit=past.plant.unit,
        tension=past.plant.tension,
        limits_hit=record.limits_hit,
    )
    return _figures(known, done)


def same_again(known: Known, *, show: Show = quiet) -> tuple[float, float]:
    """Return the error of payout of the same law again, standard deviation and largest [m], in the window.

    `known` is by the record; `show` is called with what is done, and the share of it.

    Orders that are those of the record give its readings, and its payout, to the last bit.
    """
    record = known.past.record
    if known.again.is_same:
        return 0.0, 0.0
    words, ticks = "the same law again, closed", record.ticks
    asked = Asked(words, known.nominal, None, record.has_adviser)
    done = replay(known.past, asked, on_tick=lambda tick: _show_some(show, words, tick, ticks))
    error = (done.payout - known.past.winch.payout)[known.window]
    return float(np.std(error)), float(np.abs(error).max())
