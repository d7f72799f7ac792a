"""What the operator reads of a run: one line, trends, the screen."""

import io
import math

from heave_bringup.operate.situation import (
    FAILED,
    PAUSED,
    RUNNING,
    WAITING,
    ControllerStatus,
    Figures,
    RunStatus,
    Situation,
    WinchStatus,
    run_words,
    status_line,
)
from heave_bringup.operate.trend import Trend, sparkline
from heave_bringup.operate.view import View
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

AT_WORK = Situation(
    RunStatus(RUNNING, tick=2000, time=100.0, real_time_factor=1.0),
    ControllerStatus(100.0, "compensating", "mpc", "", 1.0, 0.004, -1.2, 2.4),
    WinchStatus(100.0, 1.25, -0.3, 112e3),
    Figures(60.0, 0.0031),
    depth=904.2,
)


def picture(situation, width=80, **said):
    console = Console(file=io.StringIO(), width=width, force_terminal=False)
    view = View("ROS domain 0")
    view.note(situation)
    console.print(view.render(situation, width=width, **said))
    return console.file.getvalue()


def test_a_run_at_work_is_told_in_one_line():
    assert status_line(AT_WORK) == (
        "running at t = 100.00 s (tick 2000), 1.0 x real time; mode compensating (law mpc, authority 1.00); "
        "mean depth 904.20 m; payout 1.25 m at -0.300 m/s, brake off; "
        "unit heave, standard deviation 0.31 cm over 60 s, as estimated; no alarm"
    )


def test_a_run_that_waits_or_has_failed_says_for_what_and_why():
    assert run_words(RunStatus(WAITING, "recorder to join")) == "waiting for recorder to join"
    assert run_words(RunStatus(FAILED, "no room", 3, 0.15)) == "failed at t = 0.15 s (tick 3): no room"
    assert status_line(Situation()) == "no data from the clock master; no alarm"


def test_an_alarm_stands_until_its_part_is_well_again():
    situation = Situation(RunStatus(PAUSED))
    situation.note("winch_controller: sensor mru", 2, "frozen")
    situation.note("winch_controller: solver", 1, "not solved")
    assert status_line(situation).endswith("alarms: winch_controller: sensor mru: frozen")
    situation.note("winch_controller: sensor mru", 0, "ok")
    assert status_line(situation).endswith("no alarm")


@given(st.lists(st.floats(-1e6, 1e6) | st.just(math.nan), max_size=50), st.floats(-10, 10), st.floats(-10, 10))
def test_a_sparkline_has_one_bar_per_value_and_higher_values_have_no_lower_bars(values, low, high):
    line = sparkline(values, min(low, high), max(low, high))
    assert len(line) == len(values)
    bars = sorted((value, bar) for value, bar in zip(values, line, strict=True) if math.isfinite(value))
    assert [bar for _, bar in bars] == sorted(bar for _, bar in bars)


def test_a_trend_keeps_the_newest_value_of_each_step_and_shows_gaps():
    trend = Trend(1.0, 10)
    for time, value in ((0.0, 5.0), (0.5, 0.0), (1.0, 1.0), (3.0, 2.0)):
        trend.note(time, value)
    assert trend.draw(10) == "▁▅ █"
    assert trend.extent == (0.0, 2.0)
    assert trend.draw(2) == " ▅"  # alone in the middle of its scale
    trend.note(0.2, 7.0)  # the run has restarted
    assert trend.extent == (7.0, 7.0)


def test_the_screen_names_mode_alarms_and_the_key_of_the_emergency_stop_at_any_width():
    AT_WORK.note("virtual_winch: drive", 2, "tripped [at once]")
    for width in (40, 80, 200):
        lines = picture(AT_WORK, width).splitlines()
        assert max(map(len, lines)) <= width
        text = " ".join(line.strip("│ ") for line in lines)
        assert "mode compensating" in text
        assert "tripped [at once]" in text
        assert "SPACE: EMERGENCY STOP" in text
    AT_WORK.note("virtual_winch: drive", 0, "ok")


def test_the_screen_says_when_what_it_shows_is_old():
    assert "NO WORD from the run for 3 s" in picture(AT_WORK, silence=3.2)
    assert "NO WORD" not in picture(AT_WORK, silence=0.3)


def test_the_screen_shows_what_it_asks_and_complains_of():
    assert "depth: depth [m]: 29_" in picture(AT_WORK, prompt="depth: depth [m]: 29_")
    assert "z: no such key" in picture(AT_WORK, complaint="z: no such key")
