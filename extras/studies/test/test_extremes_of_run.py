"""Extremes of whole records: a simulated Gaussian sea against theory, tensions to either side, seeds left out."""

import math

import numpy as np
import pytest
from heave_bags.analyse.run_record import RunRecord
from heave_bags.signals import RunSignals, Signal
from heave_studies.extremes.of_run import COLUMNS, expected_of_run, expected_of_seeds, table_rows, warnings_of

STEP, PERIOD = 0.5, 9.0


def gaussian(duration, sigma, seed):
    """Return times and a narrow-banded Gaussian process: 200 harmonics about the period, of random phase and height."""
    generator = np.random.default_rng(seed)
    time = np.arange(0.0, duration, STEP)
    omega = 2.0 * np.pi / PERIOD * generator.normal(1.0, 0.1, 200)
    height = sigma / math.sqrt(200) * generator.normal(size=(2, 200))
    turn = np.outer(time, omega)
    return time, np.cos(turn) @ height[0] + np.sin(turn) @ height[1]


@pytest.fixture(scope="module")
def record():
    time, heave = gaussian(3600.0, 0.2, seed=3)
    signals = RunSignals(unit_heave=Signal(time, 5.0 + heave), tension=Signal(time, 1e5 + 1e5 * heave))
    return RunRecord("made up", signals, 0.0, float(time[-1]))


def test_the_largest_in_three_hours_of_a_gaussian_sea_is_that_of_rayleigh_crests(record):
    """Crests and troughs count: n is twice the cycles. One hour of waves says this much of its own sigma: 5 %."""
    heave = next(one for one in expected_of_run(record, 10_800.0) if one.name.startswith("load heave"))
    sigma = float(np.std(record.signals.unit_heave.value))
    exact = sigma * math.sqrt(2.0 * math.log(2.0 * 10_800.0 / PERIOD))
    assert [estimate.method for estimate in heave.estimates] == ["block maxima", "peaks over threshold"]
    for estimate in heave.estimates:
        assert heave.value(estimate.most_probable) == pytest.approx(exact, rel=0.08)
        assert estimate.p90 > estimate.most_probable
    assert warnings_of([heave]) == []


def test_tensions_are_told_to_either_side_of_their_mean_and_a_cable_never_pushes(record):
    largest, smallest = (one for one in expected_of_run(record, 10_800.0) if one.unit == "N")
    assert largest.seen == record.signals.tension.value.max()
    assert smallest.seen == record.signals.tension.value.min()
    for estimate in largest.estimates:
        assert largest.value(estimate.most_probable) > 1.5e5
    for estimate in smallest.estimates:
        assert 0.0 < smallest.value(estimate.most_probable) < 0.5e5
    assert smallest.value(2e5) == 0.0
    rows = table_rows([largest, smallest])
    assert {len(row) for row in rows} == {len(COLUMNS)}
    assert rows[0][0] == "top tension, largest [kN]"


def test_what_one_seed_alone_is_worth_is_shown():
    deviations = np.array([1.0, 1.1, 1.05, 0.95, 1.02, 3.0])
    (found,) = expected_of_seeds({"heave": ("m", np.zeros(6), deviations, 1.0)}, 600.0, 10_800.0)
    low, high = found.without_a_seed
    # without the largest one, all the others are within 1.1
    assert low < 0.6 * found.estimates[0].most_probable <= high
    assert found.seen == 3.0
    assert "only 6 values" in warnings_of([found])[0]
    assert found.to_json()["methods"][0]["sample"] == 6
