"""Every shipped scenario is complete, fits every node's parameters, and says what it says on purpose."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise
from pathlib import Path

import pytest
from heave_bringup.run.node_table import NODES
from heave_bringup.scenarios import Scenario, description_of, load_scenario, shipped_scenarios
from heave_node.parameters import flatten
from heave_node.scenario import read_scenario, values_of_node

NAMES = (
    "b1_thesis",
    "b2_calm_300",
    "b3_deep_900",
    "b4_limit_900_tp8",
    "b4_limit_900_tp10",
    "b4_limit_900_tp12",
    "b5_storm",
    "b6_resonance_payout",
    "b7_landing",
    "b8_faults",
    "b9_model_error",
    "b10_real_mru_swell",
    "s300_driven",
    "s900_driven",
)
SYSTEMS = {"s900": [name for name in NAMES if "900" in name], "s300": ["b2_calm_300", "s300_driven"]}


def scenario(name: str) -> Scenario:
    return load_scenario(name)


def test_all_scenarios_of_the_contract_are_shipped() -> None:
    assert set(NAMES) <= set(shipped_scenarios())


@pytest.mark.parametrize("name", sorted(shipped_scenarios()))
def test_scenario_fits_every_node_and_says_what_it_is(name: str) -> None:
    checked = scenario(name)
    assert set(checked.parameters) == {node.name for node in NODES}
    assert 0.0 < checked.run.transient < checked.run.duration
    assert len(description_of(shipped_scenarios()[name])) > 20


@pytest.mark.parametrize("name", sorted(shipped_scenarios()))
def test_motion_has_grown_to_its_full_size_before_the_evaluation_begins(name: str) -> None:
    checked = scenario(name)
    assert checked.parameters["wave_vessel"].ramp <= checked.run.transient


@pytest.mark.parametrize("name", sorted(set(NAMES) - {"b9_model_error"}))
def test_controller_believes_in_the_plant_and_the_winch_of_the_scenario(name: str) -> None:
    parameters = scenario(name).parameters
    plant, winch, controller = parameters["cable_sim"], parameters["virtual_winch"], parameters["winch_controller"]
    assert controller.length == plant.length
    assert controller.cable == plant.cable
    assert controller.unit == plant.unit
    real = flatten(winch)
    for key, value in flatten(controller.winch).items():
        assert key not in real or real[key] == value, key


def test_b9_is_the_system_of_b3_with_a_plant_and_a_winch_the_controller_does_not_know() -> None:
    nominal, wrong = scenario("b3_deep_900").parameters, scenario("b9_model_error").parameters
    assert wrong["winch_controller"] == nominal["winch_controller"]
    assert wrong["virtual_winch"].command_delay - nominal["virtual_winch"].command_delay == pytest.approx(0.1)
    assert wrong["virtual_winch"].time_constant / nominal["virtual_winch"].time_constant == pytest.approx(1.5)
    masses = [p["cable_sim"].unit.mass + p["cable_sim"].unit.added_mass[2] for p in (nominal, wrong)]
    assert masses[1] / masses[0] == pytest.approx(1.3)


@pytest.mark.parametrize("name", SYSTEMS["s900"])
def test_s900_is_the_system_of_thesis_6_2_6(name: str) -> None:
    plant = scenario(name).parameters["cable_sim"]
    assert plant.length == 900.0
    # 54 N/m and 50 kN in water, E 9.09e9 Pa, effective mass 125 t.
    assert plant.cable.weight_in_fluid(plant.water_density) == pytest.approx(54.0, rel=1e-4)
    assert plant.unit.weight_in_fluid(plant.water_density) == pytest.approx(50_000.0, rel=1e-4)
    assert plant.cable.axial_stiffness == pytest.approx(9.09e9 * math.pi * 0.047**2 / 4.0, rel=1e-6)
    assert plant.unit.mass + plant.unit.added_mass[2] == pytest.approx(125_000.0)
    assert (plant.cable.tangential_drag, plant.unit.drag_coefficient[2], plant.unit.drag_area[2]) == (0.025, 1.0, 1.0)


@pytest.mark.parametrize("name", SYSTEMS["s300"])
def test_s300_is_the_system_of_thesis_5_7(name: str) -> None:
    plant = scenario(name).parameters["cable_sim"]
    assert plant.cable.axial_stiffness == pytest.approx(9e9 * math.pi * 0.047**2 / 4.0, rel=1e-6)
    # Peer's weight of this cable in water.
    assert plant.cable.weight_in_fluid(plant.water_density) == pytest.approx(35.517, rel=1e-4)
    assert (plant.length, plant.unit.mass, plant.unit.volume) == (300.0, 3000.0, 0.354)


def test_sea_states_are_those_of_their_names() -> None:
    expected = {
        "b2_calm_300": (1.0, 6.0),
        "b3_deep_900": (1.5, 10.0),
        "b4_limit_900_tp8": (3.0, 8.0),
        "b4_limit_900_tp10": (3.0, 10.0),
        "b4_limit_900_tp12": (3.0, 12.0),
    }
    for name, (height, period) in expected.items():
        parameters = scenario(name).parameters
        for sea in (parameters["wave_vessel"], parameters["winch_controller"].sea):
            assert (sea.significant_wave_height, sea.peak_period) == (height, period), name


def test_faults_of_b8_come_one_after_the_other_and_the_emergency_stop_last() -> None:
    parameters = scenario("b8_faults").parameters
    mru, winch = parameters["wave_vessel"].mru, parameters["virtual_winch"]
    times = [
        *mru.faults.start,
        *parameters["cable_sim"].sensors.depth.faults.start,
        *winch.encoder.faults.start,
        *winch.faults.start,
    ]
    assert len(times) == 9
    assert min(b - a for a, b in pairwise(times)) >= 100.0
    assert winch.faults.kind[-1] == "emergency_stop"
    assert mru.faults.duration[mru.faults.kind.index("gap")] == 5.0
    assert times[-1] < scenario("b8_faults").run.duration


def test_scenario_files_are_plain_ros_parameter_files() -> None:
    for path in shipped_scenarios().values():
        text = path.read_text(encoding="utf-8")
        assert "ros__parameters:" in text
        # What ROS 2's own reader does not take: aliases, and empty lists, whose type it cannot know.
        assert not any(mark in text for mark in ("&", "<<", "[]")), path


def test_description_is_the_first_line_of_the_file() -> None:
    path = Path(shipped_scenarios()["b2_calm_300"])
    assert description_of(path).startswith("B2 Calm-300")


def test_parameter_sets_are_frozen() -> None:
    for parameters in scenario("b2_calm_300").parameters.values():
        with pytest.raises(dataclasses.FrozenInstanceError):
            parameters.law = "off"


def test_depth_programmes_stay_in_the_range_of_the_winch() -> None:
    for name in ("b6_resonance_payout", "b7_landing"):
        checked = scenario(name)
        programme, winch = checked.parameters["winch_controller"].programme, checked.parameters["virtual_winch"]
        assert programme.move_times, name
        assert all(winch.payout_minimum < payout < winch.payout_maximum for payout in programme.move_payouts), name
        assert programme.move_times[-1] < checked.run.duration
        assert checked.parameters["cable_sim"].shadow_follows_programme


def test_b6_passes_from_50_to_900_metres_and_the_gains_are_scheduled_over_all_of_it() -> None:
    parameters = scenario("b6_resonance_payout").parameters
    length = parameters["cable_sim"].length
    assert (length, length + parameters["winch_controller"].programme.move_payouts[0]) == (50.0, 900.0)
    schedule = parameters["winch_controller"].schedule
    assert (schedule.minimum_length, schedule.maximum_length) == (50.0, 900.0)


def test_b7_reaches_the_seabed_at_600_metres() -> None:
    parameters = scenario("b7_landing").parameters
    plant = parameters["cable_sim"]
    assert plant.seabed.depth == 600.0
    assert plant.length < plant.seabed.depth < plant.length + max(parameters["winch_controller"].programme.move_payouts)


@pytest.mark.parametrize("name", sorted(shipped_scenarios()))
def test_ros_reads_the_file_as_we_do(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    rclpy = pytest.importorskip("rclpy")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    path = shipped_scenarios()[name]
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(path)], context=context)
    try:
        for node_name in ("winch_controller", "cable_sim"):
            node = rclpy.create_node(
                node_name,
                context=context,
                automatically_declare_parameters_from_overrides=True,
                use_global_arguments=True,
            )
            read = {key: p.value for key, p in node.get_parameters_by_prefix("").items() if key != "use_sim_time"}
            node.destroy_node()
            read = {key: list(v) if hasattr(v, "__iter__") and not isinstance(v, str) else v for key, v in read.items()}
            expected = values_of_node(read_scenario(path), node_name)
            read.pop("start_type_description_service", None)
            assert read == expected
    finally:
        rclpy.shutdown(context=context)
