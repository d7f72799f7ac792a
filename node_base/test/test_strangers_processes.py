"""A node that is not part of the run publishes on its topics: it is reported, and its messages are ignored."""

import re
import subprocess
import sys

from loop_processes import PEERS

ROGUE = """
import signal
import time
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from heave_msgs.msg import MruSample, TickJoin, TickPart, TickRoster, TickStatus, WinchCommand
from heave_node.interface import topics
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.qos import qos_of
prepare_environment()
rclpy.init()
node = rclpy.create_node("rogue")
errors = {}
def on_diagnostics(message):
    errors.update({part.name: part.message for part in message.status if part.level == b"\\x02"})
node.create_subscription(DiagnosticArray, "/diagnostics", on_diagnostics, qos_of(topics.DIAGNOSTICS.role))
def publisher(topic, kind):
    return node.create_publisher(kind, topic.name, qos_of(topic.role))
mru, command = publisher(topics.MRU, MruSample), publisher(topics.WINCH_COMMAND, WinchCommand)
join, roster = publisher(topics.TICK_JOIN, TickJoin), publisher(topics.TICK_ROSTER, TickRoster)
lead, ahead = publisher(topics.TICK_LEAD, TickPart), publisher(topics.TICK_AHEAD, TickPart)
status = publisher(topics.TICK_STATUS, TickStatus)
part = publisher(topics.tick_part_topic("wave_vessel"), TickPart)
def hear(period):  # all that has come: one message at a time is slower than they come
    end = time.monotonic() + period
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.001)
number, is_found = 0, False
is_over = []
signal.signal(signal.SIGTERM, lambda *_: is_over.append(True))
while not is_over:
    number += 1
    sample = MruSample(sequence=1000 + number)
    sample.header.stamp.nanosec = number
    mru.publish(sample)
    order = WinchCommand(sequence=10**9 + number, payout=1e6)
    order.header.stamp.nanosec = number
    command.publish(order)
    join.publish(TickJoin(node="wave_vessel", outputs=["/mru"]))
    join.publish(b"\\x00\\x01\\x00\\x00\\xff\\xff\\xff\\xff")
    roster.publish(TickRoster(epoch=7, tick_period=float("nan"), nodes=["nobody"]))
    lead.publish(TickPart(epoch=7, tick=10**6, published=[1]))
    ahead.publish(TickPart(epoch=1, tick=10**6, published=[1]))
    lead.publish(b"\\x00\\x01\\x00\\x00" + bytes([255] * 60))
    status.publish(TickStatus(state=TickStatus.FAILED, topics=["/mru"]))
    part.publish(TickPart(epoch=1, tick=10**6, published=[1] * 99, outputs=[98], sizes=[1], data=[0]))
    hear(0.005)
    count = part.get_subscription_count(), ahead.get_subscription_count(), lead.get_subscription_count()
    if not is_found and all(seen >= wanted for seen, wanted in zip(count, (1, 1, 2))):
        is_found = True
        print("found", flush=True)
hear(1.0)
for name in sorted(errors):
    print(name, "|", errors[name])
"""


def run_with_rogue(loop, **parameters: object) -> tuple[int, str, str, str]:
    """Run the loop beside a node that publishes everywhere; return how the master ended, and what the rogue heard.

    The master comes last, once the rogue and the others have found each other: two seconds of run are short for that.
    """
    rogue = subprocess.Popen([sys.executable, "-c", ROGUE], env=loop.environment, stdout=subprocess.PIPE, text=True)
    try:
        loop.start(*PEERS, **parameters)
        assert rogue.stdout is not None
        assert rogue.stdout.readline() == "found\n"
        loop.start("cable_sim", **parameters)
        status, out, err = loop.end("cable_sim")
    finally:
        rogue.terminate()
        heard, _ = rogue.communicate(timeout=20.0)
    return status, out, err, heard


def test_in_lockstep_a_stranger_shifts_nothing_and_is_named(loop):
    # 30 simulated seconds take one and a half; each node looks at the publishers at its beginning and twice a second
    status, out, err, heard = run_with_rogue(loop, duration=30.0)
    assert status == 0, err
    assert f"ended=True ticks=601 epoch=1 sum={sum(range(1, 601))}" in out
    errors = dict(line.split(" | ", 1) for line in heard.splitlines())
    # a publisher may be known before the name of its node is
    assert re.search(r"(/rogue|without a ROS node name) \(process \d", errors["cable_sim: strangers"])
    assert "on this machine) publishes on /winch/command but is not part of the run" in errors["cable_sim: strangers"]
    assert "on /_tick/join was rejected: it has 1 outputs, 0 matched_subscriptions" in errors["cable_sim: strangers"]
    assert "on /_tick/join was rejected: it cannot be decoded" in errors["cable_sim: strangers"]
    assert "publishes on /mru" in errors["cable_sim: strangers"]
    assert "publishes on /_tick/part/wave_vessel" in errors["winch_controller: strangers"]
    assert "publishes on /_tick/lead" in errors["winch_controller: strangers"]
    assert "publishes on /_tick/ahead" in errors["wave_vessel: strangers"]
    assert "Traceback" not in err
    assert [loop.end(name)[0] for name in ("wave_vessel", "winch_controller", "virtual_winch")] == [0, 0, 0]


def test_in_real_time_a_stranger_moves_nothing(loop):
    status, out, err, heard = run_with_rogue(loop, pacing="realtime", duration=3.0, strict=False)
    assert status == 0, err
    total = float(out.split("sum=")[1].split()[0])
    assert 0.0 < total <= sum(range(1, 61)), "every payout of the stranger is a million"
    assert "publishes on /winch/command" in heard
