import math
from dataclasses import replace

import numpy as np
import pytest
from cable_sim_node.errors import LinearisationError
from cable_sim_node.vertical.axial_line import AxialClump, AxialLine, AxialSection, AxialUnit
from cable_sim_node.vertical.linear import (
    TwoStateModel,
    drag_at_unit,
    first_mode,
    fit_two_state,
    heave_transfer_function,
    mode_shape,
    natural_frequencies,
    resonant_length,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh
from scipy.optimize import brentq

STIFFNESS, MASS, INERTIA = 1.57706e7, 7.2, 125000.0
LINE = AxialLine((AxialSection(math.inf, STIFFNESS, MASS, 54.0, 1.9),), AxialUnit(INERTIA, 5e4, 512.5))


@settings(max_examples=40, deadline=None)
@given(st.floats(1e3, 1e9), st.floats(0.1, 100.0), st.floats(10.0, 5000.0), st.floats(1e-2, 1e3))
def test_natural_frequencies_solve_the_cot_equation(stiffness, mass, length, mass_ratio):
    # a bar held at the top with a mass M below: k L tan(k L) = m L/M, one root in each half wave
    line = AxialLine((AxialSection(math.inf, stiffness, mass, 1.0),), AxialUnit(mass * length * mass_ratio, 1.0))
    found = natural_frequencies(line, length, 3) * length * math.sqrt(mass / stiffness)
    for number, value in enumerate(found):
        low, high = number * math.pi + 1e-12, (number + 0.5) * math.pi - 1e-12
        exact = brentq(lambda x: x * math.sin(x) - math.cos(x) / mass_ratio, low, high, xtol=1e-14)
        assert value == pytest.approx(exact, rel=1e-9)


def test_natural_frequencies_of_sections_and_clumps_are_those_of_a_fine_chain():
    line = AxialLine(
        (AxialSection(200.0, 5e6, 20.0, 100.0), AxialSection(math.inf, 2e7, 5.0, 30.0)),
        AxialUnit(3000.0, 2e4),
        (AxialClump(300.0, 4000.0, 3e4),),
    )
    length, count = 500.0, 1000
    size = length / count
    middles = (np.arange(count) + 0.5) * size
    stiffness = np.where(middles < 200.0, 5e6, 2e7) / size
    mass = np.where(middles < 200.0, 20.0, 5.0) * size
    lumps = np.zeros(count + 1)
    lumps[:-1] += 0.5 * mass
    lumps[1:] += 0.5 * mass
    lumps[0] += 3000.0
    lumps[int(300.0 / size)] += 4000.0
    matrix = np.diag(np.append(stiffness, 0.0) + np.append(0.0, stiffness))
    matrix -= np.diag(stiffness, 1) + np.diag(stiffness, -1)
    squares = eigh(matrix[:-1, :-1], np.diag(lumps[:-1]), eigvals_only=True, subset_by_index=[0, 3])
    assert natural_frequencies(line, length, 4) == pytest.approx(np.sqrt(squares), rel=1e-5)


@settings(max_examples=40, deadline=None)
@given(st.floats(1e-2, 1e3), st.floats(10.0, 5000.0))
def test_the_first_mode_takes_its_share_of_a_motion_of_the_top(mass_ratio, length):
    # the residue of 1/(cos x - (M/m L) x sin x), the closed form of unit over top, at its first root
    line = AxialLine((AxialSection(math.inf, STIFFNESS, MASS, 1.0),), AxialUnit(MASS * length * mass_ratio, 1.0))
    mode = first_mode(line, length)
    root = length * math.sqrt(MASS / (STIFFNESS * mode.a))
    slope = -math.sin(root) - mass_ratio * (math.sin(root) + root * math.cos(root))
    assert mode.a == pytest.approx(natural_frequencies(line, length, 1)[0] ** -2)
    assert mode.participation == pytest.approx(-2.0 / (root * slope), rel=1e-6)
    assert 1.0 < mode.participation <= 4.0 / math.pi + 1e-6  # of a unit without mass, 4/pi


@pytest.mark.parametrize("omega", [0.05, 0.3, 0.45, 0.63, 0.9, 1.3])
def test_the_first_mode_is_the_unit_in_all_waves(omega):
    """From swell over the resonance, at 0.37 rad/s, to a period of 5 s; the modes above it are not quite static."""
    mode = first_mode(LINE, 900.0)
    by_mode = 1.0 - mode.participation + mode.participation / (1.0 - mode.a * omega**2)
    exact = heave_transfer_function(LINE, 900.0, [omega]).unit_heave[0].real
    assert by_mode == pytest.approx(exact, rel=2e-3, abs=1e-3)


def test_a_mode_shape_bends_nowhere_between_held_top_and_unit():
    first, second = natural_frequencies(LINE, 900.0, 2)
    labels, shape = mode_shape(LINE, 900.0, first)
    assert labels[[0, -1]] == pytest.approx([0.0, 900.0])
    assert shape[0] == pytest.approx(1.0)
    assert shape[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.diff(shape) < 0.0)
    # exact: cos(k s) - (w^2 M/(EA k)) sin(k s)
    number = first * math.sqrt(MASS / STIFFNESS)
    exact = np.cos(number * labels) - first * first * INERTIA / (STIFFNESS * number) * np.sin(number * labels)
    assert shape == pytest.approx(exact, abs=1e-9)
    assert np.sum(np.diff(np.sign(mode_shape(LINE, 900.0, second)[1][:-1])) != 0) == 1


def test_without_drag_the_transfer_function_is_the_analytic_bar():
    omegas = np.array([0.2, 0.5, 1.0, 2.0])
    number = omegas * math.sqrt(MASS / STIFFNESS)
    exact = 1.0 / (np.cos(number * 900.0) - omegas**2 * INERTIA / (STIFFNESS * number) * np.sin(number * 900.0))
    answer = heave_transfer_function(LINE, 900.0, omegas)
    assert answer.unit_heave == pytest.approx(exact, rel=1e-10)
    # slowly, the top carries unit and cable as one: tension = mass * acceleration, a minus sign for downwards
    slow = heave_transfer_function(LINE, 900.0, [1e-3]).top_tension[0]
    assert slow == pytest.approx(-(1e-3**2) * (INERTIA + 900.0 * MASS), rel=1e-4)


def test_equivalent_drag_dissipates_what_quadratic_drag_does_at_resonance():
    # at resonance only drag holds the motion: energy fed in, pi T0 x0, equals energy lost, (8/3) c v^3 /w; with a light
    # cable this is amplitude = sqrt(3 pi K x0/(8 c w^2))
    line = AxialLine((AxialSection(math.inf, 1e6, 1e-6, 0.0),), AxialUnit(1000.0, 1e4, 200.0))
    omega = float(natural_frequencies(line, 100.0, 1)[0])
    stiffness = 1e6 / 100.0
    expected = math.sqrt(3.0 * math.pi * stiffness * 0.05 / (8.0 * 200.0 * omega**2))
    answer = heave_transfer_function(line, 100.0, [omega], amplitude=0.05)
    assert 0.05 * abs(answer.unit_heave[0]) == pytest.approx(expected, rel=1e-3)
    assert float(np.angle(answer.unit_heave[0])) == pytest.approx(-math.pi / 2.0, abs=1e-3)


def test_the_drag_at_the_unit_takes_the_power_that_all_parts_take():
    """Against a sum over 20,000 pieces of a cable of two sections with a clump, which moves as it stretches."""
    sections = (AxialSection(300.0, 2e7, 3.0, 20.0, 1.5), AxialSection(1.0, 4e7, 5.0, 30.0, 4.0))
    line = AxialLine(sections, AxialUnit(20_000.0, 1e5, 3_000.0), (AxialClump(100.0, 500.0, 3e3, 700.0),))
    length, count = 800.0, 20_000
    middle = (np.arange(count) + 0.5) * length / count
    lower = middle < 300.0
    strain = np.where(lower, 1.0 / 2e7, 1.0 / 4e7) * length / count
    share = 1.0 - (np.cumsum(strain) - 0.5 * strain) / np.sum(strain)
    of_cable = np.sum(np.where(lower, 1.5, 4.0) * share**3) * length / count
    of_clump = 700.0 * np.interp(100.0, middle, share) ** 3
    assert drag_at_unit(line, length) == pytest.approx(3_000.0 + of_clump + of_cable, rel=1e-6)


def test_the_rough_resonant_length_is_exact_for_a_light_cable():
    # thesis 3.3.5: L = EA/(w^2 (M + Ma))
    light = AxialLine((AxialSection(math.inf, STIFFNESS, 1e-6, 1.0),), AxialUnit(INERTIA, 5e4))
    assert natural_frequencies(light, resonant_length(light, 0.4), 1)[0] == pytest.approx(0.4, rel=1e-6)
    # and good to a third of the mass ratio with the cable's own mass
    omega = natural_frequencies(LINE, 900.0, 1)[0]
    assert resonant_length(LINE, omega) == pytest.approx(900.0 * (1.0 + 900.0 * MASS / (3.0 * INERTIA)), rel=1e-3)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.1, 20.0), st.floats(0.01, 5.0))
def test_the_fit_finds_a_two_state_model_exactly(a, b):
    omegas = np.linspace(0.1, 2.0, 40)
    exact = TwoStateModel(a, b, 0.0).transfer(omegas)
    fit = fit_two_state(omegas, exact)
    assert (fit.a, fit.b) == pytest.approx((a, b), rel=1e-6)
    assert fit.error < 1e-6


@settings(max_examples=30, deadline=None)
@given(st.floats(100.0, 6000.0), st.floats(0.1, 3.0), st.floats(0.3, 1.5))
def test_the_fit_is_never_worse_than_a_unit_that_does_not_move(length, mass_ratio, middle):
    """Also where the cable's first resonance is below the band and its second above: a minimum on the wrong side is."""
    line = AxialLine(
        (AxialSection(math.inf, STIFFNESS, MASS, 54.0, 1.9),), AxialUnit(MASS * 1000.0 * mass_ratio, 5e4, 500.0)
    )
    omegas = middle * np.linspace(0.3, 2.5, 60)
    response = heave_transfer_function(line, length, omegas, amplitude=0.5).unit_heave
    fit = fit_two_state(
        omegas, response, weights=np.exp(-((omegas / middle - 1.0) ** 2) / 0.1) / (1.0 + np.abs(response) ** 2)
    )
    assert fit.a > 0.0
    assert fit.b >= 0.0
    assert fit.error <= 1.02


def test_the_two_state_model_of_a_stiff_short_cable_has_the_springs_own_a():
    # a = (M + m L/3)/K: Rayleigh's third of the cable's mass
    omegas = np.linspace(0.2, 1.0, 30)
    fit = fit_two_state(omegas, heave_transfer_function(LINE, 300.0, omegas, amplitude=0.5).unit_heave)
    assert fit.a == pytest.approx((INERTIA + MASS * 300.0 / 3.0) * 300.0 / STIFFNESS, rel=5e-3)
    assert fit.b > 0.0


def test_bad_input_is_refused():
    with pytest.raises(LinearisationError, match="positive"):
        heave_transfer_function(LINE, 900.0, [0.0])
    with pytest.raises(LinearisationError, match="positive"):
        natural_frequencies(LINE, -1.0, 1)
    with pytest.raises(LinearisationError, match="not a number"):
        natural_frequencies(replace(LINE, unit=AxialUnit(math.nan, 5e4)), 900.0, 1)
    with pytest.raises(LinearisationError, match="two frequencies or more"):
        fit_two_state([1.0], [1.0 + 0.0j])
    with pytest.raises(LinearisationError, match="a unit that moves"):
        fit_two_state([1.0, 2.0], [1e-300 + 0.0j, 0.0j])
