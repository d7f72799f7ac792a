"""What matters: parameters whose influence is known, and what cannot be decided."""

import numpy as np
import pandas
import pytest
from heave_bringup.cli import main
from heave_node.parameters import ParameterError
from heave_studies.campaign.sensitivity import influence_table, influences, save_tornado
from heave_studies.campaign.table import FAILURE, NOMINAL
from heave_studies.tables.case_table import CASE, SCENARIO
from scipy import stats


def frame_of(count=200, **columns):
    """Return cases with parameters of known influence on the figure: strong and curved, weak and falling, none."""
    generator = np.random.default_rng(1)
    strong, weak, none = generator.uniform(size=(3, count))
    figure = np.exp(3.0 * strong) - 2.0 * weak
    cases = {CASE: range(count), "seed": 1, NOMINAL: False, "a.strong": strong, "a.weak": weak, "a.none": none}
    cases |= {"a.word": ["off", "mpc"] * (count // 2), FAILURE: "", "unit_sigma_m": figure, SCENARIO: ""}
    return pandas.DataFrame(cases | columns)


def test_parameters_are_ranked_by_what_the_figure_follows_and_the_sign_is_told():
    frame = frame_of()
    strong, weak, none = influences(frame, "unit_sigma_m")
    assert [one.place for one in (strong, weak, none)] == ["a.strong", "a.weak", "a.none"]
    assert strong.correlation == stats.spearmanr(frame["a.strong"], frame["unit_sigma_m"]).statistic
    assert strong.correlation > 0.9
    assert weak.high < 0.0
    assert strong.is_shown
    assert not none.is_shown
    assert strong.at_high > strong.at_low
    assert weak.at_high < weak.at_low


def test_nine_intervals_in_ten_of_a_parameter_without_influence_hold_0():
    """Of 300: between 84 and 96 % with a probability of 99.9 %."""
    generator = np.random.default_rng(2)
    columns = {f"p.{number}": generator.uniform(size=100) for number in range(300)}
    frame = frame_of(100, **columns)
    frame["unit_sigma_m"] = generator.uniform(size=100)
    found = [one for one in influences(frame, "unit_sigma_m") if one.place.startswith("p.")]
    assert 0.84 < np.mean([not one.is_shown for one in found]) < 0.96


def test_a_case_that_failed_and_the_nominal_one_do_not_count():
    frame = frame_of()
    plain = influences(frame, "unit_sigma_m")
    worse = pandas.concat([frame, frame_of(2)], ignore_index=True)
    worse.loc[200, [FAILURE, "unit_sigma_m"]] = ["the cable parted", np.nan]
    worse.loc[201, NOMINAL] = True
    assert influences(worse, "unit_sigma_m") == plain


def test_too_few_cases_and_words_alone_are_refused():
    with pytest.raises(ParameterError, match=r"6 cases with unit_sigma_m: what matters needs 10"):
        influences(frame_of(6), "unit_sigma_m")
    with pytest.raises(ParameterError, match="no parameter was varied that is a number"):
        influences(frame_of().drop(columns=["a.strong", "a.weak", "a.none"]), "unit_sigma_m")


def test_the_plot_is_the_same_for_the_same_cases(tmp_path):
    found = influences(frame_of(), "unit_sigma_m")
    for name in ("one.svg", "two.svg"):
        save_tornado(found, "unit_sigma_m", tmp_path / name)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()
    assert influence_table(found, "unit_sigma_m").row_count == 3


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_figure_that_follows_one_parameter_exactly_is_drawn_too(tmp_path, sign):
    frame = frame_of()
    frame["unit_sigma_m"] = 2.0 + sign * frame["a.strong"]
    found = influences(frame, "unit_sigma_m")
    assert found[0].correlation == pytest.approx(sign, abs=1e-12)
    assert found[0].low <= found[0].correlation <= found[0].high
    save_tornado(found, "unit_sigma_m", tmp_path / "one.png")
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")


def test_a_campaign_of_too_few_cases_is_refused_before_they_are_run(tmp_path, capsys):
    campaign = tmp_path / "few.yaml"
    draws = "{count: 9, nominal: true, uniform: {system.length: [250, 300]}}"
    campaign.write_text(f"scenario: b2_calm_300\nduration: 100000\ndraw: {draws}\n")
    assert main(["campaign", str(campaign), "--tornado", str(tmp_path / "few.svg")]) == 2
    assert capsys.readouterr().err == f"heave: {campaign}: 9 cases: what matters needs 10 and more\n"
