"""What vessel and plant must agree on, and a sea that its depth cannot hold, are refused before anything starts."""

import pytest
from heave_bringup.cli import main
from heave_bringup.errors import ExitStatus
from heave_bringup.replacements import external_settings
from heave_bringup.run.before import check_waves
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError

HIGH_SEA = ["system.sea.significant_wave_height=12", "system.sea.peak_period=15"]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["cable_sim.boom_tip_height=10"], "is 10 m in cable_sim and 25 m in wave_vessel: set system.boom_tip_height"),
        (
            [*HIGH_SEA, "cable_sim.seabed.depth=8"],
            "waves of 12 m break in seabed.depth = 8 m: they are at most 0.78 of",
        ),
        (
            ["cable_sim.wave.source=regular", "cable_sim.wave.amplitude=2", "cable_sim.seabed.depth=5"],
            "waves of 4 m break in seabed.depth = 5 m",
        ),
    ],
)
def test_a_run_that_contradicts_itself_is_refused(settings, words):
    with pytest.raises(ParameterError, match=f"^[^\n]*b11_splash_zone.yaml: [^\n]*{words}"):
        check_waves(load_scenario("b11_splash_zone", settings=settings))


def test_waves_that_feel_the_bottom_are_a_warning():
    """8 s: g T^2/(2 pi) = 99.9 m, deep water from 49.9 m on."""
    (line,) = check_waves(load_scenario("b11_splash_zone", settings=["cable_sim.seabed.depth=49"]))
    assert line.endswith("seabed.depth = 49 m is less than half of their length of 99.9 m")
    assert check_waves(load_scenario("b11_splash_zone", settings=["cable_sim.seabed.depth=51"])) == []


def test_a_seabed_without_room_for_the_line_is_refused_before_a_run(tmp_path, capsys):
    place = ["--bag", str(tmp_path / "out"), "--set", "cable_sim.seabed.depth=5"]
    assert main(["run", "s300_driven", *place]) == ExitStatus.REFUSED
    assert "seabed.depth = 5 m is less than half a segment" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_parameter_of_a_node_that_is_replaced_is_said_to_have_no_reader(tmp_path, capsys):
    unread, read = "cable_sim.sensors.depth.fitted=false", "winch_controller.law=lqg"
    options = ["--replace", "cable_sim=external", "--pacing", "realtime", "--composed", "--bag", str(tmp_path / "out")]
    assert main(["run", "b2_calm_300", *options, "--set", unread, "--set", read]) == ExitStatus.REFUSED
    warning, _ = capsys.readouterr().err.splitlines()
    assert warning == f"heave: warning: --set {unread}: cable_sim is replaced and does not read it"


def test_a_latency_that_is_declared_is_expected_by_the_controller_of_each_sensor_of_the_node():
    """Taken off the stamps alone it made readings late: those of an MRU from three sampling intervals on."""
    given = external_settings(["wave_vessel=none:0.15", "winch/load_cell=own"])
    latencies = {setting.place: setting.value for setting in given if setting.name.endswith("latency")}
    assert latencies == {"winch_controller.sensors.mru.latency": 0.15}
