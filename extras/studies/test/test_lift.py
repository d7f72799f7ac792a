"""A lift by phases: what its cases are, what is refused, weather windows."""

import json
import math
from pathlib import Path

import numpy as np
import pandas
import pytest
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bringup.cli import main
from heave_studies.answers.lift import Window, warnings, windows
from heave_studies.operability.limits import HEIGHT, PERIOD, Bisection, limit_curve
from heave_studies.operability.seas import SeaRecord, at_equal_steps
from heave_studies.study import cases as engine
from heave_studies.study.phases import DEPTH, PHASE, Phase, PhaseParameters
from heave_studies.study.plan import Case, Study
from heave_studies.study.runs import CaseResult, make_tasks
from heave_studies.study.study_file import read_study

from extras.studies.test.test_operability_limits import RESIDUAL, cases

HEAD = 'scenario: unit_1500\nwanted: {dynamic_amplification: "<= 1.3"}\nset: {system.cable.breaking_force: 0.0}\n'
SEAS = f"vary:\n  - {{{PERIOD}: [7, 9]}}\n  - {{{HEIGHT}: [1, 3]}}\nask: {{answer: lift}}\nphases:\n"
LANDING = "  - {name: landing, depth: [1480, 1500], speed: 0.2, compensated: true}\n"


def _study(folder: Path, phases: str, head: str = HEAD) -> Study:
    (folder / "plan.yaml").write_text(head + SEAS + phases)
    return read_study(folder / "plan.yaml")


@pytest.mark.parametrize(
    ("phases", "words"),
    [
        ("  - {depth: [0, 10], speed: 1}\n", "phase 1: name is missing"),
        ("  - {name: a, depth: [0, 10]}\n", "phase 1 (a): needs a duration"),
        ("  - {name: a, speed: 1}\n", "phase 1 (a): depth is missing"),
        ("  - {name: a, depth: [0, 10], sped: 1}\n", "unknown key sped; known: "),
        ("  - {name: a, depth: [0, 10], speed: -1}\n", "speed = -1.0 is not allowed"),
        ("  - {name: a, depth: [-30, -8], duration: 9}\n", "a: depth = [-30.0, -8.0]: lies above the boom tip"),
        ("  - {name: a, depth: [9, 99], speed: 1}\n", "a: moves the unit by 90 m: set system.winch.payout_minimum"),
        (
            '  - {name: a, depth: [0, 9], speed: 1, wanted: {slack_percent: "<= 1"}}\n',
            "not known with the winch locked",
        ),
        (LANDING + LANDING, "two phases are called landing"),
        ("  {}\n", "phase must be a list"),
    ],
)
def test_a_lift_that_is_wrong_is_refused_in_one_line_that_says_where(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], phases: str, words: str
) -> None:
    (tmp_path / "plan.yaml").write_text(HEAD + SEAS + phases)
    assert main(["study", str(tmp_path / "plan.yaml"), "--check"]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert "plan.yaml" in said
    assert said.count("\n") == 1


def test_a_phase_is_run_as_a_move_of_the_winch_and_a_long_one_in_pieces(tmp_path: Path) -> None:
    """A run of unit_1500 counts 180 s: 90 m at 0.5 m/s, of 380 m; its boom tip is 10 m above the water."""
    limits = "{system.cable.breaking_force: 0.0, system.winch.payout_minimum: -99.0, system.winch.payout_maximum: 99.0}"
    head = HEAD.replace("{system.cable.breaking_force: 0.0}", limits)
    phases = "  - {name: down, depth: [20, 400], speed: 0.5, set: {cable_sim.segments: 7}}\n"
    phases += "  - {name: up, depth: [15, 5], speed: 0.2}\n  - {name: wait, depth: [5, 5], duration: 900}\n"
    study = _study(tmp_path, phases, head)
    found = {}
    for task in make_tasks(study, list(study.cases())[::4]):
        values = task.scenario.parameters
        moves = values["winch_controller"].programme
        given = (moves.move_times, moves.move_payouts, moves.move_speeds, values["cable_sim"].shadow_follows_programme)
        place = task.case.settings[PHASE], task.case.settings[DEPTH]
        found[place] = values["cable_sim"].length, task.scenario.run.duration, given
        assert values["cable_sim"].segments == (7 if place[0] == "down" else 20)
    moved = ((120.0,), (90.0,), (0.5,), True)
    assert found == {
        ("down", 20.0): (30.0, 300.0, moved),
        ("down", 165.0): (175.0, 300.0, moved),
        ("down", 310.0): (320.0, 300.0, moved),
        ("up", 15.0): (25.0, 170.0, ((120.0,), (-10.0,), (0.2,), True)),
        ("wait", 5.0): (15.0, 300.0, ((), (), (), False)),
    }


def test_the_limit_of_a_phase_is_the_least_of_its_pieces_and_each_is_bisected() -> None:
    frame = pandas.concat([cases(residual=0.2), cases(residual=0.4)], ignore_index=True)
    frame[PHASE], frame[DEPTH] = "down", [20.0] * 3 + [90.0] * 3
    assert limit_curve(frame, [RESIDUAL])["limit"].iloc[0] == pytest.approx(0.5 / 0.4)
    found = [
        Case(n, 1, {PHASE: "down", DEPTH: row[DEPTH], PERIOD: 8.0, HEIGHT: row[HEIGHT]})
        for n, row in enumerate(frame.to_dict("records"), 1)
    ]
    more = Bisection({"down": [RESIDUAL]}, 0.5).more(found, frame)
    assert sorted({(settings[DEPTH], settings[HEIGHT]) for _, settings in more}) == [
        (20.0, 0.5), (20.0, 2.5), (90.0, 0.5), (90.0, 1.5),
    ]  # fmt: skip


def _forecast(heights: list[float]) -> SeaRecord:
    index = pandas.date_range("2026-11-27", periods=len(heights), freq="h", tz="UTC")
    return at_equal_steps("f.csv", pandas.DataFrame({"hs": heights, "tp": 9.0}, index=index), ())


def _due(heights: list[float], *, may_wait: bool, contingency: float = 0.0) -> list[Window]:
    """Return the windows of two phases of an hour each, which allow 2 m and 1 m, in a forecast of these heights."""
    one = Phase("one", PhaseParameters((20.0, 30.0), duration=3600.0))
    two = Phase("two", PhaseParameters((30.0, 40.0), duration=3600.0, may_wait=may_wait))
    forecast = _forecast(heights)
    allowed = {"one": np.full(len(heights), 2.0), "two": np.full(len(heights), 1.0)}
    return windows([one, two], allowed, forecast, contingency)


@pytest.mark.parametrize(
    ("heights", "may_wait", "contingency", "waiting"),
    [
        ([1.9, 1.9, 1.9, 0.9, 0.9], False, 0.0, (2.0, 0.0)),  # both need one window together
        ([1.9, 1.9, 1.9, 0.9, 0.9], True, 0.0, (0.0, 2.0)),  # the second waits for itself
        ([1.9, 1.9, 0.9], True, 1.0, (0.0, None)),  # the second may take two hours
        ([0.9, 0.9, 0.9, 1.1], False, 1.0, (None, None)),  # both may: it may last until the end of the fourth hour
        ([1.9, 0.9, 0.9, 0.9], False, 1.0, (0.0, 0.0)),
        ([0.5, math.nan, 0.5, 0.5], True, 0.0, (0.0, 1.0)),  # a gap is no weather to go in
    ],
)
def test_phases_begin_when_the_forecast_allows_it(
    heights: list[float], may_wait: bool, contingency: float, waiting: tuple[float | None, ...]
) -> None:
    due = _due(heights, may_wait=may_wait, contingency=contingency)
    assert tuple(None if one.start is None else one.waiting for one in due) == waiting
    if due[0].start is not None:
        first = round(due[0].waiting)
        assert due[0].utilisation == pytest.approx(max(heights[first : first + 1 + round(contingency)]) / 2.0)


def test_what_is_to_be_known_of_a_forecast_is_said() -> None:
    curve, forecast = pandas.DataFrame({"period": [7.0, 11.0]}), _forecast([1.0, 1.0])
    assert warnings(forecast, curve) == []
    forecast.states.loc[forecast.states.index[0], "tp"] = 14.0
    (words,) = warnings(forecast, curve)
    assert "1 of 2 peak periods lie outside 7 to 11 s" in words


def test_the_command_answers_with_limits_and_forecast(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A unit whose locked load grows by a fifth of its weight for each metre of Hs reaches 1.3 at 1.5 m."""
    monkeypatch.chdir(tmp_path)

    def run_task(task: engine.Task) -> CaseResult:
        height = float(str(task.case.settings[HEIGHT]))
        row = cases(heights=(height,)).iloc[0].to_dict()
        return CaseResult(task.case, {key: float(row[key]) for key in DEFINITION_OF})

    monkeypatch.setattr(engine, "run_task", run_task)
    (tmp_path / "my_lift.yaml").write_text(HEAD + SEAS + "  - {name: deck, depth: [-5, -5], duration: 600}\n")
    forecast = "time,hs,tp\n2026-11-27T00:00Z,1.4,8\n2026-11-27T01:00Z,0.5,8\n2026-11-27T02:00Z,1,8\n"
    (tmp_path / "f.csv").write_text(forecast)
    arguments = ["study", "my_lift.yaml", "--processes", "1", "--ask", "alpha=0.5", "--forecast", "f.csv"]
    assert main([*arguments, "--json", "lift.json"]) == 0
    printed = capsys.readouterr().out
    assert "GO after 1 h of waiting" in printed
    page = (tmp_path / "studies" / "my_lift" / "page.html").read_text()
    assert "Forecast and what the lift allows" in page
    found = json.loads((tmp_path / "lift.json").read_text())
    assert [row["limit"] for row in found["situations"][0]["uncompensated_limit"]] == pytest.approx([1.5, 1.5])
    assert found["windows"][0]["start"] == "2026-11-27T01:00:00+00:00"
    (tmp_path / "f.csv").write_text("time,hs,tp\n2026-11-27T00:00Z,9.5,8\n2026-11-27T01:00Z,9.5,8\n")
    assert main(arguments) == 3
    assert "NO-GO: no window for deck" in capsys.readouterr().out
