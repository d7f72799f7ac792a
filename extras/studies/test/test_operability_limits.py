"""Limit curves from a grid of cases whose limits are known, and the page of them."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pandas
import pytest
from heave_bags.analyse import kpi_set
from heave_bringup.cli import main
from heave_bringup.run.criteria import LAW
from heave_bringup.scenarios import load_scenario
from heave_node.criteria import Criterion
from heave_studies.campaign import executors
from heave_studies.campaign.runs import CaseResult, Task
from heave_studies.commands.operability import _left_out
from heave_studies.commands.sea_options import with_strengths
from heave_studies.operability.figures import SCALE, contrast, limit_figure, map_figure
from heave_studies.operability.limits import (
    LOST_LIMIT,
    crossing,
    interval,
    limit_curve,
    limit_words,
    seed_limit,
    situations,
    too_few_seeds,
    utilisation,
)
from heave_studies.operability.seas import HEADING, HEIGHT, PERIOD, SeaGrid
from heave_studies.operability.study import study_situations
from scipy import stats

RESIDUAL = Criterion("significant_residual_m", "<=", 0.5)
AMPLIFICATION = Criterion("dynamic_amplification", "<=", 1.3)
SPEED = Criterion("winch_speed_max_mps", "<=", 2.0)


STOPS = [(at, [int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]) for at, colour in SCALE]
"""Colours of the maps, red, green and blue."""


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
                outcome = {"failure": "", "lost": height >= lost_from, "reason": "", "met": True, "missed": ""}
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
    (rope,) = with_strengths(frame, [])
    assert (rope.kpi, rope.bound) == ("rope_safety_factor", 1.0)
    found = seed_limit(frame, [rope])
    assert (found.height, found.governs) == (pytest.approx(2.5), "rope_safety_factor")
    assert seed_limit(frame, [rope], locked=True).height == pytest.approx(1.0)
    use = utilisation(frame, rope)
    assert use is not None
    assert use == pytest.approx(0.08 * frame[HEIGHT].to_numpy() / 0.2)


def test_a_rope_whose_strength_is_not_stated_and_one_with_a_criterion_of_its_own_add_none():
    assert with_strengths(cases(), [RESIDUAL]) == [RESIDUAL]
    own = Criterion("rope_safety_factor", ">=", 2.0)
    frame = cases().assign(rope_safety_factor=3.0)
    assert with_strengths(frame, [own]) == [own]


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
    assert limit_words(low) == "below 1.00"
    (high,) = limit_curve(cases(residual=0.01), [RESIDUAL]).to_dict("records")
    assert limit_words(high) == "above 3.00"
    (within,) = limit_curve(cases(), [RESIDUAL]).to_dict("records")
    assert limit_words(within) == "2.50"
    (mixed,) = limit_curve(cases(seeds=(1, 2, 5)), [RESIDUAL]).to_dict("records")  # 2.5, 1.25 and 0.5 m
    assert limit_words(mixed) == "below 1.58"
    assert interval(mixed) == "-"
    frame = cases(periods=(8.0, 9.0))
    (found,) = study_situations(frame, [RESIDUAL], None)
    drawn = {trace["name"]: trace for trace in limit_figure(found, None).traces}
    assert drawn["compensated"]["marker"]["symbol"] == ["circle", "circle"]
    assert drawn["uncompensated"]["marker"]["symbol"] == ["triangle-down-open"] * 2
    assert drawn["uncompensated"]["y"] == [1.0, 1.0], "nothing is drawn where no sea was run"


def test_the_digits_of_a_map_can_be_read_on_every_colour_of_it():
    """WCAG 2 asks for a contrast of 4.5; black on white has 21."""
    assert contrast(np.zeros(3), np.ones(3)) == pytest.approx(21.0)
    (found,) = study_situations(cases(heights=(0.1, 1.0, 2.0, 2.5, 3.0, 6.0), periods=(8.0, 9.0)), [RESIDUAL], None)
    drawn = map_figure(found, RESIDUAL, locked=False)
    assert drawn is not None
    assert "Green is within the bound, orange beyond it." in drawn.caption
    cells, digits = drawn.traces
    assert len(digits["textfont"]["color"]) == 12
    for value, colour in zip(np.ravel(cells["z"]), digits["textfont"]["color"], strict=True):
        behind = [np.interp(0.5 * value, *zip(*((at, c[k]) for at, c in STOPS), strict=True)) for k in range(3)]
        assert contrast(np.array(behind), np.full(3, 1.0 if colour == "#ffffff" else 0.0)) >= 4.5


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


def test_how_much_of_a_bound_is_used_counts_from_a_calm_sea():
    np.testing.assert_allclose(utilisation(cases(), RESIDUAL), [0.4, 0.8, 1.2])
    np.testing.assert_allclose(utilisation(cases(), AMPLIFICATION), [0.05 / 0.3, 0.1 / 0.3, 0.15 / 0.3])
    assert utilisation(cases(), SPEED, locked=True) is None


def test_each_heading_is_a_situation_of_its_own():
    frame = cases()
    both = pandas.concat([frame.assign(**{HEADING: 0.0}), frame.assign(**{HEADING: math.pi / 2})])
    assert [name for name, _ in situations(both)] == ["heading 0 deg", "heading 90 deg"]
    assert [name for name, _ in situations(frame)] == [""]


def test_a_grid_of_seas_is_every_combination_in_each_situation():
    grid = SeaGrid((1.0, 2.0), (8.0, 9.0), (0.0, 90.0), (1, 2, 3), {"system.length": [500, 900]})
    made = list(grid.campaign("b2_calm_300", settings={}, wanted={}, duration=None).cases())
    assert len(made) == 2 * 2 * 2 * 3 * 2
    assert made[-1].settings == {"system.length": 900, HEADING: pytest.approx(math.pi / 2), PERIOD: 9.0, HEIGHT: 2.0}


@pytest.mark.parametrize(("name", "values"), [("heights", (1.0,)), ("periods", (9.0, 8.0)), ("heights", (0.0, 1.0))])
def test_a_grid_that_is_none_is_refused(name, values):
    with pytest.raises(ValueError, match=f"--{name}: needs at least two values"):
        SeaGrid(**{name: values})


def pretended(task: Task) -> CaseResult:
    (row,) = cases(
        (float(task.case.settings[HEIGHT]),),  # type: ignore[arg-type]
        seeds=(task.case.seed,),
        residual=0.1,
    ).to_dict("records")
    return CaseResult(task.case, {key: row[key] for key in kpi_set.DEFINITION_OF}, "", 1.0)


def test_the_command_writes_page_and_tables_and_makes_them_again_without_running(tmp_path: Path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(executors, "run_task", pretended)
    (tmp_path / "seas.csv").write_text(
        "time,hs,tp\n" + "".join(f"2001-0{1 + d // 28}-{1 + d % 28:02d},{1 + d % 3},8\n" for d in range(56))
    )
    command = [
        *("operability", "b2_calm_300", "--heights", "1", "5", "--periods", "6", "9", "--processes", "1"),
        *("--require", "significant_residual_m<=0.4", "--record", "seas.csv", "--windows", "24", "--csv", "own.csv"),
    ]
    assert main(command) == 0
    said = capsys.readouterr().out
    # seeds 1 and 2: 4 m and 2 m; b2's own criterion on the outlet is never met where its efficiency is 0
    page = (tmp_path / "b2_calm_300_operability.html").read_text()
    assert "workable seas of seas.csv" in said
    assert re.search(r"\d to \d", said) is None, "of two seeds no confidence is printed"
    assert said.count("Confidence is not stated with 2 seeds") == 1
    assert page.count("Confidence is not stated with 2 seeds") == 1
    assert "heave campaign --case b2_calm_300_operability.parquet:CASE" in page
    assert page.count('class="figure"') > 5
    assert len(pandas.read_csv("own.csv")) == 4
    monkeypatch.setattr(executors, "run_task", None)
    again = ["operability", "b2_calm_300", "--cases", "b2_calm_300_operability.parquet", "--report", "again.html"]
    assert main(again) == 0
    assert (tmp_path / "again.html").is_file()


def test_a_scatter_diagram_gives_a_share_and_says_why_there_are_no_windows(tmp_path: Path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(executors, "run_task", pretended)
    (tmp_path / "scatter.csv").write_text("hs,6,9\n1,60,20\n3,15,5\n")
    command = ["operability", "b2_calm_300", "--heights", "1", "5", "--periods", "6", "9", "--processes", "1"]
    assert main([*command, "--require", "significant_residual_m<=0.4", "--record", "scatter.csv"]) == 0
    said = capsys.readouterr().out
    page = (tmp_path / "b2_calm_300_operability.html").read_text()
    assert "workable seas of scatter.csv" in said
    for text in (said, page):
        assert text.count("no waiting times: scatter.csv is a scatter diagram") == 1
    assert "windows with a forecast" not in page


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--heights", "2"], "--heights: needs at least two values above 0 that rise"),
        (["--windows", "6"], "--windows and --alpha need --record"),
        (["--seeds", "0"], "--seeds 0: must be at least 1"),
        (["--vary", "system.length"], "--vary system.length: must be PLACE=[V, ...]"),
        (["--record", "none.csv"], "none.csv: no such file"),
        (["--report", "own.pdf"], "--report own.pdf: must end in .html"),
        (["--cases", "none.parquet"], "none.parquet: no such file"),
        (["--require", "sgima<3"], "sgima is not a figure of merit"),
    ],
)
def test_a_wrong_command_line_is_one_line(arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["operability", "b2_calm_300", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1


@pytest.mark.parametrize("command", ["operability", "sizing"])
def test_a_study_without_criteria_is_refused_before_its_first_case(command, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(executors, "run_task", None)
    assert main([command, "b9_model_error"]) == 2
    assert "no criteria: give the scenario some (wanted), or --require" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_limits_under_the_baseline_law_are_left_out_with_a_word_on_how_to_have_them():
    own = load_scenario("b2_calm_300")
    (line,) = _left_out(own, pandas.DataFrame({"case": [1]}))
    assert "law industrial" in line
    assert "--vary 'winch_controller.law=[mpc, industrial]'" in line
    assert _left_out(own, pandas.DataFrame({LAW: ["mpc", "industrial"]})) == []
    assert (
        _left_out(load_scenario("b2_calm_300", settings=["winch_controller.law=industrial"]), pandas.DataFrame()) == []
    )
