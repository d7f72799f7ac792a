"""What the operator reads of a run in one line."""

from dataclasses import replace

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

AT_WORK = Situation(
    RunStatus(RUNNING, tick=2000, time=100.0, real_time_factor=1.0),
    ControllerStatus(100.0, "compensating", "mpc", "", 1.0, 0.004, -1.2, 2.4),
    WinchStatus(100.0, 1.25, -0.3, 112e3),
    Figures(60.0, 0.0031),
    depth=904.2,
)


def test_a_run_at_work_is_told_in_one_line():
    assert status_line(AT_WORK) == (
        "running at t = 100.00 s (tick 2000), 1.0 x real time; mode compensating (law mpc, gain 1.00); "
        "mean depth 904.20 m; payout 1.25 m at -0.300 m/s, brake off; "
        "load heave, standard deviation 0.31 cm over 60 s, as estimated; no alarm"
    )


def test_the_status_of_an_open_loop_shows_no_recorded_figure_as_one_of_now():
    """Load and winch are those of a bag: their depth, payout and heave were read as what this run does."""
    line = status_line(replace(AT_WORK, played=("cable_sim", "virtual_winch")))
    assert "open loop: the figures are those of the recorded cable_sim and virtual_winch" in line
    assert not any(word in line for word in ("payout", "mean depth", "load heave"))
    assert "payout" in status_line(replace(AT_WORK, played=("wave_vessel",))), "a sea from a bag moves a winch that is"


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
