"""Every shipped scenario is complete, fits every node's parameters, and says what it says on purpose."""

from __future__ import annotations

import json
import math
import re
import sys
from itertools import pairwise

import pytest
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bringup.cli import main
from heave_bringup.nodes import NODES
from heave_bringup.scenarios import Scenario, description_of, load_scenario, shipped_scenarios
from heave_node.loads.strength import payload_words
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.parameters import describe, flatten
from heave_node.scenario import read_sections
from heave_node.system_parameters import SYSTEM, owned_names, system_names

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
    "b11_splash_zone",
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
    assert checked.parameters["wave_vessel"].ramp <= checked.run.transient, "the motion has then its full size"
    assert 0.0 < checked.run.transient < checked.run.duration
    assert {criterion.kpi for criterion in checked.wanted} <= set(DEFINITION_OF)
    assert len(description_of(shipped_scenarios()[name])) > 20


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


@pytest.mark.parametrize("name", sorted(shipped_scenarios()))
def test_a_load_is_named_by_its_mass_in_air_and_its_weight_in_water_never_with_added_mass(name: str) -> None:
    plant = scenario(name).parameters["cable_sim"]
    words = description_of(shipped_scenarios()[name])
    if re.search(r"\d t\b", words):
        assert payload_words(plant.unit.mass, plant.unit.volume, plant.water_density) in words


def test_the_list_says_load_and_rope_of_each_scenario(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "--json", "-"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert set(listed) == set(shipped_scenarios())
    assert listed["b3_deep_900"]["mass_kg"] == 65_000.0
    # thesis 6.2.6: 50 kN in water
    assert listed["b3_deep_900"]["mass_in_water_kg"] * STANDARD_GRAVITY == pytest.approx(50_000.0, rel=1e-3)


def test_depth_programmes_stay_in_the_range_of_the_winch() -> None:
    for name in ("b6_resonance_payout", "b7_landing", "b11_splash_zone"):
        checked = scenario(name)
        programme, winch = checked.parameters["winch_controller"].programme, checked.parameters["virtual_winch"]
        assert programme.move_times, name
        assert all(winch.payout_minimum < payout < winch.payout_maximum for payout in programme.move_payouts), name
        assert programme.move_times[-1] < checked.run.duration
        assert checked.parameters["cable_sim"].shadow_follows_programme


def test_b6_passes_from_50_to_900_metres() -> None:
    parameters = scenario("b6_resonance_payout").parameters
    length = parameters["cable_sim"].length
    assert (length, length + parameters["winch_controller"].programme.move_payouts[0]) == (50.0, 900.0)


def test_b7_reaches_the_seabed_at_600_metres() -> None:
    parameters = scenario("b7_landing").parameters
    plant = parameters["cable_sim"]
    assert plant.seabed.depth == 600.0
    assert plant.length < plant.seabed.depth < plant.length + max(parameters["winch_controller"].programme.move_payouts)


def test_b11_hangs_above_the_crests_and_ends_below_the_troughs_of_the_sea_that_moves_the_vessel() -> None:
    parameters = scenario("b11_splash_zone").parameters
    plant, sea = parameters["cable_sim"], parameters["wave_vessel"]
    assert plant.wave.source == "sea"
    underside = plant.boom_tip_height - plant.length
    end = underside - parameters["winch_controller"].programme.move_payouts[0]
    assert underside > 3.0 * sea.significant_wave_height
    assert end + plant.unit.box.height < -3.0 * sea.significant_wave_height


@pytest.mark.parametrize("name", sorted(shipped_scenarios()))
def test_a_file_says_each_thing_once(name: str) -> None:
    """What ship and controller share stands under `/**`; a node's section has what differs from it, and what is its
    own."""
    sections = read_sections(shipped_scenarios()[name])
    shared = sections["/**"]
    for node in NODES:
        infos = {info.name: info for info in describe(node.parameters_type())}
        own = sections.get(f"/**/{node.name}", {})
        for system, mine in system_names(node.name, infos).items():
            if mine in own:
                assert own[mine] != shared.get(system, infos[mine].default), f"{node.name}.{mine} stands twice"
    assert set(sections) <= {"/**", *(f"/**/{node.name}" for node in NODES)}


def test_the_benchmarks_want_what_their_table_says() -> None:
    # BENCHMARKS, column "world class"; "worse < 0.15" is an efficiency above 0.85
    expected = {
        "b2_calm_300": {"outlet_efficiency >= 0.95", "significant_residual_m <= 0.05", "time_at_limit_percent <= 0.0"},
        "b3_deep_900": {"unit_sigma_m <= 0.005", "kappa <= 2.5"},
        "b4_limit_900_tp8": {"unit_sigma_m <= 0.019", "unit_efficiency > 0.85"},
        "b4_limit_900_tp10": {"unit_sigma_m <= 0.018", "unit_efficiency > 0.85"},
        "b4_limit_900_tp12": {"unit_sigma_m <= 0.012", "unit_efficiency > 0.85"},
        "b5_storm": {"unit_efficiency >= 0.0"},
        "b7_landing": {
            *("tension_ratio_min >= 0.1", "landings_held >= 1.0", "touchdown_speed_mps <= 0.3"),
            *("touchdown_rebound_m <= 0.02", "mode_changes >= 2.0"),
        },
        "b8_faults": {"slack_percent <= 0.0"},
        "b10_real_mru_swell": {"unit_efficiency >= 0.97"},
        "b11_splash_zone": {"tension_ratio_min >= 0.1", "dynamic_amplification <= 1.3", "snaps <= 0.0"},
    }
    for name in NAMES:
        assert {f"{c.kpi} {c.text}" for c in scenario(name).wanted} == expected.get(name, set()), name


def test_a_shared_name_means_the_same_to_every_node_that_takes_it() -> None:
    """Unit, type and default agree, and the controller assumes nothing that the owner does not have."""
    infos = {node.name: {info.name: info for info in describe(node.parameters_type())} for node in NODES}
    owners = {s: (n, own) for n, known in infos.items() for s, own in owned_names(n, known).items()}
    free = {"system.linear.inertia", "system.linear.damping"}  # 0 takes the controller's from cable, unit and length
    for node, known in infos.items():
        for system, own in system_names(node, known).items():
            owner, owners_own = owners[system]
            mine, theirs = known[own], infos[owner][owners_own]
            assert (mine.unit, mine.type, mine.is_array) == (theirs.unit, theirs.type, theirs.is_array), system
            assert mine.default == theirs.default or system in free, system
    assert all(name.startswith(SYSTEM) for name in owners)


@pytest.mark.parametrize("name", sorted(shipped_scenarios()))
def test_nodes_take_from_the_file_what_the_command_takes(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same file serves `heave run`, `ros2 run --params-file` and `ros2 launch`, in any namespace."""
    rclpy = pytest.importorskip("rclpy")
    from heave_node.ros.node_parameters import read_parameters  # noqa: PLC0415

    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    arguments = ["--ros-args", "--params-file", str(shipped_scenarios()[name])]
    monkeypatch.setattr(sys, "argv", ["node", *arguments])
    context = rclpy.Context()
    rclpy.init(args=arguments, context=context)
    expected = scenario(name)
    try:
        for number, entry in enumerate(NODES):
            node = rclpy.create_node(
                entry.name,
                namespace=("", "/ship")[number % 2],
                context=context,
                automatically_declare_parameters_from_overrides=True,
            )
            run, own = read_parameters(node, entry.parameters_type())
            node.destroy_node()
            assert run == expected.run
            assert own == expected.parameters[entry.name]
    finally:
        rclpy.shutdown(context=context)
