"""The live stream as Foxglove sees it: definitions, messages, time, and the frame of the unit."""

import json
import struct
import subprocess
import time

import pytest
from domain_coordinator import domain_id
from websockets.sync.client import connect

from tests.loop_runs import command, environment, wait_until

PORT = 8769
MESSAGE = 1
"""Opcode of a message in the protocol; then come the subscription, the time and the message."""


@pytest.mark.slow
@pytest.mark.long
def test_a_client_without_ros_is_given_all_that_it_needs_of_a_run_in_a_namespace(tmp_path):
    pytest.importorskip("foxglove")
    with domain_id() as domain:
        nobody = subprocess.run(
            command("view"), env=environment(domain), capture_output=True, text=True, timeout=60, check=False
        )
        assert nobody.returncode == 2
        assert nobody.stderr == f"heave: no run in ROS domain {domain}\n"
        log = (tmp_path / "run.log").open("w")
        where = ["--namespace", "ship"]
        general = ["--pacing", "lockstep", "--duration", "20000", "--no-report", "--bag", str(tmp_path / "run")]
        run = subprocess.Popen(
            command("run", "b2_calm_300", *general, *where), env=environment(domain), stdout=log, stderr=log
        )
        view = None
        try:
            wait_until(lambda: " x real time" in (tmp_path / "run.log").read_text(), 180.0)
            view = subprocess.Popen(
                command("view", "--port", str(PORT), *where), env=environment(domain), stdout=subprocess.PIPE, text=True
            )
            assert f"ws://localhost:{PORT}" in view.stdout.readline()
            look_as_foxglove()
            assert run.poll() is None
        finally:
            for process in (view, run):
                if process is not None:
                    process.send_signal(2)
                    process.wait(60.0)


def look_as_foxglove():
    """Connect as Foxglove does, and check what it would be shown."""
    channels: dict[str, dict] = {}
    seen: dict[int, tuple[int, bytes]] = {}
    with connect(f"ws://127.0.0.1:{PORT}", subprotocols=["foxglove.sdk.v1"], max_size=None) as socket:
        wanted = {"/controller/state", "/unit/odometry", "/markers", "/sea_state", "/unit_frame"}
        deadline = time.monotonic() + 60.0
        while len(seen) < len(wanted):
            assert time.monotonic() < deadline, sorted(channels)
            message = socket.recv(timeout=60.0)
            if isinstance(message, bytes):
                if message[0] == MESSAGE:
                    number, nanoseconds = struct.unpack_from("<IQ", message, 1)
                    seen[number] = nanoseconds, message[13:]
                continue
            content = json.loads(message)
            for channel in content.get("channels", []):
                channels[channel["topic"]] = channel
                if channel["topic"] in wanted:
                    entry = {"id": channel["id"], "channelId": channel["id"]}
                    socket.send(json.dumps({"op": "subscribe", "subscriptions": [entry]}))
    state = channels["/controller/state"]
    assert (state["encoding"], state["schemaName"]) == ("cdr", "heave_msgs/msg/ControllerState")
    assert "string mode" in state["schema"]
    assert "MSG: std_msgs/Header" in state["schema"]
    assert channels["/unit_frame"]["schemaName"] == "foxglove.FrameTransform"
    nanoseconds, odometry = seen[channels["/unit/odometry"]["id"]]
    assert nanoseconds < 20000e9, "the time is simulated"
    assert b"unit" in odometry
