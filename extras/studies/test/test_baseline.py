"""The baseline beside a run: computed once, kept beside the bag, and unknown where it would be of another sea."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heave_bags.analyse.run_record import RunRecord
from heave_bags.signals import RunSignals
from heave_bringup.parser import make_parser
from heave_bringup.scenarios import Scenario, load_scenario
from heave_studies import baseline


def scenario(*settings: str) -> Scenario:
    return load_scenario("b2_calm_300", settings=["all.duration=4", "all.transient=1", *settings])


def signals(value: float = 1.0) -> RunSignals:
    time = np.arange(5.0)
    parts = {name: baseline.Signal(time, value * np.sin(time + number)) for number, name in enumerate(baseline.KEPT)}
    return RunSignals(**parts)


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    (tmp_path / "bag").mkdir()
    return tmp_path / "bag"


@pytest.fixture
def add(monkeypatch, bag):
    """Add the baseline to a record; `add.runs` counts how often the loop was run for it."""

    def run(scenario: Scenario, progress: baseline.Progress) -> RunSignals:
        add.runs += 1
        add.duration = scenario.run.duration
        progress(0.5)
        return signals()

    def add(*settings: str, end: float = 4.0, **about: str) -> RunRecord:
        monkeypatch.setattr(baseline, "scenario_of", lambda _: scenario(*settings))
        record = RunRecord("run", RunSignals(), 1.0, end, run=about)
        baseline.add_baseline(record, bag)
        return record

    add.runs = 0
    monkeypatch.setattr(baseline, "baseline_signals", run)
    return add


def test_it_is_computed_once_and_what_was_kept_is_the_same_to_the_last_bit(add):
    first, again = add().signals.baseline, add().signals.baseline
    assert add.runs == 1
    for name in baseline.KEPT:
        np.testing.assert_array_equal(getattr(again, name).time, getattr(first, name).time)
        np.testing.assert_array_equal(getattr(again, name).value, getattr(first, name).value)


@pytest.mark.parametrize("change", ["all.seed=7", "virtual_winch.speed_limit=0.5", "winch_controller.length=290"])
def test_one_of_another_scenario_is_not_taken_for_its_own(add, change):
    add()
    add(change)
    assert add.runs == 2


@pytest.mark.parametrize("commit", ["", "0" * 40])
def test_one_of_other_software_is_not_taken_for_its_own(add, monkeypatch, commit):
    add()
    monkeypatch.setattr(baseline, "git_commit", lambda: commit)
    add()
    assert add.runs == 2


@pytest.mark.parametrize("damage", [lambda data: data[:-40], lambda _: b"", lambda _: b"words", lambda data: data[40:]])
def test_a_damaged_file_is_computed_anew(add, bag, damage):
    add()
    file = baseline.kept_at(bag)
    file.write_bytes(damage(file.read_bytes()))
    assert add().signals.baseline is not None
    assert add.runs == 2
    add()
    assert add.runs == 2


def test_a_file_that_would_unpack_to_more_than_a_day_is_not_read(add, bag, monkeypatch):
    add()
    monkeypatch.setattr(baseline, "LARGEST_FILE", 100)
    assert baseline.read_kept(baseline.kept_at(bag), baseline.digest_of(scenario())) is None


def test_where_nothing_can_be_kept_it_is_there_all_the_same(add, bag, monkeypatch):
    monkeypatch.setattr(baseline, "kept_at", lambda bag: bag / "no_folder" / "file.npz")
    assert add().signals.baseline is not None
    assert list(bag.parent.rglob("*.npz*")) == []


def test_a_run_under_the_baseline_law_is_its_own(add):
    record = add("winch_controller.law=industrial")
    assert record.signals.baseline is record.signals
    assert add.runs == 0


@pytest.mark.parametrize("node", baseline.SIMULATED)
def test_it_is_unknown_where_sea_winch_or_cable_were_not_simulated(add, node):
    record = add(replaced=f"winch_controller {node}")
    assert record.signals.baseline is None
    assert record.notes == [f"the baseline is unknown: {node} was not simulated"]


def test_beside_the_law_of_somebody_else_it_is_known(add):
    record = add("winch_controller.law=industrial", replaced="winch_controller")
    assert record.signals.baseline is not record.signals
    assert add.runs == 1


@pytest.mark.parametrize("meant", ["1e5", "4"])
def test_it_lasts_as_long_as_what_was_recorded_and_not_as_long_as_was_meant(add, meant):
    """A run that was ended early."""
    add(f"all.duration={meant}", end=2.5)
    assert add.duration == 2.5
    add(f"all.duration={meant}", end=3.0)
    assert (add.runs, add.duration) == (2, 3.0)


@pytest.mark.parametrize("end", [baseline.LONGEST + 1.0, 1.7e9, 0.0])
def test_of_a_bag_that_lasts_for_ever_or_holds_nothing_it_is_unknown(add, end):
    record = add("all.duration=1e6", end=end)
    assert add.runs == 0
    assert record.notes == [f"the baseline is unknown: the record ends at {end:g} s"]


def test_a_sea_from_a_file_that_is_no_longer_there_is_a_note(monkeypatch, bag):
    from_file = ("wave_vessel.boom_tip_source=file", "wave_vessel.recording_file=/nowhere/heave.csv")
    monkeypatch.setattr(
        baseline,
        "scenario_of",
        lambda _: load_scenario("b2_calm_300", settings=["all.duration=4", *from_file], needs_files=False),
    )
    record = RunRecord("run", RunSignals(), 1.0, 4.0)
    baseline.add_baseline(record, bag)
    (note,) = record.notes
    assert note.startswith("the baseline is unknown: ")
    assert "/nowhere/heave.csv" in note


def test_of_a_unit_that_floats_above_the_boom_tip_it_is_a_note(monkeypatch, bag):
    """What a bag carries is any scenario."""
    floating = scenario("system.unit.volume=20")
    monkeypatch.setattr(baseline, "scenario_of", lambda _: floating)
    record = RunRecord("run", RunSignals(), 1.0, 4.0)
    baseline.add_baseline(record, bag)
    (note,) = record.notes
    assert note.startswith("the baseline is unknown: the line does not hang")


def test_how_far_it_is_is_told():
    shares: list[float] = []
    baseline.baseline_signals(scenario(), shares.append)
    assert shares == pytest.approx([0.25, 0.5, 0.75, 1.0])


@pytest.mark.parametrize("line", [["run", "b2_calm_300"], ["kpi", "bag"], ["report", "bag"]])
def test_it_is_there_unless_it_is_left_out(line):
    parser = make_parser()
    assert parser.parse_args(line).baseline is not False
    assert parser.parse_args([*line, "--no-baseline"]).baseline is False
