"""Offsets of hosts' clocks from messages both ways: expected by hand, from a delay and an offset that are chosen."""

import pytest
from heave_node.ros.transport.host_clocks import HostClocks

NOW = 1_700_000_000_000_000_000


def exchange(clocks: HostClocks, *, ahead: float, there: float, back: float) -> None:
    """Let a node whose clock is `ahead` [s] hear and send; delays there and back [s]."""
    sent = NOW + round(1e9 * ahead)
    clocks.heard("winch", sent, NOW + round(1e9 * back), there + ahead)


@pytest.mark.parametrize("ahead", [-2.0, 0.0, 0.25])
def test_equal_delays_cancel(ahead):
    clocks = HostClocks()
    exchange(clocks, ahead=ahead, there=0.03, back=0.03)
    found = clocks.offset("winch")
    assert found.offset == pytest.approx(ahead, abs=1e-6)
    assert found.error == pytest.approx(0.03, abs=1e-6)


def test_unequal_delays_err_by_no_more_than_is_said():
    clocks = HostClocks()
    exchange(clocks, ahead=0.0, there=0.09, back=0.01)
    found = clocks.offset("winch")
    assert found.offset == pytest.approx(0.04, abs=1e-6), "half of the difference"
    assert abs(found.offset) <= found.error == pytest.approx(0.05, abs=1e-6)


def test_the_least_delays_count():
    clocks = HostClocks()
    exchange(clocks, ahead=0.5, there=0.001, back=0.4)
    exchange(clocks, ahead=0.5, there=0.001, back=0.001)
    assert clocks.offset("winch").offset == pytest.approx(0.5, abs=1e-6)


def test_nothing_is_known_before_a_message_in_each_direction():
    clocks = HostClocks()
    clocks.heard("winch", NOW, NOW + 1000, 0.0)
    assert clocks.offset("winch") is None
    assert clocks.words({"winch": "quay"}) == clocks.too_far({"winch": "quay"}, 0.1) == ""


def test_a_clock_is_too_far_only_where_the_delay_does_not_explain_it():
    near, far = HostClocks(), HostClocks()
    exchange(near, ahead=0.0, there=0.5, back=0.01)
    exchange(far, ahead=-0.5, there=0.01, back=0.01)
    assert near.too_far({"winch": "quay"}, 0.1) == "", "a slow link is no wrong clock"
    assert far.too_far({"winch": "quay"}, 0.1).startswith(
        "the clock of winch's host quay is 0.500 s behind this host's"
    )
    assert far.words({"winch": "quay"}) == "winch on quay -500.0 ms, to 10.0 ms"


def test_who_takes_part_in_no_measurement_is_not_awaited_for_ever():
    now = [50.0]
    clocks = HostClocks(lambda: now[0])
    assert clocks.awaited(["winch", "tool"]) == ["winch", "tool"]
    exchange(clocks, ahead=0.0, there=0.03, back=0.03)
    now[0] += 0.9
    assert clocks.awaited(["winch", "tool"]) == ["tool"]
    now[0] += 0.9
    assert clocks.awaited(["winch", "tool"]) == ["tool"], "one more has become known meanwhile"
    now[0] += 0.2
    assert clocks.awaited(["winch", "tool"]) == []
