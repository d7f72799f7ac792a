"""A shell in which another ROS is sourced."""

import os
import subprocess
import sys

import pytest
from heave_bringup.cli import leave_out_other_ros


@pytest.fixture
def folders(tmp_path):
    """Folders of modules: of the suite's own ROS, of another one, and of the user's own modules."""
    for name in ("own/rclpy", "humble/rclpy", "mine"):
        (tmp_path / name).mkdir(parents=True)
    return {name: str(tmp_path / name) for name in ("own", "humble", "mine")}


def test_another_ros_is_named_and_left_out_here_and_for_the_nodes(folders):
    environment = {"PYTHONPATH": os.pathsep.join([folders["humble"], folders["mine"]])}
    path = ["", folders["humble"], folders["mine"], folders["own"]]
    words = leave_out_other_ros(environment, path)
    assert folders["humble"] in words
    assert environment["PYTHONPATH"] == folders["mine"]
    assert path == ["", folders["mine"], folders["own"]]


def test_its_libraries_and_packages_are_left_out_too(folders, tmp_path):
    """A sourced setup names them as well, and the loader takes its libraries before those of this installation."""
    (tmp_path / "humble" / "librcl.so").touch()
    (tmp_path / "humble" / "share" / "rclpy").mkdir(parents=True)
    environment = {
        "LD_LIBRARY_PATH": os.pathsep.join([folders["mine"], folders["humble"]]),
        "AMENT_PREFIX_PATH": folders["humble"],
    }
    words = leave_out_other_ros(environment, [folders["own"]])
    assert words.count(folders["humble"]) == 2
    assert environment == {"LD_LIBRARY_PATH": folders["mine"]}


def test_a_middleware_that_this_installation_does_not_have_is_left_out(folders, tmp_path, monkeypatch):
    libraries = tmp_path / "prefix" / "lib"
    libraries.mkdir(parents=True)
    for name in ("librmw.so", "librmw_fastrtps_cpp.so"):
        (libraries / name).touch()
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "prefix"))
    environment = {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}
    assert "RMW_IMPLEMENTATION rmw_cyclonedds_cpp" in leave_out_other_ros(environment, [folders["own"]])
    assert environment == {}
    environment = {"RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"}
    assert leave_out_other_ros(environment, [folders["own"]]) == ""
    (libraries / "librmw.so").unlink()  # ROS is not from wheels: its middlewares are elsewhere
    assert leave_out_other_ros({"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}, [folders["own"]]) == ""


@pytest.mark.parametrize("name", ["heave_msgs", "numpy"])
def test_another_of_its_compiled_modules_is_left_out_where_it_has_its_own(name, folders, tmp_path):
    (tmp_path / "humble" / "rclpy").rmdir()
    (tmp_path / "humble" / name).mkdir()
    for has_own in (False, True):
        environment, path = {"PYTHONPATH": folders["humble"]}, [folders["humble"], folders["own"]]
        assert (folders["humble"] in leave_out_other_ros(environment, path)) == has_own
        assert (environment, path) == (({}, [folders["own"]]) if has_own else ({"PYTHONPATH": path[0]}, path))
        (tmp_path / "own" / name).mkdir(exist_ok=True)


@pytest.mark.parametrize("ending", ["", "/", "/."])
def test_a_numpy_of_another_python_is_one_line(ending, tmp_path):
    """It must be left out before it is imported."""
    (tmp_path / "numpy").mkdir()
    (tmp_path / "numpy" / "__init__.py").write_text("raise ImportError('built for another Python')\n")
    command = [sys.executable, "-c", "from heave_bringup.cli import main; main(['list'])"]
    run = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": f"{tmp_path}{ending}"}, capture_output=True, text=True, check=True
    )
    (line,) = run.stderr.splitlines()
    assert f"is left out: PYTHONPATH {tmp_path}" in line


@pytest.mark.parametrize("given", [[], ["mine"]])
def test_nothing_is_changed_where_there_is_none(folders, given):
    environment = {"PYTHONPATH": os.pathsep.join(folders[name] for name in given)} if given else {}
    before, path = dict(environment), [folders[name] for name in (*given, "own")]
    assert leave_out_other_ros(environment, path) == ""
    assert environment == before


def test_the_only_ros_there_is_stays(folders):
    """As colcon builds the suite: all is on PYTHONPATH."""
    environment = {"PYTHONPATH": folders["humble"]}
    assert leave_out_other_ros(environment, [folders["humble"], folders["mine"]]) == ""
