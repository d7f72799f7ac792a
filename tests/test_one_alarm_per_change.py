"""A winch that changes in the middle of a run: what has changed is told once."""

import re
from dataclasses import replace

import pytest
from cable_sim_node.winch.choice import make_drive
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario

CHANGED, DURATION = 120.0, 300.0
"""When the winch changes, and end of the run [s]."""


def alarms_of(**changes):
    """Return time and words of what is told of the winch of benchmark B3, which has `changes` from CHANGED on.

    That a part of the sea is left alone meanwhile is told as well, and that commands take effect later.
    """
    settings = [f"all.duration={DURATION}", "wave_vessel.ramp=20"]
    parameters = loop_parameters(load_scenario("b3_deep_900", settings=settings))
    loop = ClosedLoop(parameters)
    winch = loop.winch

    def change(tick, _):
        if tick == round(CHANGED / parameters.tick_period):
            winch._parameters = replace(winch._parameters, **changes)
            drive = make_drive(winch._parameters, 0.0)
            drive.state = winch._drive.state
            winch._drive = drive
            winch._line._delay = winch._parameters.command_delay

    alarms = loop.run(change).alarms
    return [(time, words) for time, words in alarms if "winch" in words]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "learnt", "value"),
    [
        ({"speed_gain": 0.85}, "gain by the encoder", 0.85),
        ({"speed_gain": 1.15}, "gain by the encoder", 1.15),
        ({"command_delay": 0.3}, "command delay", 0.3),
    ],
    ids=["lower gain", "higher gain", "delay"],
)
def test_a_change_of_the_winch_is_one_alarm_that_names_it(changes, learnt, value):
    alarms = alarms_of(**changes)
    ((time, words),) = [alarm for alarm in alarms if alarm[1].startswith("winch model updated")]
    assert CHANGED < time < CHANGED + 60.0
    found = re.fullmatch(rf"winch model updated: {learnt} ([\d.]+)( s)? \(was [\d.]+\)", words)
    assert found is not None, words
    assert float(found.group(1)) == pytest.approx(value, rel=0.07)
    is_later = "command_delay" in changes
    assert any("later than modelled" in words for _, words in alarms) is is_later


@pytest.mark.slow
def test_a_winch_that_stays_as_it_is_gives_none():
    assert not alarms_of()
