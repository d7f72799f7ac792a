"""The tick protocol with real processes over real DDS: the good case, and every way in which a participant can fail
it."""

import signal
import subprocess
import sys
import time

import pytest
from loop_processes import PEERS, SUM_OF_40_TICKS, Loop, start_all


def test_every_node_has_exactly_the_messages_of_its_tick(loop):
    start_all(loop)
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    assert f"ended=True ticks=41 epoch=1 sum={SUM_OF_40_TICKS}" in out
    assert [loop.end(name)[0] for name in PEERS] == [0, 0, 0]


def test_what_hangs_after_the_work_is_done_does_not_hold_up_the_end_of_a_process(loop):
    start_all(loop, "virtual_winch", fault="hang_at_exit")
    assert loop.end("cable_sim")[0] == 0
    status, out, _ = loop.end("virtual_winch", timeout=15.0)
    assert (status, out) == (0, "oldest=0.000\n")


def test_a_missing_participant_is_named_and_ends_the_start(loop):
    loop.start("cable_sim", "wave_vessel", "virtual_winch", start_timeout=2.0)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    assert "winch_controller (not seen)" in err.splitlines()[-1]
    assert "waiting for 1 s" in err, "a missing participant is named each second"


def test_a_participant_that_dies_is_named_and_ends_the_run(loop):
    start_all(loop, "winch_controller", fault="die", participant_timeout=2.0)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    last = err.splitlines()[-1]
    assert "winch_controller has not finished tick 20" in last
    assert loop.end("wave_vessel")[0] == 0, "the others hear that the run is over"


def test_a_participant_that_raises_says_why_in_one_line(loop):
    start_all(loop, "virtual_winch", fault="raise", participant_timeout=2.0)
    status, _, err = loop.end("virtual_winch")
    assert status == 1
    assert err.splitlines()[-1] == "virtual_winch: the solver gave up at t = 1.000 s"


def test_participants_leave_when_the_master_dies(loop):
    start_all(loop, "cable_sim", fault="die", participant_timeout=2.0)
    for name in PEERS:
        status, _, err = loop.end(name)
        assert status == 1
        assert "no message from the clock master cable_sim for" in err


def test_a_participant_without_a_master_says_that_there_is_none(loop):
    loop.start("wave_vessel", start_timeout=1.0)
    status, _, err = loop.end("wave_vessel")
    assert status == 1
    assert err.splitlines()[-1].endswith("s: there is none in this ROS domain")


def test_messages_that_come_late_twice_or_not_at_all_change_nothing(loop):
    faults = {"winch_controller:fault": "late", "wave_vessel:fault": "duplicate", "virtual_winch:fault": "lose"}
    start_all(loop, **faults, **{"virtual_winch:fault_tick": 30})
    status, out, err = loop.end("cable_sim")
    assert status == 0
    assert f"sum={SUM_OF_40_TICKS}" in out
    assert "resends=0" not in out
    late = err.index("PARTICIPANT_LATE (high): waiting for 1 s: winch_controller has not finished tick 20")
    assert err.index("all nodes answer again", late) > late, "an alarm that stayed would hide the next one"


def test_whoever_hears_a_topic_by_itself_hears_a_tick_that_is_sent_again_once(loop):
    fault = {"virtual_winch:fault": "late", "virtual_winch:fault_tick": 30}
    heard = [int(word) for word in ask(loop, HEAR_TO_THE_END, **fault).split()]
    assert "resends=0" not in loop.end("cable_sim")[1]
    assert heard == list(range(heard[0], 41))


def test_a_message_lost_for_ever_is_named_with_its_publisher(loop):
    start_all(loop, "wave_vessel", fault="lose_for_ever", participant_timeout=2.0)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    assert "winch_controller has not finished tick 20 (waiting for /mru from wave_vessel (19 of 20 messages)" in err


def test_a_wrong_stamp_is_refused(loop):
    faults = {"wave_vessel:fault": "future_stamp", "virtual_winch:fault": "old_stamp", "virtual_winch:fault_tick": 30}
    start_all(loop, strict=False, **faults)
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    assert f"sum={SUM_OF_40_TICKS - 20 - 1 - 30}" in out, "the controller saw no sample of tick 20, and said so by -1"


def test_different_tick_periods_are_refused(loop):
    loop.start("wave_vessel", tick_period=0.1, participant_timeout=2.0)
    loop.start("winch_controller", "virtual_winch", "cable_sim", participant_timeout=2.0)
    status, _, err = loop.end("wave_vessel")
    assert status == 1
    assert "tick_period is 0.1 s here, but 0.05 s at the clock master" in err


def test_real_time_follows_the_wall_clock(loop):
    start_all(loop, pacing="realtime", strict=False)
    began = time.monotonic()
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    assert "ended=True ticks=41 " in out
    assert "collector=False" in out, "garbage is collected between ticks, not by Python whenever it likes"
    assert time.monotonic() - began > 2.0, "forty ticks of 0.05 s cannot be faster than the wall clock"


def test_real_time_does_not_wait_for_a_late_participant(loop):
    start_all(loop, "winch_controller", fault="late", pacing="realtime", strict=False)
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    missed = int(out.split("missed=")[1].split()[0])
    assert missed >= 10, "0.8 s late at 20 Hz"


def test_real_time_misses_no_deadline_for_a_recorder_that_is_behind(loop):
    names = f"[{', '.join(PEERS)}, recorder]"
    loop.start("recorder", fault="doze", pacing="realtime", duration=4.0, strict=False, participants=names)
    loop.start(*PEERS, "cable_sim", pacing="realtime", duration=4.0, strict=False, participants=names)
    status, out, err = loop.end("cable_sim")
    assert status == 0, err
    assert int(out.split("missed=")[1].split()[0]) < 10, "2 s behind are 20 ticks more than it may be"


def test_a_participant_that_was_stopped_finds_the_readings_of_each_tick_that_it_makes_up_for(loop):
    start_all(loop, "winch_controller", fault="stop", pacing="realtime", duration=4.0, strict=False)
    status, out, err = loop.end("cable_sim")
    assert status == 0, err
    assert int(out.split("missed=")[1].split()[0]) >= 10, "0.8 s stopped at 20 Hz"
    _, out, _ = loop.end("winch_controller")
    assert int(out.split("without_load=")[1]) <= 6, "of 80 ticks, with all but a few of the 16 it was stopped for"


@pytest.mark.parametrize("pacing", ["lockstep", "realtime"])
def test_pause_step_reset_by_service(loop, pacing):
    words = ask(loop, PAUSE_STEP_RESET, duration=1e4, pacing=pacing, strict=pacing == "lockstep").split()
    paused, still_paused, stepped, resumed, epoch, after_reset = (int(word) for word in words)
    assert still_paused == paused, "time stands still"
    assert stepped == paused + 5
    assert resumed > stepped
    assert epoch == 2
    assert after_reset > 0
    loop.processes["cable_sim"].send_signal(signal.SIGINT)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    assert "ended by SIGINT" in err
    assert loop.end("virtual_winch")[0] == 0, "the others hear that the run is over"


def test_a_run_in_real_time_that_was_paused_and_reset_runs_to_its_end(loop):
    ask(loop, PAUSE_AND_RESET, duration=4.0, pacing="realtime", strict=False)
    status, out, err = loop.end("cable_sim")
    assert status == 0, err
    assert "ended=True ticks=81 epoch=2" in out


@pytest.mark.parametrize("pacing", ["lockstep", "realtime"])
def test_an_inactive_node_publishes_nothing_while_the_others_go_on(loop, pacing):
    words = ask(loop, DEACTIVATE_AND_ACTIVATE, duration=1e4, pacing=pacing, strict=False).split()
    before, while_inactive, after = map(int, words)
    assert before > 0
    assert while_inactive == 0
    assert after > 0


def test_an_inactive_clock_master_pauses_the_run(loop):
    paused, still_paused, refused, again = ask(loop, DEACTIVATE_THE_CLOCK, duration=1e4).split()
    assert still_paused == paused
    assert refused == "refused"
    assert int(again) > int(paused)


def ask(loop: Loop, script: str, **parameters: object) -> str:
    """Start the loop, and return what a client prints that talks to it and was there before it was busy."""
    client = subprocess.Popen(
        [sys.executable, "-c", CLIENT + script],
        env=loop.environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    start_all(loop, **parameters)
    out, err = client.communicate(timeout=60.0)
    assert client.returncode == 0, err
    return out


CLIENT = """
import time
import rclpy
from heave_msgs.msg import TickStatus, WinchCommand
from heave_msgs.srv import StepSimulation
from heave_node.interface import topics
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.qos import qos_of
from heave_node.ros.spin import Spinner
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from std_srvs.srv import SetBool, Trigger
prepare_environment()
rclpy.init()
node = rclpy.create_node("client")
seen, commands = [], []
node.create_subscription(TickStatus, topics.TICK_STATUS.name, seen.append, qos_of(topics.TICK_STATUS.role))
node.create_subscription(WinchCommand, topics.WINCH_COMMAND.name, commands.append, qos_of(topics.WINCH_COMMAND.role))
spinner = Spinner(node)
listen = spinner.spin_for
def until(condition):
    end = time.monotonic() + 40
    while not (seen and condition(seen[-1])):
        listen(0.05)
        assert time.monotonic() < end, seen[-1:]
    return seen[-1]
def call(kind, name, request):
    client = node.create_client(kind, name)
    assert client.wait_for_service(10.0)
    future = client.call_async(request)
    spinner.spin_for(10.0, until=future)
    return future.result().success
def change_state(name, transition):
    assert call(ChangeState, f"{name}/change_state", ChangeState.Request(transition=Transition(id=transition)))
def go_on():
    tick = seen[-1].tick
    until(lambda s: s.tick > tick + 20)
until(lambda s: s.state == TickStatus.RUNNING and s.tick > 20)
"""

PAUSE_STEP_RESET = """
assert call(SetBool, "simulation/pause", SetBool.Request(data=True))
paused = until(lambda s: s.state == TickStatus.PAUSED).tick
listen(0.6)
still = seen[-1].tick
assert call(StepSimulation, "simulation/step", StepSimulation.Request(ticks=5))
stepped = until(lambda s: s.state == TickStatus.PAUSED and s.tick > paused).tick
assert call(SetBool, "simulation/pause", SetBool.Request(data=False))
resumed = until(lambda s: s.tick > stepped + 5).tick
assert call(Trigger, "simulation/reset", Trigger.Request())
again = until(lambda s: s.epoch == 2 and s.tick > 1)
print(paused, still, stepped, resumed, again.epoch, again.tick)
"""

HEAR_TO_THE_END = """
until(lambda s: s.state == TickStatus.ENDED)
listen(0.5)
print(*(command.sequence for command in commands))
"""

PAUSE_AND_RESET = """
assert call(SetBool, "simulation/pause", SetBool.Request(data=True))
until(lambda s: s.state == TickStatus.PAUSED)
assert call(Trigger, "simulation/reset", Trigger.Request())
"""

DEACTIVATE_AND_ACTIVATE = """
go_on()  # until the subscription of this listener is matched, and commands come
before = len(commands)
change_state("winch_controller", Transition.TRANSITION_DEACTIVATE)
listen(0.3)  # what was still on its way
commands.clear()
go_on()
while_inactive = len(commands)
change_state("winch_controller", Transition.TRANSITION_ACTIVATE)
go_on()
print(before, while_inactive, len(commands))
"""

DEACTIVATE_THE_CLOCK = """
change_state("cable_sim", Transition.TRANSITION_DEACTIVATE)
paused = until(lambda s: s.state == TickStatus.PAUSED).tick
listen(0.6)
still = seen[-1].tick
refused = call(SetBool, "simulation/pause", SetBool.Request(data=False))
change_state("cable_sim", Transition.TRANSITION_ACTIVATE)
go_on()
print(paused, still, "obeyed" if refused else "refused", seen[-1].tick)
"""


def test_a_node_that_comes_into_a_run_under_way_says_so(loop):
    ask(loop, "", duration=1e5)  # it runs
    late = Loop(int(loop.environment["ROS_DOMAIN_ID"]))
    late.start("virtual_winch", duration=1e5)
    try:
        status, _, err = late.end("virtual_winch")
    finally:
        late.stop()
    assert status == 1
    assert "started too late: a run is already at tick" in err
