"""The order of a lockstep bag depends on the run alone."""

import random
import struct

from heave_bags.record.recording import TickOrder
from hypothesis import given
from hypothesis import strategies as st

PERIOD = 50_000_000
PUBLISHERS = {
    "/clock": ["master"],
    "/state": ["master"],
    "/mru": ["sea"],
    "/command": ["controller"],
    "/diagnostics": ["master", "sea", "controller"],
}
MASTERS = ("/clock", "/state")
TICKS = 12


def message(topic: str, node: str, tick: int) -> bytes:
    stamp = tick * PERIOD
    return b"\x00\x01\x00\x00" + struct.pack("<iI", stamp // 10**9, stamp % 10**9) + f"{topic} {node} {tick}".encode()


def published(tick: int) -> list[tuple[str, str]]:
    """Return what is published in a tick: (topic, node). Diagnostics come every fourth tick."""
    return [(t, n) for t, nodes in PUBLISHERS.items() for n in nodes if t != "/diagnostics" or tick % 4 == 1]


class Written(list):
    def write(self, topic: str, log_time: int, data: bytes) -> None:
        self.append((log_time, topic, data))


def record(chance: random.Random) -> Written:
    """Let a recorder step through a run whose messages arrive in an order of chance within what the protocol allows."""
    order, written = TickOrder(PUBLISHERS, "master"), Written()
    for tick in range(1, TICKS + 2):
        arrived: dict[str, list[bytes]] = {topic: [] for topic in PUBLISHERS}
        due = [(t, n, tick) for t, n in published(tick) if n == "master" and tick <= TICKS]
        due += [(t, n, tick - 1) for t, n in published(tick - 1) if n != "master" and tick > 1]
        chance.shuffle(due)
        for topic, node, of in due:
            arrived[topic].append(message(topic, node, of))
        order.write(written.write, arrived.__getitem__, tick_start=tick * PERIOD, tick_before=max(tick - 1, 1) * PERIOD)
    order.write_rest(written.write, lambda _: [], tick_start=(TICKS + 1) * PERIOD)
    return written


@given(st.integers(0, 2**32))
def test_two_runs_are_recorded_alike_whatever_the_order_of_arrival(seed):
    assert record(random.Random(seed)) == record(random.Random(seed + 1))


def test_every_message_is_recorded_once_and_log_times_never_go_back():
    written = record(random.Random(3))
    assert sorted(data for _, _, data in written) == sorted(
        message(t, n, tick) for tick in range(1, TICKS + 1) for t, n in published(tick)
    )
    assert [time for time, _, _ in written] == sorted(time for time, _, _ in written)


def test_a_message_is_logged_at_the_start_of_the_tick_that_published_it():
    for log_time, _, data in record(random.Random(5)):
        assert log_time == int(data.split()[-1]) * PERIOD


def record_laggard(chance: random.Random, latest: int) -> Written:
    """Let messages of a node that may lag come up to `latest` ticks late, and be stamped with the end of that."""
    publishers = {"/clock": ["master"], "/beliefs": ["adviser"]}
    order, written = TickOrder(publishers, "master", lagging=["adviser"]), Written()
    arrivals: dict[int, list[bytes]] = {}
    for tick in range(1, TICKS + 1, 2):
        arrivals.setdefault(chance.randint(tick + 1, tick + latest), []).append(
            message("/beliefs", "adviser", tick + latest - 1)
        )
    for tick in range(1, TICKS + 2):
        arrived = {"/clock": [message("/clock", "master", tick)], "/beliefs": arrivals.pop(tick, [])}
        order.write(written.write, arrived.__getitem__, tick_start=tick * PERIOD, tick_before=max(tick - 1, 1) * PERIOD)
    rest = {"/clock": [], "/beliefs": [data for late in arrivals.values() for data in late]}
    order.write_rest(written.write, rest.__getitem__, tick_start=(TICKS + 1) * PERIOD)
    return written


@given(st.integers(0, 2**32), st.integers(2, 5))
def test_how_far_a_laggard_was_behind_is_not_in_the_bag(seed, latest):
    written = record_laggard(random.Random(seed), latest)
    assert written == record_laggard(random.Random(seed + 1), latest)
    in_time = [log_time for log_time, topic, data in written if topic == "/beliefs"]
    assert len(in_time) == TICKS / 2
    settled = [
        (log_time, data) for log_time, topic, data in written if topic == "/beliefs" and log_time <= TICKS * PERIOD
    ]
    assert all(log_time == int(data.split()[-1]) * PERIOD for log_time, data in settled)
