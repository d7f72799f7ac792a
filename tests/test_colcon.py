"""The tree builds with colcon on a sourced ROS 2 underlay: here the ROS 2 wheels, without this project."""

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[1]
PACKAGES = (
    "cable_sim_node",
    "heave_bags",
    "heave_bringup",
    "heave_core",
    "heave_msgs",
    "heave_node",
    "wave_vessel_node",
    "winch_controller_node",
)

# three minutes, most of them for messages that `make` has compiled already: `make validate` runs it
pytestmark = [pytest.mark.slow, pytest.mark.long]


@dataclass(frozen=True)
class Workspace:
    """A colcon workspace over this repository, built outside of it."""

    folder: Path
    underlay: Path

    @property
    def environment(self) -> Mapping[str, str]:
        """The underlay is sourced; nothing of the environment that runs the tests leaks in."""
        kept = {name: os.environ[name] for name in ("HOME", "CC", "CXX", "LANG") if name in os.environ}
        return {
            **kept,
            "PATH": os.pathsep.join((str(self.underlay / "bin"), "/usr/local/bin", "/usr/bin", "/bin")),
            "AMENT_PREFIX_PATH": str(self.underlay),
            "CMAKE_PREFIX_PATH": str(self.underlay),
            "COLCON_HOME": str(self.folder / "home"),
            "CFLAGS": "-O0",  # compiled in half the time; nothing here runs for long
            "CXXFLAGS": "-O0",
            "COLCON_DEFAULTS_FILE": str(REPOSITORY / "cmake" / "colcon_on_wheels.yaml"),
        }

    def colcon(self, verb: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run a colcon verb; what it builds goes into the workspace."""
        bases = ("--build-base", "build", "--install-base", "install", "--base-paths", str(REPOSITORY))
        return self._run("colcon", "--log-base", "log", verb, *bases, *arguments)

    def sourced(self, command: str) -> subprocess.CompletedProcess[str]:
        """Run a shell command after the workspace's own set-up file."""
        return self._run("bash", "-c", f". install/local_setup.bash && {command}")

    def _run(self, *command: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            command, cwd=self.folder, env=self.environment, capture_output=True, text=True, check=False, timeout=600
        )


def files_below(folder: Path) -> set[str]:
    """Return the files of a package without what Python and numba compile beside them."""
    return {
        str(path.relative_to(folder))
        for path in folder.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workspace]:
    folder = tmp_path_factory.mktemp("workspace")
    underlay = folder / "underlay"
    uv = (sys.executable, "-m", "uv")
    subprocess.run((*uv, "venv", "--quiet", "--python", sys.executable, str(underlay)), check=True)
    wanted = ("--requirement", str(REPOSITORY / "pyproject.toml"), "--extra", "colcon", "pytest", "hypothesis")
    python = str(underlay / "bin" / "python")
    subprocess.run((*uv, "pip", "install", "--quiet", "--python", python, *wanted), check=True)
    built = Workspace(folder, underlay)
    build = built.colcon("build")
    assert build.returncode == 0, build.stdout + build.stderr
    yield built
    shutil.rmtree(folder)


def test_colcon_installs_every_package_where_ros_looks_for_it(workspace: Workspace):
    for package in PACKAGES:
        prefix = workspace.folder / "install" / package
        assert (prefix / "share/ament_index/resource_index/packages" / package).is_file()
        assert (prefix / "share" / package / "package.xml").is_file()


@pytest.mark.parametrize("mark", sorted(REPOSITORY.glob("*/resource/*")), ids=lambda path: path.name)
def test_colcon_installs_every_file_of_a_package(workspace: Workspace, mark: Path):
    package = mark.name
    (installed,) = workspace.folder.glob(f"install/{package}/lib/python*/site-packages/{package}")
    assert files_below(installed) == files_below(mark.parents[1] / package)


def test_a_build_leaves_nothing_in_the_source_tree(workspace: Workspace):
    for name in ("build", "*.egg-info"):
        assert not [path for path in REPOSITORY.glob(f"*/{name}") if not path.parent.name.startswith(".")]


def test_the_built_messages_load_with_their_type_support(workspace: Workspace):
    code = (
        "import heave_msgs.msg, heave_msgs.srv, heave_msgs.action; from rclpy.serialization import serialize_message;"
        "print(heave_msgs.__file__, len(serialize_message(heave_msgs.msg.WinchState())))"
    )
    loaded = workspace.sourced(f"python -c {shlex.quote(code)}")
    assert loaded.stdout.startswith(str(workspace.folder / "install" / "heave_msgs")), loaded.stderr


def test_the_command_of_the_built_workspace_finds_its_scenarios(workspace: Workspace):
    on_path = 'export PATH="$PWD/install/heave_bringup/lib/heave_bringup:$PATH"'  # as docs/guide/install.md says
    listed = workspace.sourced(f"{on_path} && heave list")
    assert "b2_calm_300" in listed.stdout, listed.stderr


def test_colcon_test_runs_the_tests_of_a_package(workspace: Workspace):
    tested = workspace.colcon("test", "--packages-select", "heave_node", "--pytest-args", "test/test_parameters.py")
    assert tested.returncode == 0, tested.stdout + tested.stderr
    result = workspace.sourced("colcon test-result --test-result-base build/heave_node")
    assert result.returncode == 0, result.stdout
    assert "Summary: 0 tests" not in result.stdout
