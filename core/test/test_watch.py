"""Landing's trends and the window of the figures of merit beside numpy, and what holds for any input."""

import math

import numpy as np
import pytest
from heave_core.watch import KpiRing, LandingWatch, Link, LoadRecord
from heave_core.watch_table import Landed, LoadNews
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from tests.core_parts import (
    add_depth,
    add_to_window,
    judge_landing,
    note_command,
    observe_landing,
    trend_of,
    watch_load,
)

DT = 0.05
LOAD = {
    "static_tension": 60e3,
    "weight": 50e3,
    "stiffness": 1e6,
    "following_time": 0.5,
    "swing_time": 9.0,
    "touchdown_ratio": 0.3,
    "lowered": 0.15,
    "shortest": 0.6,
    "longest": 8.0,
    "windows": (1.0, 2.0, 3.0),
    "least_readings": 4,
    "filled": 0.9,
    "least_rate": 0.01,
    "steady_share": 0.85,
    "standing_share": 0.4,
    "relief_share": 0.5,
    "certain": 3.0,
    "innovation_above": 1.0,
    "unconfirmed_time": 3.0,
    "pause": 4.0,
}


def ring(rows=40):
    return KpiRing({"tick_period": DT, "rows": rows, "speed": 1.0, "acceleration": 10.0})


NUMBER = st.floats(-5.0, 5.0)
KNOWN = st.lists(st.tuples(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER | st.just(math.nan)), min_size=1, max_size=70)


def expected(rows, size):
    """Return the statistics by numpy: a row counts where each heave is known that is known in the last one."""
    table = np.array(rows)
    rate = table[:, 4]
    acceleration = np.diff(rate, prepend=0.0) / DT
    table = np.column_stack([table[:, :5], acceleration, table[:, 5]])[-size:]
    unknown = np.isnan(table[-1, :3])
    held = table[np.all(np.isfinite(table[:, :3]) | unknown, axis=1)]
    heaves = np.where(unknown, np.nan, held[:, :3])
    outlet = heaves[:, 2] - held[:, 3]
    felt = held[np.isfinite(held[:, 6])]
    power = np.abs(felt[:, 6] * felt[:, 4])

    def deviation(values):
        return np.std(values) if len(values) > 1 else np.nan

    return [
        len(held),
        *(deviation(heaves[:, k]) for k in range(3)),
        deviation(outlet),
        np.max(np.abs(heaves[:, 0] - np.mean(heaves[:, 0]))),
        np.max(np.abs(held[:, 4])),
        np.max(np.abs(held[:, 5])),
        np.max(power) if len(power) else np.nan,
        np.mean(power) if len(power) else np.nan,
        np.min(felt[:, 6]) if len(felt) else np.nan,
        np.max(felt[:, 6]) if len(felt) else np.nan,
        np.mean((np.abs(held[:, 4]) >= 1.0) | (np.abs(held[:, 5]) >= 10.0)),
    ]


@given(KNOWN, st.lists(st.tuples(st.integers(0, 69), st.integers(0, 2)), max_size=12))
def test_a_window_holds_what_numpy_finds_in_its_ticks(rows, gaps):
    rows = [list(row) for row in rows]
    for place, column in gaps:
        rows[place % len(rows)][column] = math.nan
    window = ring()
    for unit, uncompensated, tip, payout, rate, tension in rows:
        add_to_window(window, unit, uncompensated, tip, payout, rate, 0.0, tension, 0.0)
    assert window.statistics() == pytest.approx(expected(rows, 40), rel=1e-9, abs=1e-9, nan_ok=True)


def test_a_window_that_holds_nothing_says_so():
    found = ring().statistics()
    assert (found.rows, found.speed, found.at_limit) == (0.0, 0.0, 0.0)
    assert math.isnan(found.unit) and math.isnan(found.power) and math.isnan(found.least_tension)


@given(st.lists(st.tuples(st.floats(0.0, 60.0), NUMBER), min_size=1, max_size=80), st.floats(0.5, 30.0))
def test_a_trend_is_what_numpy_finds_in_the_readings_of_its_window(readings, window):
    """Times that are no later than the last one are left out."""
    landing = LandingWatch(LOAD)
    for time, value in readings:
        add_depth(landing, time, value)
    kept = readings[:1]
    for time, value in readings[1:]:
        if time > kept[-1][0]:
            kept.append((time, value))
    times, values = np.array(kept).T
    within = times >= times[-1] - window
    found = trend_of(landing, "depth", window)
    assert found.mean == pytest.approx(np.mean(values[within]), abs=1e-9)
    is_known = np.sum(within) >= 4 and times[-1] - times[0] >= 0.9 * window
    assert bool(found.is_known) == is_known
    if is_known and np.ptp(times[within]) > 1e-3:
        slope = np.polyfit(times[within] - times[-1], values[within], 1)[0]
        assert found.slope == pytest.approx(slope, rel=1e-6, abs=1e-6)


def watched(ticks, *, payout=lambda time: 0.2 * time, **seen):
    """Return a landing that has watched a winch at 0.2 m/s for so many ticks."""
    landing = LandingWatch(LOAD)
    for k in range(ticks):
        time = DT * k
        observe_landing(
            landing, time, seen.get("tension", 60e3), seen.get("is_weighed", 1.0), payout(time), 0.2 * time, 0.0, 0.0
        )
    return landing


def flag(landing, name):
    return float(landing.state[name][0])


def test_the_speed_of_lowering_is_the_slope_of_the_mean_payout_and_none_of_one_that_stands():
    assert flag(watched(100), "lowering_rate") == pytest.approx(0.2)
    assert flag(watched(5), "lowering_rate") == 0.0
    assert flag(watched(100, payout=lambda time: 0.2 * min(time, 2.0)), "lowering_rate") == 0.0


def test_a_lost_load_cell_has_no_tension():
    assert watched(100).state["tension"]["count"][0] == 100
    assert watched(100, is_weighed=0.0).state["tension"]["count"][0] == 0


def test_without_a_depth_sensor_a_cable_that_has_lost_the_weight_over_a_whole_swing_is_a_touchdown():
    """Share of the weight at 10 kN: 0; over the 9 s of a swing."""
    assert judge_landing(watched(300, tension=10e3), 10e3, False, False, True) == Landed.TOUCHDOWN
    assert judge_landing(watched(300, tension=60e3), 10e3, False, False, True) == Landed.NOT
    assert judge_landing(watched(300, tension=10e3), 10e3, False, False, False) == Landed.NOT


def test_a_standing_unit_is_lifted_off_once_the_cable_carries_more_than_its_weight():
    landing = watched(10)
    landing.state["unit_stands"] = landing.state["is_lifting"] = 1.0
    assert judge_landing(landing, 59e3, True, False, False) == Landed.NOT
    assert judge_landing(landing, 61e3, True, False, False) == Landed.LIFTED_OFF
    assert (flag(landing, "unit_stands"), flag(landing, "is_lifting")) == (0.0, 0.0)


LINK = {"minute": 50, "window": 9, "late_ticks": 2, "tick_period": DT, "largest_share": 0.1, "cut_time": 0.5}
LINK |= {"memory": 3.0, "rounding": 1e-6}
DELAY = 4


@given(late=st.lists(st.integers(0, 7), min_size=1, max_size=120))
def test_commands_are_as_late_as_most_of_the_last_ones_by_numpy(late):
    """Of nine: the fifth largest. A command without a newer one for half a second is not known."""
    link, known, newest, without = Link(LINK), [], 0, 0
    for tick, behind in enumerate(late, start=20):
        taken = tick - DELAY - behind
        without = without + 1 if behind and taken == newest else 0
        newest = taken
        note_command(link, tick, taken, DELAY * DT)
        if without * DT <= 0.5 - 0.5 * DT:
            known.append(behind * DT)
        last = np.sort(known[-9:])[::-1]
        wanted = last[4] if len(last) > 4 and max(known[-50:]) > 0.0 else 0.0
        assert link.state["overdue"][0] == pytest.approx(wanted)
    assert (link.state["known"][0], link.state["late"][0]) == (len(known), np.count_nonzero(known))


LOADED = {"tick_period": DT, "quiet_time": 1.0, "slack_ratio": 0.05, "tension_ratio": 1.5, "saturation_time": 2.0}
LOADED |= {"saturation_share": 0.5, "capacity": 400e3, "required": 2.5, "least": 1.0}


@given(st.lists(st.tuples(st.floats(-50e3, 600e3) | st.just(math.nan), st.booleans()), min_size=1, max_size=100))
def test_a_cause_is_reported_where_it_was_away_for_long_and_limits_are_averaged_as_by_scipy(ticks):
    record, quiet = LoadRecord(LOADED), dict.fromkeys(LoadNews, 1.0)
    limited = lfilter([DT / 2.0], [1.0, DT / 2.0 - 1.0], [float(is_at_limit) for _, is_at_limit in ticks])
    for (tension, is_at_limit), share in zip(ticks, limited, strict=True):
        factor = 400e3 / tension if tension > 0.0 else math.nan
        there = {
            LoadNews.SLACK: tension < 0.05 * 100e3,
            LoadNews.TENSION_HIGH: tension > 1.5 * 100e3,
            LoadNews.SATURATED: share > 0.5,
            LoadNews.ROPE_SHORT: 1.0 <= factor < 2.5,
            LoadNews.ROPE_OVERLOADED: factor < 1.0,
        }
        wanted = sum(cause for cause, is_there in there.items() if is_there and quiet[cause] >= 1.0 - 1e-12)
        quiet |= {cause: 0.0 if is_there else quiet[cause] + DT for cause, is_there in there.items()}
        assert watch_load(record, tension, 100e3, is_at_limit=is_at_limit) == wanted
        assert record.state["at_limit"][0] == pytest.approx(share)
