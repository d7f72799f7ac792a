"""The blocks of the controller's model."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_node.numerics.linear_model import ModelError, interconnect, is_stable, state_covariance
from heave_node.parameters import build_parameters
from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.sources.scene import build_scene
from winch_controller_node.interface.sensors import LEAST_NOISE, KnownSensors, MruModelParameters
from winch_controller_node.model.blocks import CableModel, cable_block, mru_block, winch_block
from winch_controller_node.model.models import boom_tip_block, boom_tip_response, sea_spectrum, shadow_model
from winch_controller_node.parameters.model import SeaModelParameters, VesselModelParameters, WinchModelParameters


def test_the_mru_states_are_its_high_pass():
    mru = mru_block(MruModelParameters(high_pass_period=60.0, high_pass_damping=0.7))
    cut_off = 2.0 * math.pi / 60.0
    for omega in (0.05, 0.2, 0.8):
        s = 1j * omega
        inputs = np.array([1.0, s])  # heave and its rate
        outputs = mru.C @ np.linalg.solve(s * np.eye(2) - mru.A, mru.B @ inputs) + mru.D @ inputs
        exact = s**2 / (s**2 + 2.0 * 0.7 * cut_off * s + cut_off**2)
        assert outputs == pytest.approx([exact, s * exact], rel=1e-9)


def test_the_shadow_unit_follows_the_cables_transfer_function():
    cable = CableModel(2.0, 0.3)
    model = shadow_model(cable, 0.05)
    omega = 0.7
    t = 0.05 * np.arange(4000)
    heave, rate = np.sin(omega * t), omega * np.cos(omega * t)
    x = np.zeros(2)
    trace = []
    for inputs in zip(heave, rate, strict=True):
        trace.append(x[0])
        x = model.A @ x + model.B @ np.array(inputs)
    basis = np.column_stack([np.sin(omega * t), np.cos(omega * t)])[2000:]
    amplitude = np.hypot(*np.linalg.lstsq(basis, np.array(trace)[2000:], rcond=None)[0])
    assert amplitude == pytest.approx(abs(1.0 / (1.0 - 2.0 * omega**2 + 0.3j * omega)), rel=1e-3)


def test_payout_lowers_the_unit_by_as_much_in_the_long_run():
    model = interconnect([cable_block(CableModel(2.0, 1.5)), winch_block(WinchModelParameters(law="first_order"))])
    assert is_stable(model)
    steady = -np.linalg.solve(model.A, model.B[:, list(model.input_names).index("payout_command")])
    assert steady[model.state("unit_heave")] == pytest.approx(-1.0)
    assert steady[model.state("payout")] == pytest.approx(1.0)


@pytest.mark.parametrize("course", [{}, {"heading": 1.0, "speed": 1.0}, {"heading": -2.0}])
def test_a_vessel_with_raos_is_designed_for_as_the_ship_moves(course):
    """The boom tip's variance in the belief is that of the ship's own scene, by quadrature over its RAOs."""
    sea = {"significant_wave_height": 2.0, "peak_period": 9.0}
    ship = build_scene(
        build_parameters(
            WaveVesselParameters,
            {**sea, "vessel.model": "rao", **{f"course.{name}": value for name, value in course.items()}},
            where="test",
        ),
        1,
        0.05,
    )
    omega = np.linspace(0.02, 5.0, 5000)
    variance = np.sum(ship.power_response(omega) * ship.spectrum.density(omega)) * (omega[1] - omega[0])
    assumed_sea, vessel = SeaModelParameters(**sea), VesselModelParameters(model="rao", **course)
    response = boom_tip_response(assumed_sea, vessel, omega)
    assumed = np.sum(np.abs(response) ** 2 * sea_spectrum(assumed_sea).density(omega)) * (omega[1] - omega[0])
    # here the ship turns to its course at each frequency of the table, there between the frequencies
    assert assumed == pytest.approx(variance, rel=1e-4)
    tip = boom_tip_block(assumed_sea, vessel)
    row = tip.row("boom_tip_heave")
    # the second-order fit and the shaping filter are approximations: 5 % of sigma
    assert math.sqrt(row @ state_covariance(tip) @ row) == pytest.approx(math.sqrt(variance), rel=0.05)


def test_raos_that_cannot_be_read_are_refused_with_the_parameter():
    vessel = VesselModelParameters(model="fitted", rao_file="no_such.csv")
    with pytest.raises(ModelError, match=r"vessel\.rao_file: no_such\.csv: no such file"):
        boom_tip_block(SeaModelParameters(), vessel)


def test_a_sensor_that_is_stated_as_perfect_is_given_some_noise():
    perfect = {"noise": 0.0, "rate_noise": 0.0, "model_error": 0.0}
    for sensor in KnownSensors().by_name().values():
        known = {name: value for name, value in perfect.items() if hasattr(sensor, name)}
        assert {row.sigma for row in replace(sensor, **known).rows()} == {LEAST_NOISE}
