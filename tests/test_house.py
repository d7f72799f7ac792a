"""The rules of the house: imports run one way between packages and inside every folder, and few modules know ROS."""

from __future__ import annotations

import ast
import graphlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

SUITE = {
    "heave_core": (),
    "heave_node": (),
    "wave_vessel_node": ("heave_node",),
    "cable_sim_node": ("heave_node",),
    "winch_controller_node": ("heave_core", "heave_node", "wave_vessel_node", "cable_sim_node"),
    "heave_bags": ("heave_node",),
    "heave_bringup": ("heave_node", "wave_vessel_node", "cable_sim_node", "winch_controller_node", "heave_bags"),
}
"""Imports allowed to each package of the suite; all may import the messages."""

EXTRAS = {
    "heave_devices": (),
    "heave_studies": ("heave_devices",),
    "heave_statics": (),
    "heave_drives": (),
    "heave_panel": (),
    "heave_fmu": (),
}
"""Packages that may be missing, with the other extras that each may import: studies judge what devices measured."""

MAY_IMPORT = {**SUITE, **{name: (*SUITE, *others) for name, others in EXTRAS.items()}}

FOLDERS = {
    "heave_core": "core",
    "heave_node": "node_base",
    "heave_bags": "bags",
    "heave_bringup": "bringup",
    **{name: f"extras/{name.removeprefix('heave_')}" for name in EXTRAS},
}
"""Folder of each package whose folder has another name."""

BUDGETS = {
    "core": (4_139, 2_800),
    "node_base": (12_685, 9_500),
    "wave_vessel_node": (5_081, 4_400),
    "cable_sim_node": (8_994, 8_500),
    "winch_controller_node": (18_704, 14_000),
    "bags": (10_659, 7_700),
    "bringup": (7_709, 6_100),
    "extras/devices": (7_529, 4_900),
    "extras/studies": (12_332, 6_000),
    "extras/statics": (3_190, 1_800),
    "extras/drives": (1_768, 1_768),
    "extras/panel": (1_538, 900),
    "extras/fmu": (1_903, 900),
}
"""Source lines that a wing may have: what it has, and what it is to come to. A wing grows only where another pays."""

SHELLS = ("node", "winch_node", "adviser_node", "envelope_node")
"""Modules of nodes."""

KNOWS_ROS = (
    *("heave_node.ros", "heave_bags", "heave_bringup", "winch_controller_node.move_action"),
    *("heave_devices.adapt", "heave_studies.accept", "heave_panel", "heave_fmu.winch_node"),
)
"""Beside the modules of nodes (`SHELLS`), the only places that may import rclpy."""


def source_of(package: str) -> Path:
    return ROOT / FOLDERS.get(package, package) / package


def modules(package: str) -> dict[str, Path]:
    """Return the files of a package by module name."""
    found = {}
    for path in sorted(source_of(package).rglob("*.py")):
        parts = path.relative_to(source_of(package).parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def import_statements(path: Path) -> list[ast.Import | ast.ImportFrom]:
    """Return the imports of a file, wherever in it."""
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    return [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]


def imports(path: Path, known: set[str]) -> Iterator[str]:
    """Yield the modules that a file imports, wherever in it; a name that is not in `known` stands for its parent."""
    for node in import_statements(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        else:
            assert node.level == 0, f"{path}: relative import"
            for alias in node.names:
                member = f"{node.module}.{alias.name}"
                yield member if member in known else str(node.module)


def room(module: str, folder: str) -> str:
    """Return what a module stands for inside a folder: itself, or the folder one deeper that it lies in."""
    return ".".join(module.split(".")[: folder.count(".") + 2])


def arrows_inside(folder: str, arrows: Iterable[tuple[str, str]]) -> dict[str, set[str]]:
    """Return who imports whom among the modules and folders that lie directly in a folder (a dotted name)."""
    inside = defaultdict(set)
    for module, target in arrows:
        if module.startswith(f"{folder}.") and target.startswith(f"{folder}."):
            start, end = room(module, folder), room(target, folder)
            if start != end:
                inside[start].add(end)
    return inside


def circle(arrows: dict[str, set[str]]) -> str:
    """Return a circle among arrows in words; "" where there is none."""
    try:
        graphlib.TopologicalSorter(arrows).prepare()
    except graphlib.CycleError as error:
        return " imports ".join(reversed(error.args[1]))
    return ""


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_nothing_in_a_folder_imports_in_a_circle(package):
    files = modules(package)
    arrows = [(module, target) for module, path in files.items() for target in imports(path, set(files))]
    folders = {module.rsplit(".", 1)[0] for module in files if "." in module}
    assert [circle(arrows_inside(folder, arrows)) for folder in folders if circle(arrows_inside(folder, arrows))] == []


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_a_folder_has_at_most_sixteen_modules(package):
    folders = Counter(
        ".".join(path.relative_to(source_of(package).parent).parent.parts)
        for path in modules(package).values()
        if path.stem != "__init__"
    )
    too_large = {name: count for name, count in folders.items() if count > 16}
    assert too_large == {}


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_a_package_imports_only_the_packages_below_it(package):
    files = modules(package)
    others = set(MAY_IMPORT) - {package, *MAY_IMPORT[package]}
    wrong = {
        f"{module} imports {target}"
        for module, path in files.items()
        for target in imports(path, set(files))
        if target.split(".")[0] in others
    }
    assert wrong == set()


def lines_of(folder: str) -> int:
    """Return the source lines below a folder, tests apart."""
    files = [path for path in (ROOT / folder).rglob("*.py") if not {"test", "tests"} & set(path.parts)]
    return sum(path.read_text(encoding="utf-8").count("\n") for path in files)


@pytest.mark.parametrize("folder", BUDGETS)
def test_a_wing_keeps_its_budget(folder):
    now, target = BUDGETS[folder]
    assert target <= now
    assert lines_of(folder) <= now, f"{folder}: which other wing pays for it?"


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_only_the_shells_of_nodes_know_ros(package):
    files = modules(package)
    wrong = {
        module
        for module, path in files.items()
        if any(target.split(".")[0] == "rclpy" for target in imports(path, set(files)))
        and not module.endswith(tuple(f".{shell}" for shell in SHELLS))
        and not any(f"{module}.".startswith(f"{place}.") for place in KNOWS_ROS)
    }
    assert wrong == set()


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_nodes_never_import_each_others_node(package):
    files = modules(package)
    shells = {f"{name}.{module}" for name in MAY_IMPORT for module in SHELLS}
    wrong = {
        f"{module} imports {target}"
        for module, path in files.items()
        for target in imports(path, shells)
        if target in shells and package not in ("heave_bringup", *EXTRAS)
    }
    assert wrong == set()


def test_the_scan_sees_what_there_is():
    # a scan that finds nothing would pass everything above
    known = set(modules("cable_sim_node"))
    found = set(imports(ROOT / "cable_sim_node" / "cable_sim_node" / "component.py", known))
    assert {"cable_sim_node.line.dynamics", "heave_node.numerics.kinematics", "numpy"} <= found
    shell = set(imports(ROOT / "node_base" / "heave_node" / "ros" / "spin.py", set(modules("heave_node"))))
    assert any(target.split(".")[0] == "rclpy" for target in shell)
    assert room("cable_sim_node.line.dynamics", "cable_sim_node") == "cable_sim_node.line"
    assert room("cable_sim_node.errors", "cable_sim_node") == "cable_sim_node.errors"
    assert arrows_inside("a", [("a.b.c", "a.d"), ("a.b.c", "a.b.e"), ("f.g", "a.d")]) == {"a.b": {"a.d"}}
    assert circle({"a": {"b"}, "b": {"a"}}) in ("a imports b imports a", "b imports a imports b")


def arguments_of(function: ast.FunctionDef) -> int:
    """Return how many arguments the caller of a function gives at most."""
    given = function.args
    names = [argument.arg for argument in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    return len([name for name in names if name not in ("self", "cls")])


def is_inner_kernel(function: ast.FunctionDef) -> bool:
    """Return whether only kernels call a function: what they hand on costs nothing, and a group of it would."""
    return any(isinstance(mark, ast.Name) and mark.id == "inner_kernel" for mark in function.decorator_list)


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_no_function_has_more_than_ten_arguments(package):
    wrong = [
        f"{path.name}:{node.lineno}: {node.name} has {arguments_of(node)}"
        for path in modules(package).values()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and arguments_of(node) > 10 and not is_inner_kernel(node)
    ]
    assert wrong == []


def test_each_case_that_is_left_to_the_long_tests_exists():
    lines = (ROOT / "tests" / "long_cases.txt").read_text(encoding="utf-8").splitlines()
    assert lines == sorted(set(lines))
    for file, name in {tuple(line.split("[")[0].split("::")) for line in lines}:
        assert f"def {name}(" in (ROOT / file).read_text(encoding="utf-8"), f"{name} is gone"
