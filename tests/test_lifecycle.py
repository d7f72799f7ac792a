"""A node of the running loop that is made inactive and active again, by its lifecycle service."""

import subprocess
import sys

import numpy as np
import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag

from tests.loop_runs import environment, under_way

DEACTIVATE_AND_ACTIVATE = """
import time
import rclpy
from heave_msgs.msg import TickStatus
from heave_msgs.srv import SetMode
from heave_node.interface import topics
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.qos import qos_of
from heave_node.ros.spin import Spinner
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
prepare_environment()
rclpy.init()
node = rclpy.create_node("operator")
seen = []
node.create_subscription(TickStatus, topics.TICK_STATUS.name, seen.append, qos_of(topics.TICK_STATUS.role))
spinner = Spinner(node)
def until(time_of_run):
    end = time.monotonic() + 100
    while not (seen and seen[-1].simulated_time > time_of_run):
        spinner.spin_for(0.05)
        assert time.monotonic() < end, seen[-1:]
def call(kind, name, request):
    client = node.create_client(kind, name)
    assert client.wait_for_service(20.0)
    future = client.call_async(request)
    spinner.spin_for(20.0, until=future)
    return future.result()
def change_state(transition):
    request = ChangeState.Request(transition=Transition(id=transition))
    assert call(ChangeState, "winch_controller/change_state", request).success
until(40.0)
change_state(Transition.TRANSITION_DEACTIVATE)
print(call(SetMode, "controller/set_mode", SetMode.Request(mode="compensating")).message)
until(seen[-1].simulated_time + 10.0)
change_state(Transition.TRANSITION_ACTIVATE)
"""


@pytest.mark.slow
@pytest.mark.long
def test_an_inactive_controller_gives_no_command_and_begins_again_from_standby(tmp_path):
    folder = tmp_path / "run"
    options = ["--duration", "130", "--no-report", "--set", "wave_vessel.ramp=5.0"]
    with domain_id() as domain, under_way(domain, "run", "b2_calm_300", "--bag", str(folder), *options) as run:
        operator = subprocess.run(
            [sys.executable, "-c", DEACTIVATE_AND_ACTIVATE],
            env=environment(domain),
            capture_output=True,
            text=True,
            timeout=150.0,
            check=False,
        )
        assert operator.returncode == 0, operator.stderr
        _, err = run.communicate(timeout=120.0)
    assert operator.stdout.strip() == "the controller is inactive: activate it first"
    assert "virtual_winch: drive: WINCH_COMMAND_TIMEOUT (high)" in err
    bag = Bag(folder / "bag")
    names = ["payout_rate", "payout_acceleration", "fault", "brake"]
    columns = bag.columns(
        {"/winch/command": ["sequence"], "/controller/state": ["mode"], "/winch/state": names, "/mru": ["sequence"]}
    )
    time = {topic: columns[topic]["time"] for topic in columns}
    gap = np.argmax(np.diff(time["/winch/command"]))
    begin, end = time["/winch/command"][gap : gap + 2]
    assert end - begin > 9.0, "it is inactive for ten seconds of the run"
    assert np.diff(time["/mru"]).max() < 1.0, "the sea goes on"
    winch, at = columns["/winch/state"], time["/winch/state"]
    stands = (at > begin + 3.0) & (at < end)
    assert winch["brake"][stands].all()
    assert (winch["fault"][stands] == 1).all(), "FAULT_COMMAND_TIMEOUT"
    assert (winch["payout_rate"][stands] == 0.0).all()
    assert np.abs(winch["payout_acceleration"]).max() <= 1.5 * (1.0 + 1e-9), "the scenario's acceleration limit"
    modes = columns["/controller/state"]["mode"]
    after = modes[time["/controller/state"] >= end - 1e-9]
    assert after[0] == "standby"
    assert after[-1] == "compensating", "it starts as at the beginning of the run"
    assert winch["fault"][-1] == 0, "the new controller has released the winch"
