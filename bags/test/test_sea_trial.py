"""A bag of a ship, on which nobody knows the truth: its figures come from sensors and estimates, and say so."""

import math
from pathlib import Path

import numpy as np
import pytest
from heave_bags.analyse import analysis, kpi_set
from heave_bags.analyse.kpi_set import MOTIONS_OF, source_of
from heave_bags.analyse.read_run import read_run
from heave_bags.analyse.reading.unit_height import measured_height
from heave_bags.mcap.bag_writer import BagWriter
from heave_bags.report.report import render
from heave_bags.signals import Signal
from heave_msgs.msg import ControllerState, LoadCell, MruSample, WinchState
from heave_node.interface.sensors import STANDARD_WATER
from heave_node.numerics.constants import ATMOSPHERIC_PRESSURE
from heave_node.tick.tick import stamp_of
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure

TICK, DURATION, OMEGA = 0.05, 60.0, 2.0 * math.pi / 10.0
UNIT, FREE, TIP = 0.02, 0.4, 1.0
"""Amplitudes of the estimated and the uncompensated unit and of the measured boom tip [m]; s = amplitude/sqrt(2)."""
TYPES = {
    "/controller/state": ControllerState,
    "/mru": MruSample,
    "/winch/state": WinchState,
    "/winch/load_cell": LoadCell,
    "/unit/pressure": FluidPressure,
}
DEPTH = 50.0


@pytest.fixture(scope="module")
def sea_trial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("trial") / "bag"
    writer = BagWriter(folder)
    for topic, kind in TYPES.items():
        package = "sensor_msgs" if kind is FluidPressure else "heave_msgs"
        writer.add_topic(topic, f"{package}/msg/{kind.__name__}")
    for number in range(1, round(DURATION / TICK) + 1):
        time = number * TICK
        wave, wave_rate = math.sin(OMEGA * time), OMEGA * math.cos(OMEGA * time)
        state = ControllerState(mode="compensating")
        state.predicted_unit_heave, state.predicted_uncompensated_heave = UNIT * wave, FREE * wave
        winch = WinchState(payout=math.nan, payout_rate=math.nan, payout_acceleration=math.nan, tension=math.nan)
        winch.encoder_payout, winch.encoder_payout_rate = 0.9 * wave, 0.9 * wave_rate
        pressure = ATMOSPHERIC_PRESSURE + STANDARD_WATER.pressure_per_metre * (DEPTH - UNIT * wave)
        messages = [state, MruSample(heave=TIP * wave), winch, LoadCell(tension=1e5 + 1e3 * wave)]
        messages += [FluidPressure(fluid_pressure=pressure)]
        for topic, message in zip(TYPES, messages, strict=True):
            message.header.stamp = stamp_of(round(time * 1e9))
            writer.write(topic, round(time * 1e9), bytes(serialize_message(message)))
    writer.close()
    return folder


def test_every_figure_of_merit_of_a_ship_is_known_without_the_truth(sea_trial):
    values = read_run(sea_trial).kpis()
    # of sines over whole periods
    assert values["unit_sigma_m"] == pytest.approx(UNIT / math.sqrt(2.0), rel=1e-3)
    assert values["unit_efficiency"] == pytest.approx(1.0 - UNIT / FREE, rel=1e-3)
    assert values["outlet_efficiency"] == pytest.approx(0.9, rel=1e-3)
    assert values["tension_max_n"] == pytest.approx(1.01e5, rel=1e-4)
    assert values["winch_speed_max_mps"] == pytest.approx(0.9 * OMEGA, rel=1e-3)
    assert values["compensating_percent"] == 100.0


def test_each_figure_says_what_it_is_made_from(sea_trial):
    record = read_run(sea_trial)
    assert record.sources == {
        "load heave": "estimated",
        "load heave, winch locked": "estimated",
        "boom-tip heave": "measured",
        "top tension": "measured",
        "payout": "measured",
        "unit height": "measured",
    }
    assert record.signals.unit_height.value.mean() == pytest.approx(-DEPTH, abs=0.01)
    rows = {line[:40].strip(): line for line in analysis.table([record]).splitlines()}
    assert any(
        "efficiency at the load" in name and line.endswith("%  estimated by the controller's own sensors")
        for name, line in rows.items()
    )
    assert any(
        "efficiency of the rope at the boom tip" in name and line.endswith("%  measured") for name, line in rows.items()
    )
    assert "the true values were not recorded" in analysis.table([record])
    assert "<small>estimated</small>" in render([record])
    assert "estimated by the controller&#39;s own sensors</span>" in render([record])  # beside the largest figures
    assert 'title="estimated by the controller&#39;s own sensors"' in render([record])
    assert analysis.to_json(record)["sources"] == record.sources


def test_a_figure_is_as_certain_as_the_least_certain_of_its_motions():
    sources = {"load heave": "true", "load heave, winch locked": "estimated"}
    assert source_of("unit_efficiency", sources) == "estimated"
    assert source_of("unit_sigma_m", sources) == "true"
    assert source_of("missed_deadlines", sources) == ""


def test_every_name_of_a_figure_with_a_source_is_one():
    assert set(MOTIONS_OF) <= set(kpi_set.DEFINITION_OF)
    assert all(MOTIONS_OF.values())


def test_a_depth_sensor_in_air_leaves_the_height_to_the_drum():
    """Lowered at 1 m/s from 10.3 m above the surface; payout counts from elsewhere."""
    time = np.arange(0.0, 30.0)
    depth = time - 10.3
    pressure = ATMOSPHERIC_PRESSURE + STANDARD_WATER.pressure_per_metre * np.maximum(depth, 0.0)
    found = measured_height(Signal(time, pressure), Signal(time, time + 5.0), STANDARD_WATER)
    assert found.value == pytest.approx(-depth)
    wet = measured_height(Signal(time, pressure), Signal(), STANDARD_WATER)
    assert wet.value == pytest.approx(-depth[depth > 1.0])
