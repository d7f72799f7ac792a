"""The winch as an FMU in a run over ROS: in the place of `virtual_winch` it gives the same run, byte for byte."""

import pytest
from heave_bags.mcap.reader import Bag

from tests.loop_runs import CALM_DURATION, heave, recorded_messages, run_scenario

pytest.importorskip("pythonfmu", reason="pythonfmu is not installed: the extra fmu")
pytest.importorskip("fmpy", reason="fmpy is not installed: the extra fmu")


def test_the_exported_winch_in_the_place_of_virtual_winch_gives_the_same_run(calm_bag, tmp_path):
    exported = heave("fmu", "b2_calm_300", "--part", "winch", "--folder", str(tmp_path))
    assert exported.returncode == 0, exported.stderr
    options = ["--replace", f"virtual_winch=fmu:{tmp_path / 'winch.fmu'}"]
    bag = run_scenario(tmp_path / "run", duration=CALM_DURATION, options=options)
    found, expected = (
        [message for message in recorded_messages(one) if message[0] != "/diagnostics"] for one in (bag, calm_bag)
    )
    assert len(expected) > 1000
    assert found == expected
    assert Bag(bag).run["replaced"] == "virtual_winch"


def test_what_is_no_drive_is_refused_in_one_line_before_anything_starts(tmp_path):
    (tmp_path / "drive.fmu").write_text("no archive")
    file = tmp_path / "drive.yaml"
    file.write_text("fmu: drive.fmu")
    run = heave(
        "run",
        "b2_calm_300",
        "--duration",
        "2",
        "--bag",
        str(tmp_path / "run"),
        "--replace",
        f"virtual_winch=fmu:{file}",
    )
    assert run.returncode == 2
    (line,) = run.stderr.splitlines()
    assert "drive.fmu: no FMU that can be used" in line
    assert not (tmp_path / "run").exists()
