"""One case of a study: why it failed or was lost, what is no success, and the baseline beside it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from heave_bringup.closed_loop import COLUMNS, LoopRecord
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import AlarmRow, Severity
from heave_studies.study import cases, runs
from heave_studies.study.cases import Cases
from heave_studies.study.engine import run_study
from heave_studies.study.plan import Case
from heave_studies.study.runs import CaseResult, Task, lost_because, make_tasks, result_of, run_task
from heave_studies.study.study_file import read_study
from heave_studies.study.summary import case_table, left_out

TEXT = """
scenario: b2_calm_300
duration: 3
seeds: 2
set: {all.transient: 1.0, wave_vessel.ramp: 0.5, cable_sim.segments: 2}
wanted: {unit_sigma_m: "<= 0.5"}
vary: {winch_controller.law: [off, mpc], system.sea.peak_period: [6.0, 7.0]}
"""


@pytest.fixture
def study(tmp_path: Path):
    path = tmp_path / "own.yaml"
    path.write_text(TEXT)
    return read_study(path)


def test_a_case_that_raises_says_why(study, monkeypatch):
    class Parts:
        def __init__(self, parameters: object, *, has_adviser: bool) -> None:
            raise ValueError("no equilibrium:\n 3 m of cable")

    monkeypatch.setattr(runs, "ClosedLoop", Parts)
    (task, *_) = make_tasks(study, list(study.cases()))
    assert run_task(task).failure == "no equilibrium: 3 m of cable"


def test_a_case_whose_cable_would_part_is_no_success():
    """36.5 kN at the top over EA = 150 kN are a strain of 24 %, a little less in the middle of the top segment."""
    settings = ("system.cable.axial_stiffness=1.5e5", "cable_sim.segments=5", "all.duration=3", "all.transient=1")
    scenario = load_scenario("s300_driven", settings=settings)
    result = run_task(Task(Case(1, 1, {}), scenario))
    (breach,) = result.breaches
    assert "cable 2" in breach
    assert list(result.missed) == [breach]


def test_a_case_whose_rope_carries_more_than_its_breaking_force_is_no_success():
    """A wire of 28 mm breaks at 494 kN (EN 12385-4); 54 t weigh 530 kN, which strains it by 1.7 %."""
    unit = ("system.unit.mass=54025.0", "system.unit.volume=1.0")
    settings = ("system.cable=wire_28mm_6x36", *unit, "cable_sim.segments=5", "all.duration=3", "all.transient=1")
    result = run_task(Task(Case(1, 1, {}), load_scenario("s300_driven", settings=settings)))
    assert not result.failure
    assert result.kpis["tension_max_n"] > 520e3
    assert result.kpis["rope_safety_factor"] == pytest.approx(494e3 / result.kpis["tension_max_n"], rel=1e-3)
    assert len(result.breaches) == 1
    assert list(result.missed) == list(result.breaches)


def record_of(modes: list[str], alarms: list[tuple[float, str]]) -> LoopRecord:
    """Return a record with `alarms` of times and codes."""
    rows = np.zeros((len(modes), len(COLUMNS)))
    rows[:, 0] = np.arange(len(modes))
    raised = [(time, AlarmRow(code, Severity.HIGH, "mru", "words").alarm()) for time, code in alarms]
    return LoopRecord(rows, modes, raised)


def test_why_a_case_was_lost_is_when_compensation_ended_and_the_alarm_before():
    scenario = load_scenario("b2_calm_300", settings=["all.transient=3"])
    kpis = {"unit_sigma_m": 0.1, "uncompensated_sigma_m": 0.2}
    on, off = "compensating", "standby"
    whole = record_of([off, on, on, on, on, on], [])
    assert lost_because(whole, scenario, kpis) == ""
    assert "more than uncompensated" in lost_because(whole, scenario, {**kpis, "unit_sigma_m": 0.3})
    ended = record_of([off, on, on, on, "fade_out", on], [(1.0, "FIRST"), (4.0, "SENSOR_LOST, MRU"), (5.0, "LATER")])
    assert lost_because(ended, scenario, kpis) == (
        "compensation ended at 4.00 s (mode fade_out), active 66.7 % of the time: SENSOR_LOST, MRU (high): words."
    )
    never = record_of([off] * 6, [(2.0, "SEA_ABOVE_WINCH")])
    assert lost_because(never, scenario, kpis) == (
        "compensation never began (mode standby): SEA_ABOVE_WINCH (high): words."
    )
    late = record_of([off, off, off, off, on, on], [])
    assert lost_because(late, scenario, kpis).startswith("compensation began only at 4.00 s")
    locked = load_scenario("b2_calm_300", settings=["winch_controller.law=off"])
    assert lost_because(never, locked, kpis) == ""


def test_the_baseline_beside_a_case_is_the_efficiency_of_law_industrial_in_the_same_sea(tmp_path):
    path = tmp_path / "laws.yaml"
    path.write_text(TEXT.replace("[off, mpc]", "[lqg, industrial]"))
    study = read_study(path)
    own, industrial = (
        next(case for case in study.cases() if case.settings["winch_controller.law"] == law)
        for law in ("lqg", "industrial")
    )
    (task,), (other,) = make_tasks(replace(study, has_baseline=True), [own]), make_tasks(study, [industrial])
    found, expected = run_task(task).kpis, run_task(other).kpis
    assert found["baseline_efficiency"] == expected["unit_efficiency"]
    assert np.isnan(expected["baseline_efficiency"])


def test_a_study_of_laws_that_has_the_baseline_among_them_shows_it_beside_each(tmp_path, monkeypatch):
    def efficient(task: Task) -> CaseResult:
        """Stand for a run: case k has an efficiency of k/10, and knows of no baseline."""
        return CaseResult(task.case, {"unit_efficiency": 0.1 * task.case.number})

    monkeypatch.setattr(cases, "run_task", efficient)
    path = tmp_path / "laws.yaml"
    path.write_text(TEXT.replace("[off, mpc]", "[mpc, industrial]"))
    frame = run_study(Cases(read_study(path)), processes=1)[0]
    place = {
        (row["winch_controller.law"], row["system.sea.peak_period"], row["seed"]): k for k, row in frame.iterrows()
    }
    for (_, period, seed), k in place.items():
        of_industrial = frame["unit_efficiency"][place["industrial", period, seed]]
        assert frame["baseline_efficiency"][k] == of_industrial
    assert any(heading.startswith("baseline") for heading in case_table(frame).columns)
    assert left_out(frame) == []


def test_a_study_without_the_baseline_says_that_it_is_left_out(study, monkeypatch):
    monkeypatch.setattr(cases, "run_task", lambda task: CaseResult(task.case, {"unit_efficiency": 0.9}))
    (line,) = left_out(run_study(Cases(study), processes=1)[0])
    assert "law industrial" in line
    assert "--baseline" in line


def test_a_case_whose_sea_is_among_the_cases_under_the_baseline_law_is_not_run_again(tmp_path):
    path = tmp_path / "laws.yaml"
    path.write_text(TEXT.replace("[off, mpc]", "[mpc, industrial]"))
    study = read_study(path)
    tasks = make_tasks(replace(study, has_baseline=True), list(study.cases()))
    assert {task.case.settings["winch_controller.law"] for task in tasks if task.has_baseline} == {"industrial"}


def test_a_winch_that_the_baseline_law_cannot_drive_is_one_note_for_the_study(tmp_path):
    path = tmp_path / "first_order.yaml"
    path.write_text("scenario: b1_thesis\nduration: 3\nseeds: 2\nset: {all.transient: 1.0, cable_sim.segments: 2}\n")
    study = replace(read_study(path), has_baseline=True)
    frame, _ = run_study(Cases(study), tmp_path / "b1", processes=1)
    assert set(frame["failure"]) == {""}
    assert frame["baseline_efficiency"].isna().all()
    note = "the baseline is unknown: law industrial commands a rate: set winch.law to speed_servo"
    assert left_out(frame) == [note]
    frame.loc[1, ["baseline_unknown", "baseline_efficiency"]] = "", 0.5
    assert left_out(frame) == [note.replace("is unknown", "of 1 of 2 cases is unknown; case 1")]


def test_a_baseline_that_cannot_be_computed_costs_nothing_but_itself(study, monkeypatch):
    def fails(scenario: object) -> None:
        raise RuntimeError("no equilibrium:\n 3 m of cable")

    monkeypatch.setattr("heave_studies.baseline.baseline_signals", fails)
    (task, *_) = make_tasks(replace(study, has_baseline=True), list(study.cases()))
    result = run_task(task)
    assert result.failure == ""
    assert np.isfinite(result.kpis["unit_efficiency"])
    assert result.baseline_unknown == "no equilibrium: 3 m of cable"


def test_a_result_is_the_same_when_it_was_written_down(study):
    (task, *_) = make_tasks(study, list(study.cases()))
    result = run_task(task)
    again = result_of(task.case, json.loads(json.dumps(result.to_plain())))
    assert repr(again) == repr(result)  # NaN is not equal to itself
