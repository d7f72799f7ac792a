"""How many messages the recorder takes without a drop: publishers in a process of their own, 1 kB messages, real time.

    python benchmarks/recorder_throughput.py [--rate 10000] [--seconds 20] [--topics 10]

Prints what was sent, what is in the bag, and the processor time that the recorder used per message.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PAYLOAD = 980
TOPIC = "/load"


def publish(rate: int, seconds: float, topics: int) -> int:
    """Publish `rate` messages a second over `topics` topics once a subscriber is there; return how many."""
    import rclpy  # noqa: PLC0415 - only the publishing process needs ROS
    from heave_node.environment import prepare_environment  # noqa: PLC0415
    from rclpy.qos import QoSProfile  # noqa: PLC0415
    from rclpy.serialization import serialize_message  # noqa: PLC0415
    from std_msgs.msg import UInt8MultiArray  # noqa: PLC0415

    prepare_environment()
    rclpy.init()
    node = rclpy.create_node("load")
    publishers = [node.create_publisher(UInt8MultiArray, f"{TOPIC}{n}", QoSProfile(depth=5000)) for n in range(topics)]
    # Noise does not compress: the recorder pays its full price for each message.
    messages = [bytes(serialize_message(UInt8MultiArray(data=os.urandom(PAYLOAD)))) for _ in range(1009)]
    deadline = time.monotonic() + 20.0
    while any(publisher.get_subscription_count() == 0 for publisher in publishers):
        if time.monotonic() > deadline:
            sys.exit("no recorder has come")
        time.sleep(0.05)
    time.sleep(1.0)
    began, sent, total = time.monotonic(), 0, round(rate * seconds)
    while sent < total:
        due = min(total, round((time.monotonic() - began) * rate))
        while sent < due:
            publishers[sent % topics].publish(messages[sent % len(messages)])
            sent += 1
        time.sleep(0.001)
    took = time.monotonic() - began
    time.sleep(2.0)
    sys.stdout.write(json.dumps({"sent": sent, "seconds": took}))
    return 0


def measure(rate: int, seconds: float, topics: int) -> dict[str, float]:
    """Record a load; return what became of it."""
    from heave_bags.reader import Bag  # noqa: PLC0415

    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        command = [sys.executable, "-m", "heave_bags.live_recorder", "--ros-args", "-p", f"directory:={bag}"]
        recorder = subprocess.Popen(command, env=environment)
        load = [sys.executable, __file__, "--publish", "--rate", str(rate), "--seconds", str(seconds)]
        done = subprocess.run(
            [*load, "--topics", str(topics)], env=environment, capture_output=True, text=True, check=True
        )
        recorder.send_signal(signal.SIGINT)
        recorder.wait()
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        sent = json.loads(done.stdout)
        recorded = sum(t.message_count for name, t in Bag(bag).topics.items() if name.startswith(TOPIC))
        size = sum(path.stat().st_size for path in bag.glob("*.mcap"))
    return {
        "rate_per_s": sent["sent"] / sent["seconds"],
        "sent": sent["sent"],
        "recorded": recorded,
        "dropped": sent["sent"] - recorded,
        "bag_mb": size / 1e6,
        "cpu_s_of_both_processes": used.ru_utime + used.ru_stime,
    }


def main() -> None:
    """Measure, or publish."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rate", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--topics", type=int, default=10)
    parser.add_argument("--publish", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.publish:
        sys.exit(publish(arguments.rate, arguments.seconds, arguments.topics))
    print(json.dumps(measure(arguments.rate, arguments.seconds, arguments.topics), indent=2))


if __name__ == "__main__":
    main()
