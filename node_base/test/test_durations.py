"""Durations in wall time: nothing that is late is left out."""

import math
import pickle

import numpy as np
import pytest
from heave_node.tick.durations import Durations, histogram_text, parse_histogram
from heave_node.tick.loop_timing import LoopTiming


@pytest.fixture
def clock(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    return now


def test_percentiles_of_one_to_a_hundred_milliseconds():
    durations = Durations()
    for value in range(1, 101):
        durations.add(value * 1e-3)
    # linear between the ranks: 50.5 and 99.01 (numpy's and Excel's definition)
    assert durations.percentiles() == pytest.approx((0.0505, 0.09901, 0.1))
    assert durations.percentiles(last=1) == pytest.approx((0.1, 0.1, 0.1))


def test_of_many_durations_the_percentiles_are_within_half_a_percent_and_the_largest_is_exact():
    """A run of hours: those of a part of them would be exact, those of all come from classes of one percent."""
    durations, random = Durations(), np.random.default_rng(1)
    values = np.exp(random.normal(math.log(3e-3), 1.0, 20_000))
    for value in values:
        durations.add(float(value))
    p50, p99, largest = durations.percentiles()
    assert (p50, p99) == pytest.approx(np.percentile(values, [50.0, 99.0]), rel=0.006)
    assert largest == values.max()
    assert durations.percentiles(last=10) == pytest.approx((*np.percentile(values[-10:], [50, 99]), values[-10:].max()))
    assert durations.percentiles(more=(1e3,))[2] == 1e3
    for value in (0.0, 1e-7, 1e6):
        durations.add(value)
    assert durations.percentiles()[2] == 1e6


def test_what_is_kept_of_durations_does_not_grow():
    durations, sizes = Durations(), []
    for number in range(30_000):
        durations.add(1e-3 * (1.0 + number % 7))
        if number % 10_000 == 9_999:
            sizes.append(len(pickle.dumps(durations)))
    assert len(durations) == 30_000
    assert max(sizes) < 1.01 * min(sizes)


def test_a_histogram_has_each_duration_in_one_class_and_survives_as_text():
    durations = Durations()
    for value in (0.00005, 0.001, 0.0011, 0.04, 99.0):
        durations.add(value)
    histogram = durations.histogram()
    assert histogram == {"0.1": 1, "1": 1, "2": 1, "50": 1, "more": 1}
    assert parse_histogram(histogram_text(histogram)) == histogram


def test_a_tick_that_missed_its_deadline_counts_with_its_whole_age(clock):
    timing = LoopTiming()
    for tick in range(1, 11):
        timing.tick_began(tick)
        clock[0] += 0.01
        if tick != 5:
            timing.answered_up_to(tick if tick < 5 else 4)
        clock[0] += 0.04
    timing.answered_up_to(10)
    # tick 5 held up all that follow: it was answered 6 ticks of 0.05 s after its start
    assert len(timing.ages) == 10
    assert timing.loop_age()[2] == pytest.approx(0.3)


def test_a_tick_that_is_never_answered_counts_with_the_time_it_has_waited(clock):
    timing = LoopTiming()
    for tick in range(1, 4):
        timing.tick_began(tick)
        clock[0] += 0.05
    assert timing.loop_age()[2] == pytest.approx(0.15)


def test_a_run_that_begins_again_does_not_wait_for_the_ticks_of_the_last(clock):
    timing = LoopTiming()
    timing.tick_began(1)
    timing.tick_began(2)
    clock[0] += 9.0
    timing.run_began()
    assert timing.loop_age()[2] == 0.0
