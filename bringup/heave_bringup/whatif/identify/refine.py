"""Cable and unit by the twin itself: output error in time, where the boom tip is known far better than it moves.

The likelihood in the frequency domain has a linear drag and discards what lies before its taper; near a resonance whose
memory is as long as the record both matter. Where the outlet hardly moves, the error of the boom tip would bias least
squares, and the likelihood stands.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from heave_node.numerics.arrays import Array
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_bringup.whatif.identify.cable import BAND, BEGINS, DAMPING, DELAY, INDEPENDENT, INERTIA, SCALE, CableFit
from heave_bringup.whatif.signals.record import SensorRecord
from heave_bringup.whatif.signals.spectra import noise_power, tapered_transform
from heave_bringup.whatif.signals.tip import Tip
from heave_bringup.whatif.twin.plant import PlantFactors, driven, nominal_line, scaled_line
from heave_bringup.whatif.twin.winch import PastWinch

FITTED = (INERTIA, DAMPING, SCALE, DELAY)
STEPS = np.array([0.003, 0.05, 0.003, 0.003])
"""Steps of the logarithms, and of the delay [s], for the slopes of the twin."""

NEAR = (-0.1, -0.05, 0.05, 0.1)
"""Logarithms of the inertia from which it is begun as well: a resonance is narrow."""

CLEAR = 15.0
"""Motion of the outlet over the error of the boom tip, from which on least squares have a bias of less than 0.5 %."""

ROUNDS, HALVINGS, SETTLED = 8, 4, 0.05
"""Gauss-Newton steps at most, how often one is halved, and a step in standard deviations that ends it."""


def refine(
    fit: CableFit,
    record: SensorRecord,
    nominal: WinchControllerParameters,
    tip: Tip,
    winch: PastWinch,
    depth_scale: float,
) -> CableFit:
    """Return a `fit` refined on the twin; as it is where the record does not allow it.

    Parameters
    ----------
    fit : by the likelihood
    record : of the sensors; nominal : parameters of the controller
    tip : boom tip under the fit; winch : what the drum did
    depth_scale : reading over truth [-]
    """
    begins = record.time >= record.time[0] + BEGINS
    if np.std((tip.heave - winch.payout)[begins]) < CLEAR * max(tip.sigma, 1e-9):
        return fit
    residual = _residuals(fit, record, nominal, tip, winch, depth_scale)
    names = [*fit.values]
    places = [names.index(name) for name in FITTED]
    prior = np.array([fit.prior[name] for name in FITTED])
    held = _point(fit.values)
    starts = [held, np.zeros(len(FITTED)), *(np.array([near, 0.0, 0.0, 0.0]) for near in NEAR)]

    def cost(r: Array, x: Array) -> float:
        return float(r @ r + np.sum((x / prior) ** 2))

    tried_first = [(residual(one), one) for one in starts]
    r, x = min(tried_first, key=lambda pair: cost(*pair))
    before, chi2 = cost(r, x), 1.0
    for _ in range(ROUNDS):
        slopes = np.column_stack([(residual(x + step) - r) / step.sum() for step in np.diag(STEPS)])
        chi2 = max(float(r @ r) / (INDEPENDENT * len(r)), 1.0)
        curvature = slopes.T @ slopes / chi2 + np.diag(prior**-2.0)
        move = -np.linalg.solve(curvature, slopes.T @ r / chi2 + x / prior**2)
        for _ in range(HALVINGS):
            tried = residual(x + move)
            if cost(tried, x + move) <= before:
                break
            move = 0.5 * move
        else:
            break
        x, r, before = x + move, tried, cost(tried, x + move)
        if math.sqrt(float(move @ curvature @ move)) < SETTLED:
            break
    covariance = fit.covariance.copy()
    covariance[places, :] = covariance[:, places] = 0.0
    covariance[np.ix_(places, places)] = np.linalg.inv(curvature)
    values = {**fit.values, **_values(x)}
    was = fit.values
    mru = fit.mru._replace(
        scale=fit.mru.scale * values[SCALE] / was[SCALE], delay=fit.mru.delay + values[DELAY] - was[DELAY]
    )
    left = float(r @ r) / (INDEPENDENT * len(r))
    return replace(fit, values=values, covariance=covariance, mru=mru, chi2=left)


def _point(values: Mapping[str, float]) -> Array:
    """Return the point at which the values are: logarithms, and the delay as it is."""
    return np.array([values[name] if name == DELAY else math.log(values[name]) for name in FITTED])


def _values(x: Array) -> dict[str, float]:
    """Return the values at a point."""
    return {name: float(v) if name == DELAY else math.exp(v) for name, v in zip(FITTED, x, strict=True)}


def _residuals(
    fit: CableFit,
    record: SensorRecord,
    nominal: WinchControllerParameters,
    tip: Tip,
    winch: PastWinch,
    depth_scale: float,
) -> Callable[[Array], Array]:
    """Return what is left of the depth readings in the band of waves, over its noise, as a function of `FITTED`."""
    times, depth = record.scalar("depth").T
    heave = -depth / depth_scale
    start, end = float(record.time[0]) + BEGINS, float(record.time[-1])
    omegas = np.arange(BAND[0], BAND[1], 2.0 * math.pi / (end - start))
    noise = noise_power(times, heave, start, end, nominal.sensors.depth.noise)
    noise += tip.sigma**2 * math.pi / (omegas[-1] - omegas[0])
    line, was = nominal_line(nominal), fit.values

    def residual(x: Array) -> Array:
        values = _values(x)
        share, then = was[SCALE] / values[SCALE], record.time + values[DELAY] - was[DELAY]
        heaves, rates = (np.interp(then, record.time, one) for one in (tip.heave, tip.rate))
        moved = Tip(share * heaves, share * rates, tip.sigma)
        motion = driven(
            scaled_line(line, PlantFactors(values[INERTIA], values[DAMPING])),
            nominal.length,
            moved,
            winch.payout,
            winch.rate,
            tick_period=record.tick_period,
        )
        gap = heave - np.interp(times, record.time, motion.unit)
        left = tapered_transform(times, gap, omegas, start, end) * math.sqrt(2.0 * INDEPENDENT / noise)
        return np.concatenate([left.real, left.imag])

    return residual
