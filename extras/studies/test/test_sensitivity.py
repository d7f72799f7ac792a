"""What matters: parameters whose influence is known, and what cannot be decided."""

import numpy as np
import pandas
import pytest
from heave_node.parameters import ParameterError
from heave_studies.study.case_file import CASE, SCENARIO
from heave_studies.study.sampling import Draws
from heave_studies.study.summary import influence_rows, influences, sobol_indices
from heave_studies.study.table import NOMINAL
from heave_studies.study.workers import FAILURE
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


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_figure_that_follows_one_parameter_exactly_is_listed_too(sign):
    frame = frame_of()
    frame["unit_sigma_m"] = 2.0 + sign * frame["a.strong"]
    found = influences(frame, "unit_sigma_m")
    assert found[0].correlation == pytest.approx(sign, abs=1e-12)
    assert found[0].low <= found[0].correlation <= found[0].high
    assert len(influence_rows(found, "unit_sigma_m")[1]) == len(found)


def test_sobol_indices_are_the_shares_of_the_variance():
    """Ishigami's function, a = 7, b = 0.1: first-order indices 0.314, 0.442, 0; total 0.558, 0.442, 0.244 (Saltelli et
    al., Global Sensitivity Analysis: The Primer, 2008, section 4.6).
    """
    pytest.importorskip("SALib")
    draws = Draws(1024, 1, "saltelli", uniform=dict.fromkeys(("a.x", "a.y", "a.z"), (-np.pi, np.pi)))
    x, y, z = np.array([list(one.values()) for one in draws.values()], dtype=float).T
    values = np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)
    frame = pandas.DataFrame({NOMINAL: False, "unit_sigma_m": values})
    found = np.array(list(sobol_indices(draws, frame, "unit_sigma_m").values()))
    np.testing.assert_allclose(found[:, 0], (0.314, 0.442, 0.0), atol=0.04)
    np.testing.assert_allclose(found[:, 1], (0.558, 0.442, 0.244), atol=0.04)
