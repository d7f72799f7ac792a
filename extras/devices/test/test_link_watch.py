"""Gaps, bursts and silence."""

import math

from heave_devices.live.link_watch import LinkWatch


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


def test_a_device_that_sends_in_bursts_has_the_mean_as_its_usual_interval():
    """Ten samples within 9 ms, once a second."""
    watch = LinkWatch(timeout=3.0)
    for second in range(20):
        for n in range(10):
            watch.arrived(second + 0.001 * n)
    assert watch.samples == 200
    assert math.isclose(watch.usual_interval, 0.1, rel_tol=0.03)


def test_the_usual_interval_is_known_from_ten_on():
    watch = LinkWatch(timeout=1.0)
    for n in range(10):
        watch.arrived(0.1 * n)
    assert math.isnan(watch.usual_interval)
    watch.arrived(1.0)
    assert math.isclose(watch.usual_interval, 0.1)


def test_the_age_of_the_newest_sample_is_the_time_since_it_came():
    watch = LinkWatch(timeout=1.0)
    assert math.isnan(watch.age(5.0))
    watch.arrived(7.0)
    assert watch.age(7.25) == 0.25


def test_a_device_is_stale_after_its_timeout_not_at_it_and_each_silence_is_counted():
    watch = LinkWatch(timeout=1.0)
    watch.arrived(0.0)
    assert not watch.is_stale(1.0)
    assert watch.is_stale(1.25)
    watch.arrived(2.0)
    assert watch.is_stale(3.5)
    assert watch.timeouts == 2


def test_a_gap_does_not_change_the_usual_interval_and_counts_once():
    """Thirty samples a tenth of a second apart, and once five seconds: the middle one is a tenth, the mean 0.27 s."""
    watch = LinkWatch(timeout=10.0)
    for n in range(30):
        watch.arrived(0.1 * n + (4.9 if n >= 15 else 0.0))
    assert math.isclose(watch.usual_interval, 0.1, rel_tol=1e-6)
    assert (watch.gaps, watch.bursts) == (1, 0)
    assert math.isclose(watch.longest_gap, 5.0)


def test_a_gap_is_longer_than_two_and_a_half_usual_intervals_and_the_longest_is_kept():
    """Of 0.125 s: 0.3125 s is none yet."""
    watch = LinkWatch(timeout=1.0)
    for n in range(20):
        watch.arrived(0.125 * n)
    assert watch.longest_gap == 0.125
    watch.arrived(19 * 0.125 + 0.3125)
    assert (watch.gaps, watch.longest_gap) == (0, 0.3125)
    watch.arrived(19 * 0.125 + 0.3125 + 0.375)
    assert (watch.gaps, watch.longest_gap) == (1, 0.375)


def test_a_burst_is_shorter_than_a_fifth_of_the_usual_interval():
    """Of 1.25 s: 0.25 s is none yet."""
    watch = LinkWatch(timeout=9.0)
    for n in range(20):
        watch.arrived(1.25 * n)
    watch.arrived(24.0)
    assert watch.bursts == 0
    watch.arrived(24.125)
    assert watch.bursts == 1
