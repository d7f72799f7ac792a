"""How many messages the recorder takes without a drop: a publishing process of its own, 1 kB messages, real time."""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import rclpy
from heave_bags.mcap.reader import Bag
from heave_node.ros.transport import parents_death
from heave_node.ros.transport.environment import prepare_environment
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from std_msgs.msg import UInt8MultiArray

RATE = 10_000
PAYLOAD = 980
TOPICS = 10
TOPIC = "/load"
PATIENCE = 20.0
"""Wall time in which the recorder must have subscribed [s]."""


def measure_recorder(seconds: float, say: Callable[[str], None]) -> dict[str, float]:
    """Record 10,000 messages of 1 kB a second; return rate, sent, recorded, dropped and processor time.

    Parameters
    ----------
    seconds : wall time of the load
    say : called with what is being measured
    """
    say(f"recorder: {RATE} messages of 1 kB a second for {seconds:g} s")
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", **parents_death.environment()}
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        command = parents_death.command("heave_bags.record.live_recorder", "--ros-args", "-p", f"directory:={bag}")
        recorder = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            load = [sys.executable, "-m", __name__, "--seconds", str(seconds)]
            done = subprocess.run(load, env=environment, capture_output=True, text=True, check=True)
            times = psutil.Process(recorder.pid).cpu_times()
        finally:
            recorder.send_signal(signal.SIGINT)
            recorder.wait()
        sent = json.loads(done.stdout)
        recorded = sum(topic.message_count for name, topic in Bag(bag).topics.items() if name.startswith(TOPIC))
    return {
        "messages_per_s": sent["sent"] / sent["seconds"],
        "sent": sent["sent"],
        "recorded": recorded,
        "dropped": sent["sent"] - recorded,
        "cpu_us_per_message": 1e6 * (times.user + times.system) / max(recorded, 1),
    }


def publish(seconds: float) -> dict[str, float]:
    """Publish the load for `seconds` once every topic has a subscriber.

    Returns how many messages went out, and in what time.
    """
    prepare_environment()
    rclpy.init()
    node = rclpy.create_node("load")
    publishers = [node.create_publisher(UInt8MultiArray, f"{TOPIC}{n}", QoSProfile(depth=5000)) for n in range(TOPICS)]
    # Noise does not compress: the recorder pays its full price for each message.
    messages = [bytes(serialize_message(UInt8MultiArray(data=os.urandom(PAYLOAD)))) for _ in range(1009)]
    deadline = time.monotonic() + PATIENCE
    while any(publisher.get_subscription_count() == 0 for publisher in publishers):
        if time.monotonic() > deadline:
            sys.exit("no recorder has joined")
        time.sleep(0.05)
    time.sleep(1.0)
    began, sent, total = time.monotonic(), 0, round(RATE * seconds)
    while sent < total:
        due = min(total, round((time.monotonic() - began) * RATE))
        while sent < due:
            publishers[sent % TOPICS].publish(messages[sent % len(messages)])
            sent += 1
        time.sleep(0.001)
    took = time.monotonic() - began
    time.sleep(2.0)
    return {"sent": sent, "seconds": took}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Publish the load of the recorder benchmark.")
    parser.add_argument("--seconds", type=float, required=True)
    sys.stdout.write(json.dumps(publish(parser.parse_args().seconds)))
