"""Every shipped study opens: its cases are legal runs, and its answer is one that there is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heave_bringup.scenarios import load_scenario
from heave_node.files.given_files import shipped_files
from heave_node.parameters import ParameterError
from heave_studies.kinds import Options, open_study
from heave_studies.study.study_file import FOLDER, read_study

PACKAGES = {"worst_case": "cma", "extremes": "pyextremes"}
"""What a study needs that may be missing."""


@pytest.mark.parametrize("name", shipped_files(FOLDER))
def test_it_opens(name: str, tmp_path: Path) -> None:
    if name in PACKAGES:
        pytest.importorskip(PACKAGES[name])
    opened = open_study(Options(name, folder=tmp_path))
    jobs = next(opened.kind.rounds({}))
    assert opened.kind.size >= len(jobs) > 0
    numbers = [job.number for job in jobs]
    assert numbers[0] in (1, -1)  # a screening is numbered by its first case, below 0
    assert sorted(set(numbers), key=abs) == numbers
    assert opened.kind.identity == open_study(Options(name, folder=tmp_path)).kind.identity


def test_a_place_that_is_none_is_told_with_the_study_that_has_it(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text("scenario: b2_calm_300\nvary: {system.sea.peak_period: [6, 50]}\n")
    first, last = (read_study(path).settings_of(case) for case in read_study(path).cases())
    changed = load_scenario("b2_calm_300", settings=first).parameters
    assert changed["wave_vessel"].peak_period == changed["winch_controller"].sea.peak_period == 6.0
    with pytest.raises(ParameterError, match=r"own\.yaml: system\.sea\.peak_period = 50"):
        load_scenario("b2_calm_300", settings=last)


def test_model_error_covers_the_ranges_of_the_benchmark() -> None:
    cases = list(read_study(shipped_files(FOLDER)["model_error"]).cases())
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
