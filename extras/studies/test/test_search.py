"""The search for the worst case: what counts as announced, a top that is known, and a search that goes on."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from heave_bringup.cli import main
from heave_bringup.closed_loop import COLUMNS, LoopRecord
from heave_bringup.scenarios import load_scenario
from heave_studies.study import cases
from heave_studies.study.runs import CaseResult, Minute, Task, silent
from winch_controller_node.interface.alarms import ALARMS

SPACE = """scenario: b1_thesis
duration: 30
set:
  all.transient: 5.0
  wave_vessel.mru.faults.kind: [gap]
  wave_vessel.mru.faults.duration: [1.0]
  wave_vessel.mru.faults.magnitude: [0.0]
draw:
  count: 8
  seed: 3
  uniform: {winch_controller.factor: [0.0, 1.0], "wave_vessel.mru.faults.start[]": [6.0, 26.0]}
search: {figure: silent_minute, runs: 64, at_most: 1.05}
"""


def record(alarms, modes):
    """Return a record of 300 s in ticks of 1 s: alarms by time, modes from a time on."""
    rows = np.zeros((300, len(COLUMNS)))
    rows[:, 0] = np.arange(300.0)
    names = np.full(300, "compensating", dtype=object)
    for start, end, mode in modes:
        names[start:end] = mode
    return LoopRecord(rows, list(names), [(time, ALARMS.alarm(code, **values)) for time, code, values in alarms])


def test_a_minute_is_silent_where_nothing_came_in_it_or_in_the_minute_before():
    one = record([(150.0, "SENSOR_LOST, MRU: stale", {"age": 1.0, "limit": 0.15})], [(20, 30, "fade_out")])
    starts = np.arange(0.0, 240.0)
    found = starts[silent(one, starts)]
    # not while the mode rests to 29 s; not where the minute or the one before holds 150 s
    assert found.tolist() == [*np.arange(30.0, 91.0), *np.arange(211.0, 240.0)]


@pytest.fixture
def known(monkeypatch, tmp_path):
    """Replace the loop by a hill whose top is known, keep count of what is asked, and work in a folder of its own."""
    pytest.importorskip("cma")
    asked: list[int] = []

    def hill(task: Task) -> CaseResult:
        asked.append(task.case.number)
        parameters = task.scenario.parameters
        (start,) = parameters["wave_vessel"].mru.faults.start
        away = (parameters["winch_controller"].factor - 0.8) ** 2 + ((start - 20.0) / 20.0) ** 2
        return CaseResult(task.case, {"unit_sigma_m": 0.1}, minute=Minute(2.0 - away, start))

    monkeypatch.setattr(cases, "run_task", hill)
    monkeypatch.chdir(tmp_path)
    Path("space.yaml").write_text(SPACE)
    return asked


def test_the_top_of_a_known_hill_is_found_and_the_worst_case_runs_again(known, capsys):
    assert main(["study", "space.yaml", "--processes", "1", "--json", "space.json"]) == 3, "2 is above 1.05"
    shown = capsys.readouterr()
    assert "verdict: FAILED; 64 of 64 cases that ran were judged (at most 1.05)" in shown.out
    found = json.loads(Path("space.json").read_text())
    worst = max(found["cases"], key=lambda one: one["silent_minute"])
    number = int(shown.out.partition("worst case: ")[2].partition(",")[0])
    assert main(["study", "--case", f"studies/space/table.parquet:{number}", "--output", "worst.yaml"]) == 0
    again = load_scenario("worst.yaml").parameters
    assert again["winch_controller"].factor == pytest.approx(0.8, abs=0.1)
    assert again["wave_vessel"].mru.faults.start == (pytest.approx(20.0, abs=2.0),)
    assert worst["case"] == number
    assert worst["silent_minute"] == pytest.approx(2.0, abs=0.02)


def test_a_search_that_was_ended_goes_on_where_it_was_and_ends_the_same(known, monkeypatch):
    main(["study", "space.yaml", "--processes", "1", "--output", "whole"])
    known.clear()
    run = cases.run_task

    def ends(task: Task) -> CaseResult:
        if len(known) == 30:
            raise KeyboardInterrupt
        return run(task)

    monkeypatch.setattr(cases, "run_task", ends)
    assert main(["study", "space.yaml", "--processes", "1", "--output", "parts"]) == 130
    monkeypatch.setattr(cases, "run_task", run)
    main(["study", "space.yaml", "--processes", "1", "--output", "parts"])
    assert known == list(range(1, 65)), "what is known is not run again"
    assert Path("parts/table.parquet").read_bytes() == Path("whole/table.parquet").read_bytes()


def test_cases_without_a_minute_that_counts_are_no_verdict(known, monkeypatch, capsys):
    monkeypatch.setattr(cases, "run_task", lambda task: CaseResult(task.case, {"unit_sigma_m": 0.1}))
    assert main(["study", "space.yaml", "--processes", "1"]) == 1
    assert ": no minute of compensation without an alarm counts" in capsys.readouterr().err
