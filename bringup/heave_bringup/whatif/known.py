"""What a record shows: the same law again, cable, unit, MRU, winch, and what no model explains."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from winch_controller_node.beliefs.beliefs import Beliefs, parameters_under
from winch_controller_node.beliefs.corrections import Correction, corrections
from winch_controller_node.beliefs.quantities import DEPTH_SCALE, ENCODER_SCALE
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.supervision.modes import Mode

from heave_bringup.whatif.answer import MODEL_LEAST, MODEL_MOST
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
from heave_bringup.whatif.twin.replay import Past, Replayed, locked
from heave_bringup.whatif.twin.winch import PastWinch, past_winch, winch_under

OFF = Mode.OFF.value
"""Law with which the winch is locked."""

MOVES = 1e-3
"""Standard deviation of the payout rate from which on a winch has shown how it answers [m/s]."""

WINCH_SPREAD = (0.2, 0.03, 0.02)
"""Spread of a winch that has not moved, 1 sigma, as a data sheet leaves it: logarithm of lag, delay [s], logarithm of
its gain."""

STIFFNESS_PRIOR = 0.1
"""Standard deviation of the logarithm of a factor on EA at the same a: by the load cell."""

Show = Callable[[str, float], None]


def quiet(words: str, share: float) -> None:
    """Show nothing of how far the work is, in `words`, by its `share`."""


@dataclass(frozen=True)
class Known:
    """What a record has shown.

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


def learn(
    record: SensorRecord,
    nominal: WinchControllerParameters,
    *,
    start: float,
    told: tuple[Mapping[str, float], Mapping[str, float]] = (PRIOR, {}),
    show: Show = quiet,
) -> Known:
    """Return what a `record` shows.

    Parameters
    ----------
    record : that can carry an answer, see `fitness`
    nominal : parameters of its controller
    start : of the window that is judged [s]
    told : spread and centre of what is known of cable, unit and MRU before, see `CableLikelihood`
    show : called with what is done, and the share of it
    """
    ticks = record.ticks
    again = observed_again(record, nominal, lambda done: show_some(show, "the same law again", done, ticks))
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
    """Return what is `known` with another plant, and winch, that the record allows: draw `number` of a `seed`."""
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
    other = _known(past.record, known.nominal, known.again, fit, past.winch, start)
    if winch_moved(known):
        return other
    lag, delay, gain = (spread * float(random.standard_normal()) for spread in WINCH_SPREAD)
    winch = past.winch_parameters
    winch = replace(
        winch,
        time_constant=winch.time_constant * math.exp(lag),
        command_delay=max(winch.command_delay + delay, 0.0),
        speed_gain=winch.speed_gain * math.exp(gain),
    )
    return replace(other, past=replace(other.past, winch_parameters=winch))


def winch_moved(known: Known) -> bool:
    """Return whether the winch of what is `known` has moved in the window, so that its answer to orders was seen."""
    return float(np.std(known.past.winch.rate[known.window])) > MOVES


def off_sigma(known: Known) -> float:
    """Return the standard deviation of the unit with the winch locked, by what is `known` [m]."""
    motion = known.off.unit + known.off.set_point + known.unexplained.heave
    return math.hypot(float(np.std(motion[known.window])), known.unexplained.left)


def _slow(payout: Array, tick_period: float) -> Array:
    """Return the mean payout of a record whose controller did not say it: its mean over a minute."""
    half = max(1, round(30.0 / tick_period))
    about = np.ones(2 * half + 1)
    return np.asarray(np.convolve(payout, about, "same") / np.convolve(np.ones_like(payout), about, "same"))


def show_some(show: Show, words: str, done: int, of: int) -> None:
    """Have `show` say how far the work in `words` is, `done` ticks `of` all, not at every tick."""
    if done % 200 == 0 or done == of:
        show(words, done / max(of, 1))
