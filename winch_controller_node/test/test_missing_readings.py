"""A loop without some readings: of the rate, as most formats of motion sensors are, and of the depth in a move."""

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


# a depth sensor that is lost during a move


MOVES, LOST, END = 40.0, 46.0, 48.0


def test_a_move_goes_on_without_a_jerk_where_the_depth_sensor_is_lost():
    """125 t on 900 m trail 4 m of rope by a third of a metre: none of it is to be made up for, seen or unseen."""
    settings = [
        f"all.duration={END}",
        "all.transient=30",
        "system.sea.significant_wave_height=0.1",
        f"winch_controller.programme.move_times=[{MOVES}]",
        "winch_controller.programme.move_payouts=[4.0]",
        *(f"cable_sim.sensors.depth.faults.{key}" for key in ("kind=[gap]", f"start=[{LOST}]", "duration=[30.0]")),
        "cable_sim.sensors.depth.faults.magnitude=[0.0]",
    ]
    loop = ClosedLoop(loop_parameters(load_scenario("b3_deep_900", settings=settings)))
    rates = []
    loop.run(lambda tick, outputs: rates.append(outputs.order.payout_rate))
    assert loop.controller.observer.gates["depth"].is_lost
    after = np.array(rates[round(LOST / 0.05) :])
    assert np.abs(after).max() < 0.7, "1.5 m/s where the bound of what is unseen took the known swing for an error"
