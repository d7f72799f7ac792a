"""What commands print, and how they show progress."""

import argparse
import io
import json
import math
import sys
from types import SimpleNamespace

import pytest
from heave_bringup.errors import CommandError
from heave_bringup.output import make_table, write_result
from heave_bringup.progress import ProgressLine
from heave_bringup.run import records
from heave_bringup.run.live_figures import LiveFigures
from heave_bringup.run.run import _show_progress
from heave_msgs.msg import TickStatus


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_standard_output_holds_the_json_and_nothing_else_where_it_was_asked_for(capsys):
    write_result(
        argparse.Namespace(json="-"), ["words", make_table(["a"], [["1"]])], {"x": math.nan, "y": [math.inf, 1]}
    )
    assert json.loads(capsys.readouterr().out) == {"x": None, "y": [None, 1]}


def test_text_and_json_go_where_they_belong(capsys, tmp_path):
    path = tmp_path / "result.json"
    write_result(argparse.Namespace(json=str(path)), "words", {"x": 1})
    assert capsys.readouterr().out == "words\n"
    assert json.loads(path.read_text()) == {"x": 1}
    with pytest.raises(CommandError, match="cannot be written"):
        write_result(argparse.Namespace(json=str(tmp_path)), "words", {})


def test_a_table_that_goes_to_a_file_is_never_wrapped_and_its_cells_are_taken_literally(capsys):
    long = "a remark of many words " * 20
    rows = [["speeds=[lqg]", "1.5", long], ["b", "10.25", ""]]
    write_result(argparse.Namespace(json=None), make_table(["case", "unit cm", "remark"], rows, texts=["remark"]), {})
    heading, _, first, second = capsys.readouterr().out.splitlines()
    assert first.startswith("speeds=[lqg]")
    assert first.endswith(long.strip())
    assert first.index("1.5") + 3 == second.index("10.25") + 5 == heading.index("unit cm") + 7, "numbers align right"


@pytest.mark.parametrize("columns", [20, 40, 80])
def test_no_number_is_shortened_however_narrow_the_terminal(monkeypatch, columns):
    stream = Terminal()
    monkeypatch.setattr(sys, "stdout", stream)
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setenv("TERM", "xterm")
    rows = [[f"seed={n}", f"{n / 7:.4f}", f"{n * 1e4:.6f}", "words that may be wrapped"] for n in range(1, 4)]
    write_result(
        argparse.Namespace(json=None), make_table(["case", "unit cm", "off cm", "remark"], rows, texts=["remark"]), {}
    )
    for row in rows:
        assert all(cell in stream.getvalue() for cell in row[:3])


def test_progress_in_a_file_is_a_line_now_and_then_and_what_was_told_stays():
    stream = io.StringIO()
    with ProgressLine(stream) as progress:
        progress.show("starting the nodes")
        progress.show("reading", 0.5)  # work that is done before the next line would be due
        progress.tell("an alarm [of a node]")
    assert stream.getvalue() == "starting the nodes\nan alarm [of a node]\n"


def test_what_was_said_in_a_file_is_not_said_again(monkeypatch):
    monkeypatch.setattr("heave_bringup.progress.QUIET_PERIOD", 0.0)
    stream = io.StringIO()
    with ProgressLine(stream) as progress:
        for text in ("starting the nodes", "starting the nodes", "waiting for cable_sim", "waiting for cable_sim"):
            progress.show(text)
    assert stream.getvalue() == "starting the nodes\nwaiting for cable_sim\n"


def test_the_share_that_is_done_stands_before_what_is_going_on_and_says_of_what_it_is(monkeypatch):
    """A controller that compensates has an authority, a share too: it must not be taken for that."""
    monkeypatch.setattr("heave_bringup.progress.QUIET_PERIOD", 0.0)
    stream = io.StringIO()
    with ProgressLine(stream) as progress:
        progress.show("150.0 s of 600 s  compensating", 0.25)
    assert stream.getvalue() == " 25 % done  150.0 s of 600 s  compensating\n"


@pytest.mark.parametrize("columns", [80, 200])
def test_mode_residual_and_efficiency_of_a_long_run_fit_into_a_narrow_terminal(monkeypatch, columns):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", str(columns))
    stream, live = Terminal(), LiveFigures()
    live.note_mode(1.0, "compensating", "")
    status = SimpleNamespace(state=TickStatus.RUNNING, simulated_time=1263.5, real_time_factor=112.3)
    monitor = SimpleNamespace(status=status, kpi=SimpleNamespace(window=60.0, unit_sigma=0.1062, unit_efficiency=0.978))
    scenario = SimpleNamespace(run=SimpleNamespace(duration=3600.0))
    with ProgressLine(stream) as progress:
        _show_progress(scenario, SimpleNamespace(**vars(monitor), live=live), progress)
    said = stream.getvalue()
    assert "1263.5 of 3600 s" in said
    assert "compensating, load 10.62 cm rms, efficiency 97.8" in said


def test_progress_in_a_terminal_shows_text_and_share_and_leaves_only_what_was_told(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()
    with ProgressLine(stream) as progress:
        progress.show("waiting for [the] nodes")
        progress.show("running", 0.25)
        progress.tell("an alarm [of a node]")
    said = stream.getvalue()
    assert "waiting for [the] nodes" in said
    assert "25 % done" in said
    assert said.index("25 % done") < said.index("running")
    assert "an alarm [of a node]\n" in said
    assert said.rstrip().endswith("\x1b[2K") or said.endswith("\x1b[?25h") or "\x1b[2K" in said


def test_the_analysis_of_a_bag_shows_no_share_where_none_is_known(monkeypatch, capsys):
    def analyse(bags, *, progress, **_):
        progress(0.0)
        return []

    monkeypatch.setattr(records.analysis, "analyse", analyse)
    records.read_records([])
    assert capsys.readouterr().err == "analysing the bag\n"
