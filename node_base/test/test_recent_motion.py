"""The value now from the last samples."""

import math

import pytest
from heave_node.sensing.recent_motion import RecentMotion


def test_a_parabola_is_found_exactly():
    recent = RecentMotion()
    for n in range(20):
        t = 0.05 * n
        recent.add(t, 1.0 + 2.0 * t - 3.0 * t * t)
    assert recent.at(1.0) == pytest.approx((0.0, -4.0, -6.0))


def test_a_short_sea_is_told_ahead_within_a_few_percent():
    """The third derivative is what a parabola leaves: A omega^3 times the window cubed."""
    recent = RecentMotion()
    for n in range(200):
        recent.add(0.05 * n, math.sin(0.05 * n))
    value, rate, _ = recent.at(10.0)
    assert value == pytest.approx(math.sin(10.0), abs=0.02)
    assert rate == pytest.approx(math.cos(10.0), abs=0.08)


def test_nothing_is_told_of_now_by_few_or_old_samples_and_a_gap_begins_anew():
    recent = RecentMotion()
    recent.add(0.0, 1.0)
    recent.add(0.1, 1.0)
    assert recent.at(0.1) is None
    recent.add(0.2, 1.0)
    assert recent.at(0.2) is not None
    assert recent.at(2.0) is None
    recent.add(0.15, 9.0)
    recent.add(5.0, 1.0)
    assert recent.at(5.0) is None
