"""Who was late: what a node reports about the delays of ticks, of itself and of the clock master."""

import pytest
from heave_node.tick.punctuality import RECENT, REMEMBERED, Punctuality
from hypothesis import given
from hypothesis import strategies as st

TICK, SECOND = 50_000_000, 1_000_000_000
MASTER, NODE = 7 * SECOND, 1_700_000_000 * SECOND
"""Offsets of the two clocks: they need not agree."""


def after(ticks: int, *, clock_stalls: float = 0.0, node_stalls: float = 0.0, then: int = 30) -> Punctuality:
    """Return what a node knows after good ticks, a stall [s] of the master or of the node, and ticks to catch up."""
    punctuality = Punctuality()
    for number in range(1, ticks + then):
        sent = number * TICK
        if number > ticks:
            sent = max(sent, ticks * TICK + round(clock_stalls * SECOND))
        wall = sent + 2_000_000
        if number > ticks:
            wall = max(wall, ticks * TICK + round(node_stalls * SECOND))
        punctuality.entered(number * TICK, MASTER + sent, NODE + wall)
    return punctuality


def test_a_node_that_was_held_up_knows_that_it_was_itself():
    held = after(100, node_stalls=0.8, then=2)
    assert held.newest_of_node == pytest.approx(0.75, abs=0.01), "the next tick began 0.05 s after the last good one"
    held = after(100, node_stalls=0.8)
    assert held.of_node == pytest.approx(0.75, abs=0.01)
    assert held.newest_of_node == pytest.approx(0.0, abs=1e-6), "it has made up for it"
    assert held.of_clock == pytest.approx(0.0, abs=1e-6)


def test_a_machine_that_stalled_as_a_whole_is_told_from_it():
    stalled = after(100, clock_stalls=0.8)
    assert stalled.of_clock == pytest.approx(0.75, abs=0.01)
    assert stalled.of_node == pytest.approx(0.0, abs=1e-6)


def test_what_is_over_for_some_seconds_is_not_told_any_more_and_a_new_run_begins_anew():
    assert after(100, node_stalls=0.8, then=100).of_node == pytest.approx(0.0, abs=1e-6)
    held = after(100, node_stalls=0.8)
    held.entered(TICK, MASTER, NODE)
    assert held.of_node == 0.0


def test_without_times_from_the_middleware_all_delay_is_that_of_the_clock():
    punctuality = Punctuality()
    for number in range(1, 20):
        punctuality.entered(number * TICK, 0, NODE + number * TICK + (SECOND if number > 15 else 0))
    assert (punctuality.of_node, punctuality.of_clock) == (0.0, pytest.approx(1.0))


@given(st.lists(st.tuples(st.integers(0, REMEMBERED // 3), st.integers(0, SECOND)), min_size=1, max_size=40))
def test_delays_are_those_of_the_time_that_counts(steps):
    punctuality, wall, entered = Punctuality(), NODE, []
    for number, (step, delay) in enumerate(steps):
        wall += step
        entered.append((wall, delay))
        punctuality.entered(number * TICK, wall - delay, wall)
    least = min(delay for at, delay in entered if at >= wall - REMEMBERED)
    largest = max(delay for at, delay in entered if at >= wall - RECENT)
    assert punctuality.newest_of_node == pytest.approx((entered[-1][1] - least) / SECOND)
    assert punctuality.of_node == pytest.approx((largest - least) / SECOND)
