"""A scenario of one's own: the file that `heave new` writes, and what a name of the catalogue does in it."""

import json
import re

import pytest
from heave_bringup.cli import main
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario, shipped_scenarios
from heave_node.catalogue import KINDS, entries


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", sorted(shipped_scenarios()))
def test_a_file_written_like_a_shipped_scenario_is_that_scenario(here, capsys, name):
    assert main(["new", "mine", "--like", name]) == 0
    assert "heave run mine.yaml" in capsys.readouterr().out
    mine, shipped = load_scenario("mine.yaml"), load_scenario(name)
    assert mine.parameters == shipped.parameters
    assert (mine.run, [one.text for one in mine.wanted]) == (shipped.run, [one.text for one in shipped.wanted])


def test_each_value_has_its_unit_and_meaning_beside_it(here):
    assert main(["new", "mine.yaml", "--like", "unit_1500"]) == 0
    values = [line for line in (here / "mine.yaml").read_text().splitlines() if ": " in line and line[0] == " "]
    assert len(values) > 30
    assert [line for line in values if "# " not in line] == []
    assert any("speed_limit: 2.0" in line and "# [m/s] Largest payout speed" in line for line in values)


def test_a_file_with_names_of_the_catalogue_runs(here):
    options = ["--cable", "wire_28mm_6x36", "--winch", "benchmark_winch", "--unit", "mas409_load", "--length", "400"]
    assert main(["new", "mine", "--like", "b2_calm_300", *options]) == 0
    scenario = load_scenario("mine.yaml", settings=["all.duration=2", "all.transient=1", "cable_sim.segments=5"])
    assert scenario.parameters["cable_sim"].cable.diameter == 0.028
    assert scenario.parameters["winch_controller"].unit.mass == 12_600.0
    record = ClosedLoop(loop_parameters(scenario)).run()
    assert record.column("top_tension").min() > 0.0


def test_a_lift_of_ones_own_is_stated_on_the_command_line(here, capsys):
    lift = ["--mass", "6000", "--volume", "1.2", "--depth", "2000", "--hs", "2.2", "--tp", "9"]
    assert main(["new", "mine", *lift, "--title", 'Tree "A"']) == 0
    said = capsys.readouterr().out
    assert "6 t in air, 4.77 t in water, displaces 1.2 m^3; rope: 2010 m" in said, "6000 - 1025 x 1.2"
    assert "criteria (wanted) are those of unit_1500: check them" in said
    assert "added mass and drag area are scaled from the load of unit_1500: check them" in said
    assert re.search(r"depth 2000 m is before stretch; at rest the rope stretches by [\d.]+ m", said)
    scenario, model = load_scenario("mine.yaml"), load_scenario("unit_1500")
    plant, controller = scenario.parameters["cable_sim"], scenario.parameters["winch_controller"]
    assert (plant.unit.mass, plant.unit.volume, plant.length) == (6000.0, 1.2, 2000.0 + plant.boom_tip_height)
    assert controller.unit == plant.unit
    assert controller.length == plant.length
    sea = scenario.parameters["wave_vessel"]
    assert (sea.significant_wave_height, sea.peak_period) == (2.2, 9.0) == controller_sea(controller)
    was = model.parameters["cable_sim"].unit
    scale = 1.2 / was.volume
    assert plant.unit.added_mass == pytest.approx([scale * value for value in was.added_mass], rel=1e-5)
    assert plant.unit.drag_area == pytest.approx([scale ** (2 / 3) * value for value in was.drag_area], rel=1e-5)
    assert scenario.run.title == 'Tree "A"'
    assert (here / "mine.yaml").read_text().startswith("# mine: made from unit_1500, with mass 6000 kg, volume 1.2 m^3")


def test_a_rope_too_weak_for_the_load_at_rest_is_named_with_one_that_carries_it(here, capsys):
    """A load of 70.7 t in water on 1,010 m: 28 mm wire breaks at 494 kN, 44 mm at 1,220 kN."""
    heavy = ["new", "heavy", "--mass", "100000", "--density", "3500", "--depth", "1000", "--cable"]
    assert main([*heavy, "wire_28mm_6x36"]) == 0
    said = capsys.readouterr().err
    assert "Safety factor of the rope 0.68 in still water (required at least 2.535): breaking force 494 kN" in said
    advised = said.split("--cable ")[1].split(")")[0]
    for rope, words in ((advised, ""), ("wire_44mm_6x36", "Safety factor of the rope 1.6")):
        assert main([*heavy, rope, "--force"]) == 0
        assert (words in capsys.readouterr().err) if words else not capsys.readouterr().err


def test_a_mass_that_is_meant_in_tonnes_is_noted(here, capsys):
    """8 kg of steel weigh 68 N in water; 1,510 m of 28 mm wire of 3.4 kg/m some 40 kN."""
    assert main(["new", "light", "--mass", "8", "--density", "7850"]) == 0
    assert "the load of 8 kg weighs 0.2 % of the rope in water: masses are in kg" in capsys.readouterr().err
    assert main(["new", "meant", "--mass", "8000", "--density", "7850"]) == 0
    assert "masses are in kg" not in capsys.readouterr().err


def test_a_load_denser_than_lead_is_noted(here, capsys):
    """600 t in 1.2 m^3 have 500 t/m^3."""
    assert main(["new", "dense", "--mass", "600000", "--volume", "1.2"]) == 0
    assert "the load of 600000 kg in 1.2 m^3 is denser than lead: check mass and volume" in capsys.readouterr().err
    assert main(["new", "steel", "--mass", "8000", "--density", "7850"]) == 0
    assert "denser" not in capsys.readouterr().err


def controller_sea(controller) -> tuple[float, float]:
    return controller.sea.significant_wave_height, controller.sea.peak_period


def test_a_unit_by_mass_and_density_has_the_shape_of_the_entry_and_no_strength_of_another(here):
    text = (
        "/**:\n  ros__parameters:\n    system: {unit: {mass: 9000.0, volume: 1.0, attachment_breaking_force: 1.0e+6}}\n"
    )
    (here / "model.yaml").write_text(text)
    assert (
        main(["new", "mine", "--like", "model.yaml", "--unit", "mas409_load", "--mass", "25200", "--density", "6300"])
        == 0
    )
    unit = load_scenario("mine.yaml").parameters["cable_sim"].unit
    (entry,) = [one for one in entries("unit").values() if one.name == "mas409_load"]
    assert unit.mass == 2.0 * entry.values["mass"]
    assert unit.volume == pytest.approx(4.0, rel=1e-5), "25200 / 6300"
    assert unit.added_mass == pytest.approx([2.0 * value for value in entry.values["added_mass"]], rel=1e-5)
    assert unit.attachment_breaking_force == 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_every_entry_of_the_catalogue_is_taken_by_plant_and_belief(kind):
    one_of_each_family = {entry.title: entry for entry in entries(kind).values()}
    for entry in one_of_each_family.values():
        name = entry.name
        changed = load_scenario("b3_deep_900", settings=[f"system.{kind}={name}"]).parameters
        holders = [changed["virtual_winch"], changed["winch_controller"].winch]
        if kind != "winch":
            holders = [getattr(changed["cable_sim"], kind), getattr(changed["winch_controller"], kind)]
        for key, value in entry.values.items():
            wanted = tuple(value) if isinstance(value, list) else value
            assert [getattr(holder, key) for holder in holders] == [wanted, wanted], name


def test_a_value_on_the_command_line_changes_one_of_the_entry(here):
    (here / "mine.yaml").write_text("/**:\n  ros__parameters:\n    system: {cable: wire_28mm_6x36, length: 1500.0}\n")
    cable = load_scenario("mine.yaml", settings=["system.cable.diameter=0.03"]).parameters["cable_sim"].cable
    assert (cable.diameter, cable.mass_per_length) == (0.03, pytest.approx(3.207, abs=0.001))


def test_the_strength_of_a_wire_is_that_of_plant_and_belief_and_goes_with_the_wire(here):
    """EN 12385-4: 494 kN at 28 mm, 1,010 kN at 40 mm; another rope does not take over what its model states."""
    assert main(["new", "mine", "--like", "b3_deep_900", "--cable", "wire_28mm_6x36"]) == 0
    mine = load_scenario("mine.yaml", settings=["system.winch.rated_pull=3e5"]).parameters
    assert mine["cable_sim"].cable.breaking_force == pytest.approx(494e3, rel=0.005)
    assert mine["winch_controller"].cable.breaking_force == mine["cable_sim"].cable.breaking_force
    assert mine["virtual_winch"].rated_pull == 3e5
    weak = "/**:\n  ros__parameters:\n    system: {cable: {from: wire_28mm_6x36, breaking_force: 1e5}}\n"
    (here / "weak.yaml").write_text(weak)
    assert load_scenario("weak.yaml").parameters["cable_sim"].cable.breaking_force == 1e5
    for cable, force in (("wire_40mm_6x36", 1010e3), ("thesis_300", 0.0)):
        assert main(["new", "other", "--force", "--like", "weak.yaml", "--cable", cable]) == 0
        found = load_scenario("other.yaml").parameters["cable_sim"].cable.breaking_force
        assert found == pytest.approx(force, rel=0.005)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["new", "there"], "there.yaml: exists already; --force overwrites it"),
        (["new", "no/such/folder/x"], "cannot be written: No such file or directory"),
        (
            ["new", "x", "--cable", "wire_28mm_6x63"],
            "--cable: there is no cable wire_28mm_6x63 in the catalogue; did you",
        ),
        (["new", "x", "--like", "b3_deep_90"], "did you mean b3_deep_900?"),
        (["new", "x", "--length", "-3"], "length"),
        (["new", "x", "--mass", "600", "--volume", "3"], "the load floats, displacing 3075 kg"),
        (["new", "x", "--mass", "-1", "--volume", "1"], "--mass -1: must be above 0"),
        (["new", "x", "--mass", "6000"], "its weight in water is not known; add --volume"),
        (["new", "x", "--mass", "6000", "--volume", "1", "--density", "6000"], "either the --volume or the --density"),
        (["new", "x", "--volume", "nan"], "--volume nan: must be above 0"),
        (["new", "x", "--hs", "30"], "x.yaml (not written): /**: system.sea.significant_wave_height = 30.0 is not"),
        (["new", "x", "--depth", "300", "--length", "300"], "either the depth of the unit or the --length"),
        (["new", "x", "--hs", "2", "--like", "s900_driven"], "s900_driven has no sea to change"),
        (["list", "unit", "thesis_124t"], "did you mean thesis_125t?"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line_and_leaves_nothing(here, capsys, arguments, words):
    (here / "there.yaml").write_text("mine")
    assert main(arguments) != 0
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert [path.name for path in here.iterdir()] == ["there.yaml"]
    assert (here / "there.yaml").read_text() == "mine"


def test_what_is_forced_and_wrong_leaves_the_old_file_as_it_was(here, capsys):
    (here / "there.yaml").write_text("mine")
    assert main(["new", "there", "--force", "--length", "-3"]) != 0
    assert "length" in capsys.readouterr().err
    assert {path.name: path.read_text() for path in here.iterdir()} == {"there.yaml": "mine"}
    assert main(["new", "there", "--force", "--length", "400"]) == 0
    assert load_scenario("there.yaml").parameters["cable_sim"].length == 400.0
    assert [path.name for path in here.iterdir()] == ["there.yaml"]


def test_the_catalogue_prints_particulars_and_sources(capsys):
    assert main(["list", "cable"]) == 0
    assert "wire_28mm_6x36" in capsys.readouterr().out
    assert main(["list", "cable", "wire_28mm_6x36", "--json", "-"]) == 0
    (wire,) = json.loads(capsys.readouterr().out)
    assert wire["values"]["diameter"] == 0.028
    assert "EN 12385-4" in wire["sources"][0]


def test_a_file_that_the_model_names_is_found_from_the_new_place_too(here):
    (here / "seas").mkdir()
    rows = "".join(f"{0.1 * n:.1f},{0.01 * (n % 7):.2f}\n" for n in range(200))
    (here / "seas" / "sea.csv").write_text(f"time_s,z_m\n{rows}")
    vessel = "    boom_tip_source: file\n    recording_file: sea.csv\n"
    (here / "seas" / "model.yaml").write_text(f"/**/wave_vessel:\n  ros__parameters:\n{vessel}")
    assert main(["new", "mine", "--like", "seas/model.yaml"]) == 0
    assert 'recording_file: "seas/sea.csv"' in (here / "mine.yaml").read_text()
    assert load_scenario("mine.yaml").parameters["wave_vessel"].recording_file == str(here / "seas" / "sea.csv")
