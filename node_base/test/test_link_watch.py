"""Gaps, bursts and silence."""

import math

from heave_node.devices.live.link_watch import LinkWatch


def test_gaps_bursts_and_silence_are_counted():
    watch = LinkWatch(timeout=1.0)
    assert watch.is_stale(0.0), "nothing has come yet"
    for n in range(50):
        watch.arrived(0.1 * n)
    assert (watch.gaps, watch.bursts, watch.timeouts) == (0, 0, 0)
    assert math.isclose(watch.usual_interval, 0.1)
    watch.arrived(5.3)
    watch.arrived(5.301)
    assert (watch.gaps, watch.bursts) == (1, 1)
    assert not watch.is_stale(6.0)
    assert [watch.is_stale(time) for time in (6.4, 6.5)] == [True, True]
    assert watch.timeouts == 1, "one silence is one time-out"
    watch.arrived(9.0)
    assert not watch.is_stale(9.1)
    assert watch.longest_gap > 3.6
