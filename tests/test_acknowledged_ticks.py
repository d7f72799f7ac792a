"""A tick that the recorder has answered for survives the recorder: also where the master had to ask for it again."""

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import rclpy
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag
from heave_msgs.msg import TickDone
from heave_node.interface import topics
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.qos import qos_of

from tests.loop_runs import environment

LOOP = Path(__file__).parents[1] / "node_base" / "test" / "loop_program.py"
PEERS = ("wave_vessel", "winch_controller", "virtual_winch")
LAST_TICK = 37
"""A tick that the recorder does not answer for unasked: it answers for ten at a time."""
TICKS = [tick * 50_000_000 for tick in range(1, LAST_TICK + 1)]
"""Starts of the ticks [ns]: one each 0.05 s."""


@contextmanager
def loop_with(fault: str, tmp_path):
    """Start a recorded loop with a `fault` of the sea in LAST_TICK; yield its ROS domain and the recorder's process."""
    given = (f"participants:=[{', '.join((*PEERS, 'recorder'))}]", "duration:=100.0")
    programs = {name: [str(LOOP), name] for name in (*PEERS, "cable_sim")}
    programs["recorder"] = ["-m", "heave_bags.record.recorder_node"]
    own = {
        "wave_vessel": (f"fault:={fault}", f"fault_tick:={LAST_TICK}"),
        "recorder": (f"directory:={tmp_path / 'bag'}",),
    }
    with domain_id() as domain:
        started = {
            name: subprocess.Popen(
                [sys.executable, *program, "--ros-args"]
                + [part for text in (*given, *own.get(name, ())) for part in ("-p", text)],
                env=environment(domain),
                stderr=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
            )
            for name, program in programs.items()
        }
        try:
            yield domain, started["recorder"]
        finally:
            for process in started.values():
                process.kill()
                process.wait()


def stamps(bag: Path, topic: str) -> list[int]:
    return [message.log_time for message in Bag(bag).messages([topic])]


def test_a_tick_that_was_answered_when_asked_again_survives_the_recorder(tmp_path):
    with loop_with("hang", tmp_path) as (domain, recorder):
        wait_for_answer(domain, LAST_TICK)
        os.kill(recorder.pid, signal.SIGKILL)
        recorder.wait()
    assert stamps(tmp_path / "bag", "/clock") == TICKS, "one each 0.05 s, up to the one answered"


def test_a_bag_of_a_run_that_a_node_has_ended_holds_all_up_to_then(tmp_path):
    """Also what the clock master has not passed on to the recorder by then: it does so every five ticks."""
    with loop_with("raise", tmp_path) as (_, recorder):
        recorder.wait(120.0)
    bag = tmp_path / "bag"
    assert stamps(bag, "/clock") == TICKS
    assert stamps(bag, "/mru") == stamps(bag, "/winch/state") == TICKS[:-1]


def wait_for_answer(domain: int, tick: int) -> None:
    prepare_environment()
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    node = rclpy.create_node("witness", context=context)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(node)
    answered: list[int] = []
    topic = topics.tick_done_topic("recorder")
    node.create_subscription(TickDone, topic.name, lambda message: answered.append(message.tick), qos_of(topic.role))
    deadline = time.monotonic() + 60.0
    while tick not in answered:
        assert time.monotonic() < deadline, f"the recorder has answered for {answered}"
        executor.spin_once(timeout_sec=0.05)
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)
