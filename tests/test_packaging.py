"""One tree, two builds: what pip and colcon know of each package must agree."""

import ast
import os
import re
import subprocess
import sys
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path
from xml.etree import ElementTree

import pytest
from ament_index_python.packages import get_package_prefix, get_package_share_path
from heave_bringup.nodes import PROCESS_BY_NAME
from heave_node.extras import PARTS
from heave_node.ros.transport.environment import prepare_environment
from packaging.requirements import Requirement
from packaging.version import Version

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

REPOSITORY = Path(__file__).parents[1]
PYPROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())
MANIFESTS = sorted([*REPOSITORY.glob("*/package.xml"), *REPOSITORY.glob("extras/*/package.xml")])
BY_CMAKE = ("core", "msgs")
"""Folders of packages that colcon builds by CMake."""

PYTHON_MANIFESTS = [path for path in MANIFESTS if path.parent.name not in BY_CMAKE]
OF_DEVELOPERS = {"test", "coverage", "colcon", "docs", "all"}
"""Extras of pyproject.toml that are for no command."""
LAUNCHING = {"launch", "launch_ros"}
"""Packages of ROS that have no wheel: launch files alone need them, and who launches has them."""

ROSDEP = {
    **{name: f"python3-{name}" for name in ("argcomplete", "fastapi", "jinja2", "matplotlib", "numba", "numpy")},
    **{name: f"python3-{name}" for name in ("pandas", "psutil", "pynmea2", "rich", "scipy", "serial", "uvicorn")},
    **{"control": "python-control-pip", "mcap": "mcap-ros2-support", "mcap_ros2": "mcap-ros2-support"},
    **{"pymodbus": "python3-pymodbus-pip", "rosbags": "python3-rosbags-pip", "yaml": "python3-yaml"},
}
"""Keys of github.com/ros/rosdistro at 8468e88c, rosdep/python.yaml, by the names that are imported."""
ROSDEP_OF_TESTS = {"python3-pytest", "python3-hypothesis", "python3-filterpy-pip"}


def manifest(path: Path) -> ElementTree.Element:
    return ElementTree.parse(path).getroot()


def name_of(path: Path) -> str:
    return manifest(path).findtext("name") or ""


def folder_id(path: Path) -> str:
    return path.parent.name


def canonical(distribution: str) -> str:
    return re.sub(r"[-_.]+", "-", distribution).lower()


@cache
def names_in(module: Path) -> tuple[set[str], set[str]]:
    """Return the top-level names of what a module imports, and its texts."""
    names: set[str] = set()
    texts: set[str] = set()
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add((node.module or "").split(".")[0])
        elif isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            texts.add(node.value)
    return names, texts


providers_of_names = cache(packages_distributions)


def entry_points_of_setup(path: Path) -> dict[str, dict[str, str]]:
    """Return the entry points of a setup.py, by group and name, read without running it."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "set_up":
            given = {words.arg: ast.literal_eval(words.value) for words in node.keywords}
            groups = {"console_scripts": given.get("scripts", ()), **given.get("parts", {})}
            return {group: dict(re.split(r"\s*=\s*", one, maxsplit=1) for one in of) for group, of in groups.items()}
    raise AssertionError(f"{path} sets no package up")


def console_scripts_of_setup(path: Path) -> dict[str, str]:
    return entry_points_of_setup(path)["console_scripts"]


def test_every_package_of_the_house_has_a_manifest():
    assert [path.parent.name for path in MANIFESTS] == [
        "bags",
        "bringup",
        "cable_sim_node",
        "core",
        *("devices", "drives", "fmu", "panel", "statics", "studies"),
        "msgs",
        "node_base",
        "wave_vessel_node",
        "winch_controller_node",
    ]


@pytest.mark.parametrize("path", MANIFESTS, ids=folder_id)
def test_version_and_licence_of_a_manifest_are_those_of_pyproject(path):
    root = manifest(path)
    assert root.findtext("version") == PYPROJECT["project"]["version"]
    assert root.findtext("license") == PYPROJECT["project"]["license"]


@pytest.mark.parametrize("path", PYTHON_MANIFESTS, ids=folder_id)
def test_a_python_package_is_in_the_wheel_and_in_the_ament_index(path):
    name = name_of(path)
    assert (path.parent / name).relative_to(REPOSITORY).as_posix() in PYPROJECT["tool"]["scikit-build"]["wheel"][
        "packages"
    ]
    assert (path.parent / "resource" / name).is_file()
    assert (path.parent / name / "py.typed").is_file()


@pytest.mark.parametrize("path", PYTHON_MANIFESTS, ids=folder_id)
def test_every_folder_with_modules_is_a_package_that_setuptools_finds(path):
    package = path.parent / name_of(path)
    without_init = {module.parent for module in package.rglob("*.py") if not (module.parent / "__init__.py").exists()}
    assert not without_init


def test_pip_and_colcon_install_the_same_executables():
    by_colcon: dict[str, str] = {}
    for path in PYTHON_MANIFESTS:
        by_colcon |= console_scripts_of_setup(path.parent / "setup.py")
    assert by_colcon == PYPROJECT["project"]["scripts"]


def test_pip_and_colcon_install_the_same_parts_of_extras():
    by_colcon: dict[str, dict[str, str]] = {}
    for path in PYTHON_MANIFESTS:
        for group, parts in entry_points_of_setup(path.parent / "setup.py").items():
            by_colcon[group] = {**by_colcon.get(group, {}), **parts}
    del by_colcon["console_scripts"]
    assert by_colcon == PYPROJECT["project"]["entry-points"]
    assert all(set(by_colcon[group]) == set(parts) for group, parts in PARTS.items())


def test_ros_finds_each_executable_under_the_package_that_colcon_puts_it_in():
    listed = re.findall(
        r"^install_node_package\((.*)\)", (REPOSITORY / "cmake/install_node_packages.cmake").read_text(), re.M
    )
    by_pip = {words[1]: set(words[2:]) for words in map(str.split, listed) if words[0] not in BY_CMAKE}
    by_colcon = {name_of(path): set(console_scripts_of_setup(path.parent / "setup.py")) for path in PYTHON_MANIFESTS}
    assert by_pip == by_colcon


@pytest.mark.parametrize("path", PYTHON_MANIFESTS, ids=folder_id)
def test_a_manifest_names_each_package_of_the_suite_that_is_imported_and_no_other(path):
    suite = {name_of(other) for other in MANIFESTS}
    named = {element.text for element in manifest(path) if element.tag in ("depend", "exec_depend")} & suite
    imported: set[str] = set()
    for module in (path.parent / name_of(path)).rglob("*.py"):
        names, texts = names_in(module)
        # modules started or looked up by name
        by_name = {name for name in suite for text in texts if text.startswith((f"{name}.", f"{name}:"))}
        imported |= names | by_name
    assert named == (imported & suite) - {name_of(path)}


@pytest.mark.parametrize("path", MANIFESTS, ids=folder_id)
def test_a_manifest_names_what_rosdep_knows_of_what_is_imported_and_nothing_that_it_does_not_know(path):
    modules = [names_in(module)[0] for module in (path.parent / name_of(path)).rglob("*.py")]
    imported = {ROSDEP[name] for names in modules for name in names & set(ROSDEP)}
    declared = {element.text for element in manifest(path) if str(element.text).startswith(("python", "mcap"))}
    assert imported - declared == set()
    assert declared - set(ROSDEP.values()) - ROSDEP_OF_TESTS == set()


@pytest.mark.parametrize("path", PYTHON_MANIFESTS, ids=folder_id)
def test_every_distribution_that_is_imported_is_declared(path):
    extras = PYPROJECT["project"]["optional-dependencies"]
    of_extras = [name for extra in set(extras) - OF_DEVELOPERS for name in extras[extra]]
    wanted = [*PYPROJECT["project"]["dependencies"], *of_extras]
    declared = {canonical(re.split(r"[\[<>=~!; ]", requirement)[0]) for requirement in wanted}
    suite = {name_of(other) for other in MANIFESTS}
    providers = providers_of_names()
    undeclared = set()
    for module in (path.parent / name_of(path)).rglob("*.py"):
        for name in names_in(module)[0] - suite - LAUNCHING - set(sys.stdlib_module_names):
            # A ROS package's wheel also brings an egg-info of the bare name: either spelling is the same wheel.
            names = {canonical(provider) for provider in providers.get(name, [name])}
            if not names & declared and f"ros-{canonical(name)}" not in declared:
                undeclared.add(name)
    assert not undeclared


@pytest.mark.parametrize("path", MANIFESTS, ids=folder_id)
def test_the_installed_environment_knows_every_package(path, monkeypatch):
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    prepare_environment()
    name = name_of(path)
    assert manifest(get_package_share_path(name) / "package.xml").findtext("name") == name
    if path in PYTHON_MANIFESTS:
        for executable in console_scripts_of_setup(path.parent / "setup.py"):
            assert (Path(get_package_prefix(name)) / "lib" / name / executable).stat().st_mode & 0o111


def test_the_message_files_name_only_types_of_packages_that_the_manifest_depends_on():
    root = manifest(REPOSITORY / "msgs/package.xml")
    declared = {element.text for element in root.findall("depend")} | {"heave_msgs"}
    used = set()
    for path in REPOSITORY.glob("msgs/*/*"):
        used |= set(re.findall(r"^(\w+)/\w+", path.read_text(), re.M))
    assert used <= declared


@pytest.mark.parametrize(
    "path",
    [*sorted(REPOSITORY.glob("*/launch/*.launch.py")), *sorted(REPOSITORY.glob("extras/*/launch/*.launch.py"))],
    ids=lambda path: path.name,
)
def test_a_launch_file_starts_what_its_package_installs(path):
    folder = path.parents[1]
    calls = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
    for call in calls:
        if isinstance(call.func, ast.Name) and call.func.id == "one_node":
            package, executable = map(ast.literal_eval, call.args)
            assert package == name_of(folder / "package.xml")
            assert executable in console_scripts_of_setup(folder / "setup.py")
        elif isinstance(call.func, ast.Name) and call.func.id == "ExecuteProcess":
            assert '"heave", "adapt"' in path.read_text(), "a command of the suite"


def test_every_node_of_the_loop_has_the_launch_file_that_the_loop_includes():
    for node in PROCESS_BY_NAME.values():
        share = get_package_share_path(node.module.partition(".")[0])
        assert (share / "launch" / f"{node.name}.launch.py").is_file()


CONSTRAINTS = sorted((REPOSITORY / "constraints").glob("python3.*.txt"))


@pytest.mark.parametrize("path", CONSTRAINTS, ids=lambda path: path.stem)
def test_the_tested_versions_are_names_and_versions_that_pyproject_allows(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.!+_-]+", line) for line in lines)
    pinned = {canonical(name): version for name, _, version in (line.partition("==") for line in lines)}
    project = PYPROJECT["project"]
    extras = project["optional-dependencies"]
    (tested,) = [one.extras for one in map(Requirement, extras["test"]) if one.name == "heave"]
    (with_all,) = [one.extras for one in map(Requirement, extras["all"])]
    wanted = [*project["dependencies"], *extras["test"]]
    wanted += [one for extra in {*tested, *with_all} - {"all"} for one in extras[extra]]
    wanted = [one for one in wanted if Requirement(one).name != "heave"]
    wanted += PYPROJECT["build-system"]["requires"]
    python = {"python_version": path.stem.removeprefix("python")}
    for requirement in map(Requirement, wanted):
        if requirement.marker is None or requirement.marker.evaluate(python):
            assert requirement.specifier.contains(pinned[canonical(requirement.name)]), str(requirement)


SOUND = {"pip": "25.3", "setuptools": "78.1.1"}
"""First versions without the path traversals of CVE-2025-8869 and CVE-2025-47273."""


@pytest.mark.parametrize("path", CONSTRAINTS, ids=lambda path: path.stem)
def test_what_installs_is_of_a_version_without_known_holes(path):
    """A new environment brings those of its Python's release, which the setup replaces."""
    pinned = dict(line.split("==") for line in path.read_text().splitlines() if not line.startswith("#"))
    assert all(Version(pinned[name]) >= Version(least) for name, least in SOUND.items())


def test_setting_up_takes_the_tested_versions():
    make = (REPOSITORY / "Makefile").read_text()
    installing = [line for line in make.splitlines() if " install --quiet" in line and "install --quiet uv" not in line]
    assert len(installing) >= 6
    assert all("$(PINNED)" in line for line in installing)


def test_a_long_step_of_the_setup_says_that_it_goes_on_and_ends_as_its_command_does():
    step = ["sh", str(REPOSITORY / "tools/patiently.sh"), "compiling", "sh", "-c", "sleep 1.5; exit 3"]
    done = subprocess.run(step, capture_output=True, text=True, env={**os.environ, "EVERY": "1"}, check=False)
    assert (done.returncode, done.stdout) == (3, "setup: compiling, 1 s so far\n")


def test_a_users_own_law_beside_the_packages_is_not_linted(tmp_path):
    """It is saved where `heave run` finds it: in the working folder, which may be this one."""
    (tmp_path / "pyproject.toml").write_text((REPOSITORY / "pyproject.toml").read_text())
    found = {}
    for name in ("my_law.py", "my_laws/lead.py", "bringup/heave_bringup/ours.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("import os,sys\nx =1")
        command = [str(Path(sys.executable).with_name("ruff")), "check", str(tmp_path)]
        found[name] = subprocess.run(command, capture_output=True, check=False).returncode
    assert found == {"my_law.py": 0, "my_laws/lead.py": 0, "bringup/heave_bringup/ours.py": 1}
