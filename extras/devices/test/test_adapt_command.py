"""`heave adapt`: what it lists, shows, checks and refuses."""

import json

import pytest
from domain_coordinator import domain_id
from heave_bringup.cli import main

from tests.loop_runs import give
from tests.plc import free_port


def test_the_shipped_maps_are_listed_and_shown(capsys, tmp_path):
    assert main(["adapt", "--list"]) == 0
    listed = capsys.readouterr().out
    assert "psxn" in listed
    assert "sbg_ship_motion" in listed
    assert main(["adapt", "--show", "psxn"]) == 0
    path = tmp_path / "mine.yaml"
    path.write_text(capsys.readouterr().out)
    assert main(["adapt", "--check", str(path), "--json", "-"]) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert found == {
        "map": "mine",
        "from": "udp 127.0.0.1:10110",
        "publishes": "mru",
        "quantities": "heave, heave_rate, roll, pitch, roll_rate, pitch_rate",
    }


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        ([], 2, "name a map file, or a shipped map"),
        (["psxm"], 2, "psxm: there is no such file, and no map is shipped by that name"),
        (["--show", "psxm"], 2, "is no shipped map; known: crane_joint_states, em3000"),
        (["psxn", "phoct"], 2, "mru is published by more than one of the maps"),
        (["--duration", "0", "psxn"], 2, "must be above 0"),
        (["sbg_ship_motion"], 1, "the message type sbg_driver/msg/SbgShipMotion is not installed: build its package"),
        (["tss1"], 1, "serial /dev/ttyUSB0 at 9600: cannot be opened: No such file or directory"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(arguments, status, words, capsys, monkeypatch):
    with domain_id() as domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        assert main(["adapt", *arguments]) == status
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert line.startswith("heave: ")
    assert words in line


def test_a_map_without_a_source_reads_records_alone(tmp_path, capsys, monkeypatch):
    path = tmp_path / "log.yaml"
    path.write_text("format: nmea\nheave: PSXN23.heave\n")
    assert main(["adapt", "--check", str(path)]) == 0
    assert "a record" in capsys.readouterr().out
    with domain_id() as domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        assert main(["adapt", str(path)]) == 2
    assert "log: says no source: add source: {udp: PORT}" in capsys.readouterr().err


def test_a_device_that_cannot_be_reached_is_the_reason_of_the_end(tmp_path):
    path = tmp_path / "mru.yaml"
    path.write_text(f"source: {{tcp: 127.0.0.1:{free_port('tcp')}}}\nformat: nmea\nheave: PSXN23.heave\n")
    with domain_id() as domain:
        ended = give(domain, "adapt", str(path), "--duration", "0.5")
    assert ended.returncode == 1
    assert "heave: mru: Connection refused" in ended.stderr
