"""Scenarios: a file, the user's changes on top of it, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from cable_sim_node.winch.installed_drives import installed_drives
from heave_bringup.nodes import NODES
from heave_bringup.scenarios import load_scenario, make_scenario, shipped_scenarios
from heave_bringup.settings import Setting, make_setting, parse_setting
from heave_bringup.stored_scenario import stored_sections, stored_title
from heave_node.criteria import Criterion
from heave_node.parameters import ParameterError, ParameterInfo, describe, flatten
from heave_node.run_parameters import RunParameters
from heave_node.scenario import read_sections, write_sections
from heave_node.system_parameters import system_names
from hypothesis import given, settings
from hypothesis import strategies as st

OLD_FORM = """
/**: {ros__parameters: {seed: 4}}
wave_vessel: {ros__parameters: {peak_period: 9.0}}
winch_controller: {ros__parameters: {sea: {peak_period: 9.0}}}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "own.yaml"


def sea_periods(scenario):
    return scenario.parameters["wave_vessel"].peak_period, scenario.parameters["winch_controller"].sea.peak_period


def test_a_change_of_the_system_changes_the_sea_and_the_belief_of_it_and_a_change_of_a_node_the_truth_alone() -> None:
    assert sea_periods(load_scenario("b2_calm_300", settings=["system.sea.peak_period=8"])) == (8.0, 8.0)
    assert sea_periods(load_scenario("b2_calm_300", settings=["wave_vessel.peak_period=8"])) == (8.0, 6.0)
    assert sea_periods(load_scenario("b2_calm_300", settings=["winch_controller.sea.peak_period=8"])) == (6.0, 8.0)


@pytest.mark.parametrize(
    ("setting", "node", "name", "value"),
    [
        ("system.length=310", "cable_sim", "length", 310.0),
        ("system.length=310", "winch_controller", "length", 310.0),
        ("system.winch.speed_limit=1.5", "virtual_winch", "speed_limit", 1.5),
        ("system.winch.speed_limit=1.5", "winch_controller", "winch.speed_limit", 1.5),
        ("system.unit.added_mass=[1, 2, 3]", "cable_sim", "unit.added_mass", (1.0, 2.0, 3.0)),
        ("system.unit.added_mass=[1, 2, 3]", "winch_controller", "unit.added_mass", (1.0, 2.0, 3.0)),
        ("system.boom_tip_height=15", "wave_vessel", "boom_tip_height", 15.0),
        ("system.boom_tip_height=15", "cable_sim", "boom_tip_height", 15.0),
        ("system.boom_tip_height=15", "winch_controller", "boom_tip_height", 15.0),
        ("system.vessel.pitch_gain=1", "wave_vessel", "vessel.pitch_gain", 1.0),
        ("system.sensors.mru.noise=0.05", "wave_vessel", "mru.noise", 0.05),
        ("system.sensors.mru.noise=0.05", "winch_controller", "sensors.mru.noise", 0.05),
    ],
)
def test_a_shared_value_reaches_every_node_that_has_it(setting, node, name, value) -> None:
    assert flatten(load_scenario("b2_calm_300", settings=[setting]).parameters[node])[name] == value


def test_a_section_may_name_its_node_in_any_namespace_or_in_none(file) -> None:
    for section in ("wave_vessel", "/wave_vessel", "/**/wave_vessel"):
        file.write_text(f"{section}: {{ros__parameters: {{peak_period: 9.0}}}}\n")
        assert sea_periods(load_scenario(str(file))) == (9.0, 8.0)


@pytest.mark.parametrize("setting", ["system.sea.peak_period=8", "all.seed=5"])
def test_a_change_for_all_nodes_that_one_of_them_would_not_take_is_refused(file, setting) -> None:
    file.write_text(OLD_FORM)
    if setting.startswith("all"):
        assert load_scenario(str(file), settings=[setting]).run.seed == 5
        return
    with pytest.raises(ParameterError) as refusal:
        load_scenario(str(file), settings=[setting])
    assert str(refusal.value) == (
        f"--set {setting}: {file}: /wave_vessel: peak_period = 9.0 overrides this; set wave_vessel.peak_period as well"
    )
    both = [setting, "wave_vessel.peak_period=7", "winch_controller.sea.peak_period=6"]
    assert sea_periods(load_scenario(str(file), settings=both)) == (7.0, 6.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("wave_vesel: {ros__parameters: {a: 1}}", "no such node: wave_vesel; did you mean /**/wave_vessel?"),
        ("/ship/wave_vessel: {ros__parameters: {a: 1}}", "no such node: ship/wave_vessel; did you mean /**/wave_v"),
        (
            "/**: {ros__parameters: {length: 3.0}}",
            "/**: there is no parameter length; did you mean system.length or system.unit.box.length?",
        ),
        ("/**: {ros__parameters: {system: {sea: {peak: 3.0}}}}", "/**: there is no parameter system.sea.peak; did"),
        ("cable_sim: {ros__parameters: {seed: 3}}", "/cable_sim: all nodes share seed: set it under /**"),
        ("cable_sim: {ros__parameters: {system: {length: 3.0}}}", "/cable_sim: all nodes share system.length: set it"),
        ("cable_sim: {ros__parameters: {wanted: {kappa: '< 2'}}}", "/cable_sim: all nodes share wanted.kappa: set it"),
        ("/**: {ros__parameters: {wanted: {kappa: 2}}}", "/**: wanted.kappa = 2 is not allowed"),
        (
            "cable_sim: {ros__parameters: {length: 3.0}}\n/**/cable_sim: {ros__parameters: {length: 4.0}}",
            "length appears twice, in two sections for cable_sim",
        ),
        (
            "/**: {ros__parameters: {system: {sea: {significant_wave_height: 0.0}}}}",
            "/**: system.sea.significant_wave_height = 0.0 is not allowed for winch_controller: it must be a number",
        ),
        (
            "winch_controller: {ros__parameters: {winch: {payout_minimum: 60.0}}}",
            "own.yaml: winch_controller: winch.payout_minimum = 60 m must be below",
        ),
    ],
)
def test_what_is_wrong_with_a_file_is_told_in_one_line(file, text, words) -> None:
    file.write_text(text)
    with pytest.raises(ParameterError) as refusal:
        load_scenario(str(file))
    assert str(refusal.value).startswith(str(file))
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("wave_vessel.peak_period", "must be NODE.PARAM=VALUE, for example system.sea.peak_period=9"),
        ("peak_period=9", "peak_period is not a parameter; write NODE.PARAM or system.PARAM"),
        ("wave_vesel.peak_period=9", "no such node: wave_vesel; did you mean wave_vessel?"),
        ("xyz.peak_period=9", "no such node: xyz; known: system, wanted, all, cable_sim"),
        ("wave_vessel.peak_period=[1", "'[1' is not a YAML value"),
        ("wave_vessel.peak_perid=9", "there is no parameter peak_perid; did you mean peak_period?"),
        ("virtual_winch.law=off", "must be one of speed_servo, first_order; did you mean winch_controller.law?"),
        (
            "system.sea.spectrum=file",
            "is not allowed for winch_controller: it must be one of bretschneider, pierson_moskowitz, jonswap, "
            "ochi_hubble; did you mean wave_vessel.spectrum?",
        ),
        ("virtual_winch.mru.noise=0.1", "there is no parameter mru.noise; did you mean wave_vessel.mru.noise?"),
        (
            "system.sea.peak_perid=9",
            "there is no parameter system.sea.peak_perid; did you mean system.sea.peak_period?",
        ),
        (
            "winch_controller.speed_gain=1.1",
            "parameter speed_gain; did you mean ",
        ),
        (
            "virtual_winch.winch.power_limit=9",
            "did you mean virtual_winch.power_limit or winch_controller.winch.power_",
        ),
        ("winch_controller.winch.gain=1.1", "there is no parameter winch.gain; did you mean winch.speed_gain?"),
        (
            "system.winch.hauling_gain=1.1",
            "there is no parameter system.winch.hauling_gain; did you mean winch_controller.winch.hauling_gain?",
        ),
        ("system.mru.noise=0.1", "did you mean system.sensors.mru.noise?"),
        ("all.maximum_tension_ratio=2", "did you mean winch_controller.limits.maximum_tension_ratio?"),
        ("all.length=9", "there is no parameter length; did you mean system.length or system.unit.box.length?"),
        ("wave_vessel.peak_period=99", "peak_period = 99.0 is not allowed: it must be a number from 1 to 40 [s]"),
        ("cable_sim.seed=2", "all nodes share seed: set it under /**"),
    ],
)
def test_what_is_wrong_with_a_setting_is_told_with_the_setting(text, words) -> None:
    with pytest.raises(ParameterError) as refusal:
        load_scenario("b2_calm_300", settings=[text])
    assert str(refusal.value).startswith(f"--set {text}: ")
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_what_contradicts_itself_is_told_with_the_settings_that_take_part() -> None:
    with pytest.raises(ParameterError) as refusal:
        load_scenario("b2_calm_300", settings=["wave_vessel.boom_tip_source=file"])
    assert ": wave_vessel with --set wave_vessel.boom_tip_source=file: boom_tip_source = file needs" in str(
        refusal.value
    )


def test_settings_name_nodes_the_system_the_run_and_criteria() -> None:
    assert parse_setting("cable_sim.length=3") == Setting("cable_sim", "length", 3, "--set cable_sim.length=3")
    assert make_setting("system.length", 3, "x") == Setting("/**", "system.length", 3, "x")
    assert make_setting("all.seed", 3, "x") == Setting("/**", "seed", 3, "x")
    scenario = load_scenario("b2_calm_300", settings=["wanted.kappa='<= 2'"])
    assert Criterion("kappa", "<=", 2.0) in scenario.wanted


@pytest.mark.parametrize("name", sorted(shipped_scenarios()))
def test_the_stored_scenario_has_every_value_in_force_once_and_runs_again(name, file) -> None:
    scenario = load_scenario(name, settings=["wave_vessel.peak_period=9.5", "all.seed=11"])
    write_sections(stored_sections(scenario), file, title=stored_title(scenario))
    again = load_scenario(str(file))
    assert (again.run, again.parameters, again.wanted) == (scenario.run, scenario.parameters, scenario.wanted)
    sections = read_sections(file)
    for node, parameters in scenario.parameters.items():
        in_force = {name: value for name, value in flatten(parameters).items() if value != ()}
        others = set(installed_drives()) - {
            in_force.get("drive")
        }  # parameters of drives that are not chosen are left out
        in_force = {name: value for name, value in in_force.items() if name.partition(".")[0] not in others}
        own, shared = sections.get(f"/**/{node}", {}).keys(), system_names(node, in_force)
        assert own | {mine for name, mine in shared.items() if name in sections["/**"]} == in_force.keys()
    assert sections["/**"]["system.sea.peak_period"] == 9.5
    assert file.read_text().startswith(f"# {stored_title(scenario).splitlines()[0]}\n# All values active")
    changed = load_scenario(str(file), settings=["system.gravity=9.7"])
    assert changed.parameters["cable_sim"].gravity == changed.parameters["winch_controller"].gravity == 9.7


@settings(max_examples=20)
@given(
    st.fixed_dictionaries(
        {},
        optional={
            "wave_vessel.peak_period": st.floats(3.0, 40.0),
            "winch_controller.sea.peak_period": st.floats(1.0, 40.0),
            "system.winch.speed_limit": st.floats(0.001, 100.0),
            "virtual_winch.speed_limit": st.floats(0.001, 100.0),
            "cable_sim.unit.added_mass": st.lists(st.floats(0.0, 1e6), min_size=3, max_size=3),
            "winch_controller.programme.modes": st.just([]),
            "all.pacing": st.sampled_from(["lockstep", "realtime"]),
        },
    )
)
def test_any_scenario_survives_being_stored(tmp_path_factory, changes) -> None:
    made = [make_setting(place, value, place) for place, value in changes.items()]
    scenario = load_scenario("b2_calm_300", settings=made)
    path = tmp_path_factory.mktemp("stored") / "scenario.yaml"
    write_sections(stored_sections(scenario), path)
    again = load_scenario(str(path))
    assert (again.run, again.parameters) == (scenario.run, scenario.parameters)


def test_an_empty_list_in_the_place_of_a_default_cannot_be_stored_and_is_refused() -> None:
    scenario = load_scenario("b2_calm_300", settings=["recorder.exclude=[]"])
    with pytest.raises(ParameterError, match=r"recorder: exclude = \[\] is not possible: ROS 2 has no empty lists"):
        stored_sections(scenario)


def test_a_scenario_of_values_is_checked_like_a_file() -> None:
    scenario = make_scenario({"/**": {"seed": 5, "system.length": 500.0}, "cable_sim": {"segments": 7}})
    assert (scenario.run.seed, scenario.parameters["winch_controller"].length) == (5, 500.0)
    with pytest.raises(ParameterError, match=r"^cable_sim: segments = 0 is not allowed"):
        make_scenario({"cable_sim": {"segments": 0}})


def test_a_quality_of_service_of_ros_is_kept_for_its_node(file) -> None:
    overrides = {"qos_overrides": {"/winch/state": {"publisher": {"depth": 7}}}}
    file.write_text(yaml.safe_dump({"/**/virtual_winch": {"ros__parameters": overrides}}))
    scenario = load_scenario(str(file))
    stored = stored_sections(scenario)
    assert stored["/**/virtual_winch"]["qos_overrides./winch/state.publisher.depth"] == 7
    write_sections(stored, file)
    assert load_scenario(str(file)).quality_of_service == scenario.quality_of_service


def test_files_are_those_beside_the_scenario_and_found_before_anything_starts(tmp_path, monkeypatch):
    (tmp_path / "ship").mkdir()
    table = tmp_path / "ship" / "rao.csv"
    table.write_text("anything\n")
    scenario = tmp_path / "ship" / "own.yaml"
    scenario.write_text("/**: {ros__parameters: {system.vessel.model: rao, system.vessel.rao_file: rao.csv}}\n")
    monkeypatch.chdir(tmp_path)
    loaded = load_scenario("ship/own.yaml")
    assert loaded.parameters["wave_vessel"].vessel.rao_file == str(table)
    assert loaded.parameters["winch_controller"].vessel.rao_file == str(table)
    told = load_scenario("b2_calm_300", settings=["system.vessel.rao_file=ship/rao.csv"])
    assert told.parameters["wave_vessel"].vessel.rao_file == str(table)
    table.unlink()
    with pytest.raises(ParameterError, match=r"own\.yaml: /\*\*: system\.vessel\.rao_file = 'rao\.csv': no such file"):
        load_scenario("ship/own.yaml")
    assert load_scenario("ship/own.yaml", needs_files=False).parameters["wave_vessel"].vessel.rao_file == "rao.csv"


def choices() -> list[tuple[str, ParameterInfo, str]]:
    """Return each text parameter that has choices, with its node and each of its choices."""
    of_nodes = [(node.name, info) for node in NODES for info in describe(node.parameters_type())]
    of_run = [("all", info) for info in describe(RunParameters)]
    return [(node, info, choice) for node, info in [*of_run, *of_nodes] for choice in info.choices]


def test_every_choice_of_a_text_can_be_given_bare_in_a_file_and_on_the_command_line(file) -> None:
    for node, info, choice in choices():
        bare = f"[{choice}, {choice}]" if info.is_array else choice
        wanted = [choice, choice] if info.is_array else choice
        set_here = parse_setting(f"{node}.{info.name}={bare}")
        assert info.check(set_here.value, where="") == info.check(wanted, where=""), (node, info.name, choice)
        file.write_text(f"/**/{node}: {{ros__parameters: {{{info.name}: {bare}}}}}\n")
        (read,) = read_sections(file).values()
        assert info.check(read[info.name], where="") == info.check(wanted, where=""), (node, info.name, choice)


def test_ros_reads_every_choice_of_a_text_from_a_stored_scenario_as_it_was_meant(file, monkeypatch) -> None:
    rclpy = pytest.importorskip("rclpy")
    given = choices()
    values = {
        f"p{n}": (choice, info.choices[0]) if info.is_array else choice for n, (_, info, choice) in enumerate(given)
    }
    write_sections({"/**": values}, file)
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(file)], context=context)
    try:
        node = rclpy.create_node("any", context=context, automatically_declare_parameters_from_overrides=True)
        read = {name: node.get_parameter(name).value for name in values}
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)
    assert read == {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}


def test_a_sensor_that_sends_nan_can_be_asked_for_without_quotes(file) -> None:
    faults = "{kind: [freeze, nan], start: [60.0, 70.0], duration: [5.0, 0.0], magnitude: [0.0, 0.0]}"
    settings = ["kind=[freeze, nan]", "start=[60.0, 70.0]", "duration=[5.0, 0.0]", "magnitude=[0.0, 0.0]"]
    told = load_scenario("b2_calm_300", settings=[f"wave_vessel.mru.faults.{setting}" for setting in settings])
    assert told.parameters["wave_vessel"].mru.faults.kind == ("freeze", "nan")
    file.write_text(f"/**/wave_vessel: {{ros__parameters: {{mru: {{faults: {faults}}}}}}}\n")
    assert load_scenario(str(file)).parameters["wave_vessel"].mru.faults.kind == ("freeze", "nan")


def test_a_stored_scenario_names_what_was_changed_for_the_run():
    settings = ["system.sea.peak_period=7", "winch_controller.factor=0.9"]
    scenario = load_scenario("b2_calm_300", settings=settings)
    assert stored_title(scenario).splitlines()[-1] == "changed: system.sea.peak_period, winch_controller.factor"
    assert "changed" not in stored_title(load_scenario("b2_calm_300"))
