"""The search for the worst minute: what counts as announced, an optimum that is known, and a search that goes on."""

import json
from concurrent.futures import Future
from contextlib import contextmanager
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest
from heave_bringup.cli import main
from heave_bringup.closed_loop import COLUMNS, LoopRecord
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import Severity
from heave_node.parameters import ParameterError
from heave_studies.campaign.campaign_file import read_campaign
from heave_studies.falsify import search as search_module
from heave_studies.falsify.objective import Minute, judged, silent
from heave_studies.falsify.search import Found, Search
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
"""
MARK = {"digest": "one", "baseline": "no"}


def record(alarms, modes):
    """Return a record of 300 s in ticks of 1 s: alarms by time, modes from a time on."""
    rows = np.zeros((300, len(COLUMNS)))
    rows[:, 0] = np.arange(300.0)
    names = np.full(300, "compensating", dtype=object)
    for start, end, mode in modes:
        names[start:end] = mode
    return LoopRecord(rows, list(names), [(time, ALARMS.alarm(code, **values)) for time, code, values in alarms])


def test_a_minute_is_silent_where_nothing_came_in_it_or_in_the_minute_before():
    one = record([(150.0, "CABLE_SLACK", {"tension": 0.0, "percent": 0.0})], [(20, 30, "fade_out")])
    starts = np.arange(0.0, 240.0)
    found = starts[silent(one, starts, Severity.MEDIUM)]
    # not while the mode rests to 29 s; not where the minute or the one before holds 150 s
    assert found.tolist() == [*np.arange(30.0, 91.0), *np.arange(211.0, 240.0)]
    assert silent(one, starts, Severity.CRITICAL)[100]


def test_the_worst_of_all_minutes_is_kept_with_what_announced_it():
    one = record([(150.0, "CABLE_SLACK", {"tension": 0.0, "percent": 0.0})], [(20, 30, "fade_out")])
    starts, ratios = np.arange(0.0, 240.0), np.full(240, 0.1)
    ratios[[40, 140]] = 0.8, 6.0
    minute = judged(one, starts, ratios, Severity.MEDIUM)
    assert (minute.ratio, minute.start) == (0.8, 40.0)
    assert minute.of_all_words == "6.000 from 140 s on, announced by CABLE_SLACK"
    ratios[10] = 7.0
    assert "compensation was not active" in judged(one, starts, ratios, Severity.MEDIUM).of_all_words
    assert judged(one, starts, ratios, Severity.CRITICAL).ratio == 6.0
    ratios[:] = np.nan
    assert judged(one, starts, ratios, Severity.MEDIUM).ratio == 0.0


@pytest.fixture
def known(monkeypatch):
    """Replace the loop by a hill whose top is known, and count how often it is asked."""
    asked = count()

    class Pool:
        def submit(self, function, task, severity):
            next(asked)
            future = Future()
            parameters = task.scenario.parameters
            (start,) = parameters["wave_vessel"].mru.faults.start
            away = (parameters["winch_controller"].factor - 0.8) ** 2 + ((start - 20.0) / 20.0) ** 2
            future.set_result(Minute(2.0 - away, start, ("MRU_STALE",), "", 5.97, 1.0, ("MRU_STALE",)))
            return future

        def shutdown(self, **_):
            pass

    @contextmanager
    def pool(_):
        yield Pool()

    monkeypatch.setattr(search_module, "worker_pool", pool)
    return asked


@pytest.fixture
def space(tmp_path):
    path = tmp_path / "space.yaml"
    path.write_text(SPACE)
    return read_campaign(path)


def run(space, folder, generations, monkeypatch):
    monkeypatch.setattr(search_module, "GENERATIONS", generations)
    search = Search(space, Severity.MEDIUM, folder / "journal.jsonl", MARK)
    search.run(1e6, 1, lambda *_: None)
    return search


def test_the_top_of_a_known_hill_is_found(space, known, tmp_path, monkeypatch):
    found = run(space, tmp_path, 8, monkeypatch).found
    assert found[0].minute.ratio == pytest.approx(2.0, abs=0.02)
    assert found[0].values["winch_controller.factor"] == pytest.approx(0.8, abs=0.1)
    assert found[0].values["wave_vessel.mru.faults.start"] == [pytest.approx(20.0, abs=2.0)]
    assert [one.minute.ratio for one in found] == sorted((one.minute.ratio for one in found), reverse=True)


def test_a_search_that_was_ended_goes_on_where_it_was_and_ends_the_same(space, known, tmp_path, monkeypatch):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    whole.mkdir()
    parts.mkdir()
    at_once = run(space, whole, 3, monkeypatch)
    first = next(known)
    begun = run(space, parts, 1, monkeypatch)
    between = next(known)
    assert between - first - 1 == begun.asked
    resumed = run(space, parts, 3, monkeypatch)
    assert next(known) - between - 1 == resumed.asked - begun.asked, "what is known is not run again"
    assert [(one.values, one.minute) for one in resumed.found] == [(one.values, one.minute) for one in at_once.found]


def test_the_journal_of_another_search_is_refused(space, tmp_path):
    Search(space, Severity.MEDIUM, tmp_path / "journal.jsonl", MARK)
    with pytest.raises(ParameterError, match="another campaign"):
        Search(space, Severity.MEDIUM, tmp_path / "journal.jsonl", {**MARK, "digest": "other"})


def test_the_worst_cases_are_scenarios_that_run_again(known, space, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(search_module, "GENERATIONS", 1)
    arguments = ["falsify", "b1_thesis", "--space", str(space.path), "--output", str(tmp_path / "out")]
    assert main([*arguments, "--json", str(tmp_path / "result.json")]) == 3, "2 is above 1.05"
    result = json.loads((tmp_path / "result.json").read_text())
    shown = capsys.readouterr()
    assert "worst_1.yaml" in shown.err
    assert "verdict: FAILED; 16 cases, 2 generations of 8" in shown.out
    assert "the worst of all minutes of that run: 5.970 from 1 s on, announced by MRU_STALE" in shown.out
    assert "a generation of 8 cases takes about 0 s here" in shown.out
    assert result["worst"][0]["announced_by"] == ["MRU_STALE"]
    for rank, one in enumerate(result["worst"], 1):
        again = load_scenario(str(tmp_path / "out" / f"worst_{rank}.yaml"))
        assert again.parameters["winch_controller"].factor == one["values"]["winch_controller.factor"]
        assert again.parameters["wave_vessel"].mru.faults.start == tuple(one["values"]["wave_vessel.mru.faults.start"])
        assert again.run.duration == 30.0
    assert main([*arguments, "--bound", "2.5"]) == 0
    assert "verdict: passed; 16 cases" in capsys.readouterr().out


def test_a_budget_that_ends_within_the_first_generation_says_so(known, space, tmp_path, monkeypatch, capsys):
    def look(waiting, *_, **__):
        return SimpleNamespace(done=[next(iter(waiting))])

    monkeypatch.setattr(search_module, "wait", look)
    arguments = ["falsify", "b1_thesis", "--space", str(space.path), "--output", str(tmp_path / "out")]
    assert main([*arguments, "--budget", "1e-9", "--bound", "3"]) == 0
    assert "verdict: passed; 1 case, less than one generation of 8" in capsys.readouterr().out


def test_cases_of_which_none_could_be_run_are_no_verdict(known, space, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(search_module, "GENERATIONS", 1)
    monkeypatch.setattr(Search, "found", property(lambda _: [Found(1, {}, Minute(0.0, failure="no loop"))]))
    assert main(["falsify", "b1_thesis", "--space", str(space.path), "--output", str(tmp_path / "out")]) == 1
    assert "none of 16 cases could be run: no loop" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["b1_thesis", "--budget", "0"], "--budget 0: must be above 0"),
        (["b1_thesis", "--space", "b2_seeds"], "has nothing to search"),
        (["b1_thesis", "--population", "4"], "must be at least 5"),
        (["b1_thesys"], "no such scenario"),
    ],
)
def test_what_is_wrong_is_one_line(arguments, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["falsify", *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
