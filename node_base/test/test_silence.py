"""The silence of another node: what counts, and what does not."""

import pytest
from heave_node.ros.silence import Silence


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
