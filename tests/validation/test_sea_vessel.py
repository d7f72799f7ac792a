"""From the sea to the boom tip and the MRU's reading of it: variances against integrals, responses against formulae."""

import math

import numpy as np
import pytest
from heave_node.parameters import build_parameters
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.mru.mru import MotionReferenceUnit, high_pass_response
from wave_vessel_node.parameters import MruParameters, WaveVesselParameters
from wave_vessel_node.sea.filter_fit import filter_quality, fit_filter
from wave_vessel_node.sea.shaping_filter import shaping_filter
from wave_vessel_node.sea.spectra import Bretschneider, Jonswap
from wave_vessel_node.vessel.fit import fit_vessel
from wave_vessel_node.vessel.motion import VesselMotions, lever_arm_matrix
from wave_vessel_node.vessel.rao_files import shipped_rao
from wave_vessel_node.vessel.second_order import SecondOrderVessel

DT, DURATION = 1.0, 10800.0  # variances need no finer sampling
ARM = np.array([-20.0, 10.0, 15.0])
SEA = Bretschneider(2.5, 9.0)
GRID = np.linspace(0.15, 6.0, 900)


def boom_tip(seed=1, **values):
    """Return three hours of boom-tip motion, shape (n, 3)."""
    defaults = {"significant_wave_height": 2.5, "peak_period": 9.0, "ramp": 0.0}
    parameters = build_parameters(WaveVesselParameters, defaults | values, where="test")
    vessel = WaveVessel(parameters, seed=seed, tick_period=DT)
    return np.array([vessel.step(tick).boom_tip.position for tick in range(1, round(DURATION / DT) + 1)])


def interval(density):
    """Return the variance integral and its 95 % interval over the record, var(m_0) = (2 pi / T) integral of S^2."""
    variance = np.trapezoid(density, GRID)
    return variance, 1.96 * math.sqrt(2 * math.pi / DURATION * np.trapezoid(density**2, GRID))


@pytest.mark.parametrize("vessel", [(0.9, 0.4, 1.0), (0.393, 0.6, 0.5)], ids=["osv", "thesis"])
def test_the_variance_of_a_second_order_vessel_is_the_integral_of_its_response_and_the_sea(vessel):
    names = ("vessel.natural_frequency", "vessel.damping_ratio", "vessel.gain")
    heave = boom_tip(**dict(zip(names, vessel, strict=True)))[:, 2]
    variance, spread = interval(np.abs(SecondOrderVessel(*vessel).response(GRID)) ** 2 * SEA.density(GRID))
    assert heave.var() == pytest.approx(variance, abs=spread)


HEADINGS = {"head": math.pi, "bow quarter": 2.3, "beam": math.pi / 2}


def test_the_variance_of_the_boom_tip_is_the_integral_of_rao_squared_and_the_sea():
    found, integral, spread = (np.zeros((len(HEADINGS), 3)) for _ in range(3))
    for row, heading in enumerate(HEADINGS.values()):
        found[row] = boom_tip(**{"vessel.model": "rao", "direction": heading}).var(axis=0)
        response = lever_arm_matrix(ARM) @ shipped_rao().at(GRID, heading)
        for axis in range(3):
            integral[row, axis], spread[row, axis] = interval(np.abs(response[axis]) ** 2 * SEA.density(GRID))

    assert (found - integral) / (spread + 1e-9) == pytest.approx(np.zeros_like(found), abs=1.0)


def test_the_variance_in_a_spread_sea_is_the_integral_over_all_directions():
    exponent = 4.0
    settings = {"vessel.model": "rao", "direction": 2.3, "spreading.exponent": exponent, "components": 1500}
    heave = boom_tip(**settings)[:, 2]
    angles = np.linspace(-math.pi, math.pi, 37)[:-1]
    share = np.cos(angles / 2) ** (2 * exponent)
    share /= share.sum()
    lever, table = lever_arm_matrix(ARM)[2], shipped_rao()
    squared = sum(s * np.abs(lever @ table.at(GRID, 2.3 + a)) ** 2 for s, a in zip(share, angles, strict=True))
    variance, spread = interval(squared * SEA.density(GRID))
    # each component has one direction: the scatter of |H|^2 over directions adds to that of the sea
    assert heave.var() == pytest.approx(variance, abs=2.0 * spread)


def test_forward_speed_moves_the_variance_as_the_table_says():
    heave = boom_tip(**{"vessel.model": "rao", "course.speed": 2.5})[:, 2]
    response = lever_arm_matrix(ARM)[2] @ shipped_rao().at(GRID, math.pi, 2.5)
    variance, spread = interval(np.abs(response) ** 2 * SEA.density(GRID))
    assert heave.var() == pytest.approx(variance, abs=spread)


def test_responses_of_the_shipped_hull():
    table = shipped_rao()
    omega = np.linspace(0.15, 2.2, 300)

    # bounds of physics: long waves carry the hull, short ones leave it; roll resonates in beam seas
    assert abs(table.at([0.15], math.pi)[2, 0]) == pytest.approx(1.0, abs=0.01)
    beam = np.abs(table.at(omega, math.pi / 2)[3]) / (omega**2 / 9.80665)
    assert beam.max() > 1.5


def test_a_second_order_vessel_identified_from_the_hull():
    omega = np.linspace(0.2, 2.4, 120)
    response = lever_arm_matrix(ARM)[2] @ shipped_rao().at(omega, math.pi / 2)
    fit = fit_vessel(omega, response, SEA)

    assert fit.sigma_ratio == pytest.approx(1.0, abs=0.03)


def test_the_mru_answers_as_its_high_pass_says():
    # 24 sines at once through the whole unit; amplitudes and phases by least squares over the last 1500 s
    cut_off, damping = 2 * math.pi / 60.0, 0.7071
    parameters = MruParameters(noise=0.0, rate_noise=0.0, high_pass_period=60.0, high_pass_damping=damping)
    tick, count = 0.1, 21000
    omega = 2 * math.pi * np.unique(np.round(np.geomspace(0.004, 0.4, 24) * 1500.0)) / 1500.0
    time = np.arange(1, count + 1) * tick
    angles = np.outer(time, omega) + 0.37 * np.arange(omega.size) ** 2
    heave = np.stack((np.cos(angles).sum(1), -np.sin(angles) @ omega, -np.cos(angles) @ omega**2), axis=1)
    unit = MotionReferenceUnit(parameters, seed=1, tick_period=tick)
    unit.look(VesselMotions.still(range(1, count + 1), tick), heave)
    readings = [unit.step(k) for k in range(1, count + 1)]
    late = time > time[-1] - 1500.0 + 1e-6
    basis = np.hstack((np.cos(angles[late]), -np.sin(angles[late])))
    measured = {}
    for name in ("heave", "heave_rate"):
        values = np.array([getattr(reading, name) for reading in readings])[late]
        solution = np.linalg.lstsq(basis, values, rcond=None)[0]
        measured[name] = solution[: omega.size] + 1j * solution[omega.size :]
    exact = high_pass_response(omega, cut_off, damping)

    np.testing.assert_allclose(measured["heave"], exact, atol=2e-5)
    np.testing.assert_allclose(measured["heave_rate"] / (1j * omega), exact, atol=2e-4)


def test_shaping_filters_against_their_spectra():
    cases = [(SEA, "thesis", 0.709), (SEA, "four_state", 0.0534), (SEA, "six_state", 0.0112)]
    qualities = {form: filter_quality(shaping_filter(sea, form), sea) for sea, form, _ in cases}
    eight = fit_filter(SEA, 8)
    jonswap = Jonswap(2.5, 9.0)
    other = fit_filter(jonswap, 8)

    for _, form, error in cases:
        assert qualities[form].relative_error == pytest.approx(error, rel=2e-3)
    assert qualities["six_state"].leak < 0.2 * qualities["four_state"].leak < 0.02 * qualities["thesis"].leak
    assert eight.quality.relative_error < 0.0013
    assert eight.quality.leak < 2e-4
    assert other.quality.relative_error < 0.0135


def test_the_sea_state_is_found_from_the_mru_alone():
    values = {
        "significant_wave_height": 2.5,
        "peak_period": 9.0,
        "mru.high_pass_period": 60.0,
        "ramp": 10.0,
    }
    parameters = build_parameters(WaveVesselParameters, values, where="test")
    vessel = WaveVessel(parameters, seed=4, tick_period=0.2)
    outputs = [vessel.step(tick) for tick in range(1, 18001)]
    estimates = [output.estimate for output in outputs if output.estimate is not None]

    last = estimates[-1]
    assert last.record_length == pytest.approx(1800.0, rel=0.1)
    assert last.significant_wave_height_interval[0] < 2.5 < last.significant_wave_height_interval[1]
    assert last.peak_period == pytest.approx(9.0, rel=0.1)
