"""A count that is lost is distinguished from a drum that slips or runs away: gravity says how far a drum can get."""

import math

import pytest
from heave_devices.live.drum_count import DrumCount


def jumps(readings, restarted_at=math.inf):
    """Return the jumps found in `readings`: time [s], payout as read [m], rate [m/s]; one found is taken off."""
    count, found = DrumCount(), []
    for time, payout, rate in readings:
        jump = count.jump(time, payout - sum(found), rate, has_restarted=time == restarted_at)
        found += [jump] if jump else []
    return found


def falling(period):
    """A load that falls freely for 2 s, the fastest that a drum can be."""
    times = [period * k for k in range(round(2.0 / period))]
    return [(time, 0.5 * 9.80665 * time**2, 9.80665 * time) for time in times]


@pytest.mark.parametrize("period", [0.02, 0.1, 0.5])
def test_no_drum_that_falls_with_its_load_is_taken_for_a_lost_count(period):
    assert not jumps(falling(period))


@pytest.mark.parametrize("late", [0.0, 0.09, 0.19])
def test_arrivals_that_bunch_together_are_no_jump(late):
    """2 m/s read every 0.1 s, every second one handed over late, and so just before the next."""
    times = [0.1 * k for k in range(40)]
    assert not jumps([(time + late * (k % 2) / 2.0, 2.0 * time, 2.0) for k, time in enumerate(times)])


def test_a_count_that_restarts_at_nought_is_found_once():
    held = [(0.02 * k, 12.3 if k < 20 else 0.0, 0.0) for k in range(40)]
    assert jumps(held) == [pytest.approx(-12.3)]


def test_a_restart_that_is_known_shows_a_count_that_could_have_turned_meanwhile():
    """In 5 s of silence a drum may get 12.3 m; a PLC whose clock restarted has lost what its drum counted."""
    readings = [(0.0, 12.3, 0.0), (5.0, 0.0, 0.0), (5.02, 0.0, 0.0)]
    assert not jumps(readings)
    assert jumps(readings, restarted_at=5.0) == [pytest.approx(-12.3)]


def test_it_is_told_with_its_size_and_cause():
    count = DrumCount()
    count.jump(0.0, 12.3, 0.0, has_restarted=False)
    count.jump(0.02, 0.0, 0.0, has_restarted=False)
    assert "-12.30 m" in count.words
    assert "no drum does so" in count.words
