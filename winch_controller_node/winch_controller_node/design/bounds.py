"""The bounds that kappa is measured against: what no controller can beat, whatever it does.

s_est (see `sensor_bound`) is what sensors and delay leave without limits; s_act is what the winch's limits leave to a
controller that knows the whole future. kappa = s(z) / sqrt(s_est^2 + s_act^2).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import covariance_factor, state_covariance
from heave_node.numerics.linear_sampling import discretise
from heave_node.numerics.randomness import random_stream
from heave_node.numerics.spectral_estimate import SEGMENT_TIME, RecordTooShortError, estimate_spectrum
from wave_vessel_node.sea.filter_fit import fitted_filter
from wave_vessel_node.sea.spectra import SpectrumError, TabulatedSpectrum, WaveSpectrum
from wave_vessel_node.vessel.second_order import boom_tip_model

from winch_controller_node.design.clairvoyant import clairvoyant_heave
from winch_controller_node.design.design import design_controller, with_boom_tip
from winch_controller_node.design.prediction import estimation_bound
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.model.models import boom_tip_block
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import (
    CableModelParameters,
    SeaModelParameters,
    VesselModelParameters,
    WeightParameters,
    WinchModelParameters,
)

BOUND_STEP = 0.2
"""Step of the clairvoyant's plan [s]: a fortieth of the shortest peak period of the benchmarks."""
HIGHEST_FREQUENCY = 4.0
"""End of the spectrum of a record that counts [rad/s]; no vessel moves above it."""
FILTER_STATES = 8
"""States of the filter that models a record's spectrum: two peaks and their flanks."""


def boom_tip_realisation(
    sea: SeaModelParameters, vessel: VesselModelParameters, *, duration: float, step: float, seed: int
) -> Array:
    """Return stationary boom-tip heave of the design sea, shape (duration/step,) [m], from its shaping filter.

    Parameters
    ----------
    sea, vessel : of the design
    duration, step : of the record [s]
    seed : of the noise that drives the filter
    """
    model = discretise(boom_tip_block(sea, vessel), step)
    rng = random_stream(seed, "winch_controller/bound")
    count = round(duration / step)
    x = covariance_factor(state_covariance(model)) @ rng.standard_normal(model.order)
    noise = rng.standard_normal((count, model.G.shape[1])) @ model.G.T
    row = model.row("boom_tip_heave")
    heave = np.empty(count)
    for k in range(count):
        heave[k] = row @ x
        x = model.A @ x + noise[k]
    return heave


def actuator_bound(cable: CableModel, winch: WinchModelParameters, boom_tip_heave: Array, step: float) -> float:
    """Return s_act [m]: the least unit sigma within the winch's limits for one who knows the boom tip beforehand.

    See `clairvoyant`. All of the record counts, its ends too, where the plan is free to begin and end as suits it.

    Parameters
    ----------
    cable : two-state
    winch : whose limits are kept, of payout the nearer end of its range either way
    boom_tip_heave : the record [m]
    step : between its samples [s]

    Raises DesignError where the plan is not found.
    """
    bounds = min(-winch.payout_minimum, winch.payout_maximum), winch.speed_limit, winch.acceleration_limit
    return float(np.std(clairvoyant_heave(cable, bounds, np.ascontiguousarray(boom_tip_heave, dtype=float), step)))


def recorded_spectrum(heave: Array, step: float) -> TabulatedSpectrum:
    """Return the spectrum of the boom tip's `heave` about its mean [m], sampled each `step` [s], by Welch's method.

    Raises DesignError for a record that is too short, or has no motion.
    """
    try:
        found = estimate_spectrum(heave, step, segment=min(SEGMENT_TIME, len(heave) * step / 3.0))
        is_counted = (found.omega > 0.0) & (found.omega < HIGHEST_FREQUENCY)
        return TabulatedSpectrum(found.omega[is_counted], found.density[is_counted], name="boom tip")
    except (RecordTooShortError, SpectrumError) as error:
        raise DesignError(str(error)) from error


def sensor_bound(truth: WinchControllerParameters, tick_period: float, boom_tip: WaveSpectrum) -> float:
    """Return s_est [m] for a winch, sensors and a cable as they are, in a sea as it was.

    Nothing but sea and sensor noise drives the model: parameters of a controller's robustness move no bound.

    Parameters
    ----------
    truth : winch, sensors, cable and unit as they are
    tick_period : [s]
    boom_tip : spectrum of its heave, see `recorded_spectrum`; a shaping filter fitted to it models it

    Raises DesignError where sensors do not determine the motion.
    """
    known = replace(
        truth,
        cable_model=CableModelParameters(
            inertia=truth.cable_model.inertia, damping=truth.cable_model.damping, disturbance=0.0
        ),
        winch=replace(truth.winch, disturbance=0.0),
        weights=WeightParameters(),
    )
    shaped = boom_tip_model(fitted_filter(boom_tip, FILTER_STATES), None)
    return estimation_bound(with_boom_tip(design_controller(known, tick_period=tick_period), shaped))
