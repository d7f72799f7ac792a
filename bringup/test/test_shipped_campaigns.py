"""Every shipped campaign reads, and every case of it is a legal run."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from heave_bringup.campaign.plan import as_settings, read_campaign
from heave_bringup.scenarios import load_scenario

FOLDER = Path(str(resources.files("heave_bringup"))) / "campaigns"
FILES = sorted(FOLDER.glob("*.yaml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_cases_are_legal_settings_of_the_scenario(path: Path) -> None:
    campaign = read_campaign(path)
    cases = list(campaign.cases())
    assert len(cases) in (4, 8, 65)
    for case in cases[:8]:
        settings = as_settings({**campaign.common, **case.settings})
        load_scenario(campaign.scenario, settings=settings, common={"seed": case.seed})


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
