"""`heave extremes`: seeds of a table, and what it refuses."""

import json

import pytest
from heave_bags.analyse import kpi_set
from heave_bringup.cli import main
from heave_studies.campaign import executors, study
from heave_studies.campaign.campaign_file import read_campaign
from heave_studies.campaign.runs import CaseResult
from scipy import stats

TEXT = """
scenario: b2_calm_300
seeds: {seeds}
vary: {{system.sea.peak_period: [6.0, 7.0]}}
"""


def pretended(task):
    """Stand for a run: its largest heave has a square that is Gumbel, by its seed; twice as high in the longer sea."""
    sea = task.case.settings["system.sea.peak_period"]
    square = stats.gumbel_r(9.0, 0.8).ppf((task.case.seed - 0.5) / 15.0)
    figures = {"max_abs_heave_m": square**0.5 * (2.0 if sea == 7.0 else 1.0), "tension_mean_n": 4e4}
    figures |= {"uncompensated_max_abs_heave_m": 5.0, "tension_max_n": 5e4, "tension_min_n": 3e4}
    return CaseResult(task.case, dict.fromkeys(kpi_set.DEFINITION_OF, 0.1) | figures)


def table_of(tmp_path, monkeypatch, *, seeds):
    monkeypatch.setattr(executors, "run_task", pretended)
    path, table = tmp_path / "own.yaml", tmp_path / "own.parquet"
    path.write_text(TEXT.format(seeds=seeds))
    study.run_study(read_campaign(path), output=table, processes=1)
    return table


def test_the_seeds_of_each_sea_are_records_of_it(tmp_path, monkeypatch, capsys):
    table = table_of(tmp_path, monkeypatch, seeds=15)
    capsys.readouterr()
    assert main(["extremes", str(table), "--json", "-"]) == 0
    seas = json.loads(capsys.readouterr().out)["seas"]
    assert [sea["sea"].rpartition(" ")[0][-2:] for sea in seas] == ["15", "15"]
    first, second = ({one["name"]: one for one in sea["expected"]} for sea in seas)
    heave = first["load heave about its mean"]["methods"][0]
    # records of 480 s after the transient: 3 h are 22.5 of them; Gumbel: location + scale ln(22.5)
    assert heave["most_probable"] == pytest.approx((9.0 + 0.8 * 3.1135) ** 0.5, rel=0.02)
    twice = second["load heave about its mean"]["methods"][0]
    assert twice["most_probable"] == pytest.approx(2.0 * heave["most_probable"], rel=0.01)
    low, high = first["load heave about its mean"]["without_a_seed"]
    assert low < heave["most_probable"] < high
    assert first["top tension, largest"]["methods"][0]["most_probable"] == pytest.approx(5e4)


def test_seas_of_two_seeds_say_nothing(tmp_path, monkeypatch, capsys):
    table = table_of(tmp_path, monkeypatch, seeds=2)
    capsys.readouterr()
    assert main(["extremes", str(table)]) == 2
    assert "no sea has 3 seeds" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--hours", "0"], "heave: --hours 0: must be a number above 0"),
        (["--hours", "nan"], "heave: --hours nan: must be a number above 0"),
        (["--transient", "5"], "heave: --transient: is for bags"),
        ([], "heave: no.parquet: no such file"),
    ],
)
def test_what_cannot_be_told_is_refused_in_one_line(arguments, words, capsys):
    assert main(["extremes", "no.parquet", *arguments]) == 2
    said = capsys.readouterr().err
    assert said.startswith(words)
    assert said.count("\n") == 1
