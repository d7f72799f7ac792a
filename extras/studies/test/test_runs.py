"""One case of a study: why it failed or was lost, what is no success."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from heave_bringup.closed_loop import COLUMNS, LoopRecord
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import AlarmRow, Severity
from heave_studies.study import runs
from heave_studies.study.plan import Case
from heave_studies.study.runs import Task, lost_because, make_tasks, result_of, run_task
from heave_studies.study.study_file import read_study

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


def test_cases_that_differ_by_their_seed_have_the_text_that_each_would_have_alone(study):
    tasks = make_tasks(study, list(study.cases()))
    assert [task.alike is not None for task in tasks] == [False, True] * 4
    for task in tasks:
        assert task.text == replace(task, alike=None).text
    assert len({task.values for task in tasks}) == len(tasks)


def test_a_case_that_raises_says_why_and_where(study, monkeypatch):
    class Parts:
        def __init__(self, parameters: object, *, has_adviser: bool) -> None:
            raise ValueError("no equilibrium:\n 3 m of cable")

    monkeypatch.setattr(runs, "ClosedLoop", Parts)
    (task, *_) = make_tasks(study, list(study.cases()))
    assert run_task(task).failure.startswith("ValueError: no equilibrium: 3 m of cable (test_runs.py, line ")


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


def test_a_result_is_the_same_when_it_was_written_down(study):
    (task, *_) = make_tasks(study, list(study.cases()))
    result = run_task(task)
    again = result_of(task.case, json.loads(json.dumps(result.to_plain())))
    assert repr(again) == repr(result)  # NaN is not equal to itself
