"""Cases for the loop as FMUs: what `heave qualify` writes, and what sim-explorer and libcosim find where installed."""

from __future__ import annotations

import ast
import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from heave_bringup.cli import main
from heave_bringup.scenarios import load_scenario
from heave_fmu.export import make_parts
from heave_studies.qualify.cases import command_of, read_cases, write_cases

PAGE = Path(__file__).parents[1] / "docs" / "guide" / "howto" / "fmu.md"
GIVEN = read_cases()
SYSTEMS = {system["system"]: system for system in GIVEN["systems"]}
CASES = [(system, case) for system, of in SYSTEMS.items() for case in of["cases"]]
FUNCTIONS = {"abs"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("cases")
    write_cases(made)
    return made


def test_there_are_thirty_cases_with_all_three_kinds_of_assertion(folder):
    files = [json.loads((folder / name / f"{name}.cases").read_text()) for name in SYSTEMS]
    cases = [case for found in files for name, case in found.items() if name not in ("header", "base")]
    assert len(cases) == len(CASES) >= 30
    kinds = {key.partition("@")[2][0] for case in cases for key in case["assert"]}
    assert {"A", "F"} < kinds
    assert all(case["description"] and case["assert"] for case in cases)


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_file_is_as_sim_explorer_reads_it(folder, system):
    found = json.loads((folder / system / f"{system}.cases").read_text())
    header = found.pop("header")
    assert header["simulator"] == "OSP"
    assert header["modelFile"] == "OspSystemStructure.xml"
    assert header["description"] == f"FMUs by: {command_of(SYSTEMS[system])}"
    variables, base = header["variables"], found.pop("base")
    assert base["spec"]["stopTime"] > 0.0
    assert {name.removesuffix("@step") for name in base["results"]} == set(GIVEN["variables"])
    keys = [key.partition("@")[0] for case in found.values() for key in case["assert"]]
    assert len(keys) == len(set(keys)), "sim-explorer keeps one expression for a key"
    assert all(f"_{key}".isidentifier() for key in keys), "it makes a function of each"
    for case in found.values():
        assert {name.partition("@")[0] for name in case["spec"]} <= set(GIVEN["inputs"])
        for text, why in case["assert"].values():
            names = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
            assert names <= {"t", *FUNCTIONS, *variables}
            assert re.match(r"requirement|physics|statics|reference|definition|limits", why)


def test_every_variable_is_one_of_its_fmu_and_what_a_case_overrides_is_an_input():
    parts = make_parts(load_scenario("b2_calm_300"))
    for rows, side in ((GIVEN["variables"], "outputs"), (GIVEN["inputs"], "inputs")):
        for part, name in rows.values():
            ports = getattr(parts[part], side).values()
            assert name in {variable.name for port in ports for variable in port.variables}, name


def test_no_name_ends_with_another_one_of_an_assertion():
    """sim-explorer takes INSTANCE_VARIABLE apart from the end."""
    names = set(GIVEN["variables"])
    assert not [(one, other) for one in names for other in names if one.endswith(f"_{other}")]


@pytest.fixture(scope="module")
def exported(folder):
    if not all(map(importlib.util.find_spec, ("sim_explorer", "libcosimpy", "pythonfmu"))):
        pytest.skip("sim-explorer, libcosimpy 0.0.5 or pythonfmu is not installed: see docs/guide/howto/fmu.md")
    script = re.search(r'```python title="run_case.py"\n(.*?)```', PAGE.read_text(), re.DOTALL)
    assert script is not None
    (folder / "run_case.py").write_text(script[1])
    for name, system in SYSTEMS.items():
        settings = [part for setting in system["settings"] for part in ("--set", setting)]
        assert main(["fmu", system["scenario"], *settings, "--folder", str(folder / name)]) == 0
    return folder


@pytest.mark.long
@pytest.mark.parametrize(("system", "case"), CASES)
def test_what_is_expected_of_a_case_holds_under_libcosim(exported, tmp_path, system, case):
    words = [sys.executable, str(exported / "run_case.py"), str(exported / system / f"{system}.cases"), case]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    verdicts = [line for line in done.stdout.splitlines() if line.startswith(("passed |", "FAILED |"))]
    named = SYSTEMS[system]["cases"][case]["assert"]
    expected = GIVEN["asserts"][named] if isinstance(named, str) else named
    assert len(verdicts) == len(expected), done.stderr[-2000:]
    assert [line for line in verdicts if not line.startswith("passed")] == []
