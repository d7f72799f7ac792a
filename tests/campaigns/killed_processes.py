"""Processes of runs killed at random moments: every bag opens at once, and nothing acknowledged is missing.

    python -m tests.campaigns.killed_processes --count 100

Each node in turn, in lockstep and in real time. An observer hears which tick the recorder has answered. The bag must
open with the project's reader, `rosbags` and `mcap`. In lockstep it must hold every message of every tick up to that
one; in real time, where nodes may miss ticks and a thread writes, every message that the observer itself had received
half a second before the kill. Prints a table and ends with status 1 where something is wrong.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas
import rclpy
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag
from heave_bringup.progress import ProgressLine
from heave_msgs.msg import TickDone
from heave_node.interface import topics
from heave_node.interface.messages import message_type
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.qos import qos_of
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from tests.campaigns.in_process import commit_line
from tests.loop_runs import command, environment, process_of

NODES = ("recorder", "cable_sim", "wave_vessel", "virtual_winch", "winch_controller")
PACINGS = ("lockstep", "realtime")
TICK = 50_000_000
OF_MASTER = ("/clock", "/cable/state", "/unit/odometry", "/unit_uncompensated")
OF_OTHERS = ("/boom_tip", "/mru", "/winch/command", "/winch/state", "/controller/state")
BEHIND = 0.5
"""Wall time by which the disk may be behind in real time, where a thread writes [s]."""
STAMP = slice(4, 12)
"""Bytes of the stamp in a serialised message that begins with a header, or with a time."""
LONGEST_START = 120.0
LONGEST_DELAY = 8.0
"""Wall time from the first tick to the kill at most [s]."""


@dataclass(frozen=True)
class Kill:
    """One run and its end: what was killed after how many ticks, how many the bag holds, and what is wrong."""

    node: str
    pacing: str
    answered: int
    held: int
    by_others: int
    wrong: str


class Witness:
    """Receives for which tick the recorder of a run has answered, and when each message of the loop came."""

    def __init__(self, domain: int) -> None:
        prepare_environment()
        self._context = rclpy.Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._node = rclpy.create_node("witness", context=self._context)
        self._executor = rclpy.executors.SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self.tick = 0
        topic = topics.tick_done_topic("recorder")
        self._node.create_subscription(TickDone, topic.name, self._hear, qos_of(topic.role))
        self.received: dict[str, list[tuple[float, bytes]]] = {name: [] for name in (*OF_MASTER, *OF_OTHERS)}
        for name in self.received:
            self._receive_from(name)

    def _receive_from(self, name: str) -> None:
        topic = topics.TOPIC_BY_NAME[name.removeprefix("/")]

        def note(data: bytes) -> None:
            self.received[name].append((time.monotonic(), data[STAMP]))

        self._node.create_subscription(message_type(topic.type), name, note, qos_of(topic.role), raw=True)

    def _hear(self, message: TickDone) -> None:
        self.tick = max(self.tick, message.tick)

    def listen(self, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
        """Listen for some wall time, or until something is so."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline and not until():
            self._executor.spin_once(timeout_sec=0.01)

    def close(self) -> None:
        """Leave ROS."""
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


def kill_one(number: int, folder: Path) -> Kill:
    """Start a run, kill one of its processes, and judge the bag that is left."""
    chance = random.Random(number)
    node, pacing = NODES[number % len(NODES)], PACINGS[number // len(NODES) % len(PACINGS)]
    arguments = ("run", "b2_calm_300", "--duration", "100000", "--pacing", pacing, "--bag", str(folder), "--no-report")
    with domain_id() as domain:
        witness = Witness(domain)
        run = subprocess.Popen(
            command(*arguments), env=environment(domain), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            witness.listen(LONGEST_START, lambda: witness.tick > 0 or run.poll() is not None)
            witness.listen(chance.uniform(0.0, LONGEST_DELAY))
            os.kill(process_of(node, folder), signal.SIGKILL)
            answered = witness.tick
            safe = time.monotonic() - BEHIND
            received = {
                name: {stamp for arrival, stamp in came if arrival < safe} for name, came in witness.received.items()
            }
            run.wait(90.0)
        finally:
            if run.poll() is None:
                run.send_signal(signal.SIGINT)  # it ends its nodes in order
                run.wait(60.0)
            witness.close()
    return _judge(node, pacing, answered, received, folder / "bag")


def _judge(node: str, pacing: str, answered: int, received: Mapping[str, set[bytes]], folder: Path) -> Kill:
    bag = Bag(folder)
    ticks: dict[str, list[int]] = {name: [] for name in (*OF_MASTER, *OF_OTHERS)}
    stamps: dict[str, set[bytes]] = {name: set() for name in ticks}
    count = 0
    for message in bag.messages():
        count += 1
        if message.topic in ticks:
            ticks[message.topic].append(message.log_time // TICK)
            stamps[message.topic].add(bytes(message.data[STAMP]))
    if pacing == "lockstep":
        wrong = _unacknowledged(ticks, answered)
    else:
        lost = {name: len(came - stamps[name]) for name, came in received.items()}
        wrong = [f"{name} lacks {count} of {len(received[name])} messages" for name, count in lost.items() if count]
    wrong += [str(loss) for loss in bag.losses if loss.messages != 0]
    by_rosbags, by_mcap = _read_by_others(folder, bag.files, wrong)
    if by_rosbags != by_mcap:
        wrong.append(f"rosbags reads {by_rosbags}, mcap {by_mcap}")
    if node != "recorder" and by_mcap != count:
        wrong.append(f"the bag was closed, but others read {by_mcap} of {count}")
    held = min(len(found) for found in ticks.values())
    return Kill(node, pacing, answered, held, by_mcap, "; ".join(wrong))


def _unacknowledged(ticks: Mapping[str, list[int]], answered: int) -> list[str]:
    """Return the topics that lack messages which the recorder has answered for, in lockstep.

    What comes behind is what a run that broke off had not completed.
    """
    wanted = {**dict.fromkeys(OF_MASTER, answered), **dict.fromkeys(OF_OTHERS, answered - 1)}
    return [
        f"{name} lacks some of the {count} ticks"
        for name, count in wanted.items()
        if ticks[name][:count] != list(range(1, count + 1))
    ]


def _read_by_others(folder: Path, files: Sequence[Path], wrong: list[str]) -> tuple[int, int]:
    by_rosbags = by_mcap = 0
    try:
        with AnyReader([folder]) as reader:
            by_rosbags = sum(1 for _ in reader.messages())
        for path in files:
            with path.open("rb") as stream:
                by_mcap += sum(1 for _ in make_reader(stream).iter_messages(log_time_order=False))
    except Exception as error:  # whatever it is, it must be reported
        wrong.append(f"{type(error).__name__}: {error}")
    return by_rosbags, by_mcap


def table(kills: Sequence[Kill]) -> str:
    """Return what became of the runs as a table."""
    runs = pandas.DataFrame(kills)
    runs = runs.assign(beyond=runs["held"] - runs["answered"], is_wrong=runs["wrong"] != "")
    figures = {"answered": ["count", "min", "max"], "beyond": "min", "is_wrong": "sum"}
    lines = [f"{kill.node}, {kill.pacing}: {kill.wrong}" for kill in kills if kill.wrong]
    return "\n".join([runs.groupby(["node", "pacing"]).agg(figures).to_string(), *lines])


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(prog="killed_processes", description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="runs (default 100)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default 0)")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # no run is left behind
    progress = ProgressLine()
    kills = []
    for number in range(options.first, options.first + options.count):
        with tempfile.TemporaryDirectory() as folder:
            kills.append(kill_one(number, Path(folder) / "run"))
        progress.show(f"{len(kills)} of {options.count} runs, {sum(1 for kill in kills if kill.wrong)} wrong")
    progress.close()
    sys.stdout.write(f"{commit_line()}\n{table(kills)}\n")
    return 1 if any(kill.wrong for kill in kills) else 0


if __name__ == "__main__":
    sys.exit(main())
