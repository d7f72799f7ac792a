import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.errors import NoEquilibriumError
from cable_sim_node.parameters import CableParameters, CableSimParameters, ClumpsParameters, SectionsParameters
from cable_sim_node.vertical.axial import simulate_axial
from cable_sim_node.vertical.axial_line import AxialClump, AxialLine, AxialSection, AxialUnit, axial_line
from cable_sim_node.vertical.axial_stepper import AxialError
from cable_sim_node.vertical.linear import heave_transfer_function
from hypothesis import given, settings
from hypothesis import strategies as st

LINE = AxialLine((AxialSection(math.inf, 1.5e7, 5.0, 35.0, 0.7),), AxialUnit(6000.0, 25000.0, 380.0))


def first_harmonic(time, values, omega, since):
    """Amplitude and phase [rad] of the first harmonic, by least squares after `since`."""
    late = time >= since
    basis = np.column_stack((np.ones(late.sum()), np.sin(omega * time[late]), np.cos(omega * time[late])))
    _, sine, cosine = np.linalg.lstsq(basis, values[late], rcond=None)[0]
    return math.hypot(sine, cosine), math.atan2(cosine, sine)


def ramped_sine(time, omega, amplitude, ramp=60.0):
    share = np.clip(time / ramp, 0.0, 1.0)
    return amplitude * 0.5 * (1.0 - np.cos(np.pi * share)) * np.sin(omega * time)


def test_a_cable_at_rest_stays_at_rest_under_its_static_tension():
    response = simulate_axial(LINE, 300.0, np.zeros(200), 0.05)
    # by hand: weight of unit and cable
    assert response.top_tension == pytest.approx(25000.0 + 300.0 * 35.0, rel=1e-9)
    assert response.unit_heave == pytest.approx(0.0, abs=1e-9)


def test_static_stretch_is_that_of_a_hanging_bar():
    assert LINE.static_stretch(300.0) == pytest.approx((25000.0 * 300.0 + 0.5 * 35.0 * 300.0**2) / 1.5e7, rel=1e-12)


def test_paid_out_cable_lowers_the_unit_by_its_length_and_its_stretch():
    time = np.arange(0.0, 120.0, 0.05)
    share = np.clip(time / 100.0, 0.0, 1.0)
    payout = 20.0 * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)  # smooth: no oscillation is left
    response = simulate_axial(LINE, 300.0, np.zeros_like(time), 0.05, payout=payout)
    stretch = LINE.static_stretch(320.0) - LINE.static_stretch(300.0)
    assert response.unit_heave[-200:].mean() == pytest.approx(-20.0 - stretch, abs=2e-4)
    assert response.top_tension[-200:].mean() == pytest.approx(25000.0 + 320.0 * 35.0, rel=1e-5)


@pytest.mark.parametrize("omega", [0.3, 0.8, 1.5, 4.0])
def test_small_regular_heave_gives_the_exact_linear_answer(omega):
    time = np.arange(0.0, 300.0, 0.05)
    response = simulate_axial(LINE, 300.0, ramped_sine(time, omega, 0.01), 0.05, largest_step=0.005)
    expected = heave_transfer_function(LINE, 300.0, [omega], amplitude=0.01)
    amplitude, phase = first_harmonic(time, response.unit_heave, omega, 150.0)
    assert amplitude == pytest.approx(0.01 * abs(expected.unit_heave[0]), rel=2e-3)
    assert phase == pytest.approx(float(np.angle(expected.unit_heave[0])), abs=1e-2)
    tension, _ = first_harmonic(time, response.top_tension, omega, 150.0)
    assert tension == pytest.approx(0.01 * abs(expected.top_tension[0]), rel=5e-3)


def test_time_steps_converge_at_second_order():
    time = np.arange(0.0, 80.0, 0.1)
    motion = ramped_sine(time, 1.2, 0.5, ramp=10.0)

    def run(step):
        return simulate_axial(LINE, 300.0, motion, 0.1, segments=20, largest_step=step).unit_heave

    exact = run(0.1 / 128)
    errors = [float(np.abs(run(0.1 / steps) - exact).max()) for steps in (4, 8, 16)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)
    assert math.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.2)


def test_segments_converge_at_second_order():
    # a heavy cable and a light unit, so that the cable's own mass matters
    line = AxialLine((AxialSection(math.inf, 1e6, 10.0, 60.0, 0.0),), AxialUnit(2000.0, 1e5))
    time = np.arange(0.0, 60.0, 0.1)
    motion = ramped_sine(time, 1.5, 0.2, ramp=10.0)

    def run(segments):
        return simulate_axial(line, 500.0, motion, 0.1, segments=segments, largest_step=0.02).unit_heave

    exact = run(320)
    errors = [float(np.abs(run(segments) - exact).max()) for segments in (5, 10, 20)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)
    assert math.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.3)


def test_a_violent_motion_makes_the_cable_slack_and_snap():
    time = np.arange(0.0, 60.0, 0.05)
    omega, amplitude = 2.0, 2.0
    response = simulate_axial(LINE, 300.0, ramped_sine(time, omega, amplitude, ramp=10.0), 0.05)
    assert response.least_tension.min() == 0.0
    assert np.all(response.least_tension >= 0.0)
    # a unit that cannot be pushed falls no faster than free: the linear answer would have negative tension
    linear = simulate_axial(LINE, 300.0, ramped_sine(time, omega, amplitude, ramp=10.0), 0.05, allow_slack=False)
    assert linear.least_tension.min() < 0.0
    assert response.top_tension.max() > 1.3 * LINE.static_top_tension(300.0)


def test_material_stays_at_rest_when_winch_and_boom_tip_move_alike():
    # the boom tip heaves and the winch feeds the same length: a real sheave leaves the cable below where it is
    time = np.arange(0.0, 100.0, 0.05)
    motion = ramped_sine(time, 1.256, 1.0, ramp=20.0)
    response = simulate_axial(LINE, 300.0, motion, 0.05, payout=motion)
    late = time > 40.0
    # tension feels the weight of the extra metre, and that a metre let out is longer by its strain (2.4 mm): to that
    # the line answers as to boom-tip heave
    strain = LINE.static_top_tension(300.0) / 1.5e7
    stretch = strain * abs(heave_transfer_function(LINE, 300.0, [1.256]).top_tension[0])
    assert np.ptp(response.top_tension[late]) / 2.0 == pytest.approx(35.0 + stretch, rel=0.03)
    assert np.abs(response.unit_heave[late]).max() < 5e-3


def test_a_joint_between_alike_sections_is_not_felt():
    section = AxialSection(110.0, 1.5e7, 5.0, 35.0, 0.7)
    joined = AxialLine((section, dataclasses.replace(section, length=math.inf)), LINE.unit)
    time = np.arange(0.0, 40.0, 0.05)
    motion = ramped_sine(time, 1.1, 1.0, ramp=10.0)
    one = simulate_axial(LINE, 300.0, motion, 0.05, payout=0.2 * time)
    other = simulate_axial(joined, 300.0, motion, 0.05, payout=0.2 * time)
    assert other.unit_heave == pytest.approx(one.unit_heave, abs=1e-9)


def test_a_clump_at_the_unit_is_part_of_the_unit():
    split = AxialLine(LINE.sections, AxialUnit(4000.0, 15000.0, 380.0), (AxialClump(0.0, 2000.0, 10000.0),))
    time = np.arange(0.0, 40.0, 0.05)
    motion = ramped_sine(time, 1.1, 1.0, ramp=10.0)
    one = simulate_axial(LINE, 300.0, motion, 0.05)
    other = simulate_axial(split, 300.0, motion, 0.05)
    assert other.unit_heave == pytest.approx(one.unit_heave, abs=1e-9)


@settings(max_examples=15, deadline=None)
@given(st.floats(50.0, 1000.0), st.floats(0.1, 3.0), st.floats(0.2, 2.0), st.floats(-0.5, 1.0))
def test_any_motion_gives_finite_answers_and_no_negative_tension(length, omega, amplitude, speed):
    time = np.arange(0.0, 30.0, 0.1)
    response = simulate_axial(
        LINE, length, ramped_sine(time, omega, amplitude, ramp=5.0), 0.1, payout=speed * time, segments=10
    )
    for values in (response.unit_heave, response.unit_velocity, response.top_tension, response.least_tension):
        assert np.all(np.isfinite(values))
    assert np.all(response.least_tension >= 0.0)


def test_parameters_become_a_line_of_the_same_weight_and_inertia():
    parameters = CableSimParameters(
        sections=SectionsParameters((40.0,), (0.06,), (0.0,), (9.0,), (2e7,)),
        clumps=ClumpsParameters((60.0,), (400.0,), (0.1,), (50.0,), (0.3,)),
    )
    line = axial_line(parameters)
    density, gravity = parameters.water_density, parameters.gravity
    assert line.unit.inertia == pytest.approx(3000.0 + 3000.0)
    assert line.unit.weight == pytest.approx((3000.0 - density * 0.354) * gravity)
    below = (9.0 - density * math.pi * 0.06**2 / 4.0) * gravity * 40.0
    above = parameters.cable.weight_in_fluid(density) * 260.0
    clump = (400.0 - density * 0.1) * gravity
    assert line.static_top_tension(300.0) == pytest.approx(line.unit.weight + below + above + clump)


def test_a_stiffening_cable_is_as_stiff_as_its_law_at_the_static_tension():
    cable = CableParameters(axial_stiffness=2e6, stiffness_quadratic=20.0, stiffness_cubic=0.0)
    parameters = CableSimParameters(cable=cable)
    line = axial_line(parameters)
    # by hand: half-way up T = EA e (1 + 20 e), slope EA (1 + 40 e)
    tension = line.unit.weight + 150.0 * cable.weight_in_fluid(parameters.water_density)
    strain = (-1.0 + math.sqrt(1.0 + 4.0 * 20.0 * tension / 2e6)) / 40.0
    assert line.sections[0].axial_stiffness == pytest.approx(2e6 * (1.0 + 40.0 * strain), rel=1e-9)


def test_a_law_that_yields_below_the_static_tension_is_refused():
    cable = CableParameters(axial_stiffness=2e6, stiffness_quadratic=-50.0)
    with pytest.raises(NoEquilibriumError, match="tension law"):
        axial_line(CableSimParameters(cable=cable))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"boom_tip_heave": np.array([0.0, math.nan, 0.0, 0.0])}, r"boom_tip_heave\[1\]"),
        ({"boom_tip_heave": np.zeros(3)}, "at least 4"),
        ({"payout": np.zeros(7)}, "same number"),
        ({"payout": np.full(10, -301.0)}, "cannot have a length of -1 m"),
        ({"segments": 0}, "segments"),
        ({"sample_period": 0.0}, "sample_period"),
    ],
)
def test_bad_input_is_refused_with_its_reason(arguments, message):
    given_arguments = {"boom_tip_heave": np.zeros(10), "sample_period": 0.1, **arguments}
    with pytest.raises(AxialError, match=message):
        simulate_axial(LINE, 300.0, given_arguments.pop("boom_tip_heave"), **given_arguments)
