"""Designing a controller: what comes out, and what is refused in words."""

import numpy as np
import pytest
from heave_node.numerics.linear_model import linear_model, spectral_abscissa, with_feedback
from heave_node.parameters import ParameterError, build_parameters
from winch_controller_node.design.design import design_controller
from winch_controller_node.model.lqr import DesignError, QuadraticCost, check_stabilisable, lqr_gain
from winch_controller_node.model.regulator import unit_regulator_gain
from winch_controller_node.node_parameters import WinchControllerParameters


def parameters(**values):
    named = {name.replace("__", "."): value for name, value in values.items()}
    return build_parameters(WinchControllerParameters, named, where="test: winch_controller")


def design(**values):
    return design_controller(parameters(**values), tick_period=0.05)


def test_the_closed_loop_of_the_full_state_gain_is_stable():
    result = design()
    closed = with_feedback(result.model, result.gain)
    slow = [name for name in closed.state_names if name == "depth_bias"]
    keep = [name for name in closed.state_names if name not in slow]
    assert spectral_abscissa(closed.select_states(keep)) < 1.0


def test_the_delay_of_0_2_s_is_four_past_commands():
    assert design().delay_states == tuple(f"payout_rate_command_{i}" for i in (1, 2, 3, 4))


def test_sensor_states_have_no_gain():
    result = design(sensors__mru__high_pass_period=60.0, sensors__mru__scale_sigma=0.05)
    for name in ("mru_offset", "mru_offset_rate", "mru_scale", "depth_bias"):
        assert result.gain[result.model.state(name)] == 0.0


def test_the_regulator_is_that_of_unit_winch_and_delay_alone():
    """The states of the sea, which nobody controls, change no gain of the others: the thesis's plant has none."""
    result = design(weights__outlet_heave=0.0)
    alone = unit_regulator_gain(result.parameters.weights, result.model)
    plant = [i for i, name in enumerate(result.model.state_names) if not name.startswith(("vessel_", "wave_"))]
    np.testing.assert_allclose(alone[plant], result.gain[plant])
    assert np.count_nonzero(alone) < np.count_nonzero(result.gain)
    # a weight of the outlet would hold the payout where it is, as if the boom tip stood still
    held = design(weights__outlet_heave=0.05)
    np.testing.assert_array_equal(unit_regulator_gain(held.parameters.weights, held.model), alone)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"weights__command": 0.0}, "weights.command must be above 0"),
        ({"weights__unit_heave": 0.0, "weights__outlet_heave": 0.0, "weights__payout": 0.0,
        "weights__payout_acceleration": 0.0}, "no output has a weight"), ({"weights__outlet_heave": 0.0,
        "weights__unit_heave": 0.0, "weights__payout": 0.0}, "leave .*payout.* free"), ({"sensors__use": ("mru",
        "depth")}, "must include the encoder"), ({"sensors__use": ("encoder",)}, "must include one of mru"),
        ({"sensors__use": ("mru", "encoder"), "sensors__mru__scale_sigma": 0.05}, "mru_scale cannot be observed"),
        ({"winch__command_delay": 20.0}, "longer than the boom tip can usefully"),
        ({"unit__mass": 55000.0, "unit__volume": 58.44}, "the load floats: .* 58.44 m.3 displaces .* 55000 kg"),
    ],
)  # fmt: skip
def test_what_cannot_be_designed_is_refused_in_words(values, message):
    with pytest.raises(DesignError, match=message):
        design(**values)


@pytest.mark.parametrize(
    ("values", "tick_period", "message"),
    [
        ({"winch__command_delay": 1.9}, 0.02, r"^estimator: \d+ states, and at most 96 fit: use longer ticks, .*delay"),
        ({"estimator__largest_age": 10.0}, 0.02, r"^estimator: 501 ticks of .*: lower estimator.largest_age$"),
    ],
)
def test_a_model_that_does_not_fit_the_core_is_refused_in_one_line(values, tick_period, message):
    with pytest.raises(DesignError, match=message):
        design_controller(parameters(**values), tick_period=tick_period)


def test_depth_bias_that_no_other_sensor_resolves_is_named():
    # depth with a free bias sees x + bias; without MRU the mean of x is still tied to the payout, so this is detectable
    assert design(sensors__use=("depth", "encoder")).model.has_state("depth_bias")


def test_an_unknown_sensor_is_refused_by_the_parameter_check():
    with pytest.raises(ParameterError, match="one of mru"):
        parameters(sensors__use=("sonar", "encoder"))


def test_a_growing_state_out_of_reach_is_named():
    model = linear_model([[0.1, 0.0], [0.0, -1.0]], states=("runaway", "x"), inputs={"u": [0.0, 1.0]})
    with pytest.raises(DesignError, match="no effect on runaway"):
        check_stabilisable(model)


def test_indefinite_weights_are_refused():
    model = linear_model([[-1.0]], states=("x",), inputs={"u": [1.0]})
    with pytest.raises(DesignError, match="indefinite"):
        lqr_gain(model, QuadraticCost(-np.eye(1), np.zeros((1, 1)), np.eye(1)))


def test_an_identified_cable_is_taken_as_given():
    result = design(cable_model__inertia=0.9, cable_model__damping=0.2, cable_model__inertia_factor=1.3)
    assert (result.cable.a, result.cable.b) == (pytest.approx(1.17), pytest.approx(0.2))


def test_the_static_tension_is_that_of_the_length_that_is_out():
    """40 t and 8 m^3 in a box of 4 m below a boom tip 25 m up: in air on 17 m of wire, under water from 29 m on.

    By hand: M g = 392.27 kN, buoyancy 1025 x 8 x g = 80.41 kN, wire w = (m - rho pi/4 d^2) g a metre.
    """
    box = {"unit__box__length": 5.0, "unit__box__breadth": 4.0, "unit__box__height": 4.0}
    given = {"unit__mass": 40e3, "unit__volume": 8.0, "length": 17.0, "boom_tip_height": 25.0}
    wire = {"cable__diameter": 0.048, "cable__mass_per_length": 9.4, "cable__axial_stiffness": 9e7}
    result = design(**given, **wire, **box)
    gravity, buoyancy = 9.80665, 1025.0 * 8.0 * 9.80665
    metre = (9.4 - 1025.0 * np.pi / 4.0 * 0.048**2) * gravity
    top = {length: 40e3 * gravity + metre * length for length in (17.0, 27.0, 41.0)}
    assert result.cable.unit_weight == pytest.approx(40e3 * gravity)
    assert result.cable.static_tension == result.static_tension_at(17.0) == pytest.approx(top[17.0])
    assert result.static_tension_at(27.0) == pytest.approx(top[27.0] - 0.5 * buoyancy)
    assert result.static_tension_at(41.0) == pytest.approx(top[41.0] - buoyancy)
    assert result.wet_tension == pytest.approx(top[17.0] - buoyancy)
    # without a box all of it is always under water
    bare = design(**given, **wire)
    assert bare.cable.static_tension == bare.wet_tension == pytest.approx(top[17.0] - buoyancy)


def test_the_assumed_period_of_a_unit_in_air_has_no_added_mass():
    """a = M L/EA in air, (M + A33) L/EA under water; the wire's own mass is a third of 160 kg."""
    box = {"unit__box__length": 5.0, "unit__box__breadth": 4.0, "unit__box__height": 4.0}
    given = {"unit__mass": 40e3, "unit__added_mass": (0.0, 0.0, 30e3), "length": 17.0, "boom_tip_height": 25.0}
    wire = {"cable__diameter": 0.048, "cable__mass_per_length": 9.4, "cable__axial_stiffness": 9e7}
    in_air, wet = (design(**given, **wire, **one).cable for one in (box, {}))
    assert in_air.natural_a == pytest.approx(40e3 * 17.0 / 9e7, rel=3e-3)
    assert wet.natural_a == pytest.approx(70e3 * 17.0 / 9e7, rel=3e-3)
