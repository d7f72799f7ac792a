"""The draws of the promise: what is drawn, how it is judged and counted; no long run."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, replace

import numpy as np
import pandas
import pytest
from heave_bringup.cli import main
from heave_bringup.closed_loop import COLUMNS, LoopRecord
from heave_bringup.scenarios import load_scenario
from heave_core.layout import STRUCTURES
from heave_core.library import dtype_of
from heave_studies.answers.promise import ablation_rows, broken, changes, figures_of
from heave_studies.promise import cases, run, study
from heave_studies.promise.cases import KINDS, SAFETY, SCENARIOS, STRAINS, Case, draw
from heave_studies.promise.deviation import Chance, nominal
from heave_studies.promise.run import Outcome, counted, findings_of, judged, run_case, warnings_of
from heave_studies.promise.study import ALL, CHECKS, LEARNING, REFLEXES, switched_off
from heave_studies.promise.table import DEVIATIONS, OPERATIONS, highest, sea_of
from winch_controller_node.core.component import WinchController

DAY = 20300101
TICK = 0.05


@pytest.mark.parametrize("kind", list(KINDS))
def test_a_draw_is_fixed_by_kind_day_and_index(kind):
    assert [draw(kind, DAY, index) for index in range(8)] == [draw(kind, DAY, index) for index in range(8)]
    assert len({draw(kind, DAY, index).words for index in range(8)} | {draw(kind, DAY + 1, 0).words}) == 9


@pytest.mark.parametrize(("kind", "least", "most"), [("few", 1, 2), ("stacked", 3, 5), ("seas", 1, 1)])
def test_so_many_things_differ_as_the_kind_says_and_sometimes_an_operation_is_under_way(kind, least, most):
    operations = {row.name for row in OPERATIONS}
    drawn = [draw(kind, DAY, index) for index in range(100)]
    counts = [sum(name not in operations or kind == "seas" for name in one.deviations) for one in drawn]
    assert {least, most} <= set(counts) <= set(range(least, most + 1))
    under_way = [one for one in drawn if operations & set(one.deviations)]
    if kind != "seas":
        # a share of 0.35 of 100, within 4 sigma
        assert 0.35 - 4 * math.sqrt(0.35 * 0.65 / 100) < len(under_way) / 100 < 0.35 + 4 * math.sqrt(0.35 * 0.65 / 100)
    assert {one.scenario for one in drawn} == set(SCENARIOS)


@pytest.mark.parametrize("row", [*DEVIATIONS, *OPERATIONS], ids=lambda row: row.name)
def test_each_row_draws_what_a_scenario_takes(row):
    """Limits of the parameters are checked where the scenario is read: an extreme of each range is among 30 draws."""
    for number in range(30):
        scenario = SCENARIOS[number % len(SCENARIOS)]
        case = cases._with(Case("few", DAY, number, scenario, "mpc", 1), [row], Chance(row.name, number))
        if number < 7:
            case.load(10.0)


def test_seas_are_no_steeper_than_there_are():
    """DNV-RP-C205, 3.5.5: 1/15 up to 8 s, 1/25 from 15 s on, a line between; so 6.66 m at 8 s, 14.05 m at 15 s."""
    assert highest(8.0) == pytest.approx(9.80665 * 64.0 / (2.0 * math.pi) / 15.0)
    assert highest(15.0) == pytest.approx(9.80665 * 225.0 / (2.0 * math.pi) / 25.0)
    for number in range(200):
        height, period = sea_of(Chance("sea", number))
        assert 0.3 <= height <= min(highest(period), 4.5) * (1.0 + 1e-5)
        assert 4.0 <= period <= 16.0


def test_ropes_of_drawn_lifts_are_strong_and_stiff_enough():
    for index in range(5):
        scenario = draw("lifts", DAY, index).load(10.0)
        belief = scenario.parameters["winch_controller"]
        top = belief.unit.weight_in_fluid(belief.water_density)
        top += belief.length * belief.cable.weight_in_fluid(belief.water_density)
        assert STRAINS[0] * 0.99 < max(top, 0.0) / belief.cable.axial_stiffness < STRAINS[1]
        assert scenario.parameters["cable_sim"].unit == belief.unit
        assert SAFETY > 1.0


def test_what_is_nominal_is_what_the_scenario_has():
    base = nominal("b4_limit_900_tp10")
    assert (base.speed, base.acceleration, base.lag, base.delay) == (2.0, 1.5, 0.15, 0.2)
    # 65,000 - 1,025 * 58.4404 kg of the unit and 900 m of (7.2 - 1,025 * pi/4 * 0.045868^2) kg/m
    assert base.tension == pytest.approx(
        9.80665 * (65_000 - 1025 * 58.4404 + 900 * (7.2 - 1025 * math.pi / 4 * 0.045868**2)), rel=1e-3
    )


CASE = Case("few", DAY, 0, "b3_deep_900", "mpc", 1, deviations=("MRU scale",), parts=("mru",))


def record_of(unit, mode=lambda time: "compensating" if time > 20.0 else "standby", alarms=()):
    """Return 390 s of a sea of 10 s in which the unit moves `unit(time)` times as much as the uncompensated one."""
    time = TICK * np.arange(round(390.0 / TICK))
    off = np.sin(2.0 * math.pi * time / 10.0)
    rows = np.zeros((time.size, len(COLUMNS)))
    values = {"time": time, "uncompensated": off, "unit": off * np.array([unit(one) for one in time])}
    for name, column in values.items():
        rows[:, COLUMNS.index(name)] = column
    return LoopRecord(rows, [mode(one) for one in time], list(alarms))


def test_the_worst_minute_and_the_efficiency_are_counted_from_half_a_minute_after_the_beginning():
    found = judged(CASE, record_of(lambda time: 2.0 if time < 50.0 else 0.2))
    assert found.worst == pytest.approx(0.2)
    assert found.efficiency == pytest.approx(0.8, abs=1e-3)
    assert found.is_alarmed is None
    assert not (found.is_lost or found.given_up)


def test_times_that_are_excused_are_not_judged_but_counted_apart():
    fault = replace(CASE, excused=((100.0, 130.0),))
    found = judged(fault, record_of(lambda time: 2.0 if 100.0 <= time < 130.0 else 0.2))
    assert found.worst == pytest.approx(0.2)
    # half of a minute at 2, half at 0.2
    assert found.worst_of_all == pytest.approx(math.sqrt((4.0 + 0.04) / 2.0), rel=1e-3)
    assert counted(np.array([30.0, 40.0, 41.0, 129.0, 130.0]), fault.excused).tolist() == [
        True,
        True,
        False,
        False,
        True,
    ]


@pytest.mark.parametrize("counted_metre", [1.0, 1.05])
def test_a_move_is_no_heave(counted_metre):
    """A unit that follows a move a lag behind, on cable stretched by 1 %, and heaves by a fifth of the sea."""
    record = record_of(lambda _: 0.2)
    time, stiffness, tension = record.column("time"), 1e7, 1e5
    planned = np.clip(0.3 * (time - 150.0), 0.0, 12.0)
    moved = np.clip(0.3 * (time - 150.0 - run.MOVE_LAG), 0.0, 12.0)
    record.rows[:, COLUMNS.index("depth_set_point")] = planned
    record.rows[:, COLUMNS.index("top_tension")] = tension
    record.rows[:, COLUMNS.index("unit")] -= counted_metre * (1.0 + tension / stiffness) * moved
    case = CASE if counted_metre == 1.0 else replace(CASE, parts=("drum", "encoder"))
    assert judged(case, record, stiffness).worst == pytest.approx(0.2, rel=0.02)


@pytest.mark.parametrize(("when", "is_alarmed"), [(140.0, True), (10.0, False), (380.0, False)])
def test_an_alarm_comes_before_a_minute_at_one_and_a_half_is_over(when, is_alarmed):
    alarms = [(when, "WORSE_THAN_OFF (high): x."), (120.0, "SEA_MODEL_UPDATED (event): peak period 9.0 s (was 8.0).")]
    found = judged(CASE, record_of(lambda time: 3.0 if time > 130.0 else 0.2, alarms=alarms))
    assert found.worst == pytest.approx(3.0)
    assert found.is_alarmed is is_alarmed


def test_a_loop_that_never_begins_says_why_and_whether_it_has_a_reason():
    never = record_of(lambda _: 1.0, mode=lambda _: "standby")
    found = judged(CASE, never, obstacle="mru frozen")
    assert (found.reason, found.has_true_reason) == ("never began: mru frozen", False)
    assert math.isnan(found.worst)
    silent = replace(CASE, lost=(("mru", 0.0, 390.0),))
    assert judged(silent, never, obstacle="mru frozen").has_true_reason


def test_giving_up_is_counted_and_losing_is_told_apart_from_a_stop_that_is_requested():
    def mode(time):
        return "fade_out" if 150.0 < time < 160.0 else "compensating" if time < 150.0 else "standby"

    assert (
        judged(CASE, record_of(lambda _: 0.2, mode)).given_up,
        judged(CASE, record_of(lambda _: 0.2, mode)).is_lost,
    ) == (
        1,
        True,
    )
    stopped = replace(CASE, deviations=("stop and restart",), excused=((145.0, 300.0),))
    assert judged(stopped, record_of(lambda _: 0.2, mode)).given_up == 0
    silent = replace(CASE, lost=(("encoder", 140.0, 390.0),))
    assert not judged(silent, record_of(lambda _: 0.2, mode)).is_lost


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        ("IDENTIFIED, MRU (event): x.", {("mru",)}),
        ("SENSOR_LOST, DEPTH (medium): x.", {("depth",)}),
        ("IDENTIFIED, MRU (event): reads 0.85 times the motion.", {("mru",)}),
        ("WINCH_MODEL_UPDATED (event): gain by the encoder 1.117 (was 1.000)", {("winch", "encoder")}),
        (
            "WINCH_MODEL_UPDATED (event): time constant 0.115 s (was 0.150), gain by the encoder 1.1 (was 1.0)",
            {("winch",)},
        ),
        ("SENSOR_DOUBTFUL, DEPTH (low): noise of unit_heave is 0.1, 5.0 times nominal.", {("depth",)}),
        ("NOMINAL, ENCODER (event): confirmed nominal.", set()),
        ("SEA_MODEL_UPDATED (event): peak period 9.0 s (was 8.0).", set()),
    ],
)
def test_findings_are_read_from_words(words, parts):
    assert {one.parts for one in findings_of([(100.0, words)])} == parts
    is_news = words.startswith(("SEA_MODEL_UPDATED", "NOMINAL, ENCODER"))
    assert warnings_of([(100.0, words)]) == ([] if is_news else [100.0])


def test_a_finding_is_wrong_where_it_blames_what_does_not_differ():
    alarms = [(90.0, "IDENTIFIED, MRU (event): x."), (95.0, "SENSOR_LOST, DEPTH (medium): x.")]
    found = judged(CASE, record_of(lambda _: 0.2, alarms=alarms))
    assert (found.right, found.wrong) == ((f"90 s: {alarms[0][1]}",), (f"95 s: {alarms[1][1]}",))


def drawn(ratios, **values) -> pandas.DataFrame:
    """Return the table of draws with these worst minutes over winch locked."""
    rows = []
    for number, ratio in enumerate(ratios):
        outcome = {
            **asdict(Outcome(worst=float(ratio), at=60.0, efficiency=1.0 - float(ratio))),
            **{"alarmed": "", **values},
        }
        row = {"case": number + 1, "index": number, "without": "", "law": "mpc", **outcome}
        rows.append({name: "" if isinstance(value, tuple) else value for name, value in row.items()})
    return pandas.DataFrame(rows).astype({"worst": float})


def test_the_table_counts_what_was_drawn():
    never, failed = (
        drawn([math.nan], reason="never began: mru frozen", efficiency=0.0),
        drawn([math.nan], failure="slack"),
    )
    found = figures_of(pandas.concat([drawn(np.linspace(0.1, 1.1, 11)), never, failed], ignore_index=True))
    names = ("draws", "failed", "judged", "never begun", "without a true reason")
    assert [found[name] for name in names] == [13, 1, 11, 1, 1]
    assert [found[name] for name in ("p50", "p90", "largest")] == pytest.approx([0.6, 1.0, 1.1])
    assert [found["within 1.05"], found["within 1.2"]] == pytest.approx([10 / 11, 1.0])
    # of eleven from -0.1 to 0.9 and the 0 of what never began
    assert found["efficiency"] == pytest.approx(np.median([*np.linspace(-0.1, 0.9, 11), 0.0]))


@pytest.mark.parametrize(
    ("kind", "ratios", "values", "breaches"),
    [
        ("few", 100 * [0.5], {}, []),
        ("few", [*97 * [0.5], *3 * [1.1]], {}, []),
        ("few", [*96 * [0.5], *4 * [1.1]], {}, ["96.0 % within 1.05, promised 97 %"]),
        ("few", [*99 * [0.5], 1.3], {}, ["99.0 % within 1.2, promised 99.5 %"]),
        ("few", [0.5], {"is_lost": True}, ["1 lost"]),
        ("few", [0.5], {"wrong": "SENSOR_LOST, DEPTH: excluded"}, ["1 with a healthy part blamed"]),
        ("stacked", [*85 * [0.5], *12 * [1.4], *3 * [2.0]], {"wrong": "x"}, []),
        ("stacked", [*84 * [0.5], *16 * [1.4]], {}, ["84.0 % within 1.05, promised 85 %"]),
        ("stacked", [*96 * [0.5], *4 * [2.0]], {}, ["96.0 % within 1.5, promised 97 %"]),
        ("stacked", [0.5], {"alarmed": "no"}, ["1 reached 1.5 without an alarm"]),
    ],
)
def test_the_promise_is_broken_where_a_share_is_not_reached(kind, ratios, values, breaches):
    assert broken(kind, figures_of(drawn(ratios, **values))) == breaches


def test_an_ablation_counts_the_draws_that_a_part_saves_and_costs():
    """By more than 0.1: without the part draw 1 is worse, draw 2 better, draw 0 the same."""
    frame = pandas.concat([drawn([0.1, 0.9, 0.5]), drawn([0.15, 2.0, 0.2]).assign(without="guard")])
    _, rows = ablation_rows(frame)
    assert [row[:3] for row in rows] == [["nothing", "0", "0"], ["guard", "1", "1"]]
    pairs = changes(frame[frame["without"] == ""], frame[frame["without"] != ""])
    assert list(pairs.index) == [1, 2], "the largest change first"


def pretended(case):
    """Stand for a run: the worst minute is that of the index, larger where the adviser looks at no sea."""
    ((owner, name, replacement),) = ALL["sea"]
    worst = 3.0 if getattr(owner, name) is replacement else 0.1 * case.index
    return Outcome(worst=worst, at=60.0, efficiency=0.9, alarms=((1.0, "x"),))


def test_the_study_runs_the_draws_of_a_seed_and_without_a_part_and_compares(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(study, "run_case", pretended)
    run = ["study", "few", "--ask", f"seed={DAY}", "--draws", "3", "--processes", "1"]
    assert main([*run, "--output", "before"]) == 0
    assert "verdict: passed: the promise is kept" in capsys.readouterr().out
    assert main([*run, "--ask", "without=[sea]", "--output", "now"]) == 0
    said = capsys.readouterr().out
    assert "What each part saves" in said
    frame = pandas.read_parquet("now/table.parquet")
    assert frame["worst"].tolist() == pytest.approx([0.0, 0.1, 0.2, 3.0, 3.0, 3.0])
    assert frame["words"].tolist()[:3] == [draw("few", DAY, index).words for index in range(3)]
    assert "significant_wave_height" in frame["scenario"][0]
    monkeypatch.setattr(study, "run_case", lambda _: Outcome(worst=1.3))
    assert main([*run, "--ask", "only=7"]) == 3, "a promise that is broken fails the verdict"
    assert (tmp_path / "studies" / f"few-{DAY}" / "page.html").exists()


def test_a_case_is_run_for_a_few_seconds_with_its_operator():
    """Too short to be judged: what is looked at is that the loop runs, is measured, and says why nothing was judged."""
    case = replace(draw("few", DAY, 0), scenario="b2_calm_300", settings={}, actions=((1.0, "speed", 0.1),))
    found = run_case(case, duration=3.0)
    assert not found.failure
    assert found.reason.startswith("never began: ")
    assert found.refused == ("1 s: an operator's speed needs mode compensating or manual; the mode is standby",)
    assert found.efficiency == 0.0
    assert found.cost["controller"] > 0.0


def test_a_case_that_cannot_be_run_says_why():
    assert run_case(replace(draw("few", DAY, 0), settings={"virtual_winch.no_such": 1.0})).failure.startswith(
        "ParameterError"
    )


NAME_OF = {dtype_of(one): one.name for one in STRUCTURES}


def designs_in(what: object, seen: set[int]) -> Iterator[bytes]:
    """Yield the designs that the compiled core reads, as bytes, of all that hangs on an object, in its order."""
    if id(what) in seen or isinstance(what, str | bytes | int | float | type):
        return
    seen.add(id(what))
    if isinstance(what, np.ndarray):
        if NAME_OF.get(what.dtype, "").endswith("Design"):
            yield what.tobytes()
    elif isinstance(what, list | tuple | dict):
        for one in what.values() if isinstance(what, dict) else what:
            yield from designs_in(one, seen)
    else:
        for one in list(getattr(what, "__dict__", {}).values()):
            yield from designs_in(one, seen)


@pytest.mark.parametrize("name", [*REFLEXES, *CHECKS])
def test_what_is_switched_off_in_the_compiled_core_reaches_its_design_and_is_there_again(name):
    nominal = load_scenario("b2_calm_300").parameters["winch_controller"]

    def designs() -> list[bytes]:
        return list(designs_in(WinchController(nominal, tick_period=TICK), set()))

    whole = designs()
    with switched_off(name):
        without = designs()
    assert len(without) == len(whole) > 3
    assert without != whole
    assert designs() == whole


@pytest.mark.parametrize("name", LEARNING)
def test_what_is_switched_off_in_python_is_another_and_is_there_again(name):
    whole = [getattr(owner, part) for owner, part, _ in ALL[name]]
    with switched_off(name):
        assert all(getattr(owner, part) is value for owner, part, value in ALL[name])
    assert whole == [getattr(owner, part) for owner, part, _ in ALL[name]]
    assert whole != [value for *_, value in ALL[name]]
