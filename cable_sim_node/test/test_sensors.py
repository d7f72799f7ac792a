"""Sensors measure when they should, deliver late, are as noisy as they say, and fail as ordered."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.node import CableSimNode
from cable_sim_node.sensors.instruments import (
    DepthSensorParameters,
    ImuParameters,
    LoadCellParameters,
    SensorParameters,
    SensorsParameters,
    SensorTruth,
    UsblParameters,
    VelocitySensorParameters,
    View,
)
from cable_sim_node.sensors.suite import SensorSuite
from heave_node.interface.faults import FaultParameters
from heave_node.interface.sensors import SENSORS, Reading
from heave_node.parameters import ParameterError, build_parameters
from heave_node.sensing.sensor import Sensor
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

TICK = 0.05


TRUTH = SensorTruth(
    position=np.array([3.0, 4.0, -300.0]),
    velocity=np.array([0.1, 0.2, -0.3]),
    acceleration=np.array([0.5, 0.0, -1.0]),
    drum_tension=36_500.0,
    static_top_tension=36_500.0,
    gravity=9.83,
)


@dataclasses.dataclass(frozen=True)
class Probe(SensorParameters):
    """A sensor of one value that sees the tension."""

    sigma: float = 0.0

    def view(self, truth: SensorTruth) -> View:
        return View(np.array([truth.drum_tension]), self.sigma)


def probe(parameters: Probe, seed: int = 1) -> Sensor:
    return Sensor(parameters, name="probe", node="cable_sim", width=1, seed=seed, tick_period=TICK)


def run(parameters: Probe, ticks: int, *, seed: int = 1) -> list[tuple[int, Reading]]:
    """Let a probe see the time in place of the tension; return the delivered readings and the ticks of delivery."""
    sensor = probe(parameters, seed)
    truths = ((k, TRUTH._replace(drum_tension=k * TICK)) for k in range(1, ticks + 1))
    return [(k, reading) for k, truth in truths for reading in sensor.step(k, truth)]


def with_fault(
    kind: str, *, start: float = 2.0, duration: float = 1.0, magnitude: float = 0.0, sigma: float = 0.0
) -> Probe:
    faults = FaultParameters((kind,), (start,), (duration,), (magnitude,))
    return Probe(rate=10.0, latency=0.1, faults=faults, sigma=sigma)


@pytest.mark.parametrize("rate", [1.0, 5.0, 10.0, 20.0, 7.0, 0.5, 1000.0])
def test_number_of_samples_is_the_rate_times_the_time_and_at_most_one_a_tick(rate: float) -> None:
    readings = run(Probe(rate=rate), 2000)
    assert len(readings) == pytest.approx(min(rate, 1.0 / TICK) * 100.0, abs=1)
    stamps = [reading.time for _, reading in readings]
    assert stamps == sorted(set(stamps))


@pytest.mark.parametrize("latency", [0.0, 0.1, 0.12, 1.0])
def test_reading_keeps_the_time_of_measurement_and_comes_at_the_first_tick_after_the_latency(latency: float) -> None:
    for tick, reading in run(Probe(rate=10.0, latency=latency), 400):
        assert reading.value[0] == reading.time
        assert -1e-9 <= tick * TICK - (reading.time + latency) < TICK - 1e-9


def test_noise_is_white_normal_and_of_the_stated_deviation() -> None:
    sigma = 0.02
    readings = run(Probe(rate=20.0, sigma=sigma), 20_000)
    errors = np.array([reading.value[0] - reading.time for _, reading in readings])
    low, high = stats.chi2.ppf([0.0005, 0.9995], len(errors)) / len(errors)
    middle = 0.5 * (low + high)
    assert np.mean(errors**2) / sigma**2 == pytest.approx(middle, abs=high - middle)
    assert stats.kstest(errors / sigma, "norm").pvalue > 1e-3
    assert abs(np.corrcoef(errors[1:], errors[:-1])[0, 1]) < 4.0 / math.sqrt(len(errors))
    assert all(reading.sigma[0] == sigma for _, reading in readings)


def test_same_seed_same_noise_and_another_seed_another() -> None:
    first, again, other = ([r.value[0] for _, r in run(Probe(sigma=0.1), 200, seed=seed)] for seed in (3, 3, 4))
    assert first == again
    assert first != other


def test_scale_error_is_relative() -> None:
    for _, reading in run(Probe(scale_error=0.05), 100):
        assert reading.value[0] == pytest.approx(1.05 * reading.time)


def test_freeze_repeats_the_last_value_with_fresh_stamps() -> None:
    readings = [r for _, r in run(with_fault("freeze"), 100)]
    frozen = [r for r in readings if 2.0 - 1e-9 <= r.time < 3.0 - 1e-9]
    assert len(frozen) == 10
    assert [r.value[0] for r in frozen] == pytest.approx([1.9] * 10)
    assert all(r.value[0] == r.time for r in readings if r not in frozen)


def test_gap_takes_no_samples() -> None:
    stamps = [r.time for _, r in run(with_fault("gap"), 100)]
    assert not [stamp for stamp in stamps if 2.0 - 1e-9 <= stamp < 3.0 - 1e-9]
    assert len(stamps) == pytest.approx(40, abs=1)


def test_spike_spoils_one_sample_and_jump_all_of_its_duration() -> None:
    spike = [r.value[0] - r.time for _, r in run(with_fault("spike", magnitude=5.0), 100)]
    assert sorted(spike)[-2:] == [0.0, pytest.approx(5.0)]
    jump = [r for _, r in run(with_fault("jump", magnitude=-3.0), 100)]
    assert [r.time for r in jump if r.value[0] != r.time] == pytest.approx(np.arange(2.0, 3.0, 0.1))


@pytest.mark.parametrize("factor", [-1.0, 0.5])
def test_scale_multiplies_the_samples_of_its_duration(factor: float) -> None:
    for _, reading in run(with_fault("scale", magnitude=factor), 100):
        is_scaled = 2.0 - 1e-9 <= reading.time < 3.0 - 1e-9
        assert reading.value[0] == pytest.approx((factor if is_scaled else 1.0) * reading.time, rel=1e-12)


def test_nan_fault_delivers_nan() -> None:
    bad = [r.time for _, r in run(with_fault("nan"), 100) if math.isnan(r.value[0])]
    assert bad == pytest.approx(np.arange(2.0, 3.0, 0.1))


def test_rate_fault_changes_the_rate_while_it_lasts() -> None:
    stamps = np.array([r.time for _, r in run(with_fault("rate", duration=10.0, magnitude=1.0), 400)])
    np.testing.assert_allclose(stamps[(stamps > 1.95) & (stamps < 11.95)], np.arange(2.0, 12.0, 1.0))
    np.testing.assert_allclose(np.diff(stamps[stamps > 12.05]), 0.1)


def test_delay_fault_makes_readings_later_and_keeps_their_stamps() -> None:
    for tick, reading in run(with_fault("delay", magnitude=0.5), 200):
        is_late = 2.0 - 1e-9 <= reading.time < 3.0 - 1e-9
        assert tick * TICK - reading.time == pytest.approx(0.6 if is_late else 0.1)


def test_fault_without_duration_lasts_to_the_end() -> None:
    readings = run(with_fault("jump", duration=0.0, magnitude=1.0), 400)
    assert all(r.value[0] == pytest.approx(r.time + 1.0) for _, r in readings if r.time > 2.0 - 1e-9)


def test_jitter_fault_makes_readings_late_each_by_its_own_time_and_keeps_their_stamps() -> None:
    lates = {round(r.time, 9): tick * TICK - r.time for tick, r in run(with_fault("jitter", magnitude=0.5), 200)}
    jittered = [late for stamp, late in lates.items() if 2.0 <= stamp < 3.0]
    assert len(jittered) == 10
    assert len({round(late, 9) for late in jittered}) > 3
    assert all(0.1 - 1e-9 <= late <= 0.6 + TICK for late in jittered)  # latency, and the tick in which it arrives
    assert all(late == pytest.approx(0.1) for stamp, late in lates.items() if not 2.0 <= stamp < 3.0)


@pytest.mark.parametrize("kind", ["freeze", "gap", "spike", "jump", "scale", "nan", "rate", "delay", "jitter"])
def test_fault_of_one_sensor_leaves_the_noise_of_all_other_samples_as_it_was(kind: str) -> None:
    def errors(parameters: Probe) -> dict[float, float]:
        return {r.time: r.value[0] for _, r in run(parameters, 200) if not 1.99 < r.time < 3.01}

    healthy = errors(Probe(rate=10.0, latency=0.1, sigma=0.1))
    assert errors(with_fault(kind, magnitude=1.0, sigma=0.1)) == healthy


def test_fault_injected_during_the_run_acts_and_can_be_cleared() -> None:
    sensor = probe(Probe(rate=20.0))
    values = []
    for k in range(1, 61):
        if k == 20:
            sensor.faults.inject("jump", start=k * TICK, magnitude=2.0)
        if k == 40:
            sensor.faults.inject("clear", start=k * TICK)
        values += [r.value[0] - TRUTH.drum_tension for r in sensor.step(k, TRUTH)]
    assert values == pytest.approx([0.0] * 19 + [2.0] * 20 + [0.0] * 21)


def test_every_sensor_of_the_plant_is_in_the_table_of_the_suite_and_the_other_way_round() -> None:
    in_table = [name for name, sensor in SENSORS.items() if sensor.topic.publisher == CableSimNode.name]
    assert list(SensorsParameters().by_name()) == in_table


@pytest.mark.parametrize("name", SensorsParameters().by_name())
def test_every_sensor_sees_as_many_values_as_its_messages_hold(name: str) -> None:
    view = SensorsParameters().by_name()[name].view(TRUTH)
    assert view.value.shape == (SENSORS[name].width,)


def fault_values(sensor: str, kind: str) -> dict[str, object]:
    columns = {"kind": kind, "start": 0.0, "duration": 0.0, "magnitude": 0.0}
    return {f"{sensor}.faults.{name}": [value] for name, value in columns.items()}


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"depth.faults.kind": ["gap"], "depth.faults.start": [1.0]},
            "sensors.depth.faults: the lists kind, start, duration and magnitude must have the same length; "
            "got 1, 1, 0, 0",
        ),
        ({"depth.faults.kind": ["melt"]}, "depth.faults.kind = 'melt' is not allowed"),
        ({"depth.noise": -0.1}, "depth.noise = -0.1 is not allowed"),
        (
            fault_values("usbl", "drive"),
            "usbl.faults.kind = 'drive' is not allowed: it must be a list of any number of values, each one of freeze,",
        ),
        (fault_values("imu", "rate"), "sensors.imu.faults: the magnitude of kind rate must be above 0 Hz; got 0"),
    ],
)
def test_wrong_sensor_parameters_are_refused_in_one_line(values: dict[str, object], message: str) -> None:
    with pytest.raises(ParameterError) as raised:
        build_parameters(SensorsParameters, values, where="my.yaml: cable_sim")
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


QUIET = SensorsParameters(
    depth=DepthSensorParameters(noise=0.0, latency=0.0, bias=0.3),
    velocity=VelocitySensorParameters(noise=0.0, latency=0.0, rate=20.0),
    imu=ImuParameters(noise=0.0, gyro_noise=0.0),
    usbl=UsblParameters(noise=0.0, range_noise=0.0, latency=0.25, rate=20.0),
    load_cell=LoadCellParameters(noise=0.0),
)


def suite(parameters: SensorsParameters) -> SensorSuite:
    return SensorSuite(parameters, seed=1, tick_period=TICK)


def test_each_sensor_sees_its_own_truth() -> None:
    readings = suite(QUIET).step(2, TRUTH)
    assert readings["depth"][0].value == pytest.approx([300.3])
    assert readings["velocity"][0].value == pytest.approx([0.1, 0.2, -0.3])
    # At rest an accelerometer shows gravity upwards, that of the place: 9.83 - 1.
    assert readings["imu"][0].value == pytest.approx([0.5, 0.0, 8.83, 0.0, 0.0, 0.0])
    assert readings["load_cell"][0].value == pytest.approx([36_500.0])
    assert readings["usbl"] == ()


def test_a_sensor_that_is_not_fitted_gives_nothing_and_leaves_the_others_as_they_were() -> None:
    whole = suite(SensorsParameters())
    parts = suite(
        dataclasses.replace(
            SensorsParameters(), imu=ImuParameters(fitted=False), velocity=VelocitySensorParameters(fitted=False)
        )
    )
    assert "imu" not in parts.by_name
    for k in range(1, 100):
        both, one = whole.step(k, TRUTH), parts.step(k, TRUTH)
        assert set(one) == {"depth", "usbl", "load_cell"}
        assert [reading.value[0] for reading in one["depth"]] == [reading.value[0] for reading in both["depth"]]
        assert [reading.value[0] for reading in one["load_cell"]] == [reading.value[0] for reading in both["load_cell"]]


def test_usbl_comes_after_the_two_way_travel_of_sound_and_its_noise_grows_with_range() -> None:
    sensors = suite(QUIET)
    deliveries = [k for k in range(1, 40) if sensors.step(k, TRUTH)["usbl"]]
    # Slant range 300.04 m: 2 * 300.04 / 1500 + 0.25 = 0.65006 s after the first sample, at 0.05 s; next is tick 15.
    assert deliveries[0] == 15
    noisy = suite(dataclasses.replace(QUIET, usbl=UsblParameters(noise=0.1, range_noise=0.003, rate=20.0)))
    sigma = next(r["usbl"][0].sigma[0] for r in (noisy.step(k, TRUTH) for k in range(1, 40)) if r["usbl"])
    assert sigma == pytest.approx(math.hypot(0.1, 0.003 * math.sqrt(300.0**2 + 25.0)))


FAULT = st.tuples(
    st.sampled_from(["freeze", "gap", "spike", "jump", "scale", "nan", "rate", "delay", "jitter"]),
    st.floats(0.0, 10.0),
    st.floats(0.0, 5.0),
    st.floats(0.1, 30.0),
)


@settings(max_examples=60, deadline=None)
@given(faults=st.lists(FAULT, max_size=5), rate=st.floats(0.1, 50.0), latency=st.floats(0.0, 2.0))
def test_whatever_the_faults_readings_are_of_the_past_and_of_distinct_times(
    faults: list[tuple[str, float, float, float]], rate: float, latency: float
) -> None:
    columns = tuple(zip(*faults, strict=True)) or ((), (), (), ())
    parameters = Probe(rate=rate, latency=latency, faults=FaultParameters(*columns))
    stamps = []
    for tick, reading in run(parameters, 300):
        assert reading.time + latency <= tick * TICK + 1e-8
        stamps.append(reading.time)
    assert len(stamps) == len(set(stamps))


def test_depth_is_read_in_whole_steps_of_the_resolution() -> None:
    of_run = {"name": "depth", "node": "cable_sim", "width": 1, "seed": 1, "tick_period": TICK}
    exact, coarse = (Sensor(DepthSensorParameters(resolution=step), **of_run) for step in (0.0, 0.05))
    pairs = [
        (one, other)
        for tick in range(1, 400)
        for one, other in zip(exact.step(tick, TRUTH), coarse.step(tick, TRUTH), strict=True)
    ]
    assert len(pairs) > 100
    for one, other in pairs:
        assert other.value[0] == pytest.approx(0.05 * round(one.value[0] / 0.05))
