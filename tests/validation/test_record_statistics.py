import math

import numpy as np
import pytest
from wave_vessel_node.sea.realisation import draw_components
from wave_vessel_node.sea.spectra import Bretschneider, Jonswap

from tests.validation.record_statistics import record_statistics

DT = 0.5


def gaussian_record(sea, duration, seed):
    """Return a record that is Gaussian and not of our making: inverse FFT of random lines."""
    generator = np.random.default_rng(seed)
    count = round(duration / DT)
    omega = 2 * math.pi * np.fft.rfftfreq(count, DT)
    sigma = np.sqrt(0.5 * sea.density(omega) * omega[1])
    lines = sigma * (generator.standard_normal(omega.size) + 1j * generator.standard_normal(omega.size))
    return np.fft.irfft(lines, count) * count / math.sqrt(2.0)


def test_intervals_hold_the_target_as_often_as_they_say():
    # 60 Gaussian seas of half an hour: 95 % is 57, and 50 is 3.5 sigma of the binomial below it
    sea = Bretschneider(2.0, 8.0)
    inside = np.zeros(4)
    for seed in range(60):
        statistics = record_statistics(gaussian_record(sea, 1800.0, seed), DT, sea)
        names = ("m0", "m2", "significant_wave_height", "zero_crossing_period")
        inside += [getattr(statistics, name).is_inside for name in names]
    assert (inside >= 50).all()
    assert (inside < 60).any()


@pytest.mark.parametrize("sea", [Bretschneider(2.0, 9.0), Jonswap(3.0, 12.0)], ids=["bretschneider", "jonswap"])
def test_a_realisation_of_components_lies_in_the_intervals(sea):
    components = draw_components(sea, 600, np.random.default_rng(1))
    time = np.arange(1, 7201) * DT
    record = np.zeros(time.size)
    for a, w, p in zip(components.amplitude, components.frequency, components.phase, strict=True):
        record += a * np.cos(w * time + p)
    statistics = record_statistics(record, DT, sea)
    for name in ("m0", "m2", "significant_wave_height", "zero_crossing_period", "peak_period"):
        assert getattr(statistics, name).is_inside, name


def test_another_sea_lies_outside():
    sea = Bretschneider(2.0, 8.0)
    statistics = record_statistics(gaussian_record(sea, 7200.0, 1), DT, Bretschneider(2.4, 9.0))
    assert not statistics.significant_wave_height.is_inside
    assert not statistics.zero_crossing_period.is_inside
