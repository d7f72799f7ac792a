"""A motion sensor that states heave alone, as most formats of motion sensors do, is one like any other."""

import math

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.codes import SensorLevel


def run(scenario, *settings):
    """Return the record of a loop of three minutes and how the MRU is seen at its end."""
    seen = []
    settings = [*settings, "all.duration=180"]
    loop = ClosedLoop(loop_parameters(load_scenario(scenario, settings=settings)))
    record = loop.run(lambda _, outputs: seen.append(outputs))
    return record, next(one for one in seen[-1].report.sensors if one.sensor == "mru")


@pytest.mark.slow
@pytest.mark.parametrize(("scenario", "law"), [("b2_calm_300", "mpc"), ("b3_deep_900", "lqg")])
def test_the_unit_is_held_by_heave_alone_and_better_than_by_the_industrial_law_with_the_rate(scenario, law):
    alone, mru = run(scenario, f"winch_controller.law={law}", "wave_vessel.mru.measures_rate=false")
    assert (mru.level, mru.refused) == (SensorLevel.OK, 0)
    assert "no rate" in mru.reason
    industrial, mru = run(scenario, "winch_controller.law=industrial")
    assert mru.reason == ""
    assert [alarm.values.get("mode") for _, alarm in alone.alarms] == ["compensating"]
    assert alone.unit_sigma(90.0) < 0.5 * industrial.unit_sigma(90.0)
    assert alone.unit_sigma(90.0) < 0.1 * alone.uncompensated_sigma(90.0)


def test_law_feedforward_without_prediction_is_given_the_estimated_rate():
    settings = ["winch_controller.law=feedforward", "winch_controller.feedforward.prediction=false"]
    settings += ["wave_vessel.mru.measures_rate=false", "all.duration=60"]
    record = ClosedLoop(loop_parameters(load_scenario("b2_calm_300", settings=settings))).run()
    assert np.all(np.isfinite(record.column("unit")))
    assert not math.isnan(record.unit_sigma(40.0))
    assert record.unit_sigma(40.0) < 0.7 * record.uncompensated_sigma(40.0)
