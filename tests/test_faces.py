"""What users import from the packages themselves."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGES = ("heave_node", "wave_vessel_node", "cable_sim_node", "winch_controller_node", "heave_bags", "heave_bringup")
HEAVY = ("rclpy", "numpy", "numba", "scipy", "pandas", "matplotlib")
NODES = (
    "wave_vessel_node.node",
    "cable_sim_node.node",
    "winch_controller_node.node",
)
ADVISER = "winch_controller_node.adviser_node"  # its first design is within a tick, and loads nothing any more
OF_REPORTS = ("scipy.signal", "scipy.stats", "scipy.ndimage", "pandas", "matplotlib")


@pytest.mark.parametrize("package", PACKAGES)
def test_every_name_of_a_face_is_there_and_is_what_type_checkers_are_told(package):
    module = importlib.import_module(package)
    told = {
        alias.name: node.module
        for node in ast.walk(ast.parse(Path(module.__file__).read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{package}.")
        for alias in node.names
    }
    told.pop("lazy_face", None)
    assert sorted(module.__all__) == sorted(told)
    for name, source in told.items():
        assert getattr(module, name) is getattr(importlib.import_module(source), name)
    with pytest.raises(AttributeError, match=f"module '{package}' has no attribute 'nothing'"):
        _ = module.nothing


@pytest.mark.parametrize("package", PACKAGES)
def test_a_face_can_be_listed_before_anything_of_it_is_used(package):
    program = f"import {package}; print(set({package}.__all__) <= set(dir({package})))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"


@pytest.mark.parametrize(
    ("modules", "left_out"),
    [
        (PACKAGES, HEAVY),
        (("heave_bringup.run.evaluation",), OF_REPORTS),
        (("heave_bringup.scenarios", *NODES), ("scipy.optimize", *OF_REPORTS)),
        ((ADVISER,), OF_REPORTS),
    ],
    ids=["packages", "what judges a run", "scenarios and nodes", "adviser"],
)
def test_nothing_heavy_is_loaded_before_it_is_needed(modules, left_out):
    program = f"import sys, {', '.join(modules)}; print([name for name in {left_out} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
