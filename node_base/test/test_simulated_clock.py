"""Simulated time between ticks, without ROS."""

from heave_node.tick.clock_rule import ClockRule
from heave_node.tick.external_clock import ExternalClock
from heave_node.tick.simulated_clock import LONGEST_LEAD, WINDOW, SimulatedClock
from hypothesis import given
from hypothesis import strategies as st

TICK = 50_000_000
SECOND = 1_000_000_000
START = 77 * SECOND
"""Wall time at which the run begins."""


@given(st.lists(st.integers(0, 20 * TICK), min_size=1, max_size=80))
def test_the_clock_is_never_ahead_and_no_further_behind_than_the_newest_tick_is_late(delays):
    """Ticks begin in order, so a late one holds up those behind it."""
    clock = SimulatedClock()
    wall = 0
    for number, delay in enumerate(delays, start=1):
        wall = max(wall, START + number * TICK + delay)
        clock.tick_began(number * TICK, wall)
        assert number * TICK <= clock.now(wall) <= wall - START


def test_it_goes_on_between_ticks_and_stands_still_while_the_run_is_paused():
    clock = SimulatedClock()
    assert clock.now(START) == 0
    clock.tick_began(TICK, START + TICK)
    assert clock.now(START + TICK + 7) == TICK + 7
    assert clock.now(START + 100 * SECOND) == TICK + LONGEST_LEAD


def test_after_a_pause_it_is_right_again_when_the_window_has_passed():
    clock = SimulatedClock()
    clock.tick_began(TICK, START)
    paused = 3 * SECOND
    for number in range(2, 2 + WINDOW // TICK + 2):
        clock.tick_began(number * TICK, START + paused + number * TICK)
    assert clock.now(START + paused + number * TICK) == number * TICK


def test_another_run_begins_at_its_own_time():
    clock = SimulatedClock()
    clock.tick_began(1000 * TICK, START)
    clock.tick_began(TICK, START + 1)
    assert clock.now(START + 1) == TICK


def test_a_hiccup_of_the_machine_does_not_move_the_clock_of_hardware():
    """For 0.9 s no tick is seen, then those of that time, one each 10 ms: the offset of an own clock stays."""
    clock, hardware = SimulatedClock(), ExternalClock(ClockRule.OWN)
    seen, stall, end = START, START + 20 * SECOND, START + 20 * SECOND + 9 * SECOND // 10
    ticks = []
    for number in range(1, 1200):
        due = START + number * TICK
        seen = max(seen + TICK // 5, end if stall <= due < end else due)
        ticks.append((seen, number))
    errors = []
    for measured in range(START + 2 * TICK, START + 59 * SECOND, TICK // 5):
        arrival = measured + 2_000_000
        while ticks[0][0] <= arrival:
            seen, number = ticks.pop(0)
            clock.tick_began(number * TICK, seen)
        found = hardware.simulated_time(12_345 * SECOND + measured, clock.now(arrival), arrival)
        errors.append(abs(found - (measured - START)))
    assert max(errors) <= 2_000_000, "the least delay cannot be told from the offset"


def test_a_late_start_is_not_remembered_by_the_clock_of_hardware():
    """The first second of ticks is seen 0.4 s late, as when all nodes compile at once."""
    clock, hardware = SimulatedClock(), ExternalClock(ClockRule.OWN)
    errors = []
    for number in range(1, 200):
        arrival = START + number * TICK + (8 * TICK if number < 20 else 0)
        clock.tick_began(number * TICK, arrival)
        found = hardware.simulated_time(12_345 * SECOND + arrival - 2_000_000, clock.now(arrival), arrival)
        errors.append(abs(found - (arrival - START)))
    assert max(errors[30:]) <= 2_000_000
