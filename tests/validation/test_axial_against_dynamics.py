"""The axial model and the three-dimensional solver, written apart, on the same vertical problems."""

import dataclasses
import itertools

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.line.linearised import linearise
from cable_sim_node.parameters import CableParameters, CableSimParameters, ClumpsParameters, SectionsParameters
from cable_sim_node.vertical.axial import simulate_axial
from cable_sim_node.vertical.axial_line import axial_line
from cable_sim_node.vertical.linear import heave_transfer_function, natural_frequencies
from heave_node.numerics.kinematics import PointMotion

PERIOD = 0.05
S300 = CableSimParameters(segments=30)
SECTIONED = dataclasses.replace(
    S300,
    sections=SectionsParameters((60.0,), (0.06,), (0.0,), (9.0,), (8e6,)),
    clumps=ClumpsParameters((150.0,), (800.0,), (0.2,), (0.0,), (0.5,)),
)


def smooth(time, duration):
    share = np.clip(time / duration, 0.0, 1.0)
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def run_dynamics(parameters, heave, payout):
    """Return unit heave [m] and top tension [N] at every sample."""
    cable = CableDynamics(
        dataclasses.replace(parameters, solver=dataclasses.replace(parameters.solver, time_step=0.01))
    )
    cable.start_at_equilibrium(np.array([0.0, 0.0, heave[0]]))
    rate, feed = np.gradient(heave, PERIOD), np.gradient(payout, PERIOD)
    start = cable.unit_position[2] - heave[0]
    unit, tension = [cable.unit_position[2] - start], [cable.top_tension]
    motions = [
        PointMotion(k * PERIOD, np.array([0.0, 0.0, z]), np.array([0.0, 0.0, v]))
        for k, (z, v) in enumerate(zip(heave, rate, strict=True))
    ]
    for k in range(len(heave) - 1):
        cable.advance(PERIOD, motions[k], motions[k + 1], payout[k], feed[k], payout[k + 1], feed[k + 1])
        unit.append(cable.unit_position[2] - start)
        tension.append(cable.top_tension)
    return np.array(unit), np.array(tension)


TIME = np.arange(0.0, 60.0, PERIOD)
HEAVE = {
    "none": np.zeros_like(TIME),
    "regular": smooth(TIME, 15.0) * np.sin(1.256 * TIME),
    "two waves": smooth(TIME, 15.0) * (0.7 * np.sin(0.7 * TIME) + 0.4 * np.sin(1.6 * TIME + 1.0)),
}
PAYOUT = {
    "locked": np.zeros_like(TIME),
    "steady": 1.0 * (TIME - 5.0 * smooth(TIME, 10.0)) * smooth(TIME, 10.0),
    "periodic": 2.0 * smooth(TIME, 10.0) * np.sin(0.5 * TIME),
    "hauled in": -1.5 * TIME * smooth(TIME, 10.0),
}
CASES = [
    (S300, "regular", "locked"),
    (S300, "two waves", "steady"),
    (S300, "none", "periodic"),
    (S300, "two waves", "hauled in"),
    (SECTIONED, "regular", "steady"),
]


@pytest.mark.parametrize(
    ("parameters", "heave", "payout"), CASES, ids=["locked", "steady", "periodic", "in", "sections"]
)
def test_axial_and_three_dimensional_solver_agree(parameters, heave, payout):
    axial = simulate_axial(
        axial_line(parameters),
        parameters.length,
        HEAVE[heave],
        PERIOD,
        payout=PAYOUT[payout],
        segments=60,
        largest_step=0.005,
    )
    unit, tension = run_dynamics(parameters, HEAVE[heave], PAYOUT[payout])

    moved = max(np.ptp(axial.unit_heave + PAYOUT[payout]), 0.05)
    # both start alike; the axial run moves with its first sample's speed, which is nothing here
    assert unit == pytest.approx(axial.unit_heave, abs=1e-4 * moved)
    swing = np.ptp(axial.top_tension)
    assert np.sqrt(np.mean((tension - axial.top_tension) ** 2)) < 6e-4 * swing


STIFFENING = dataclasses.replace(
    S300, cable=CableParameters(axial_stiffness=2e6, stiffness_quadratic=20.0, stiffness_cubic=300.0)
)


# of the stiffening cable the bar knows one slope, half-way up; the line knows the slope at every segment
@pytest.mark.parametrize(
    ("parameters", "tolerance"),
    [(S300, 3e-3), (SECTIONED, 3e-3), (STIFFENING, 1e-2)],
    ids=["S300", "sections", "stiffening"],
)
def test_linearised_line_and_exact_bar_have_the_same_heave(parameters, tolerance):
    omegas = [0.3, 0.8, 1.8, 2.1]
    exact = heave_transfer_function(axial_line(parameters), parameters.length, omegas)
    line = linearise(parameters).response(omegas)
    assert line.unit[:, 2, 2] == pytest.approx(exact.unit_heave, rel=tolerance)
    assert line.top_tension[:, 2] == pytest.approx(exact.top_tension, rel=tolerance)
    # and a vertical line does not couple heave with sway
    assert np.abs(line.unit[:, :2, 2]).max() < 1e-9


def test_the_heave_mode_of_the_line_is_the_bars():
    frequencies, modes = linearise(S300).natural_frequencies(20)
    upright = [i for i in range(20) if np.abs(modes[i][:, 2]).max() > 0.5]
    exact = natural_frequencies(axial_line(S300), 300.0, 1)
    assert frequencies[upright[0]] == pytest.approx(exact[0], rel=1e-3)


def test_transverse_modes_of_a_heavily_loaded_light_cable_are_those_of_a_string():
    # unit so heavy that it stands still and its pendulum is slow: f_n = n/(2 L) sqrt(T/mu), mu with added mass
    parameters = CableSimParameters(
        length=100.0,
        segments=100,
        cable=CableParameters(mass_per_length=5.4, axial_stiffness=1e11),
        unit=dataclasses.replace(S300.unit, mass=3e6, volume=354.0),
    )
    frequencies, modes = linearise(parameters).natural_frequencies(8)
    tension = parameters.unit.weight_in_fluid(1025.0)
    mu = 5.4 + 1025.0 * parameters.cable.displaced_area
    string = np.pi / 100.0 * np.sqrt(tension / mu)
    sideways = [f for f, mode in zip(frequencies, modes, strict=True) if np.abs(mode[:, 2]).max() < 0.5]
    # first the pendulum about both axes, then the string in both planes
    assert sideways[2] == pytest.approx(string, rel=3e-3)
    assert sideways[3] == pytest.approx(string, rel=3e-3)


def test_the_linearised_line_in_a_current_follows_the_nonlinear_one():
    # small boom-tip motion in x, y and z at once, in a strong current: first harmonic of the unit against the transfer
    # function
    parameters = dataclasses.replace(S300, current=(0.8, 0.3), segments=20)
    omega, size = 0.9, 0.01
    time = np.arange(0.0, 120.0, PERIOD)
    wave = size * smooth(time, 30.0) * np.sin(omega * time)
    slope = np.gradient(wave, PERIOD)
    cable = CableDynamics(
        dataclasses.replace(parameters, solver=dataclasses.replace(parameters.solver, time_step=0.025))
    )
    cable.start_at_equilibrium(np.zeros(3))
    motions = [
        PointMotion(k * PERIOD, np.full(3, z), np.full(3, v)) for k, (z, v) in enumerate(zip(wave, slope, strict=True))
    ]
    unit = [cable.unit_position]
    for before, after in itertools.pairwise(motions):
        cable.advance(PERIOD, before, after, 0.0, 0.0, 0.0, 0.0)
        unit.append(cable.unit_position)
    late = time > 120.0 - 4.0 * 2.0 * np.pi / omega
    basis = np.column_stack((np.ones(late.sum()), time[late], np.sin(omega * time[late]), np.cos(omega * time[late])))
    fit = np.linalg.lstsq(basis, np.array(unit)[late], rcond=None)[0]
    found = (fit[2] + 1j * fit[3]) / size
    expected = linearise(parameters).response([omega]).unit[0].sum(axis=1)
    assert found == pytest.approx(expected, abs=0.02)
    assert found[2] == pytest.approx(expected[2], rel=5e-3)


def test_a_hanging_line_in_any_current_is_stable():
    for current in ((0.0, 0.0), (0.5, 0.0), (1.5, -1.0)):
        assert linearise(dataclasses.replace(S300, current=current), speed_amplitude=0.1).poles().real.max() < 0.0
