"""Limit curves from a grid of cases whose limits are known, and the page of them."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas
import pytest
from heave_bags.analyse import kpi_set
from heave_bringup.cli import main
from heave_node.criteria import Criterion
from heave_studies.answers.answer import criteria_of
from heave_studies.answers.limits import limit_figure
from heave_studies.operability.limits import (
    FAILED_LIMIT,
    HEIGHT,
    LOST_LIMIT,
    PERIOD,
    crossing,
    interval,
    limit_curve,
    limit_words,
    seed_limit,
    situations,
    too_few_seeds,
)
from heave_studies.operability.seas import study_situations
from heave_studies.study import cases as engine
from heave_studies.study.runs import CaseResult, Task
from heave_studies.study.study_file import study_of
from scipy import stats

RESIDUAL = Criterion("significant_residual_m", "<=", 0.5)
AMPLIFICATION = Criterion("dynamic_amplification", "<=", 1.3)
WANTED = {"unit_sigma_m": "<= 0.1"}
NO_ROPE = {"system.cable.breaking_force": 0.0}
SPEED = Criterion("winch_speed_max_mps", "<=", 2.0)


def cases(heights=(1.0, 2.0, 3.0), periods=(8.0,), seeds=(1,), residual=0.2, lost_from=math.inf) -> pandas.DataFrame:
    """Return cases whose residual grows by `residual` for each metre, times the seed; locked it is five times that."""
    rows = []
    for period in periods:
        for height in heights:
            for seed in seeds:
                kpis = dict.fromkeys(kpi_set.DEFINITION_OF, 0.0)
                kpis["significant_residual_m"] = residual * height * seed
                kpis["uncompensated_sigma_m"] = 5.0 * residual * height / 4.0
                kpis["dynamic_amplification"] = 1.0 + 0.05 * height
                kpis["uncompensated_dynamic_amplification"] = 1.0 + 0.2 * height
                outcome = {
                    "failure": "",
                    "lost": height >= lost_from,
                    "reason": "",
                    "met": True,
                    "missed": "",
                    "breaches": "",
                }
                head = {"case": len(rows) + 1, "seed": seed, "nominal": False, PERIOD: period, HEIGHT: height}
                rows.append({**head, **outcome, "compensating_share": 1.0, **kpis, "scenario": ""})
    return pandas.DataFrame(rows)


def test_the_limit_is_where_the_figure_reaches_its_bound():
    found = seed_limit(cases(), [RESIDUAL, AMPLIFICATION])
    assert found.height == pytest.approx(0.5 / 0.2)
    assert found.governs == "significant_residual_m"
    # of the locked winch the residual ends at 0.5 m, the amplification at 1.5 m; winch speed it has none
    locked = seed_limit(cases(), [RESIDUAL, AMPLIFICATION, SPEED], locked=True)
    assert (locked.height, locked.governs) == (pytest.approx(0.5), "significant_residual_m")
    by_tension = seed_limit(cases(), [AMPLIFICATION], locked=True)
    assert (by_tension.height, by_tension.governs) == (pytest.approx(1.5), "dynamic_amplification")


def test_a_rope_limits_where_its_load_reaches_its_breaking_force():
    """A static load of 0.8 of the capacity grows by a tenth of itself for each metre, locked by a quarter."""
    frame = cases(heights=(1.0, 4.0))
    for prefix, share in (("", 0.1), ("uncompensated_", 0.25)):
        amplification = 1.0 + share * frame[HEIGHT]
        frame[f"{prefix}dynamic_amplification"] = amplification
        frame[f"{prefix}rope_safety_factor"] = 1.0 / (0.8 * amplification)
    rope = Criterion("rope_safety_factor", ">=", 1.0)
    found = seed_limit(frame, [rope])
    assert (found.height, found.governs) == (pytest.approx(2.5), "rope_safety_factor")
    assert seed_limit(frame, [rope], locked=True).height == pytest.approx(1.0)


def test_a_rope_that_is_too_weak_for_still_water_is_workable_in_no_sea():
    """The static load is 0.5 of the capacity, 0.4 are allowed: no height is within the limit."""
    frame = cases(heights=(1.0, 4.0)).assign(rope_safety_factor=[1.0 / 0.51, 1.0 / 0.54])
    frame["dynamic_amplification"] = [1.02, 1.08]
    assert seed_limit(frame, [Criterion("rope_safety_factor", ">=", 2.5)]).height == 0.0
    (row,) = limit_curve(frame, [Criterion("rope_safety_factor", ">=", 2.5)]).to_dict("records")
    assert (limit_words(row), row["governs"]) == ("below 1.0", "rope_safety_factor")


@pytest.mark.parametrize(
    ("own", "required"),
    [(None, 2.535), (">= 2.0", 2.535), (">= 3.0", 3.0)],
)
def test_a_stated_rope_adds_the_factor_by_which_its_cases_are_judged(own, required):
    """2.535 is the nominal safety factor of GL Noble Denton 0027/ND; a run with less fails whatever is wanted."""
    wanted = {"unit_sigma_m": "<= 0.1", **({"rope_safety_factor": own} if own else {})}
    study = replace(
        study_of("b2_calm_300"), wanted=wanted, common={"system.cable.breaking_force": 2e5}, path=Path("my.yaml")
    )
    bounds = {one.kpi: one.bound for one in criteria_of(study)[""]}
    assert bounds["rope_safety_factor"] == required
    without = criteria_of(replace(study, common=NO_ROPE, wanted=WANTED))[""]
    assert "rope_safety_factor" not in {one.kpi for one in without}


def test_no_case_that_failed_lies_within_a_limit():
    """Whatever fails it: here the rope was strained too much, which no criterion names."""
    frame = cases(residual=0.01)
    frame.loc[frame[HEIGHT] == 3.0, "breaches"] = "Largest strain of the cable 4 % (required at most 3 %)"
    found = seed_limit(frame, [RESIDUAL])
    assert (found.height, found.governs) == (2.0, FAILED_LIMIT)
    frame = cases()  # the residual ends it at 2.5 m, below the failed case
    frame.loc[frame[HEIGHT] == 3.0, "breaches"] = "FAILED"
    assert seed_limit(frame, [RESIDUAL]).height == pytest.approx(2.5)


def test_nothing_limits_where_every_criterion_holds():
    found = seed_limit(cases(residual=0.01), [RESIDUAL])
    assert (found.height, found.governs) == (math.inf, "")
    (row,) = limit_curve(cases(residual=0.01), [RESIDUAL]).to_dict("records")
    assert (row["limit"], row["is_open"]) == (3.0, True)


def test_a_limit_outside_the_heights_that_were_run_is_reported_as_below_or_above_them():
    """Locked, the residual reaches its bound at 0.5 m, below the 1 m that was run; compensated above the 3 m."""
    (low,) = limit_curve(cases(), [RESIDUAL], locked=True).to_dict("records")
    assert low["is_below"]
    assert low["limit"] == pytest.approx(0.5), "by which workable seas are counted"
    assert limit_words(low) == "below 1.0"
    (high,) = limit_curve(cases(residual=0.01), [RESIDUAL]).to_dict("records")
    assert limit_words(high) == "above 3.0"
    (within,) = limit_curve(cases(), [RESIDUAL]).to_dict("records")
    assert limit_words(within) == "2.5"
    (mixed,) = limit_curve(cases(seeds=(1, 2, 5)), [RESIDUAL]).to_dict("records")  # 2.5, 1.25 and 0.5 m
    assert limit_words(mixed) == "below 1.6"
    assert interval(mixed) == "-"
    frame = cases(periods=(8.0, 9.0))
    (found,) = study_situations(frame, {"": [RESIDUAL]})
    drawn = {trace["name"]: trace for trace in limit_figure(found).traces}
    assert drawn["compensated"]["marker"]["symbol"] == ["circle", "circle"]
    assert drawn["winch locked"]["marker"]["symbol"] == ["triangle-down-open"] * 2
    assert drawn["winch locked"]["y"] == [1.0, 1.0], "nothing is drawn where no sea was run"


def test_a_lost_case_ends_the_limit_at_the_height_before():
    found = seed_limit(cases(lost_from=2.0), [RESIDUAL])
    assert (found.height, found.governs) == (1.0, LOST_LIMIT)
    assert seed_limit(cases(lost_from=1.0), [RESIDUAL]).height == 0.0
    assert seed_limit(cases(lost_from=1.0), [RESIDUAL], locked=True).height == pytest.approx(0.5)


def test_a_bound_that_allows_nothing_ends_at_the_last_height_with_none():
    values = np.array([0.0, 0.0, 0.4])
    assert crossing(np.array([1.0, 2.0, 3.0]), values, Criterion("slack_percent", "<=", 0.0)) == pytest.approx(2.0)
    ratio = Criterion("tension_ratio_min", ">=", 0.5)
    assert crossing(np.array([1.0, 2.0]), np.array([0.9, 0.1]), ratio) == pytest.approx(1.5)
    assert crossing(np.array([1.0]), np.array([0.0]), ratio) == pytest.approx(0.5)  # 1 in a calm sea


def test_the_confidence_of_a_limit_is_student_s_over_the_seeds():
    heights = (0.5, 1.0, 2.0, 3.0, 4.0)
    (row,) = limit_curve(cases(seeds=(1, 2, 4), heights=heights), [RESIDUAL]).to_dict("records")
    limits = [2.5, 1.25, 0.625]
    interval = stats.t.interval(0.9, 2, loc=np.mean(limits), scale=stats.sem(limits))
    assert row["limit"] == pytest.approx(np.mean(limits))
    assert row["upper"] == pytest.approx(interval[1])
    assert row["lower"] == max(interval[0], 0.0)
    (cut,) = limit_curve(cases(seeds=(1, 2, 4), heights=heights[:-1]), [RESIDUAL]).to_dict("records")
    assert cut["upper"] == 3.0 < interval[1], "the study has not looked beyond"


@pytest.mark.parametrize("seeds", [(1,), (1, 2)])
def test_fewer_than_three_seeds_show_no_confidence_and_say_how_many_would(seeds):
    curve = limit_curve(cases(seeds=seeds), [RESIDUAL])
    (row,) = curve.to_dict("records")
    assert row["limit"] > 0.0
    assert math.isnan(row["lower"])
    assert math.isnan(row["upper"])
    line = too_few_seeds([curve])
    assert line.startswith(f"Confidence is not stated with {len(seeds)} seed")
    assert "at least 3, better 5" in line
    assert too_few_seeds([limit_curve(cases(seeds=(1, 2, 3)), [RESIDUAL])]) == ""


def test_each_heading_is_a_situation_of_its_own():
    frame = cases()
    both = pandas.concat(
        [frame.assign(**{"system.course.heading": 0.0}), frame.assign(**{"system.course.heading": math.pi / 2})]
    )
    assert [name for name, _ in situations(both)] == ["heading 0 deg", "heading 90 deg"]
    assert [name for name, _ in situations(frame)] == [""]


def pretended(task: Task) -> CaseResult:
    (row,) = cases(
        (float(task.case.settings[HEIGHT]),),  # type: ignore[arg-type]
        seeds=(task.case.seed,),
        residual=0.1,
    ).to_dict("records")
    return CaseResult(task.case, {key: row[key] for key in kpi_set.DEFINITION_OF}, "", 1.0)


def seas(*more: str) -> list[str]:
    vary = ["--vary", f"{HEIGHT}=1,5", "--vary", f"{PERIOD}=6,9", "--seeds", "2", "--processes", "1"]
    return ["study", "operability", "b2_calm_300", *vary, *more]


def test_the_study_answers_and_answers_again_without_running(tmp_path: Path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(engine, "run_task", pretended)
    required = ("--require", "significant_residual_m<=0.4")
    assert main(seas(*required)) == 0
    said = capsys.readouterr().out
    page = (tmp_path / "studies" / "operability-b2_calm_300" / "page.html").read_text()
    for text in (said, page):  # b2_calm_300 itself asks for other bounds
        assert re.search(r"significant residual\W.*at most 40 cm", text, re.DOTALL)
        assert "compensated: ended by" in text
    for words in (
        "b2_calm_300",
        "t in air",
        "Hs",
        "220" if "220" in page else "s each, figures from",
        "peak_period 6, 9",
    ):
        assert words in page
    assert "uncompensated" not in said
    assert re.search(r"\d\.\d to \d", said) is None, "of two seeds no confidence is printed"
    for text in (said, page):
        assert text.count("Confidence is not stated with 2 seeds") == 1
    assert page.count('class="figure"') >= 1
    monkeypatch.setattr(engine, "run_task", None)
    assert main(seas(*required)) == 0
    assert capsys.readouterr().out == said


def test_limits_are_enclosed_by_bisection_in_the_same_waves(tmp_path, monkeypatch, capsys):
    """The residual is 0.1 m for each metre, times the seed: 0.4 m is reached at 4 and 2 m, locked (x 5) at 0.8 m."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(engine, "run_task", pretended)
    only = ("--require", "significant_residual_m<=0.4", "--require", "dynamic_amplification<=9", "--ask", "within=0.25")
    words = [word.replace("b2_calm_300", "b9_model_error") for word in seas(*only)]  # which has no criteria of its own
    assert main(words) == 0
    assert "enclosed within 0.25 m of Hs by bisection, in the same waves" in capsys.readouterr().out
    frame = pandas.read_parquet(tmp_path / "studies" / "operability-b9_model_error" / "table.parquet")
    for (_, seed), part in frame.groupby([PERIOD, "seed"]):
        heights = np.sort(part[HEIGHT])
        for limit in (4.0 / seed, 0.8):
            near = np.abs(heights - limit)
            assert np.sort(near)[:2].sum() <= 0.25 + 1e-9 or near.min() < 1e-9
    assert frame.groupby(PERIOD)["seed"].nunique().eq(2).all()
