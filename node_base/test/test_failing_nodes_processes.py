"""A node that fails, whoever started it: the run ends at once, and says where in whose code."""

from loop_processes import start_all

LONG = {"duration": 100.0, "participant_timeout": 300.0}


def test_an_error_in_a_tick_is_shown_with_file_and_line_and_ends_the_run_at_once(loop):
    start_all(loop, "winch_controller", fault="bug", **LONG)
    status, _, err = loop.end("winch_controller")
    assert status == 1
    said = err.splitlines()[-1]
    line = line_of("the line that a user must be shown")
    assert said == (
        f"winch_controller: IndexError: list index out of range (loop_program.py, line {line}) at t = 1.000 s"
    ), "tick 20 of 0.05 s"
    status, _, err = loop.end("cable_sim")
    assert status == 1, "the end of the wait for an answer is 300 s away"
    assert err.splitlines()[-1].startswith(f"cable_sim: {said}")
    assert loop.end("virtual_winch")[0] == 0, "the others hear that the run is over"


def test_in_real_time_the_run_goes_on_until_the_winch_has_stopped(loop):
    start_all(loop, "winch_controller", fault="bug", pacing="realtime", strict=False, **LONG)
    status, out, err = loop.end("cable_sim")
    assert status == 1
    assert "winch_controller: IndexError" in err
    ticks = int(out.split("ticks=")[1].split()[0])
    assert 20 + 60 <= ticks < 200, "tick 20, and then the 3 s of STOP_RECORDING_TIME"


def test_an_error_before_the_first_tick_ends_the_start_at_once(loop):
    start_all(loop, "winch_controller", fault="bug_at_start", start_timeout=300.0)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    line = line_of("raised before the run")
    assert err.splitlines()[-1] == f"cable_sim: winch_controller: KeyError: 'gain' (loop_program.py, line {line})"


def line_of(words: str) -> int:
    from loop_processes import PROGRAM  # noqa: PLC0415

    return next(number for number, text in enumerate(PROGRAM.read_text().splitlines(), 1) if words in text)
