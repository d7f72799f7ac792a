"""Never worse than off: a sample of the campaign `tests.campaigns.promise`, and how it judges."""

import math

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario

from tests.campaigns.promise import (
    LARGEST,
    PLAIN,
    SCENARIO,
    WINDOW,
    Draw,
    draw,
    is_wrong,
    parameters_of,
    run,
    worst_window,
)


def test_the_worst_window_is_found_where_it_is():
    """Unit and uncompensated unit are sines of whole periods in a window; between 100 and 160 s the unit doubles."""
    time = 0.1 * np.arange(3000)
    off = np.sin(2.0 * math.pi * time / 10.0)
    unit = 0.3 * off * np.where((time >= 100.0) & (time < 100.0 + WINDOW), 2.0, 1.0)
    ratio, at = worst_window(time, unit, off, 54.0)
    assert ratio == pytest.approx(0.6, rel=1e-6)
    assert at == pytest.approx(100.0, abs=1.0)
    assert worst_window(time, unit, off, 170.0)[0] == pytest.approx(0.3, rel=1e-6)


@pytest.mark.parametrize(
    ("words", "truth", "wrong"),
    [
        ("winch model updated: acceleration limit 0.776 m/s^2 (was 1.500)", PLAIN["acceleration 0.8"], False),
        ("winch model updated: acceleration limit 0.776 m/s^2 (was 1.500)", {}, True),
        ("winch model updated: speed limit 0.9 m/s (was 2.000), by its power limit", PLAIN["power 100 kW"], False),
        ("winch model updated: gain 0.950 (was 1.000)", PLAIN["speed 1.0"], True),
        ("mru suspect: its heave has a high-pass", PLAIN["high-pass 30 s"], False),
        ("depth suspect: its readings contradict all others", PLAIN["high-pass 30 s"], True),
        ("noise of mru_heave is 0.05, 5.0 times what is believed", PLAIN["MRU noise x5"], False),
    ],
)
def test_an_alarm_is_wrong_that_names_what_is_as_believed(words, truth, wrong):
    assert is_wrong(words, truth) is wrong


def test_a_draw_is_the_same_each_time_and_none_is_beyond_its_range():
    for number in range(200):
        one = draw(number)
        assert one == draw(number)
        assert 0.75 <= one.settings["virtual_winch.acceleration_limit"] <= 1.65
        assert one.settings["wave_vessel.significant_wave_height"] in (1.5, 1.8, 2.8)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["acceleration 0.8", pytest.param("high-pass 30 s", marks=pytest.mark.long)], ids=["limit", "high-pass"]
)
def test_a_wrong_belief_is_found_out_before_it_does_harm(name):
    found = run(Draw(name, 1, PLAIN[name]), duration=150.0)
    assert found.worst < LARGEST
    assert not found.wrong
    assert found.fades == 0


@pytest.mark.parametrize("number", [0, 7])
def test_a_noisy_sensor_is_not_blamed_before_its_noise_is_known(number):
    """Depth sensors with four to five times the noise believed were suspect for spikes in its first 10 s."""
    scenario = load_scenario(SCENARIO, settings=parameters_of(draw(number), duration=11.0))
    alarms = [words for _, words in ClosedLoop(loop_parameters(scenario)).run().alarms]
    assert any(words.startswith("noise of unit_heave") for words in alarms)
    assert not any("suspect" in words for words in alarms)
