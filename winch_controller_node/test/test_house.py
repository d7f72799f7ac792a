"""The house of the controller: what it needs of the other packages, and which wing may use which."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest
from winch_controller_node.laws.registry import LAWS

PACKAGE = Path(__file__).parents[1] / "winch_controller_node"

SIMULATORS = (
    "cable_sim_node.component",
    "cable_sim_node.node",
    "tests.validation.peers",
    "cable_sim_node.sensors",
    "cable_sim_node.winch",
    "cable_sim_node.winch_node",
    "heave_bags",
    "heave_bringup",
    "moordyn",
    "wave_vessel_node.component",
    "wave_vessel_node.sources",
    "wave_vessel_node.mru",
    "wave_vessel_node.node",
)
"""A ship has none of these."""

PROGRAM = f"""
import sys

class Refusal:
    def find_spec(self, name, path=None, target=None):
        if any(name == blocked or name.startswith(blocked + ".") for blocked in {SIMULATORS!r}):
            raise ImportError("blocked: " + name)

sys.meta_path.insert(0, Refusal())
import {{module}}
from winch_controller_node.core.component import WinchController
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.node_parameters import WinchControllerParameters
controller = WinchController(WinchControllerParameters(), tick_period=0.05)
print(controller.step(1, Measurements()).report.mode)
"""


@pytest.mark.parametrize("module", ["winch_controller_node.node", "winch_controller_node.design.report"])
def test_the_controller_runs_without_simulators_sensors_and_recorder(module):
    if module.endswith(".node"):
        pytest.importorskip("rclpy")
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(module=module)], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "standby"


def imports_of(path):
    """Return the modules of this package that a file imports, without the package's name."""
    prefix = "winch_controller_node."
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(prefix):
            yield node.module.removeprefix(prefix)


CORE = (
    "component",
    "events",
    "operator_requests",
    "parts",
    "restarts",
    "estimation",
    "supervision",
    "beliefs_in_force",
    "design_in_force",
    "loop_command",
)
"""Modules that a ship's controller runs in a tick."""


def is_in(module, wings):
    return any(module == wing or module.startswith(wing + ".") for wing in wings)


def test_core_and_adviser_import_nothing_of_one_another():
    """Both stand on the beliefs; the one runs without the other."""
    across = []
    for path in PACKAGE.rglob("*.py"):
        module = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        own, other = (CORE, ("adviser",)) if is_in(module, CORE) else (("adviser",), CORE)
        across += [f"{module} -> {name}" for name in imports_of(path) if is_in(module, own) and is_in(name, other)]
    assert across == []


def test_a_law_is_named_by_its_own_file_and_nowhere_else():
    """What the rest must know of a law, the law says: nobody asks for it by name."""
    own = {Path(sys.modules[law.__module__].__file__) for law in LAWS.values()}
    named = []
    for path in set(PACKAGE.rglob("*.py")) - own:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Compare):
                words = {item.value for item in ast.walk(node) if isinstance(item, ast.Constant)}
                named += [f"{path.name}:{node.lineno}" for law in LAWS if law in words]
    assert not named


SHELL = ("node", "envelope_node", "move_action", "interface", "model", "identification")
"""ROS messages and the estimator's own records are filled in there."""

LIBRARY = ("self._fresh.settings",)
"""daqp takes its settings so."""


def written_attributes(path):
    """Return the attributes of anything but `self` that a module assigns to."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            words = ast.unparse(node)
            if ast.unparse(node.value) != "self" and words not in LIBRARY:
                yield f"{path.name}: {words}"


def test_nobody_writes_into_the_attributes_of_another():
    """Each helper owns its state; what others must know of it is passed down as a value."""
    modules = [
        path for path in PACKAGE.rglob("*.py") if path.relative_to(PACKAGE).with_suffix("").parts[0] not in SHELL
    ]
    assert len(modules) > 30
    assert [write for path in modules for write in written_attributes(path)] == []


def test_what_holds_arrays_is_compared_by_identity():
    """The == of a data class comes to its arrays, whose truth is ambiguous: a ValueError, once all before are equal."""
    compared = []
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.ClassDef):
                continue
            decorators = [ast.unparse(one) for one in node.decorator_list]
            holds = any(
                isinstance(one, ast.AnnAssign) and re.search(r"\bArray\b", ast.unparse(one.annotation))
                for one in node.body
            )
            if holds and any(one.startswith("dataclass") and "eq=False" not in one for one in decorators):
                compared.append(f"{path.relative_to(PACKAGE)} {node.name}")
    assert not compared


# the README


README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def test_the_example_runs(capsys):
    example = re.search(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert example is not None
    exec(compile(example.group(1), "README.md", "exec"), {})
    assert "standby" in capsys.readouterr().out


def test_every_module_that_the_readme_names_exists():
    package = Path(__file__).parents[1] / "winch_controller_node"
    table = README.split("## What is in here")[1].split("## Laws")[0]
    rows = re.findall(r"^\| (`[a-z_`/, ]+) \|", table, flags=re.MULTILINE)
    names = {name for row in rows for name in re.findall(r"`([a-z_/]+)`", row)}
    assert len(names) > 15
    missing = [name for name in sorted(names) if not ((package / f"{name}.py").exists() or (package / name).is_dir())]
    assert missing == []


def test_every_law_is_in_the_table_of_laws():
    table = README.split("## Laws (parameter `law`)")[1]
    assert set(LAWS) <= set(re.findall(r"^\| `([a-z_]+)` \|", table, flags=re.MULTILINE))
