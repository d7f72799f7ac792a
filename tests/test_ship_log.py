"""A ship's own record of its motion, of another sea than the controller assumes."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.kpi import kappa
from heave_studies.kappa import bounds_of
from winch_controller_node.design.bounds import BOUND_STEP, boom_tip_realisation
from winch_controller_node.parameters.model import SeaModelParameters, VesselModelParameters

from tests.campaigns.promise import LARGEST, TROUBLE, worst_window

SCENARIO = "b3_deep_900"
"""A scenario that assumes significant waves of 1.5 m at 10 s."""

HEIGHT, PERIOD = 2.5, 12.0
"""Sea in which the record was taken [m], [s]."""

DURATION, JUDGED = 240.0, 90.0
"""Duration of a run, and time from which on it is judged [s]."""

LARGEST_OVER_MATCHED = 1.3
"""Largest standard deviation of the unit over that under the belief that matches the record."""


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A CSV file of heave of the boom tip as a ship's logger writes it, ten samples a second."""
    sea = SeaModelParameters(significant_wave_height=HEIGHT, peak_period=PERIOD)
    vessel = VesselModelParameters(natural_frequency=0.9, damping_ratio=0.4)
    heave = boom_tip_realisation(sea, vessel, duration=DURATION + 10.0, step=0.05, seed=7)[::2]
    path = tmp_path_factory.mktemp("ship") / "log.csv"
    rows = (f"{0.1 * number:.2f},{value:.4f}" for number, value in enumerate(heave))
    path.write_text("\n".join(["time_s,heave_m", *rows]) + "\n")
    return path


def settings_of(log, *settings):
    """Return the settings of a run on the record `log`."""
    run = (f"all.duration={DURATION}", "all.transient=30", "wave_vessel.ramp=5")
    return [*run, "wave_vessel.boom_tip_source=file", f"wave_vessel.recording_file={log}", *settings]


def run_on(log, *settings):
    """Return scenario and record of a run on the record `log`."""
    scenario = load_scenario(SCENARIO, settings=settings_of(log, *settings))
    return scenario, ClosedLoop(loop_parameters(scenario)).run()


@pytest.fixture(scope="module")
def as_assumed(log):
    return run_on(log)


@pytest.mark.slow
def test_a_ships_own_record_is_met_under_the_default_belief_as_well_as_under_that_which_matches(log, as_assumed):
    _, found = as_assumed
    matched = [
        f"winch_controller.sea.{name}" for name in (f"significant_wave_height={HEIGHT}", f"peak_period={PERIOD}")
    ]
    _, known = run_on(log, *matched)
    assert found.unit_sigma(JUDGED) < LARGEST_OVER_MATCHED * known.unit_sigma(JUDGED)
    unit = found.column("unit") + found.column("depth_set_point")
    begun = found.column("time")[found.modes.index("compensating")]
    assert worst_window(found.column("time"), unit, found.column("uncompensated"), begun + TROUBLE)[0] < LARGEST
    assert "fade_out" not in found.modes


@pytest.mark.long
def test_kappa_on_a_record_is_at_least_one_and_no_belief_moves_its_bounds(log, as_assumed):
    """The bound is that of the record's own spectrum, not of the sea that the controller assumes."""
    scenario, record = as_assumed
    time, tip = record.column("time", after=JUDGED), record.column("boom_tip", after=JUDGED)
    tip = np.interp(np.arange(time[0], time[-1], BOUND_STEP), time, tip)
    bounds = bounds_of(scenario, tip, BOUND_STEP)
    assert 1.0 <= kappa(record.unit_sigma(JUDGED), *bounds) < 5.0
    turned = load_scenario(SCENARIO, settings=settings_of(log, "winch_controller.cable_model.disturbance=0.05"))
    assert bounds_of(turned, tip, BOUND_STEP) == bounds
