"""What cannot be run is refused in one line, with status 2, before a node starts."""

import fcntl
import os
import tempfile
from pathlib import Path

import pytest
from heave_bringup.cli import main
from heave_bringup.errors import ExitStatus
from heave_bringup.network import only_run_in_domain

REFUSED = ExitStatus.REFUSED.value


@pytest.mark.parametrize("domain", ["x", "-1", "233", "1.5"])
def test_a_ros_domain_that_is_no_number_is_refused(monkeypatch, capsys, domain):
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    assert main(["run", "b2_calm_300"]) == REFUSED
    assert f"ROS_DOMAIN_ID='{domain}': must be a whole number from 0 to 232" in capsys.readouterr().err


def test_a_folder_that_cannot_be_made_is_refused(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["run", "b2_calm_300", "--bag", str(tmp_path / "file" / "bag")]) == REFUSED
    assert "bag: cannot be made: Not a directory; choose another folder" in capsys.readouterr().err


def test_a_run_of_no_tick_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["run", "b2_calm_300", "--duration", "0"]) == REFUSED
    assert "duration = 0 s: must be at least one tick of 0.05 s" in capsys.readouterr().err
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("changes", "refused"),
    [
        (["--set", "all.duration=nan", "--duration", "1"], "duration = 'nan' is not allowed"),
        (["--set", "system.unit.mass=.nan", "--set", "system.unit.mass=9e3"], "system.unit.mass = nan is not allowed"),
        (
            ["--set", "recorder.split_size=x", "--set", "recorder.split_size=9"],
            "split_size = 'x' is not allowed",
        ),
    ],
)
def test_a_value_that_is_not_allowed_is_refused_where_another_replaces_it(changes, refused, capsys):
    assert main(["run", "b2_calm_300", *changes]) == REFUSED
    said = capsys.readouterr().err
    assert refused in said
    assert said.count("\n") == 1


def test_numbers_in_a_refusal_are_short(capsys):
    assert main(["run", "b2_calm_300", "--set", "system.unit.mass=1e300"]) == REFUSED
    assert "strained by 6.28e+295 % at rest, more than 10 %" in capsys.readouterr().err


def test_a_second_run_in_a_domain_is_refused_and_the_namespace_is_named(tmp_path, monkeypatch, capsys):
    pytest.importorskip("rclpy")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROS_DOMAIN_ID", "87")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    lock = Path(tempfile.gettempdir()) / f"heave-{os.getuid()}-domain-87.lock"
    with only_run_in_domain() as is_only, lock.open() as held:
        assert is_only
        with pytest.raises(BlockingIOError):
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        assert main(["run", "b2_calm_300", "--no-report", "--no-baseline"]) == REFUSED
    said = capsys.readouterr().err
    assert "wait for it, or use --namespace NAME" in said
    assert said.count("\n") == 1, "before anything else is said, or any node started"
    assert not (tmp_path / "runs").exists()
