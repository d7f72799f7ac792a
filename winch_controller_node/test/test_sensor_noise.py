"""The noise of a sensor is known from its readings alone; noise that is stated far too large is reported as well."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_core.sense_table import NOISE_READINGS
from winch_controller_node.core.estimation.sense_design import GATES
from winch_controller_node.model.estimator import Innovation

from tests.gates import Consistency, SensorNoise

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
    assert np.mean(found[2 * NOISE_READINGS :]) == pytest.approx(sigma, rel=0.06)
    assert found[GATES["fewest_noise"]] == GATES["noise_unknown"] * 0.01


def told_of(sigma, count):
    """Return the reports in `count` readings of a sensor whose noise is assumed to be 0.01 and is `sigma`."""
    noise = SensorNoise(0.01, DT)
    news = []
    for value in waves(count) + sigma * np.random.default_rng(1).standard_normal(count):
        noise.add(float(value))
        news.append(noise.news())
    return [factor for factor in news if factor]


def test_noise_is_told_when_it_is_known_well():
    # 1.4 times the assumed noise is not reported; 30 readings show twice as much now and then, 100 hardly ever
    assert not told_of(0.014, 20000)


def test_noise_that_is_worth_telling_is_told_once():
    (factor,) = told_of(0.03, 4000)
    assert factor == pytest.approx(3.0, rel=0.25)


def test_noise_is_never_less_than_believed_and_spikes_are_none():
    noise = SensorNoise(0.01, DT)
    readings = waves(400)
    readings[::25] += 3.0
    found = [noise.add(float(value)) for value in readings]
    assert set(found[: GATES["fewest_noise"]]) == {GATES["noise_unknown"] * 0.01}
    assert set(found[2 * GATES["fewest_noise"] :]) == {0.01}


def test_a_sensor_without_noise_is_known_as_well():
    noise = SensorNoise(0.01, DT)
    assert [noise.add(1.0) for _ in range(NOISE_READINGS)][-1] == 0.01


def test_what_a_sensor_states_of_itself_counts_where_it_is_more():
    noise = SensorNoise(0.01, DT)
    assert noise.add(0.0, 0.03) == 0.03
    assert noise.add(0.0, 0.001) == 0.01
    assert noise.add(0.0) == GATES["noise_unknown"] * 0.01  # it says no more, and has not been seen for long enough


@pytest.mark.parametrize("stated", [1e300, 1e160, 10.1, np.inf, -np.inf, -1.0])
def test_an_accuracy_that_cannot_be_counts_as_not_stated(stated):
    """The limit is that of the parameter `noise`, 10 m."""
    noise, as_not_stated = SensorNoise(0.01, DT), SensorNoise(0.01, DT)
    assert noise.add(0.0, stated) == as_not_stated.add(0.0)
    assert noise.add(0.0, 10.0) == 10.0
    assert float(noise.memory[0]["noises"][noise.row]["refused"]) == stated


def test_rare_readings_are_not_judged():
    noise = SensorNoise(0.02, 1.0)
    assert {noise.add(float(value)) for value in np.random.default_rng(0).standard_normal(300)} == {0.02}


def run_b3(duration, *settings):
    """Return the record of benchmark B3 with `settings`, over a `duration` [s]."""
    scenario = load_scenario("b3_deep_900", settings=[f"all.duration={duration}", *settings])
    return ClosedLoop(loop_parameters(scenario)).run()


def told_quiet(record):
    """Return time and measurement of each alarm that a sensor is quieter than assumed."""
    return [(time, alarm.values["measurement"]) for time, alarm in record.alarms if alarm.name.startswith("NOISE_LOW")]


def test_sensors_that_are_believed_five_times_noisier_than_they_are_are_told_once_and_compensation_goes_on():
    sensors = "winch_controller.sensors"
    record = run_b3(140.0, f"{sensors}.mru.noise=0.05", f"{sensors}.mru.rate_noise=0.05", f"{sensors}.depth.noise=0.1")
    told = told_quiet(record)
    assert sorted(name for _, name in told) == ["MRU heave", "MRU heave rate", "load depth"]
    # their mean squares fall from 1 to 0.4 within half a minute (the depth sensor reads half as often), and
    # a minute more must pass
    assert all(60.0 <= time <= 120.0 for time, _ in told)
    assert record.modes[-1] == "compensating"
    (alarm,) = [alarm for _, alarm in record.alarms if alarm.values.get("measurement") == "MRU heave"]
    assert (alarm.name, alarm.values["sigma"]) == ("NOISE_LOW, MRU", 0.05)
    assert 0.0 < float(alarm.values["seen"]) < 0.05


def test_sensors_as_believed_are_not_told_also_in_a_sea_far_lower_than_believed():
    assert not told_quiet(run_b3(125.0, "wave_vessel.significant_wave_height=0.1"))


def test_noise_of_the_depth_that_has_become_known_is_not_told_as_jumps():
    """Ten times the assumed noise: before it is known, within 3 s, a reading or two look like jumps."""
    record = run_b3(60.0, "all.seed=104", "cable_sim.sensors.depth.noise=0.2")
    jumps = [
        time
        for time, alarm in record.alarms
        if alarm.name in ("SENSOR_DOUBTFUL, DEPTH: jump", "SENSOR_LOST, DEPTH: scale jump")
    ]
    assert len(jumps) <= 2
    assert all(time < 5.0 for time in jumps)
    assert [alarm.name for _, alarm in record.alarms].count("SENSOR_DOUBTFUL, DEPTH: noise") == 1


def test_a_reading_that_comes_back_into_its_band_within_the_minute_is_not_told():
    consistency = Consistency(DT)
    quiet, usual = ({"mru_heave": Innovation(0.0, 1.0, nis, accepted=True)} for nis in (0.0, 1.0))
    told = []
    for seconds, innovations in ((60.0, quiet), (60.0, usual), (60.0, quiet)):
        for _ in range(round(seconds / DT)):
            consistency.add(innovations)
            told.append(consistency.newly_quiet())
    # it takes 18 s to fall to 0.4
    assert not any(told)
    for _ in range(round(60.0 / DT)):
        consistency.add(quiet)
        told.append(consistency.newly_quiet())
    (news,) = [news for news in told if news]
    assert list(news) == ["mru_heave"]


def test_a_reading_that_goes_on_from_those_before_is_no_spike_however_far_it_is_from_its_prediction():
    """A unit of 1 m in 10 s, read four times a second: its third difference is 4 mm, that of a spike the spike."""
    noise = SensorNoise(0.01, DT)
    for k in range(40):
        noise.add(np.sin(0.2 * np.pi * 0.25 * k))
        assert k < 3 or not noise.stands_out(0.3)
    noise.add(np.sin(0.2 * np.pi * 0.25 * 40) - 0.3)
    assert noise.stands_out(-0.3)


def test_of_the_first_three_readings_it_is_not_known_how_they_go_on():
    noise = SensorNoise(0.01, DT)
    for value in (0.0, 1.0, 0.0):
        noise.add(value)
        assert noise.stands_out(5.0)
