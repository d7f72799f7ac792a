"""What `heave import` says of the motion that it took."""

import json
import math

import numpy as np
import pytest
from heave_bringup.cli import main


@pytest.fixture
def imported(tmp_path, capsys):
    """Return a function: heave at 10 Hz in, what the command prints and its JSON out."""

    def run(heave):
        log, mapping, result = tmp_path / "log.csv", tmp_path / "mapping.yaml", tmp_path / "result.json"
        rows = "\n".join(f"{0.1 * i:.1f},{z:.6f}" for i, z in enumerate(heave))
        log.write_text(f"time_s,heave\n{rows}\n")
        mapping.write_text("heave: {column: heave}\n")
        arguments = ["--mapping", str(mapping), "--output", str(tmp_path / "sea.csv"), "--json", str(result)]
        assert main(["import", str(log), *arguments]) == 0
        return capsys.readouterr().out, json.loads(result.read_text())

    return run


def test_height_and_period_of_the_record_are_told_with_their_intervals(imported):
    # a swell of 0.5 m amplitude and 10 s: 4 sigma = 4 * 0.5 / sqrt(2) m
    text, result = imported(0.5 * np.sin(2.0 * math.pi / 10.0 * 0.1 * np.arange(12_000)))
    assert result["significant_heave_m"] == pytest.approx(2.0 / math.sqrt(2.0), rel=1e-3)
    assert result["peak_period_s"] == pytest.approx(10.0, rel=0.01)
    low, high = result["significant_heave_interval_m"]
    assert low < result["significant_heave_m"] < high
    assert "significant heave 1.41 m (" in text
    assert "peak period 10.0 s (" in text


def test_a_record_too_short_for_them_says_so(imported):
    text, result = imported(np.sin(0.1 * np.arange(1000)))
    assert "no significant height and peak period: a record of 99.95 s is too short" in text
    assert result["peak_period_s"] is None


def test_a_record_without_motion_has_no_period(imported):
    _, result = imported(np.zeros(12_000))
    assert result["significant_heave_m"] == 0.0
    assert result["peak_period_s"] is None
