"""What `heave import` says of the motion that it took."""

import json
import math

import numpy as np
import pytest
from heave_bringup.cli import main
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario


def write_log(path, heave):
    """Write a log of `heave` [m] at 10 Hz."""
    rows = "\n".join(f"{0.1 * i:.1f},{z:.6f}" for i, z in enumerate(heave))
    path.write_text(f"time_s,heave\n{rows}\n")


SWELL = np.sin(0.07 * np.arange(6000))


@pytest.fixture
def imported(tmp_path, capsys):
    """Return a function: heave at 10 Hz in, what the command prints and its JSON out."""

    def run(heave):
        log, mapping, result = tmp_path / "log.csv", tmp_path / "mapping.yaml", tmp_path / "result.json"
        write_log(log, heave)
        mapping.write_text("heave: {column: heave}\n")
        arguments = ["--mapping", str(mapping), "--output", str(tmp_path / "sea.csv"), "--json", str(result)]
        assert main(["import", str(log), *arguments]) == 0
        return capsys.readouterr().out, json.loads(result.read_text())

    return run


def test_height_and_period_of_the_record_are_told_with_their_intervals(imported):
    # a swell of 0.5 m amplitude and 10 s: 4 sigma = 4 * 0.5 / sqrt(2) m
    text, result = imported(0.5 * np.sin(2.0 * math.pi / 10.0 * 0.1 * np.arange(12_000)))
    assert result["significant_heave_m"] == pytest.approx(2.0 / math.sqrt(2.0), rel=1e-3)
    assert result["peak_period_s"] == pytest.approx(10.0, rel=0.01)
    low, high = result["significant_heave_interval_m"]
    assert low < result["significant_heave_m"] < high
    assert "significant heave 1.41 m (" in text
    assert "peak period 10.0 s (" in text


def test_a_record_too_short_for_them_says_so(imported):
    text, result = imported(np.sin(0.1 * np.arange(1000)))
    assert "no significant height and peak period: a record of 99.95 s is too short" in text
    assert result["peak_period_s"] is None


@pytest.mark.parametrize("options", [[], ["--accept-implausible"]])
def test_a_record_without_motion_is_no_sea(options, tmp_path, capsys):
    write_log(tmp_path / "mru.csv", np.full(12_000, 0.1))
    sea = tmp_path / "sea.csv"
    arguments = ["import", str(tmp_path / "mru.csv"), "--column", "heave", "--output", str(sea), *options]
    assert main(arguments) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "mru.csv: heave is constant: no sea" in line
    assert not sea.exists()


def test_the_scenario_that_is_written_plays_the_record_and_believes_its_height_and_period(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_log(tmp_path / "mru.csv", 0.5 * np.sin(2.0 * math.pi / 10.0 * 0.1 * np.arange(12_000)))
    arguments = ["--column", "heave", "--output", "sea.csv", "--scenario", "mine.yaml", "--like", "unit_1500"]
    assert main(["import", "mru.csv", *arguments]) == 0
    scenario = load_scenario("mine.yaml", settings=["all.duration=3", "all.transient=1", "cable_sim.segments=5"])
    vessel, belief = scenario.parameters["wave_vessel"], scenario.parameters["winch_controller"]
    assert (vessel.boom_tip_source, vessel.recording_file) == ("file", str(tmp_path / "sea.csv"))
    assert belief.vessel.model == "direct"  # the record is of the boom tip, which no model of the vessel changes again
    assert belief.sea.significant_wave_height == pytest.approx(2.0 / math.sqrt(2.0), rel=1e-3)
    assert belief.sea.peak_period == pytest.approx(10.0, rel=0.01)
    assert scenario.parameters["cable_sim"].length == 1500.0
    assert load_scenario("mine.yaml").run.duration == 1198.0  # of 1,199.9 s
    assert ClosedLoop(loop_parameters(scenario)).run().column("boom_tip").std() > 0.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--bridge", "60"], "--bridge 60: must be above 0 and at most 10 s"),
        (["--to", "300", "--scenario", "mine.yaml"], "gives no height and period to assume"),
        (["--scenario", "mine.yaml", "--like", "b3"], "b3: no such scenario"),
    ],
)
def test_what_cannot_be_taken_is_refused_in_one_line(tmp_path, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(tmp_path)
    write_log(tmp_path / "mru.csv", SWELL)
    assert main(["import", "mru.csv", "--column", "heave", "--output", "sea.csv", *arguments]) != 0
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert not (tmp_path / "mine.yaml").exists()


def test_the_log_itself_is_never_written_over(tmp_path, capsys):
    log = tmp_path / "log.csv"
    write_log(log, SWELL)
    before = log.read_text()
    for option in ("--output", "--scenario"):
        others = [] if option == "--output" else ["--output", str(tmp_path / "sea.csv")]
        assert main(["import", str(log), "--column", "heave", option, str(log), *others]) != 0
        assert "is the record itself" in capsys.readouterr().err
    assert log.read_text() == before


def test_no_file_is_written_over_unless_that_is_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_log(tmp_path / "mru.csv", SWELL)
    arguments = ["import", "mru.csv", "--column", "heave", "--output", "sea.csv", "--scenario", "mine.yaml"]
    (tmp_path / "mine.yaml").write_text("mine")
    assert main(arguments) != 0
    assert "mine.yaml: exists already; --force overwrites it" in capsys.readouterr().err
    assert not (tmp_path / "sea.csv").exists()
    (tmp_path / "sea.csv").write_text("mine")
    assert main(arguments) != 0
    assert "sea.csv: exists already" in capsys.readouterr().err
    assert main([*arguments, "--force"]) == 0
    assert (tmp_path / "sea.csv").read_text().startswith("# boom-tip motion")


def test_a_scenario_that_would_be_wrong_leaves_the_one_that_is_there(tmp_path, monkeypatch, capsys):
    """A height beyond what a sea may have: the record is taken, its scenario is refused."""
    monkeypatch.chdir(tmp_path)
    write_log(tmp_path / "mru.csv", 90.0 * SWELL)
    (tmp_path / "mine.yaml").write_text("mine")
    arguments = ["import", "mru.csv", "--column", "heave", "--output", "sea.csv", "--scenario", "mine.yaml", "--force"]
    assert main([*arguments, "--accept-implausible"]) != 0
    assert "significant_wave_height" in capsys.readouterr().err
    assert (tmp_path / "mine.yaml").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.yaml", "mru.csv", "sea.csv"]
