"""The nodes cable_sim and virtual_winch as processes, with stand-ins for sea and controller."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from heave_node.interface.codes import WinchFault

pytest.importorskip("rclpy")
pytest.importorskip("heave_msgs")
domain_coordinator = pytest.importorskip("domain_coordinator")

PEERS = Path(__file__).with_name("peer_program.py")
COMMANDS = {
    "cable_sim": ["-m", "cable_sim_node.node"],
    "virtual_winch": ["-m", "cable_sim_node.winch_node"],
    "wave_vessel": [str(PEERS), "wave_vessel"],
    "winch_controller": [str(PEERS), "winch_controller"],
}
HARDWARE_WINCH = {**COMMANDS, "virtual_winch": [str(PEERS), "hardware_winch"]}
TICK = 50_000_000  # ns
TICKS = 100


@pytest.fixture(scope="module")
def domain() -> Iterator[int]:
    with domain_coordinator.domain_id() as number:
        yield number


def run(
    domain: int,
    tmp_path: Path,
    commands: dict[str, list[str]] = COMMANDS,
    common: dict[str, object] | None = None,
    listener: str = "winch_controller",
    **of_nodes: dict[str, object],
) -> tuple[dict[str, Any], dict[str, str]]:
    """Run five simulated seconds; return what the listener received and each node's standard error."""
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    processes = {}
    for name, command in commands.items():
        given = {
            "duration": 5.0,
            "participants": "[wave_vessel, winch_controller, virtual_winch]",
            **(common or {}),
            **of_nodes.get(name, {}),
        }
        arguments = [part for key, value in given.items() for part in ("-p", f"{key}:={value}")]
        processes[name] = subprocess.Popen(
            [sys.executable, *command, "--ros-args", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
            cwd=tmp_path,
        )
    try:
        ends = {name: process.communicate(timeout=90.0) for name, process in processes.items()}
    finally:
        for process in processes.values():
            process.kill()
    errors = {name: err for name, (_, err) in ends.items()}
    lines = ends[listener][0].strip().splitlines()
    assert lines, errors
    return json.loads(lines[-1]), errors


@pytest.fixture(scope="module")
def heard(domain: int, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return run(domain, tmp_path_factory.mktemp("run"))[0]


def test_run_ends_well_and_state_comes_in_every_tick_at_its_time(heard: dict[str, Any]) -> None:
    assert heard["ended"]
    assert heard["cable_stamps"] == [k * TICK for k in range(1, TICKS + 1)]
    # The winch's state of tick k is that of t_{k+1}; the controller gets it in tick k + 1.
    assert heard["winch_stamps"] == [k * TICK for k in range(2, TICKS + 1)]


def test_sensors_come_at_their_rates(heard: dict[str, Any]) -> None:
    counts = heard["counts"]
    assert counts["unit/odometry"] == counts["unit_uncompensated"] == TICKS
    assert counts["winch/load_cell"] == counts["unit/imu"] == TICKS
    # 10 Hz, 0.1 s late: samples of 0.1 s to 4.9 s have come by 5.0 s.
    assert heard["pressure_stamps"] == [2 * k * TICK for k in range(1, 50)]
    assert counts["markers"] == 10


def test_pressure_is_that_of_still_water_above_the_unit(heard: dict[str, Any]) -> None:
    depth = {stamp: -z for stamp, z in zip(heard["cable_stamps"], heard["unit"], strict=True)}
    for stamp, pressure in zip(heard["pressure_stamps"], heard["pressure"], strict=True):
        assert (pressure - 101_325.0) / (1025.0 * 9.80665) == pytest.approx(depth[stamp], abs=0.1)


def test_plant_follows_boom_tip_and_winch_of_the_tick(heard: dict[str, Any]) -> None:
    t = np.arange(2, TICKS + 1) * 0.05
    np.testing.assert_allclose(heard["tip"][1:], 0.5 * (1.0 - np.cos(0.8 * t)), atol=1e-9)
    np.testing.assert_allclose(np.array(heard["length"][1:]) - 300.0, heard["payout"], atol=1e-9)
    assert heard["payout"][-1] > 0.4
    assert heard["unit"][-1] < heard["uncompensated"][-1] - 0.3
    assert np.mean(heard["imu"]) == pytest.approx(9.80665, abs=0.1)


def test_power_is_negative_while_the_load_drives_the_winch_down(heard: dict[str, Any]) -> None:
    assert heard["power"][-1] == pytest.approx(-0.1 * heard["tension"][-1], rel=0.01)
    assert heard["tension"][-1] == heard["top_tension"][-2]


def test_markers_show_the_cable_where_it_is(heard: dict[str, Any]) -> None:
    assert [ns for ns, _, _ in heard["markers"]] == ["plant"] * 5
    np.testing.assert_allclose(heard["cable_marker"], heard["cable_nodes"][str(heard["marker_stamp"])])


@pytest.mark.slow
def test_faults_are_injected_and_cleared_by_service(domain: int, tmp_path: Path) -> None:
    faults = {"inject": "virtual_winch winch emergency_stop, cable_sim depth clear"}
    heard, _ = run(domain, tmp_path, winch_controller=faults)
    depth, winch = heard["answers"]
    assert depth.startswith("depth: clear from t = ")
    assert winch.startswith("winch: emergency_stop from t = ")
    assert heard["fault"][-1] == WinchFault.EMERGENCY_STOP
    assert heard["brake"][-1]


@pytest.mark.slow
def test_hardware_winch_with_a_clock_of_its_own_moves_the_plant_in_real_time(domain: int, tmp_path: Path) -> None:
    common = {"pacing": "realtime", "external": "[virtual_winch]"}
    heard, errors = run(domain, tmp_path, HARDWARE_WINCH, common)
    assert heard["ended"], errors
    let_out = np.array(heard["length"]) - 300.0
    # 0.1 m/s for five seconds, less the time from the start of the run to the moment the stand-in hears of it.
    assert 0.2 < let_out[-1] < 0.52
    assert np.diff(let_out).min() >= -0.01
    assert np.diff(let_out).max() < 0.05, "bridged without a jump"


@pytest.mark.slow
def test_winch_stops_by_itself_when_the_controller_is_killed(domain: int, tmp_path: Path) -> None:
    common = {"pacing": "realtime", "participant_timeout": 2.0}
    dying = {"die_in_tick": 40, "rate": 1.0}
    heard, errors = run(domain, tmp_path, common=common, listener="wave_vessel", winch_controller=dying)
    assert "winch_controller" in heard["reason"], errors
    faults, rates, times = np.array(heard["faults"]), np.array(heard["rates"]), np.array(heard["times"])
    # The command of tick 39, 1.95 s, works until 0.2 s + 0.5 s later, 2.65 s; from 1 m/s it is at rest at 3.32 s.
    assert times[faults == WinchFault.COMMAND_TIMEOUT].min() == pytest.approx(2.7, abs=0.2)
    assert rates[times < 2.6].max() == pytest.approx(1.0, abs=0.01)
    assert np.abs(np.diff(rates) / np.diff(times)).max() <= 1.5 + 1e-6
    assert (rates[-1], heard["brakes"][-1], faults[-1]) == (0.0, True, WinchFault.COMMAND_TIMEOUT)


def test_plant_that_cannot_start_ends_with_one_line(domain: int, tmp_path: Path) -> None:
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, *COMMANDS["cable_sim"], "--ros-args", "-p", "unit.volume:=30.0"]
    ended = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=60.0, check=False)
    assert ended.returncode == 1
    assert (
        ended.stderr.strip().splitlines()[-1].startswith("cable_sim: the line does not hang: the unit's buoyancy lifts")
    )
    assert "Traceback" not in ended.stderr


def test_wrong_parameter_of_the_winch_is_refused_with_one_line(domain: int, tmp_path: Path) -> None:
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, *COMMANDS["virtual_winch"], "--ros-args", "-p", "speed_limit:=-2.0"]
    ended = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=60.0, check=False)
    assert ended.returncode == 2
    assert ended.stderr.strip() == (
        "virtual_winch: command line: speed_limit = -2.0 is not allowed: it must be a number from 0.001 to 100 [m/s]"
    )
