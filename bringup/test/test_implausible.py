"""What is implausible is refused in one line before anything starts, and taken where the user says so."""

import numpy as np
import pytest
from heave_bringup.cli import main
from heave_bringup.run.before import check_files, check_rest
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError
from heave_studies.operability.seas import read_record
from wave_vessel_node.vessel.rao import ResponseTable
from wave_vessel_node.vessel.rao_files import write_rao_csv

OMEGA = np.linspace(0.2, 2.0, 10)


@pytest.fixture
def millimetres(tmp_path, monkeypatch):
    """An RAO table in mm/m, in the folder where the commands are given."""
    monkeypatch.chdir(tmp_path)
    response = np.zeros((1, 3, 6, OMEGA.size), dtype=complex)
    response[:, :, 2] = 1000.0 / (1.0 + 0.5j * OMEGA)
    headings = np.array([0.0, np.pi / 2.0, np.pi])
    write_rao_csv("mm.csv", ResponseTable(np.zeros(1), headings, OMEGA, response))
    return ["--set", "system.vessel.model=rao", "--set", "system.vessel.rao_file=mm.csv"]


def test_responses_in_millimetres_are_refused_by_run_and_design(millimetres, capsys):
    for command in (["run", "b2_calm_300", "--bag", "out"], ["design", "unit_1500"]):
        assert main([*command, *millimetres]) != 0
        (line,) = [line for line in capsys.readouterr().err.splitlines() if "mm.csv" in line]
        assert "heave in long waves is" in line
        assert "--set system.accept_implausible=true takes the figures as they are" in line


def test_one_word_accepts_them_for_ship_and_controller(millimetres):
    scenario = load_scenario("b2_calm_300", settings=["system.accept_implausible=true"])
    assert scenario.parameters["wave_vessel"].accept_implausible
    assert scenario.parameters["winch_controller"].vessel.accept_implausible
    assert not scenario.parameters["wave_vessel"].vessel.rao_file


def test_what_is_accepted_or_left_out_of_a_file_is_said_by_run_and_design(millimetres, capsys):
    scenario = load_scenario("b2_calm_300", settings=[*millimetres[1::2], "system.accept_implausible=true"])
    assert any("mm.csv" in line and "heave in long waves" in line for line in check_files(scenario))
    accepted = [*millimetres, "--set", "system.accept_implausible=true"]
    assert main(["design", "unit_1500", *accepted, "--pictures", "pictures"]) == 0
    assert any(
        line.startswith("heave: warning: ") and "mm.csv" in line and "heave in long waves" in line
        for line in capsys.readouterr().err.splitlines()
    )


def test_where_a_recorded_motion_stood_still_is_known_before_the_run(tmp_path):
    rows = "".join(f"{t:.1f},{0.3 if 5.0 <= t < 20.0 else np.sin(t):.4f}\n" for t in np.arange(0.0, 40.0, 0.1))
    (tmp_path / "m.csv").write_text("time_s,z_m\n" + rows)
    settings = ["wave_vessel.boom_tip_source=file", f"wave_vessel.recording_file={tmp_path / 'm.csv'}"]
    (line,) = check_files(load_scenario("b2_calm_300", settings=settings))
    assert "m.csv: stands still for 14.9 s from 5 s on" in line


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("system.cable.axial_stiffness=1000", "it would part; check cable.axial_stiffness (1000 N"),
        ("system.cable.stiffness_quadratic=-1e4", "stiffness_quadratic = -10000"),
        ("cable_sim.unit.volume=20", "the line does not hang: the unit's buoyancy lifts it above the boom tip"),
    ],
)
def test_a_line_that_has_no_rest_is_refused_before_a_run_by_its_cause(setting, says, tmp_path, capsys):
    with pytest.raises(ParameterError) as refused:
        check_rest(load_scenario("b2_calm_300", settings=[setting]))
    assert says in str(refused.value)
    assert main(["run", "b2_calm_300", "--bag", str(tmp_path / "out"), "--set", setting]) == 2
    assert says in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("system.unit.mass=1000", "the load floats: unit.volume of 3 m^3 displaces 3075 kg of water"),
        ("winch_controller.unit.mass=1000", "the load floats"),
        ("winch_controller.sensors.use=[mru]", "sensors.use must include the encoder"),
        ("system.winch.command_delay=9", "longer than the boom tip can usefully be predicted"),
    ],
)
def test_what_no_controller_serves_is_refused_before_a_run(setting, says, tmp_path, capsys):
    assert main(["run", "unit_1500", "--bag", str(tmp_path / "out"), "--set", setting]) == 2
    assert says in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


OR_VARY = "use heave run {0}, or heave study {0} --vary NODE.PARAM=V,V"


def test_a_file_of_another_kind_is_named_with_its_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my_lift"]) == 0
    (tmp_path / "plan.yaml").write_text("scenario: b2_calm_300\nphases: [{name: deck}]\n")
    (tmp_path / "scenario.yaml").write_text("")
    (tmp_path / "runs" / "empty").mkdir(parents=True)
    for command, file, says in (
        ("run", "plan.yaml", "plan.yaml: this is a lift plan; use heave study plan.yaml"),
        ("design", "plan.yaml", "plan.yaml: this is a lift plan; use heave study plan.yaml"),
        ("study", "my_lift.yaml", f"my_lift.yaml: this is a scenario; {OR_VARY.format('my_lift.yaml')}"),
        ("study", "b2_calm_300", f"b2_calm_300: this is a scenario; {OR_VARY.format('b2_calm_300')}"),
        ("run", "my_lift", "my_lift: no such scenario; did you mean my_lift.yaml?"),
        ("run", ".", ".: this is a folder; the scenario of a run is its file scenario.yaml"),
        ("run", "runs/empty", "runs/empty: this is a folder; give a file, such as that of a run"),
    ):
        capsys.readouterr()
        assert main([command, file]) == 2
        assert capsys.readouterr().err == f"heave: {says}\n"


STEEP = ["system.sea.significant_wave_height=5", "system.sea.peak_period=3"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "b2_calm_300", "--set", STEEP[0], "--set", STEEP[1]],
        ["design", "b2_calm_300", "--set", STEEP[0], "--set", STEEP[1]],
        ["new", "steep", "--hs", "5", "--tp", "3"],
    ],
)
def test_a_sea_whose_waves_break_is_refused_wherever_it_is_stated(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    assert "waves this steep break: a height of 5 m needs a peak period of 4.8 s or more" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        (["spectrum=ochi_hubble", "swell.significant_wave_height=6", "swell.peak_period=5"], "swell: waves this steep"),
        (
            ["later_sea.duration=60", "later_sea.significant_wave_height=6", "later_sea.peak_period=5"],
            "later_sea: wave",
        ),
    ],
)
def test_swell_and_later_sea_are_seas_too(settings, says):
    with pytest.raises(ParameterError, match=says):
        load_scenario("b2_calm_300", settings=[f"wave_vessel.{one}" for one in settings])


def test_a_spectrum_that_derives_its_period_takes_any_height():
    settings = ["spectrum=pierson_moskowitz", "significant_wave_height=20", "peak_period=3"]
    load_scenario("b2_calm_300", settings=[f"wave_vessel.{one}" for one in settings])


def test_fill_values_in_a_record_of_seas_are_not_measured(tmp_path):
    rows = [f"2001-01-01T{hour:02d}:00,{99.0 if hour == 3 else 2.0},{99.0 if hour == 5 else 8.0}" for hour in range(20)]
    (tmp_path / "seas.csv").write_text("﻿time,hs,tp\n" + "\n".join(rows) + "\n", encoding="utf-8")
    record = read_record(tmp_path / "seas.csv")
    assert record.states["hs"].max() == 2.0
    (warning,) = record.warnings
    assert "2 implausible states count as not measured, the first 2001-01-01 03:00" in warning


def test_a_record_in_other_units_is_refused(tmp_path):
    (tmp_path / "seas.csv").write_text("time,hs,tp\n2001-01-01T00:00,200,8\n2001-01-01T01:00,150,8\n")
    with pytest.raises(ParameterError, match="2 of 2 states are implausible"):
        read_record(tmp_path / "seas.csv")
