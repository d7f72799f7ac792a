"""A ship's own record of its motion, of another sea than the controller assumes."""

import numpy as np
import pytest
from heave_bringup.scenarios import load_scenario
from heave_node.kpi import kappa
from heave_studies.kappa import bounds_of
from winch_controller_node.design.bounds import BOUND_STEP, boom_tip_realisation
from winch_controller_node.parameters.model import SeaModelParameters, VesselModelParameters

from tests.loops import TROUBLE, begin_of, loop_of, settings_text, worst_minute

SCENARIO = "b3_deep_900"
"""A scenario that assumes significant waves of 1.5 m at 10 s."""

HEIGHT, PERIOD = 2.5, 12.0
"""Sea in which the record was taken [m], [s]."""

DURATION, JUDGED = 240.0, 90.0
"""Duration of a run [s], and time from which on it is judged [s]."""


@pytest.fixture(scope="module")
def on_log(tmp_path_factory):
    """Settings of a run on a CSV file of heave of the boom tip as a ship's logger writes it, ten samples a second."""
    sea = SeaModelParameters(significant_wave_height=HEIGHT, peak_period=PERIOD)
    vessel = VesselModelParameters(natural_frequency=0.9, damping_ratio=0.4)
    heave = boom_tip_realisation(sea, vessel, duration=DURATION + 10.0, step=0.05, seed=7)[::2]
    path = tmp_path_factory.mktemp("ship") / "log.csv"
    rows = (f"{0.1 * number:.2f},{value:.4f}" for number, value in enumerate(heave))
    path.write_text("\n".join(["time_s,heave_m", *rows]) + "\n")
    run = {"all.duration": DURATION, "all.transient": 30, "wave_vessel.ramp": 5}
    return {**run, "wave_vessel.boom_tip_source": "file", "wave_vessel.recording_file": path}


@pytest.fixture(scope="module")
def as_assumed(on_log):
    return loop_of(SCENARIO, on_log).run()


@pytest.mark.slow
def test_a_ships_own_record_is_met_under_the_default_belief_as_well_as_under_that_which_matches(on_log, as_assumed):
    """At most 1.3 times the motion under the matching belief."""
    sea = {"significant_wave_height": HEIGHT, "peak_period": PERIOD}
    known = loop_of(SCENARIO, {**on_log, **{f"winch_controller.sea.{name}": one for name, one in sea.items()}}).run()
    assert as_assumed.unit_sigma(JUDGED) < 1.3 * known.unit_sigma(JUDGED)
    assert worst_minute(as_assumed, begin_of(as_assumed) + TROUBLE) < 1.05
    assert "fade_out" not in as_assumed.modes


@pytest.mark.long
def test_kappa_on_a_record_is_at_least_one_and_no_belief_moves_its_bounds(on_log, as_assumed):
    """The bound is that of the record's own spectrum, not of the sea that the controller assumes."""
    time, tip = as_assumed.column("time", after=JUDGED), as_assumed.column("boom_tip", after=JUDGED)
    tip = np.interp(np.arange(time[0], time[-1], BOUND_STEP), time, tip)
    bounds = bounds_of(load_scenario(SCENARIO, settings=settings_text(on_log)), tip, BOUND_STEP)
    assert 1.0 <= kappa(as_assumed.unit_sigma(JUDGED), *bounds) < 5.0
    turned = settings_text({**on_log, "winch_controller.cable_model.disturbance": 0.05})
    assert bounds_of(load_scenario(SCENARIO, settings=turned), tip, BOUND_STEP) == bounds
