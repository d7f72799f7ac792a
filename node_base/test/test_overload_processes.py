"""Real time with a node that is too slow, or stood still: it does not live in the past, and the run's end counts what
was lost.
"""

import re

from loop_processes import start_all

REAL_TIME = {"pacing": "realtime", "strict": False}


def test_a_node_that_is_too_slow_jumps_to_the_newest_messages(loop):
    """A tick of it takes three periods: after n ticks of the run it would be two thirds of n behind."""
    start_all(loop, "winch_controller", fault="slow", duration=6.0, **REAL_TIME)
    status, _, err = loop.end("cable_sim", timeout=60.0)
    assert status == 0, err
    _, out, _ = loop.end("virtual_winch")
    oldest = float(out.split("oldest=")[1])
    assert oldest < 2.0, "working through its backlog it would send commands that are 3.3 s old at the end of 5 s"


def test_the_end_of_an_overloaded_run_counts_what_was_lost(loop):
    """4 s of sleep at 100 Hz are 400 messages on each topic, of which the queues keep the last 200."""
    parameters = {"tick_period": 0.01, "duration": 5.5, "participant_timeout": 20.0}
    start_all(loop, "winch_controller", fault="doze", **parameters, **REAL_TIME)
    status, out, err = loop.end("cable_sim", timeout=60.0)
    assert status == 0, err
    assert "ended=True ticks=551" in out
    lost = int(re.search(r"lost=messages of the run were lost: .*?(\d+) to winch_controller", out)[1])
    assert 0 < lost < 3 * 550, "of one message a tick on each of its three inputs"
