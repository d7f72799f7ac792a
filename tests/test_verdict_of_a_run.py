"""The verdict ends the table of a run, and sets its exit status."""

import json

import pytest
from heave_bringup.errors import ExitStatus

from tests.loop_runs import heave

SHORT = ["--composed", "--duration", "5", "--set", "all.transient=1.0", "--no-report"]
"""Options of a run that ends before compensation begins."""


@pytest.mark.slow
def test_a_required_figure_that_is_missed_sets_the_exit_status(tmp_path):
    options = [*SHORT, "--json", str(tmp_path / "kpi.json")]
    require = ["--require", "unit_sigma_m<1e-9", "--require", "missed_deadlines<1"]
    result = heave("run", "b2_calm_300", "--bag", str(tmp_path / "run"), *options, *require)
    assert result.returncode == ExitStatus.VERDICT_FAILED
    assert result.stderr.strip().splitlines()[-1].startswith("heave: verdict FAILED: ")
    met, rope = result.stdout.strip().splitlines()[-2:]
    assert met.endswith(": met"), "the table ends with the verdict"
    assert rope.startswith("  Rope strength not stated: not judged"), "and with what it leaves out"
    assert f"all figures: heave kpi {tmp_path / 'run'}" in result.stdout
    assert "latency" not in result.stdout, "of more than eight figures --full or heave kpi tells"
    verdict = json.loads((tmp_path / "kpi.json").read_text())["verdict"]
    assert (verdict["good"], verdict["state"]) == (False, "FAILED")
    assert verdict["time_in_modes"]["standby"] > 0.5, "compensation never began, which so short a run is not judged by"
    missed = [entry for entry in verdict["criteria"] if not entry["met"]]
    assert len(verdict["failures"]) == len(missed)
    met = {entry["kpi"]: entry["met"] for entry in verdict["criteria"]}
    assert met["missed_deadlines"]
    assert not met["unit_sigma_m"]


@pytest.mark.slow
def test_what_a_reader_must_be_warned_of_is_told_by_a_quiet_run_and_by_the_figures_of_its_bag(tmp_path):
    """Worse than off is one such warning; that compensation never began is one that a few seconds have."""
    options = [*SHORT, "--json", str(tmp_path / "kpi.json")]
    result = heave("run", "b2_calm_300", "--bag", str(tmp_path / "run"), *options, "--quiet")
    assert result.returncode == ExitStatus.DONE, result.stderr
    assert "will not be judged: only 4 s after the transient" in result.stderr
    (warning,) = json.loads((tmp_path / "kpi.json").read_text())["warnings"]
    assert warning.startswith("Compensation never began")
    assert f"heave: warning: {warning}\n" in result.stderr
    assert result.stdout == ""
    again = tmp_path / "again.json"
    assert heave("kpi", str(tmp_path / "run" / "bag"), "--json", str(again)).stdout.endswith(f": {warning}\n")
    assert json.loads(again.read_text())["warnings"] == [warning]
