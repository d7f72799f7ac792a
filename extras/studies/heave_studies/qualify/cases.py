"""Cases for the loop as FMUs under libcosim, in the format of sim-explorer: JSON5 with temporal assertions."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from heave_node.files.bounded_yaml import parse_yaml

FILE = Path(__file__).with_name("cases.yaml")


def read_cases() -> dict[str, Any]:
    """Return the cases as `cases.yaml` states them: `variables`, `inputs`, `asserts` and `systems`."""
    return parse_yaml(FILE.read_text(encoding="utf-8"))  # type: ignore[no-any-return]


def command_of(system: Mapping[str, Any]) -> str:
    """Return the command that exports the FMUs of a `system` beside its cases, in the folder of all systems."""
    settings = " ".join(f"--set '{setting}'" for setting in system["settings"])
    return f"heave fmu {system['scenario']} {settings} --folder {system['system']}"


def write_cases(folder: Path) -> None:
    """Write the cases of each system to `folder`/SYSTEM/SYSTEM.cases, where its FMUs go."""
    given = read_cases()
    for system in given["systems"]:
        file = folder / system["system"] / f"{system['system']}.cases"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(_of_system(given, system), indent=1) + "\n", encoding="utf-8")


def _of_system(given: Mapping[str, Any], system: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the file of a `system` holds. All outputs are recorded at each step; `base` is a run without faults.

    Keys of assertions are unique in a file, as one name stands for one expression there.
    """
    header = {
        "name": system["system"],
        "description": f"FMUs by: {command_of(system)}",
        "modelFile": "OspSystemStructure.xml",
        "simulator": "OSP",
        "timeUnit": "second",
        "variables": {**given["variables"], **given["inputs"]},
    }
    results = [f"{name}@step" for name in given["variables"]]
    found = {"header": header, "base": {"description": "", "spec": {"stopTime": system["stop"]}, "results": results}}
    for name, case in system["cases"].items():
        named = case["assert"]
        rows = given["asserts"][named] if isinstance(named, str) else named
        checks = {f"{name}_{number}@{when}": [text, why] for number, (when, text, why) in enumerate(rows, 1)}
        found[name] = {"description": case["what"], "spec": case.get("set", {}), "assert": checks}
    return found
