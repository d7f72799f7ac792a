"""The noise of a sensor is known from its readings alone."""

import numpy as np
import pytest
from winch_controller_node.estimation.sensor_noise import FEWEST, READINGS, UNKNOWN, SensorNoise

DT = 0.05


def waves(count):
    """Heave of 2 m at 7 s."""
    return 2.0 * np.sin(0.9 * DT * np.arange(count))


@pytest.mark.parametrize("sigma", [0.02, 0.05])
def test_noise_more_than_believed_is_seen_through_a_sea(sigma):
    noise = SensorNoise(0.01, DT)
    readings = waves(8000) + sigma * np.random.default_rng(0).standard_normal(8000)
    found = [noise.add(float(value)) for value in readings]
    # 80 medians of 100 correlated magnitudes, each within some 15 %
    assert np.mean(found[2 * READINGS :]) == pytest.approx(sigma, rel=0.06)
    assert found[FEWEST] == UNKNOWN * 0.01


def test_noise_is_told_when_it_is_known_well():
    noise = SensorNoise(0.01, DT)
    news = []
    for value in waves(400) + 0.014 * np.random.default_rng(1).standard_normal(400):
        noise.add(float(value))
        news.append(noise.news())
    # 1.4 times what is believed is not worth telling; 30 readings say twice as much now and then
    assert not any(news)


def test_noise_is_never_less_than_believed_and_spikes_are_none():
    noise = SensorNoise(0.01, DT)
    readings = waves(400)
    readings[::25] += 3.0
    found = [noise.add(float(value)) for value in readings]
    assert set(found[:FEWEST]) == {UNKNOWN * 0.01}
    assert set(found[2 * FEWEST :]) == {0.01}


def test_a_sensor_without_noise_is_known_as_well():
    noise = SensorNoise(0.01, DT)
    assert [noise.add(1.0) for _ in range(READINGS)][-1] == 0.01


def test_what_a_sensor_states_of_itself_counts_where_it_is_more():
    noise = SensorNoise(0.01, DT)
    assert noise.add(0.0, 0.03) == 0.03
    assert noise.add(0.0, 0.001) == 0.01
    assert noise.add(0.0) == UNKNOWN * 0.01  # it says no more, and has not been seen for long enough


def test_rare_readings_are_not_judged():
    noise = SensorNoise(0.02, 1.0)
    assert {noise.add(float(value)) for value in np.random.default_rng(0).standard_normal(300)} == {0.02}
