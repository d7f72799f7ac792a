"""Every shipped campaign reads, and every case of it is a legal run."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError
from heave_studies.campaign.campaign_file import read_campaign

FOLDER = Path(str(resources.files("heave_studies"))) / "campaigns"
FILES = sorted(FOLDER.glob("*.yaml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_cases_are_legal_settings_of_the_scenario(path: Path) -> None:
    campaign = read_campaign(path)
    cases = list(campaign.cases())
    assert len(cases) in (2, 4, 8, 24, 65, 256)
    for case in cases[:8]:
        scenario = load_scenario(campaign.scenario, settings=campaign.settings_of(case))
        assert scenario.run.seed == case.seed
        assert scenario.run.duration == campaign.duration or campaign.duration is None


def test_a_name_that_is_no_parameter_s_is_told_with_the_campaign_that_has_it(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text("scenario: b2_calm_300\nvary: {system.sea.peak_period: [6, 50]}\n")
    first, last = (read_campaign(path).settings_of(case) for case in read_campaign(path).cases())
    changed = load_scenario("b2_calm_300", settings=first).parameters
    assert changed["wave_vessel"].peak_period == changed["winch_controller"].sea.peak_period == 6.0
    with pytest.raises(ParameterError, match=r"own\.yaml: system\.sea\.peak_period: system\.sea\.peak_period = 50"):
        load_scenario("b2_calm_300", settings=last)
    path.write_text("scenario: b2_calm_300\nset: {wave_vesel.peak_period: 6}\n")
    campaign = read_campaign(path)
    with pytest.raises(ParameterError, match=r"own\.yaml: wave_vesel\.peak_period: no such node: wave_vesel; did"):
        campaign.settings_of(next(campaign.cases()))


def test_the_draws_of_b3_say_that_they_are_not_those_of_the_promise_and_where_those_are() -> None:
    promise = "tests/campaigns/promise.py"
    repository = Path(__file__).parents[3]
    assert (repository / promise).is_file()
    for text in ((FOLDER / "b3_robustness.yaml").read_text(), (repository / "bringup" / "README.md").read_text()):
        assert promise in text
        assert "python -m tests.campaigns.promise --draws 256" in text


def test_b9_draws_cover_the_ranges_of_the_benchmark() -> None:
    cases = list(read_campaign(FOLDER / "b9_model_error.yaml").cases())
    # BENCHMARKS B9: a, b +-30 %, servo +-50 % of 0.15 s, delay 0.2 +- 0.1 s.
    ranges = {
        "winch_controller.cable_model.inertia_factor": (0.7, 1.3),
        "winch_controller.cable_model.damping_factor": (0.7, 1.3),
        "virtual_winch.time_constant": (0.075, 0.225),
        "virtual_winch.command_delay": (0.1, 0.3),
    }
    for name, (low, high) in ranges.items():
        values = np.array([case.settings[name] for case in cases if not case.is_nominal])
        assert low <= values.min() < low + 0.1 * (high - low)
        assert high - 0.1 * (high - low) < values.max() <= high
