"""A winch with half of the assumed acceleration, over the ROS nodes of a run, with its verdict."""

import json
import re

import pytest
from heave_bringup import ClosedLoop, load_scenario, loop_parameters
from winch_controller_node.interface.alarms import HARMFUL

from tests.loop_runs import HAS_RUN, heave

LIMIT = 0.8
"""Acceleration limit [m/s^2]; benchmark B3 assumes 1.5 m/s^2."""

WEAK = (f"virtual_winch.acceleration_limit={LIMIT}", f"virtual_winch.stop_deceleration={LIMIT}")


def test_a_winch_weaker_than_believed_is_found_out_and_the_unit_held_still(tmp_path):
    """The loop was lost here, and the unit moved eight times as much as without compensation.

    The limit is reached first by the group of waves at 60 s, after which the unit swings for 15 s.
    """
    settings = [*WEAK, "wave_vessel.ramp=10", "all.transient=78"]
    result = heave(
        *("run", "b3_deep_900", "--duration", "130", "--bag", str(tmp_path / "run"), "--composed", "--no-report"),
        *("--json", str(tmp_path / "kpi.json"), "--require", "unit_efficiency>0.9"),
        *(word for setting in settings for word in ("--set", setting)),
    )
    assert result.returncode in HAS_RUN, result.stdout + result.stderr
    verdict = json.loads((tmp_path / "kpi.json").read_text())["verdict"]
    assert {entry["kpi"]: entry["met"] for entry in verdict["criteria"]}["unit_efficiency"]
    told = re.findall(
        r"WINCH_MODEL_UPDATED \(event\): .*acceleration limit (?:hauling in|paying out) ([\d.]+) m/s\^2 \(was 1\.500\)",
        result.stdout + result.stderr,
    )
    assert any(float(value) == pytest.approx(LIMIT, rel=0.1) for value in told), told
    assert not [code for code in HARMFUL if code in result.stdout + result.stderr]


def test_a_winch_of_a_quarter_of_the_assumed_speed_is_identified_before_the_envelope_takes_it_for_a_runaway():
    """It was not: the drum trailed by 1.7 m at its limit, was braked, and the load swung 2.5 times as far as locked."""
    scenario = load_scenario("b3_deep_900", settings=["all.duration=100", "virtual_winch.speed_limit=0.5"])
    record = ClosedLoop(loop_parameters(scenario)).run()
    assert record.modes[-1] == "compensating"
    codes = {alarm.name for _, alarm in record.alarms}
    said = [alarm.values["changes"] for _, alarm in record.alarms if alarm.name == "WINCH_MODEL_UPDATED"]
    limits = [float(limit) for text in said for limit in re.findall(r"speed limit [a-z ]*([\d.]+)", text)]
    assert limits == pytest.approx([0.5], rel=0.01), "of the direction that has reached it, and as it is"
    assert not codes & {"ORDER_REPLACED: too far", "ORDER_REPLACED: too fast", "COMPENSATION_LOST"}


OTHERWISE = {
    "acceleration limit and stiffness": (
        *("unit_1500", "all.seed=277681", "virtual_winch.acceleration_limit=0.87"),
        *("virtual_winch.stop_deceleration=0.87", "cable_sim.cable.axial_stiffness=19328728.5"),
    ),
    "creep": ("unit_1500", "all.seed=290183", "winch_controller.law=lqg", "virtual_winch.creep=0.032"),
}
"""Scenario and settings of runs in which something is other than stated: draws of one or two such deviations."""


@pytest.mark.slow
@pytest.mark.parametrize("what", OTHERWISE)
def test_a_deviation_from_what_is_stated_is_not_taken_over_by_the_envelope(what):
    """They were: a swing that is stopped as compensation begins, and a creep that sums up, and the load then swung."""
    name, *settings = OTHERWISE[what]
    loop = ClosedLoop(loop_parameters(load_scenario(name, settings=["all.duration=60", *settings])))
    for _ in range(1200):
        outputs, _ = loop.step()
        assert not loop.controller.envelope.last.cause
    assert outputs.mode == "compensating"
