"""What a reliable topic loses on its way is sent again, in order, on one machine and over a network."""

import signal
import sys
import time

import pytest

from tests.hosts import Host, stop, two_hosts, why_not

UNABLE = why_not()
pytestmark = pytest.mark.skipif(bool(UNABLE), reason=UNABLE)

WRITER = """
import sys, time
from heave_node.ros.transport.environment import prepare_environment
prepare_environment()
import rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import UInt8MultiArray
topics, count, size = (int(word) for word in sys.argv[1:])
rclpy.init()
node = rclpy.create_node("writer")
publishers = [node.create_publisher(UInt8MultiArray, f"chatter{n}", QoSProfile(depth=200)) for n in range(topics)]
while any(publisher.get_subscription_count() == 0 for publisher in publishers):
    time.sleep(0.02)
time.sleep(1.0)
print("ready", flush=True)
sys.stdin.readline()
for number in range(count):
    for publisher in publishers:
        publisher.publish(UInt8MultiArray(data=number.to_bytes(4, "little") + bytes(size)))
    time.sleep(0.005)
print("written", flush=True)
sys.stdin.readline()
"""

READER = """
import sys, time
from heave_node.ros.transport.environment import prepare_environment
prepare_environment()
import rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import UInt8MultiArray
topics, count = (int(word) for word in sys.argv[1:])
rclpy.init()
node = rclpy.create_node("reader")
got = [[] for _ in range(topics)]
def hear(n):
    return lambda message: got[n].append(int.from_bytes(bytes(message.data[:4]), "little"))
for n in range(topics):
    node.create_subscription(UInt8MultiArray, f"chatter{n}", hear(n), QoSProfile(depth=200))
end = time.monotonic() + 30.0
while time.monotonic() < end and any(len(numbers) < count for numbers in got):
    rclpy.spin_once(node, timeout_sec=0.1)
print([len(numbers) for numbers in got], all(numbers == list(range(count)) for numbers in got), flush=True)
"""


class Stream:
    """A writer and a reader of some topics, each in a process."""

    def __init__(self, writer: Host, reader: Host, *, topics: int, count: int, size: int, **environment: str) -> None:
        self.wanted = f"{[count] * topics} True"
        self.reader = reader.start(sys.executable, "-c", READER, str(topics), str(count), environment=environment)
        program = (sys.executable, "-c", WRITER, str(topics), str(count), str(size))
        self.writer = writer.start(*program, environment=environment)
        assert self.writer.stdout.readline() == "ready\n", self.writer.communicate()[1]

    def begin(self) -> None:
        self.writer.stdin.write("\n")
        self.writer.stdin.flush()

    def wait_until_written(self) -> None:
        assert self.writer.stdout.readline() == "written\n"

    def heard(self) -> str:
        return self.reader.stdout.readline().strip()

    def stop(self) -> None:
        stop(self.writer, self.reader)


@pytest.fixture
def hosts():
    with two_hosts() as pair:
        yield pair


@pytest.mark.parametrize(("topics", "count", "size"), [(12, 180, 600), (1, 150, 10_000)])
def test_a_reader_that_stood_still_gets_all_that_its_writer_keeps(hosts, topics, count, size):
    """Twelve topics of a run, three seconds; and more bytes than Fast DDS by itself lets a process keep."""
    this, _ = hosts
    stream = Stream(this, this, topics=topics, count=count, size=size)
    try:
        stream.reader.send_signal(signal.SIGSTOP)
        time.sleep(0.1)
        stream.begin()
        stream.wait_until_written()
        time.sleep(2.0)
        stream.reader.send_signal(signal.SIGCONT)
        assert stream.heard() == stream.wanted
    finally:
        stream.stop()


def test_what_a_network_swallows_for_half_a_second_is_sent_again(hosts):
    this, other = hosts
    stream = Stream(this, other, topics=3, count=190, size=600, ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET")
    try:
        stream.begin()
        time.sleep(0.2)
        other.plug("down")
        time.sleep(0.5)
        other.plug("up")
        stream.wait_until_written()
        assert stream.heard() == stream.wanted
    finally:
        stream.stop()
