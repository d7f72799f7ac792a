"""Half of the sea compensated: the rest that is left to the unit is that of the true cable, not of the assumed one."""

from dataclasses import replace

import pytest
from heave_bringup.scenarios import load_scenario

from tests.campaigns.draws.cases import Case
from tests.campaigns.draws.run import run_case

SCENARIO = "b3_deep_900"


@pytest.mark.long
@pytest.mark.parametrize("law", ["lqg", "mpc"])
def test_half_of_the_sea_on_a_cable_half_as_stiff_leaves_no_more_than_off(law):
    """Steered along the motion of the assumed cable it was 1.14 (lqg) and 1.66 (mpc) in the worst minute.

    1.2 is the promise of a single deviation in 99.5 % of the draws.
    """
    stiffness = load_scenario(SCENARIO).parameters["cable_sim"].cable.axial_stiffness
    settings = {
        "winch_controller.factor": 0.5,
        "wave_vessel.peak_period": 12.0,
        "cable_sim.cable.axial_stiffness": 0.5 * stiffness,
    }
    case = replace(Case("few", 1, 0, SCENARIO, law, 5), settings=settings)
    found = run_case(case, duration=300.0)
    assert not found.failure
    assert found.worst < 1.2
