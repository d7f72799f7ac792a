"""When a node reports on its health: with its part of a tick in lockstep, behind it in real time, where others wait."""

from collections import deque
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("heave_msgs")

from heave_node.ros.master import ClockMasterNode
from heave_node.ros.node import HeaveNode
from heave_node.ros.participant import ParticipantNode
from heave_node.tick.protocol import Part
from heave_node.tick.tick import Tick


class Noted(SimpleNamespace):
    """What the steps of a node need; `order` has what it did, in this order."""

    name, failure, is_active, epoch, lag = "node", "", True, 1, 0
    report = HeaveNode.report

    def __init__(self, **parts):
        self.order = []
        super().__init__(**parts)

    def __getattr__(self, name):
        """Return a method that notes its name."""
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *_, **__: self.order.append(name)

    def fail_on_error(self, do):
        do()


def run_of(*, is_lockstep):
    return SimpleNamespace(is_lockstep=is_lockstep, tick_count=9, tick_nanoseconds=50_000_000)


@pytest.mark.parametrize("is_lockstep", [True, False])
def test_a_participant_in_real_time_reports_when_it_has_answered(is_lockstep):
    idle = SimpleNamespace(began=lambda: None, ended=lambda _: None)
    node = Noted(
        run=run_of(is_lockstep=is_lockstep),
        own_time=idle,
        clock_of_run=SimpleNamespace(now=lambda _: 0),
        _starts=deque([Part(3, 1)]),
        tick=Tick(3, 1, 50_000_000),
        _do_tick=lambda tick: ParticipantNode._do_tick(node, tick),
    )
    ParticipantNode._step(node)
    order = [one for one in node.order if one in ("on_tick", "_answer", "publish_diagnostics")]
    last = ["publish_diagnostics", "_answer"] if is_lockstep else ["_answer", "publish_diagnostics"]
    assert order == ["on_tick", *last]


@pytest.mark.parametrize("is_lockstep", [True, False])
def test_a_clock_master_in_real_time_reports_when_the_tick_has_begun(is_lockstep):
    master = Noted(
        run=run_of(is_lockstep=is_lockstep),
        timing=SimpleNamespace(tick_began=lambda _: None),
        clock_of_run=SimpleNamespace(tick_began=lambda *_: None),
        _clock_output=SimpleNamespace(publish=lambda _: None),
        _publish_readings=lambda tick: ClockMasterNode._publish_readings(master, tick),
    )
    ClockMasterNode._begin_tick(master, 3)
    last = ["publish_diagnostics", "_send_start"] if is_lockstep else ["_send_start", "publish_diagnostics"]
    assert master.order == ["on_readings", *last]


@pytest.mark.parametrize(
    ("number", "pause_at", "follows"), [(3, None, "_begin_tick"), (9, None, "_begin_flush"), (3, 3, "send")]
)
def test_a_node_that_reads_nothing_begins_a_tick_before_the_plant_integrates_where_one_follows(
    number, pause_at, follows
):
    master = Noted(run=run_of(is_lockstep=True), tick_number=number, _reset_wanted=False, _pause_at=pause_at)
    master._past = SimpleNamespace(send=lambda *_: master.order.append("send"))
    master._begin_what_follows = lambda: ClockMasterNode._begin_what_follows(master)
    ClockMasterNode._end_tick(master, Tick(number, 1, 50_000_000))
    assert master.order == [*["_announce"] * (follows == "_begin_tick"), "on_advance", follows]


def test_a_tick_is_announced_once_to_nodes_that_read_nothing_in_it_and_again_as_the_end_of_a_run():
    sent = []
    master = Noted(
        run=run_of(is_lockstep=True),
        roster=SimpleNamespace(counters=[4, 2]),
        _ahead=Part(),
        _ahead_output=None,
        send_part=lambda part, _: sent.append(part),
    )
    for number, flush in ((3, False), (3, False), (4, True)):
        ClockMasterNode._announce(master, Tick(number, 1, 50_000_000), flush=flush)
    assert sent == [Part(3, 1, [4, 2], stamp=150_000_000), Part(4, 1, [4, 2], stamp=200_000_000, flush=True)]


@pytest.mark.parametrize("is_lockstep", [True, False])
def test_a_node_that_lags_reports_in_real_time_alone(is_lockstep):
    node = Noted(run=run_of(is_lockstep=is_lockstep), lag=20)
    for is_answered in (False, True):
        node.report(Tick(3, 1, 50_000_000), is_answered=is_answered)
    assert node.order == ([] if is_lockstep else ["publish_diagnostics"])


def test_a_run_in_real_time_begins_without_a_new_timer():
    """An executor that takes in a new timer serves nobody meanwhile: the first 20 ticks were late by up to 0.1 s."""
    master = Noted(
        run=run_of(is_lockstep=False),
        roster=SimpleNamespace(missing=lambda *_: [], freeze=lambda: None),
        _mismatch_of_external=str,
        _external_topics=lambda **_: [],
        _rivals=list,
        _may_start_by_clocks=lambda: True,
        _wall_clock=SimpleNamespace(reset=lambda: master.order.append("clock")),
    )
    ClockMasterNode._try_to_start(master)
    assert master.order == ["_begin_run", "clock"]
