"""The silence of another node: what counts, and what does not."""

import pytest
from heave_node.ros.silence import MasterWaits, Patience, Silence


class Clock:
    time = 100.0

    def __call__(self):
        return self.time


def test_a_silence_grows_with_every_look_and_ends_with_what_is_heard():
    clock = Clock()
    silence = Silence(clock)
    for _ in range(60):
        clock.time += 0.2
        seen = silence.look()
    assert seen == pytest.approx(12.0)
    silence.end()
    clock.time += 0.2
    assert silence.look() == pytest.approx(0.2)


def test_the_time_in_which_this_process_stood_still_is_not_the_silence_of_another():
    """A node of the process computes for 12 s; the messages that wait are only heard after the look."""
    clock = Clock()
    silence = Silence(clock)
    clock.time += 0.2
    silence.look()
    clock.time += 12.0
    assert silence.look() == pytest.approx(0.2)
    clock.time += 0.5
    assert silence.look() == pytest.approx(0.7)


def test_what_is_seen_counts_once_it_has_stayed_the_same_for_long_enough_and_another_begins_anew():
    clock = Clock()
    patience = Patience(0.5, clock)
    assert not patience.is_over("one")
    clock.time += 0.4
    assert not patience.is_over("one")
    clock.time += 0.2
    assert patience.is_over("one")
    assert not patience.is_over("another")
    clock.time += 0.6
    assert patience.is_over("another")


def test_what_is_not_answered_is_sent_again_after_a_wait_that_doubles():
    clock = Clock()
    waits = MasterWaits(clock)
    waits.sent(1.0)
    due = []
    for tenth in range(1, 80):
        clock.time += 0.1
        if waits.is_resend_due():
            due.append(0.1 * tenth)
    assert due == pytest.approx([1.1, 3.2, 7.3], abs=0.11), "after 1 s, 2 s more, 4 s more"
    waits.sent(1.0)
    clock.time += 1.05
    assert waits.is_resend_due(), "the next tick begins with the first wait"


def test_status_and_warnings_are_due_once_a_period_and_a_tick_that_is_sent_puts_off_the_warning():
    clock = Clock()
    waits = MasterWaits(clock)
    counts = {"status": 0, "warning": 0}
    for _ in range(40):
        clock.time += 0.05
        counts["status"] += waits.is_status_due(0.24)
        counts["warning"] += waits.is_warning_due(0.99)
    assert counts == {"status": 8, "warning": 2}, "2 s of 0.25 and of 1 s"
    clock.time += 0.9
    waits.sent(1.0)
    clock.time += 0.5
    assert not waits.is_warning_due(0.99)
    assert waits.age == pytest.approx(3.4)
