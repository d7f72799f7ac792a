"""Predictions of the LQG loop against simulation of the same linear loop, margins against theory, bounds."""

import math
from functools import lru_cache

import numpy as np
import pytest
from heave_node.parameters import build_parameters
from winch_controller_node.design.bounds import actuator_bound, boom_tip_realisation
from winch_controller_node.design.design import design_controller
from winch_controller_node.design.margins import frequencies, margins, output_feedback_loop, state_feedback_loop
from winch_controller_node.design.prediction import error_covariances, estimation_bound, predict_loop, sensor_periods
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.estimator import Measurement
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import SeaModelParameters, VesselModelParameters, WinchModelParameters

DT = 0.05


@lru_cache
def design(**values):
    named = {"cable_model.inertia": 2.0, "cable_model.damping": 0.3}
    named |= {name.replace("__", "."): value for name, value in values.items()}
    return design_controller(build_parameters(WinchControllerParameters, named, where="test"), tick_period=DT)


def simulate(loop, ticks, seed):
    """Mean squares of the outputs of the linear loop with its estimator, sampled sensors and late depth."""
    rng = np.random.default_rng(seed)
    model, estimator = loop.model, loop.make_estimator()
    periods = sensor_periods(loop)
    x = np.zeros(model.order)
    command, past, squares = 0.0, [], np.zeros(len(model.output_names))
    warm = 600
    for k in range(1, ticks + warm):
        past.append(x)
        readings = []
        for m in loop.measurements:
            period, age = periods[m.sensor]
            if k % period == 0 and k > age:
                value = m.row @ past[k - 1 - age] + m.sigma * rng.standard_normal()
                readings.append(Measurement(m.name, float(value), k - age))
        command = -float(loop.gain @ estimator.step(k, command, readings))
        if k >= warm:
            squares += (model.C @ x + model.D[:, 0] * command) ** 2
        x = model.A @ x + model.B[:, 0] * command + model.G @ rng.standard_normal(model.G.shape[1])
    return dict(zip(model.output_names, squares / ticks, strict=True))


def test_the_lyapunov_prediction_equals_the_simulated_sigma_within_confidence():
    loop = design()
    predicted = predict_loop(loop).sigma
    runs = [simulate(loop, 2500, seed) for seed in range(6)]
    for name in ("unit_heave", "payout_rate", "payout_acceleration", "outlet_heave"):
        variances = [run[name] for run in runs]
        margin = 4.0 * np.std(variances, ddof=1) / math.sqrt(len(runs))  # Student's t of 5 degrees at 99 %
        assert margin < 0.7 * np.mean(variances)
        assert np.mean(variances) == pytest.approx(predicted[name] ** 2, abs=margin), name


def test_the_filters_own_covariance_is_the_predicted_one():
    # a property of the Riccati equation: the running filter settles at it, whatever the readings say
    loop = design()
    estimator = loop.make_estimator()
    periods = sensor_periods(loop)
    for k in range(1, 4001):
        readings = []
        for m in loop.measurements:
            period, age = periods[m.sensor]
            if k % period == 0 and k > age:
                readings.append(Measurement(m.name, 0.0, k - age))
        estimator.step(k, 0.0, readings)
    _, after = error_covariances(loop)[(4000 - 1) % 2]
    C = loop.model.C
    seen, predicted = np.diag(C @ estimator.covariance @ C.T), np.diag(C @ after @ C.T)
    assert seen == pytest.approx(predicted, rel=1e-2, abs=1e-12)


def test_no_weights_beat_the_estimation_bound():
    loop = design()
    bound = estimation_bound(loop)
    for weights in ({}, {"weights__unit_heave": 0.002}, {"weights__outlet_heave": 0.0}):
        assert predict_loop(design(**weights)).sigma["unit_heave"] >= bound * (1.0 - 1e-6)


def test_the_bound_grows_with_the_delay():
    bounds = [estimation_bound(design(winch__command_delay=delay)) for delay in (0.0, 0.2, 0.6)]
    assert bounds == sorted(bounds)


def test_margins_of_a_loop_known_in_closed_form():
    # L = K e^{-s tau}/s: crossover K, phase margin pi/2 - K tau, gain margin pi/(2 K tau), delay margin pi/(2K) - tau
    K, tau = 1.5, 0.3
    omegas = np.geomspace(1e-2, 30.0, 4_000)
    found = margins(omegas, K * np.exp(-1j * omegas * tau) / (1j * omegas))
    assert found.phase == pytest.approx(math.pi / 2 - K * tau, rel=1e-3)
    assert found.gain_up == pytest.approx(math.pi / (2.0 * K * tau), rel=1e-3)
    assert found.delay == pytest.approx(math.pi / (2.0 * K) - tau, rel=1e-3)
    assert found.gain_down == 0.0


def poles_with_delay(loop, extra):
    """Largest closed-loop pole of the state feedback when the winch is `extra` ticks later than assumed."""
    model = loop.model
    n = model.order
    A = np.zeros((n + extra, n + extra))
    A[:n, :n] = model.A
    A[:n, -1] = model.B[:, 0]
    for i in range(1, extra):
        A[n + i, n + i - 1] = 1.0
    A[n, :n] = -loop.gain
    keep = [i for i in range(n + extra) if i >= n or model.state_names[i] != "depth_bias"]
    return np.max(np.abs(np.linalg.eigvals(A[np.ix_(keep, keep)])))


def test_the_delay_margin_is_where_the_loop_turns_unstable():
    # reference: eigenvalues of the loop with whole ticks of delay more; past commands stay those assumed
    loop = design()
    omegas = frequencies(DT)
    margin = margins(omegas, state_feedback_loop(loop, loop.gain, omegas)).delay
    ticks = margin / DT
    assert poles_with_delay(loop, max(1, math.floor(ticks))) < 1.0
    assert poles_with_delay(loop, math.ceil(ticks) + 1) > 1.0


def test_the_kalman_filter_costs_margin():
    loop = design()
    omegas = frequencies(DT)
    state = margins(omegas, state_feedback_loop(loop, loop.gain, omegas))
    output = margins(omegas, output_feedback_loop(loop, loop.gain, omegas))
    assert output.sensitivity_peak > state.sensitivity_peak
    assert output.gain_up > 1.2


def winch(speed, acceleration):
    """Return a winch with these limits [m/s], [m/s^2], and as much payout as there may be."""
    limits = {"speed_limit": speed, "acceleration_limit": acceleration}
    return WinchModelParameters(payout_minimum=-2e4, payout_maximum=2e4, **limits)


def tip(duration=120.0):
    sea = SeaModelParameters(significant_wave_height=3.0, peak_period=8.0)
    return boom_tip_realisation(sea, VesselModelParameters(), duration=duration, step=0.2, seed=1)


def test_the_clairvoyant_leaves_nothing_without_limits_and_more_with_tighter_ones():
    bounds = [actuator_bound(CableModel(7.0, 0.05), winch(10.0, a), tip(), 0.2) for a in (20.0, 0.5, 0.1)]
    assert bounds[0] < 1e-4
    assert bounds == sorted(bounds)


def test_a_winch_that_cannot_move_leaves_the_uncompensated_motion():
    still = actuator_bound(CableModel(2.0, 1.0), winch(1e-3, 1e-3), tip(), 0.2)
    free = actuator_bound(CableModel(2.0, 1.0), winch(10.0, 20.0), tip(), 0.2)
    assert still > 0.3
    assert free < 1e-3 * still


def test_all_of_a_record_counts_in_the_bound_of_the_actuator_its_ends_too():
    quiet, loud = 0.001 * tip(), tip()
    limits = winch(10.0, 0.1)
    for group in (slice(0, 40), slice(len(quiet) - 40, None)):
        record = quiet.copy()
        record[group] = loud[group]
        assert actuator_bound(CableModel(7.0, 0.05), limits, record, 0.2) > 1e-3
    assert actuator_bound(CableModel(7.0, 0.05), limits, quiet, 0.2) < 1e-4


def test_sensor_rates_without_a_common_pattern_are_refused():
    odd = design(
        sensors__use=("mru", "depth", "encoder", "velocity"),
        sensors__depth__rate=20.0 / 17,
        sensors__velocity__rate=20.0 / 19,
    )
    with pytest.raises(DesignError, match="repeats only after 323 ticks"):
        predict_loop(odd)


def test_the_thesis_scenario_through_the_whole_design_gives_the_thesis_numbers():
    # thesis 6.3.6: 0.2551 m off; 2.96e-4 m with all states known at q/r = 554, the limit of sensors without noise
    thesis = {
        "winch.law": "first_order",
        "winch.position_rate": 1.0,
        "winch.command_delay": 0.0,
        "winch.disturbance": 1e-6,
        "cable_model.inertia": 0.8959,
        "cable_model.damping": 0.1658,
        "cable_model.disturbance": 1e-6,
        "sea.significant_wave_height": 3.048,
        "sea.peak_period": 2.0 * math.pi / 0.785,
        "sea.filter_form": "thesis",
        "vessel.natural_frequency": 0.393,
        "vessel.damping_ratio": 0.6,
        "vessel.gain": 0.5,
        "sensors.mru.noise": 1e-5,
        "sensors.mru.rate_noise": 1e-5,
        "sensors.depth.noise": 1e-5,
        "sensors.depth.rate": 20.0,
        "sensors.depth.latency": 0.0,
        "sensors.encoder.noise": 1e-6,
        "weights.unit_heave": 1.0 / math.sqrt(554.0),
        "weights.outlet_heave": 0.0,
        "weights.payout": 0.0,
        "weights.payout_acceleration": 0.0,
        "weights.command": 1.0,
    }
    loop = design_controller(build_parameters(WinchControllerParameters, thesis, where="test"), tick_period=DT)
    assert loop.sigma["unit_heave"] == pytest.approx(0.2551, abs=5e-5)
    assert predict_loop(loop).sigma["unit_heave"] == pytest.approx(2.96e-4, rel=5e-3)
