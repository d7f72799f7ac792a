"""A second controller in a running system: not obeyed, named everywhere, and the run does not count as a success."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag
from rclpy.serialization import deserialize_message

from tests.loop_runs import beside, give

ROGUE = """
import time
import rclpy
from heave_msgs.msg import WinchCommand
from heave_node.ros.transport.environment import prepare_environment
prepare_environment()
rclpy.init()
node = rclpy.create_node("rogue_controller")
publisher = node.create_publisher(WinchCommand, "winch/command", 10)
while not node.count_subscribers("winch/command"):
    time.sleep(0.1)
sequence = 10**9
try:
    while True:
        sequence += 1
        message = WinchCommand(sequence=sequence, payout=100.0, payout_rate=2.0)
        message.header.stamp.sec = sequence
        publisher.publish(message)
        time.sleep(0.05)
except KeyboardInterrupt:
    pass
"""


@pytest.mark.slow
@pytest.mark.parametrize("pacing", ["realtime", pytest.param("lockstep", marks=pytest.mark.long)])
def test_a_second_controller_moves_nothing_and_fails_the_run(tmp_path, pacing):
    folder = tmp_path / "run"
    options = ["--pacing", pacing, "--duration", {"realtime": "15", "lockstep": "100"}[pacing]]
    with domain_id() as domain, beside(domain, "-c", ROGUE) as rogue:
        run = give(domain, "run", "b2_calm_300", "--bag", str(folder), "--no-report", *options, timeout=180.0)
    assert run.returncode == 1, run.stdout + run.stderr
    named = f"/rogue_controller (process {rogue.pid} on this machine) publishes on /winch/command"
    assert f"cable_sim: strangers: UNKNOWN_PUBLISHER (high): {named}" in run.stderr, (
        "told on the terminal as it happens"
    )
    assert named in run.stderr.strip().splitlines()[-1], "and as the reason of the exit status"
    assert "efficiency" in run.stdout, "the figures of merit come nevertheless"
    columns = Bag(folder / "bag").columns(
        {"/winch/command": ["sequence"], "/winch/state": ["command_sequence", "payout_rate"]}
    )
    assert columns["/winch/command"]["sequence"].max() < 10**9
    assert 0 < columns["/winch/state"]["command_sequence"][-1] < 10**9, "the lawful controller is not locked out"
    assert np.abs(columns["/winch/state"]["payout_rate"]).max() < 1.9, "the rogue asks for 2 m/s"
    assert "cable_sim: strangers" in _errors_in(folder / "bag")


def _errors_in(bag) -> set[str]:
    arrays = [deserialize_message(message.data, DiagnosticArray) for message in Bag(bag).messages(["/diagnostics"])]
    return {part.name for array in arrays for part in array.status if part.level == DiagnosticStatus.ERROR}
