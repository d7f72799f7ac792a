"""A winch with half of the acceleration that is believed, over the ROS nodes of a run, with its verdict."""

import json

from tests.loop_runs import heave

WEAK = ("virtual_winch.acceleration_limit=0.8", "virtual_winch.stop_deceleration=0.8")
"""Benchmark B3 believes in 1.5 m/s^2."""


def test_a_winch_weaker_than_believed_is_found_out_and_the_unit_held_still(tmp_path):
    """The loop was lost here, and the unit moved eight times as much as without compensation."""
    settings = [*WEAK, "wave_vessel.ramp=10", "all.transient=45"]
    result = heave(
        *("run", "b3_deep_900", "--duration", "90", "--bag", str(tmp_path / "run"), "--composed", "--no-report"),
        *("--json", str(tmp_path / "kpi.json"), "--require", "unit_efficiency>0.9"),
        *(word for setting in settings for word in ("--set", setting)),
    )
    assert result.returncode == 0, result.stdout + result.stderr
    verdict = json.loads((tmp_path / "kpi.json").read_text())["verdict"]
    assert {entry["kpi"]: entry["met"] for entry in verdict["criteria"]}["unit_efficiency"]
    told = [line for line in (result.stdout + result.stderr).splitlines() if "winch model updated" in line]
    assert any("acceleration limit 0.7" in line and "(was 1.500)" in line for line in told), told
    assert not any("compensation is harmful" in line for line in (result.stdout + result.stderr).splitlines())
