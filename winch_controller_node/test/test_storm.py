"""A sensor lost in a storm: what follows is orderly, and the cable none the worse for the compensation."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario, make_scenario
from heave_node.kpi import snap_times

from tests.supervised import HARMFUL
from tests.validation.peers.reference_systems import DEEP_900

DT = 0.05
SEA = {"significant_wave_height": 6.0, "peak_period": 12.0}
LOST = 80.0
FADE = 10.0
COAST = 1.5
"""Time for which the prediction of the boom tip is followed [s]."""


def test_the_shipped_storm_has_a_highest_tension_that_bounds_what_compensation_does_and_an_alarm_below_it():
    """Twice the static tension, a crane of 20 t with 10 t on it; uncompensated, it is exceeded from the first waves on.

    A highest tension that the sea takes the cable to every few waves would cost compensation more than it spares.
    """
    settings = ["all.duration=200", "all.seed=1"]
    loop = ClosedLoop(loop_parameters(load_scenario("b5_storm", settings=settings)))
    static = loop.controller.design.cable.static_tension
    assert loop.controller.design.limits.maximum_tension == pytest.approx(2.0 * static)
    assert static == pytest.approx(98.6e3, rel=0.01)
    record = loop.run()
    told = [alarm for _, alarm in record.alarms if alarm.name == "TENSION_HIGH"]
    assert told
    assert all(alarm.values["limit"] == 1.5 for alarm in told)
    highest, without = (np.max(record.column(name, after=60.0)) for name in ("top_tension", "uncompensated_tension"))
    assert highest < 2.0 * static < without
    assert record.unit_sigma(60.0) < 0.5 * record.uncompensated_sigma(60.0)


@pytest.mark.slow
def test_an_mru_lost_in_a_storm_leaves_a_unit_that_the_depth_sensor_damps_without_a_jerk_and_without_a_snap():
    record = ClosedLoop(
        loop_parameters(
            make_scenario(
                {
                    "/**": {"seed": 2, "duration": 120.0},
                    "wave_vessel": SEA
                    | {"ramp": 20.0, "vessel.natural_frequency": 0.9, "vessel.damping_ratio": 0.4}
                    | {"mru.faults.kind": ["gap"], "mru.faults.start": [LOST]}
                    | {"mru.faults.duration": [60.0], "mru.faults.magnitude": [0.0]},
                    "cable_sim": {**DEEP_900} | {"segments": 12},
                    "virtual_winch": {},
                    "winch_controller": {**DEEP_900} | {f"sea.{name}": value for name, value in SEA.items()},
                }
            )
        )
    ).run()
    time, rate, authority = (record.column(name) for name in ("time", "payout_rate", "authority"))
    assert set(record.modes[round((LOST + COAST + 0.5) / DT) :]) == {"fade_out"}
    assert np.max(np.abs(np.diff(authority))) <= DT / FADE + 1e-9
    # the winch: 2 m/s and 1.5 m/s^2
    assert np.max(np.abs(rate)) <= 2.0 + 1e-9
    assert np.max(np.abs(np.diff(rate))) <= 1.5 * DT + 1e-9
    blind = time > LOST + COAST + FADE
    unit, off = record.column("unit"), record.column("uncompensated")
    assert np.std(unit[blind]) < np.std(off[blind])
    static = record.column("top_tension")[0]
    snaps, without = (
        snap_times(time, record.column(name), static) for name in ("top_tension", "uncompensated_tension")
    )
    assert len(snaps) <= len(without)
    # uncompensated, this sea takes the cable beyond what it carries in that time
    during = (time > LOST) & (time < LOST + COAST + FADE)
    assert np.max(record.column("top_tension")[during]) < np.max(record.column("uncompensated_tension")[during])
    # the winch stays near its mean, so that nothing is left to swing about
    assert abs(record.column("payout")[-1]) < 1.0


def test_the_lull_behind_the_highest_wave_of_a_storm_is_not_taken_for_a_loop_that_runs_wild():
    """With this seed the drum comes back from its limits while the boom tip stands still, 53 s after the start.

    It was faded out there, and the unit swung twice as far as one that was never compensated.
    """
    record = ClosedLoop(loop_parameters(load_scenario("b5_storm", settings=["all.seed=7", "all.duration=70"]))).run()
    assert not {alarm.name for _, alarm in record.alarms} & HARMFUL
    assert record.modes[-1] == "compensating"
