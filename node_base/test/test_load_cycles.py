"""Rainflow counting against the standard's example and closed forms."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from heave_node.loads.cycles import DAMAGE_EXPONENT, load_cycles, rainflow, reversals
from hypothesis import given
from hypothesis import strategies as st

EXAMPLE = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]
"""ASTM E1049-85, Fig. 6."""

RECORDS = st.lists(st.integers(-9, 9).map(float), max_size=30)


def counted(values) -> dict[float, float]:
    total: Counter[float] = Counter()
    for size, count in zip(*rainflow(values), strict=True):
        total[float(size)] += float(count)
    return dict(total)


def test_the_example_of_the_standard_is_counted_as_it_counts_it():
    assert counted(EXAMPLE) == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def test_samples_between_reversals_and_plateaus_are_no_cycles():
    between = np.interp(np.arange(0.0, 8.01, 0.25), np.arange(9), EXAMPLE)
    assert counted(np.repeat(between, 3)) == counted(EXAMPLE)
    assert counted([5.0, 5.0, 5.0]) == counted([5.0]) == counted([]) == {}


@given(RECORDS)
def test_every_range_between_reversals_is_half_a_cycle_and_the_largest_is_among_them(values):
    found = counted(values)
    assert sum(found.values()) == pytest.approx(0.5 * max(len(reversals(values)) - 1, 0))
    if found:
        assert max(found) == max(values) - min(values)
    assert counted([-value for value in values]) == found


def test_a_sine_has_one_cycle_a_period_of_twice_its_amplitude():
    time = np.arange(0.0, 200.01, 0.05)
    tension = 1e5 + 2e4 * np.cos(2.0 * math.pi * time / 8.0)
    found = load_cycles(time, tension)
    assert found.per_hour == pytest.approx(3600.0 / 8.0, rel=1e-3)
    # one cycle of 40 kN in 8 s does the damage of eight of 40 kN / 8^(1/m), one each second
    assert found.equivalent_range == pytest.approx(4e4 / 8.0 ** (1.0 / DAMAGE_EXPONENT), rel=1e-3)
    assert load_cycles(time, tension, exponent=1.0).equivalent_range == pytest.approx(4e4 / 8.0, rel=1e-3)


def test_a_ripple_adds_nothing_to_the_count_and_a_record_without_time_is_not_known():
    time = np.arange(0.0, 200.01, 0.05)
    tension = 1e5 + 2e4 * np.cos(2.0 * math.pi * time / 8.0)
    ripple = 100.0 * (-1.0) ** np.arange(time.size)
    assert load_cycles(time, tension + ripple).per_hour == pytest.approx(3600.0 / 8.0, rel=1e-3)
    assert math.isnan(load_cycles([1.0], [1e5]).per_hour)
    assert math.isnan(load_cycles([], []).equivalent_range)
