"""`heave static`: every problem prints a table, writes its picture and its JSON, and refuses what it cannot do."""

import json
import re
import shlex
from pathlib import Path

import pytest
from heave_bringup.cli import main
from heave_bringup.commands.models import modes
from heave_bringup.parser import make_parser
from heave_statics.commands import static

PLANT_README = Path(__file__).parents[3] / "cable_sim_node" / "README.md"
EXAMPLES = [*static.EXAMPLES, *modes.EXAMPLES]
if PLANT_README.is_file():
    EXAMPLES += re.findall(r"^(heave (?:static|modes) .*?)(?: +#.*)?$", PLANT_README.read_text("utf-8"), re.MULTILINE)

PROBLEMS = {
    "hanging": ([], "top_tension_n"),
    "towing": (["--towing", "--speed", "0.5", "1.5"], "tows"),
    "mooring": (["--mooring", "--depth", "290", "--offset", "40", "--pull", "2000"], "cables"),
    "footprint": (["--footprint", "--depth", "280", "--thrust", "2000", "--tension-limit", "12000"], "headings"),
    "laying": (["--laying", "--depth", "280", "--speed", "1", "--bottom-tension", "500"], "lays"),
}


@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_problem_gives_a_table_a_picture_and_numbers(problem, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments, key = PROBLEMS[problem]
    assert main(["static", "s300_driven", *arguments, "--json", "result.json"]) == 0
    name = f"s300_driven_{'static' if problem == 'hanging' else problem}.svg"
    printed = capsys.readouterr().out
    assert str(tmp_path / name) in printed
    assert len(printed.splitlines()) > 3
    assert "<svg" in (tmp_path / name).read_text(encoding="utf-8")
    assert json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))[key]


def test_the_boom_tip_stands_at_its_height(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["static", "s300_driven", "--set", "cable_sim.boom_tip_height=12.0", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["boom_tip_m"] == [0.0, 0.0, 12.0]


def test_a_unit_above_water_is_judged_by_its_weight_in_air(tmp_path, capsys, monkeypatch):
    """40 t x g = 392.3 kN and 17 m of wire: a rope of 350 kN breaks; in water the unit weighs 311.9 kN."""
    monkeypatch.chdir(tmp_path)
    strength = ["--set", "system.cable.breaking_force=350000"]
    assert main(["static", "b11_splash_zone", *strength, "--json", "-"]) != 0
    report = json.loads(capsys.readouterr().out)
    assert report["unit_weight_n"] == pytest.approx(40e3 * 9.80665)
    assert report["top_tension_n"] == pytest.approx(393.84e3, abs=10.0)
    assert report["verdict"]["good"] is False


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--towing"], "heave: --towing: give --speed"),
        (["--mooring", "--depth", "290"], "heave: --mooring: give --offset M or --pull N"),
        (["--footprint", "--depth", "280"], "heave: --footprint: give --thrust"),
        (["--laying", "--speed", "1"], "heave: --laying: s300_driven has no seabed: give --depth M or --set"),
        (["--towing", "--speed", "1", "--thrust", "5"], "heave: --thrust: needs --footprint\n"),
        (["--speed", "1"], "heave: --speed: needs --towing or --laying\n"),
        (["--towing", "--speed", "-1"], "heave: --speed -1: must not be negative"),
        (["--towing", "--speed", "nan"], "heave: --speed nan: must be a finite number"),
        (["--mooring", "--depth", "290", "--offset", "inf"], "heave: --offset inf: must be a finite number"),
        (["--towing", "--laying"], "heave static: argument --laying: not allowed with argument --towing"),
    ],
)
def test_a_wrong_option_is_refused_in_one_line(arguments, words, capsys):
    try:
        status = main(["static", "s300_driven", *arguments])
    except SystemExit as exit_:
        status = exit_.code
    said = capsys.readouterr().err
    assert status == 2
    assert said.startswith(words)
    assert said.count("\n") == 1


def test_what_statics_cannot_solve_is_one_line_and_status_1(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["static", "s300_driven", "--footprint", "--depth", "320", "--thrust", "2000"]) == 1
    said = capsys.readouterr().err.splitlines()[-1]
    assert "s300_driven.yaml: " in said
    assert "300 m of cable" in said


@pytest.mark.parametrize("problem", PROBLEMS)
def test_every_problem_refuses_a_cable_that_parts(problem, tmp_path, capsys, monkeypatch):
    """2,000 N of tension strain an EA of 1,000 N by 200 %; steel parts at some 2 %."""
    monkeypatch.chdir(tmp_path)
    arguments, _ = PROBLEMS[problem]
    assert main(["static", "s300_driven", *arguments, "--set", "system.cable.axial_stiffness=1000"]) == 1
    said = capsys.readouterr().err.splitlines()[-1]
    assert "it would part; check cable.axial_stiffness (1000 N" in said
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("problem", PROBLEMS)
def test_every_problem_refuses_a_tension_law_that_carries_nothing(problem, tmp_path, capsys, monkeypatch):
    """With q = -1e4 the law peaks at EA/(4e4), 390 N of tension."""
    monkeypatch.chdir(tmp_path)
    arguments, _ = PROBLEMS[problem]
    assert main(["static", "s300_driven", *arguments, "--set", "system.cable.stiffness_quadratic=-1e4"]) == 1
    assert "the cable's tension law carries no load" in capsys.readouterr().err.splitlines()[-1]


@pytest.mark.parametrize("problem", ["hanging", "towing"])
@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["system.unit.volume=6.0"], "the unit's buoyancy lifts it above the boom tip"),
        (["cable_sim.seabed.depth=250"], "below the seabed: reduce length (300 m) or increase seabed.depth (250 m)"),
    ],
)
def test_a_unit_that_floats_or_lies_below_the_seabed_is_refused(
    problem, settings, words, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    arguments, _ = PROBLEMS[problem]
    assert main(["static", "s300_driven", *arguments, *(word for s in settings for word in ("--set", s))]) == 1
    assert words in capsys.readouterr().err.splitlines()[-1]


@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_of_help_and_readme_is_a_command_line(example):
    options = make_parser().parse_args(shlex.split(example)[1:])
    if options.command == "static":
        static.check_options(options)
