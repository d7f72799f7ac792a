"""What differs between releases of ROS 2 stands in one file, and the loop spins where there is no events executor."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from heave_node.ros.release import first_of

ROOT = Path(__file__).resolve().parents[2]
OWN = ROOT / "node_base" / "heave_node" / "ros" / "release.py"
DIFFERS = ("rclpy.experimental", "rclpy.impl", "rclpy.executors", "rclpy._rclpy_pybind11")
WITHOUT = """
import sys
sys.modules["rclpy.experimental"] = None
import rclpy
from heave_node.ros.spin import Spinner
from rclpy.node import Node
from rclpy.task import Future

rclpy.init()
node, done = Node("alone"), Future()
node.create_timer(0.01, lambda: done.set_result(True))
spinner = Spinner(node)
spinner.spin_for(10.0, until=done)
print(type(spinner._executor).__name__, done.done())
spinner.close()
node.destroy_node()
rclpy.shutdown()
"""


def sources():
    for package in (
        "node_base",
        "bringup",
        "bags",
        "winch_controller_node",
        "cable_sim_node",
        "wave_vessel_node",
        "extras",
    ):
        yield from (path for path in (ROOT / package).rglob("*.py") if "test" not in path.parts)


def test_no_other_module_imports_what_differs_between_releases():
    """Names of packages and modules, wherever they are imported."""
    for path in sources():
        if path == OWN:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            module = node.module if isinstance(node, ast.ImportFrom) else ""
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            assert not any((name or "").startswith(DIFFERS) for name in (module, *names)), path


def test_the_loop_spins_by_the_default_executor_where_there_is_no_other():
    run = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True, timeout=120, check=True)
    assert run.stdout.split() == ["SingleThreadedExecutor", "True"]


def test_what_no_release_has_is_named():
    assert first_of("json:nothing", "nowhere:json", "json:dumps")([1]) == "[1]"
    with pytest.raises(ImportError, match="none of json:nothing, nowhere:json"):
        first_of("json:nothing", "nowhere:json")
