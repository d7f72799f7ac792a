"""Nodes under a lifecycle manager: configured, activated, left and ended by their services, as Nav2's manager does."""

import subprocess
import sys

import pytest
from loop_processes import PEERS, SUM_OF_40_TICKS, Loop, start_all

MANAGER = """
import sys
import time
import rclpy
from heave_msgs.msg import TickStatus
from heave_node.interface import topics
from heave_node.ros.transport.qos import qos_of
from heave_node.ros.spin import Spinner
from heave_node.ros.transport.environment import prepare_environment
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
prepare_environment()
rclpy.init()
node = rclpy.create_node("lifecycle_manager")
spinner = Spinner(node)
clients = {}
def call(kind, name, request):
    client = clients[name] = clients.get(name) or node.create_client(kind, name)
    assert client.wait_for_service(20.0), name
    future = client.call_async(request)
    spinner.spin_for(20.0, until=future)
    return future.result()
def state_of(name):
    for _ in range(3):  # DDS may lose an answer to a client that the server has not discovered yet
        answer = call(GetState, f"{name}/get_state", GetState.Request())
        if answer is not None:
            return answer.current_state.id
def bring(names, transition, expected):
    for name in names:
        state_of(name)
        answer = call(ChangeState, f"{name}/change_state", ChangeState.Request(transition=Transition(id=transition)))
        assert answer is None or answer.success, (name, transition)
        if expected is not None:
            assert state_of(name) == expected, name
def startup(names):
    bring(names, Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE)
    bring(names, Transition.TRANSITION_ACTIVATE, State.PRIMARY_STATE_ACTIVE)
def reset(names):
    bring(names[::-1], Transition.TRANSITION_DEACTIVATE, State.PRIMARY_STATE_INACTIVE)
    bring(names[::-1], Transition.TRANSITION_CLEANUP, State.PRIMARY_STATE_UNCONFIGURED)
def shutdown(names):
    reset(names)
    bring(names[::-1], Transition.TRANSITION_UNCONFIGURED_SHUTDOWN, None)
def until_it_runs():
    seen = []
    node.create_subscription(TickStatus, topics.TICK_STATUS.name, seen.append, qos_of(topics.TICK_STATUS.role))
    while not (seen and seen[-1].tick > 20):
        spinner.spin_for(0.05)
names = sys.argv[1].split(",")
"""


def manage(loop: Loop, script: str, *names: str) -> None:
    """Run a `script` of the manager over the nodes of these `names`."""
    done = subprocess.run(
        [sys.executable, "-c", MANAGER + script, ",".join(names)],
        env=loop.environment,
        capture_output=True,
        text=True,
        timeout=100.0,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("pacing", ["lockstep", "realtime"])
def test_a_manager_starts_the_run_and_it_runs_to_its_end(loop, pacing):
    start_all(loop, autostart=False, pacing=pacing, strict=pacing == "lockstep")
    manage(loop, "time.sleep(0.5)\nstartup(names)", *PEERS, "cable_sim")
    status, out, err = loop.end("cable_sim")
    assert status == 0, err
    assert "ended=True ticks=41 epoch=1" in out
    assert pacing == "realtime" or f"sum={SUM_OF_40_TICKS}" in out
    assert [loop.end(name)[0] for name in PEERS] == [0, 0, 0]


def test_all_nodes_of_one_process_are_managed_too(loop):
    loop.start("composed", autostart=False)
    manage(loop, "startup(names)", *PEERS, "cable_sim")
    status, out, err = loop.end("composed")
    assert status == 0, err
    assert f"sum={SUM_OF_40_TICKS}" in out


def test_a_node_that_was_cleaned_up_is_configured_anew_and_the_run_is_complete(loop):
    start_all(loop, autostart=False)
    manage(loop, "startup(names[:-1]); reset(names[:-1]); startup(names)", *PEERS, "cable_sim")
    status, out, err = loop.end("cable_sim")
    assert status == 0, err
    assert f"sum={SUM_OF_40_TICKS}" in out


def test_a_manager_ends_nodes_that_it_has_not_configured_or_cleaned_up(loop):
    start_all(loop, autostart=False)
    manage(loop, "startup(names[:2]); shutdown(names[:2])", *PEERS, "cable_sim")
    manage(loop, "bring(names, Transition.TRANSITION_UNCONFIGURED_SHUTDOWN, None)", "virtual_winch", "cable_sim")
    assert {name: loop.end(name)[0] for name in (*PEERS, "cable_sim")} == dict.fromkeys((*PEERS, "cable_sim"), 0)


def test_a_wait_for_the_manager_is_no_wait_for_the_clock_master(loop):
    """Twice the start timeout passes before the activation, and none of it counts."""
    start_all(loop, autostart=False, start_timeout=5.0)
    manage(loop, "bring(names, 1, 2); time.sleep(10.0); bring(names, 3, 3)", *PEERS, "cable_sim")
    assert loop.end("cable_sim")[0] == 0


def test_a_node_that_is_cleaned_up_in_a_run_ends_it_with_the_reason(loop):
    start_all(loop, duration=1e4, participant_timeout=30.0, strict=False)
    manage(loop, "until_it_runs(); reset(names)", "virtual_winch")
    status, _, err = loop.end("cable_sim", timeout=10.0)
    assert status == 1
    assert "cable_sim: virtual_winch: it was cleaned up at t = " in err.splitlines()[-1]
    assert loop.processes["virtual_winch"].poll() is None, "it waits, unconfigured, for its manager"
