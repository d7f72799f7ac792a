"""The exit statuses: one table for all commands, the same in the documents, and 3 for a verdict that is FAILED."""

import json
import math
from pathlib import Path
from types import SimpleNamespace

import pytest
from heave_bringup.cli import main
from heave_bringup.commands.models.design import expected_loads
from heave_bringup.errors import ExitStatus, status_table
from heave_bringup.parser import make_parser
from winch_controller_node.model.blocks import CableModel

README = Path(__file__).parents[1] / "README.md"
WEAK = ("--set", "system.cable=wire_28mm_6x36", "--set", "system.unit.mass=54025.0", "--set", "system.unit.volume=1.0")
"""A unit of 520 kN in water on a wire that breaks at 494 kN."""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_numbers_are_those_that_scripts_rely_on():
    assert {status.name: status.value for status in ExitStatus} == {
        "DONE": 0,
        "FAILED": 1,
        "REFUSED": 2,
        "VERDICT_FAILED": 3,
        "INTERRUPTED": 130,
    }


def test_the_readme_and_the_help_have_the_table_of_the_code():
    assert status_table() in README.read_text(encoding="utf-8")
    help_text = make_parser().format_help()
    assert all(status.meaning in help_text for status in ExitStatus)


def test_a_rope_that_does_not_carry_the_unit_at_rest_is_a_verdict_that_failed(here, capsys):
    assert main(["static", "s300_driven", *WEAK, "--json", "static.json"]) == ExitStatus.VERDICT_FAILED
    result = json.loads((here / "static.json").read_text())
    assert result["verdict"]["state"] == "FAILED"
    (rope,) = result["verdict"]["loads"]
    assert rope["factor"] == pytest.approx(494e3 / result["top_tension_n"], rel=1e-3)
    (line,) = [line for line in capsys.readouterr().err.splitlines() if "verdict FAILED" in line]
    assert line.startswith("heave: verdict FAILED: Safety factor of the rope")
    assert line.endswith("; see the verdict above")
    assert len(line) < 100, "the table has the figures"


def test_strengths_that_suffice_pass_and_a_part_that_is_not_there_is_not_judged(here, capsys):
    strong = ("--set", "system.cable.breaking_force=1e6", "--set", "system.unit.attachment_breaking_force=1e6")
    assert main(["static", "s300_driven", *strong, "--json", "static.json"]) == 0
    verdict = json.loads((here / "static.json").read_text())["verdict"]
    assert (verdict["state"], len(verdict["loads"])) == ("passed", 2)
    mooring = ("--mooring", "--depth", "290", "--offset", "40")
    assert main(["static", "s300_driven", *mooring, *strong, "--json", "moored.json"]) == 0
    assert len(json.loads((here / "moored.json").read_text())["verdict"]["loads"]) == 1
    assert main(["static", "s300_driven", "--json", "none.json"]) == 0
    assert json.loads((here / "none.json").read_text())["verdict"]["state"] == "none"
    assert capsys.readouterr().out.count("Rope strength not stated: not judged") == 1


def made_up_design(static_tension: float, unit_weight: float) -> SimpleNamespace:
    """Return what of a design report its loads are made from: 1,000 peak periods in 3 h, sigma of 2 kN."""
    sea = SimpleNamespace(peak_period=10.8)
    cable = CableModel(a=1.0, b=0.1, static_tension=static_tension, unit_weight=unit_weight)
    design = SimpleNamespace(parameters=SimpleNamespace(sea=sea), cable=cable)
    return SimpleNamespace(design=design, prediction=SimpleNamespace(sigma={"tension": 2e3}))


def test_the_largest_of_a_thousand_crests_is_expected_at_3_7_standard_deviations():
    """Longuet-Higgins 1952: the most probable largest of 1,000 wave heights is 1.86 Hs, so a crest of 3.72 sigma."""
    top, unit = expected_loads(made_up_design(50e3, 30e3))
    assert top == pytest.approx(50e3 + 3.72 * 2e3, rel=1e-3)
    assert unit == pytest.approx(30e3 + 3.72 * 2e3, rel=1e-3)


def test_an_identified_cable_knows_no_weights_and_no_load():
    assert all(map(math.isnan, expected_loads(made_up_design(0.0, math.inf))))


@pytest.mark.slow
def test_a_design_whose_sea_brings_more_than_the_rope_carries_is_a_verdict_that_failed(here):
    weak = ("--set", "system.cable.breaking_force=1e4", "--json", "design.json")
    assert main(["design", "b2_calm_300", *weak]) == ExitStatus.VERDICT_FAILED
    found = json.loads((here / "design.json").read_text())
    (rope,) = found["verdict"]["loads"]
    assert rope["load_n"] == found["expected_tension_max_n"]
    assert rope["factor"] < 1.0
