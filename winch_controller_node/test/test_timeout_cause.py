"""A command timeout is told with its cause: who was silent."""

import pytest
from winch_controller_node.interface.readings import Lateness
from winch_controller_node.supervision.watch.timeout_cause import TimeoutCause

DT = 0.05


def after_good_ticks(untaken=0.0, silent=0):
    cause = TimeoutCause(DT)
    for tick in range(200):
        cause.update(has_state=True, untaken=untaken if tick > 180 else 0.0)
    for tick in range(silent):
        cause.update(has_state=tick == silent - 1, untaken=0.0)
    return cause


@pytest.mark.parametrize(
    ("lateness", "silent", "untaken", "words"),
    [
        (Lateness(0.03, 0.75), 1, 0.6, "this controller was held up, its commands came 0.75 s late"),
        (Lateness(0.80, 0.10), 1, 0.6, "ticks began 0.80 s late, the machine or the clock master stalled"),
        (Lateness(0.03, 0.04), 17, 0.0, "the winch itself was silent for 0.80 s"),
        (Lateness(0.03, 0.04), 1, 0.55, "commands were given in time, but the winch has taken none for 0.55 s"),
        (Lateness(), 1, 0.0, ""),
    ],
    ids=["controller", "machine", "winch", "transport", "unknown"],
)
def test_who_was_silent_is_told(lateness, silent, untaken, words):
    cause = after_good_ticks(untaken, silent if silent > 1 else 0)
    assert cause.words(lateness) == words


def test_a_silence_of_long_ago_is_no_cause():
    cause = after_good_ticks(silent=17)
    for _ in range(80):
        cause.update(has_state=True, untaken=0.0)
    assert cause.words(Lateness()) == ""
