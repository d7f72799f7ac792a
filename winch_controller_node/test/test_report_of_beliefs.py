"""Changes of the beliefs are reported once: those of the winch when it has settled, all others at once."""

from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType

import pytest
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.adviser.report import LONGEST, SETTLED, Report
from winch_controller_node.beliefs.beliefs import Belief, Beliefs
from winch_controller_node.beliefs.quantities import QUANTITIES
from winch_controller_node.beliefs.words import alarms_of
from winch_controller_node.node_parameters import WinchControllerParameters

NOMINAL = WinchControllerParameters()


def beliefs(**values):
    named = {name.replace("__", "."): value for name, value in values.items()}
    return Beliefs(0, values=MappingProxyType({name: Belief(name, v, nats=60.0, since=7) for name, v in named.items()}))


def told(each, seconds=1.0):
    """Show each of the beliefs for so many `seconds`; return findings with the time at which they were reported."""
    report, found = Report(NOMINAL), []
    for second, one in enumerate(one for one in each for _ in range(round(seconds))):
        found += [(float(second), finding) for finding in report.news(one, float(second))]
    return found


def test_a_finding_is_data_with_value_unit_nominal_evidence_and_onset():
    ((when, finding),) = told([beliefs(mru__scale=1.4)] * 5)
    assert when == 0.0
    assert finding == ("differs", "mru.scale", 1.4, "", 1.0, 60.0, 7)


def test_nothing_believed_is_nothing_told():
    assert told([beliefs()] * 100) == []


def test_the_winch_is_told_once_it_has_settled():
    hunting = [beliefs(winch__acceleration_out=value) for value in (1.2, 0.9, 0.85)]
    ((when, finding),) = told([*hunting, *[beliefs(winch__acceleration_out=0.8)] * 60])
    assert (finding.quantity, finding.value) == ("winch.acceleration_out", 0.8)
    # the last change of more than a tenth was from 1.2 to 0.9 in the second, or third, second
    assert SETTLED <= when <= 3.0 + SETTLED


def test_a_winch_that_never_settles_is_told_at_the_latest_after_the_longest_time_and_not_more_often():
    hunting = [beliefs(winch__time_constant=0.15 + 0.1 * (k % 2 + 1)) for k in range(200)]
    times = [when for when, _ in told(hunting)]
    assert times[0] <= LONGEST
    assert all(b - a >= LONGEST for a, b in pairwise(times))


def test_a_limit_that_was_never_found_is_not_told_and_one_that_was_is_told_when_it_is_on_trial():
    """Assumed of the other direction, and raised since no record needs it: no record says it (0 nats)."""
    (name, found), assumed = (
        ("winch.speed_out", beliefs(winch__speed_out=0.5)),
        Belief("winch.speed_out", 0.6, nats=0.0),
    )
    on_trial = replace(beliefs(), values=MappingProxyType({name: assumed}))
    assert told([on_trial] * 60) == []
    assert [finding.value for _, finding in told([found] * 30 + [on_trial] * 30)] == [0.5, 0.6]
    (alarm,) = alarms_of([told([found] * 30 + [on_trial] * 30)[-1][1]])
    assert "0.600 m/s on trial (was 0.500)" in alarm.values["changes"]


def test_what_comes_back_to_nominal_is_told_as_nominal():
    found = told([beliefs(depth__scale=-1.0), beliefs(), beliefs(depth__scale=-1.0)])
    assert [(f.code, f.quantity, f.value) for _, f in found] == [
        ("differs", "depth.scale", -1.0),
        ("nominal", "depth.scale", 1.0),
        ("differs", "depth.scale", -1.0),
    ]


def test_a_sensor_that_is_excluded_and_one_that_is_used_again_are_told_once_each():
    without = replace(beliefs(), excluded="mru")
    found = told([beliefs(), without, without, replace(beliefs(), excluded="depth"), beliefs(), beliefs()])
    assert [(f.code, f.quantity) for _, f in found] == [
        ("excluded", "mru"),
        ("excluded", "depth"),
        ("recovered", "depth"),
    ]


def test_what_cannot_be_designed_for_is_told_once_of_each_owner():
    report, found = Report(NOMINAL), []
    for second, owner in enumerate(["winch", "winch", "cable", "winch"]):
        report.refuse(owner)
        found += [(second, finding.code, finding.quantity) for finding in report.news(beliefs(), float(second))]
    assert found == [(0, "refused", "winch"), (2, "refused", "cable")]


@pytest.mark.parametrize("name", [name for name, one in QUANTITIES.items() if one.relative or one.absolute])
@given(share=st.floats(-0.95, 0.95))
def test_a_change_of_less_than_is_worth_a_report_is_never_told(name, share):
    quantity, nominal = QUANTITIES[name], QUANTITIES[name].nominal_in(NOMINAL)
    if quantity.relative and nominal == 0.0:
        return
    value = nominal * (1.0 + share * quantity.relative * 0.9) + share * quantity.absolute
    assert told([beliefs(**{name.replace(".", "__"): value})] * 60) == []


@pytest.mark.parametrize("name", [name for name in QUANTITIES if name != "mru.bias_sigma"])
def test_each_quantity_far_from_nominal_is_told_once(name):
    nominal = QUANTITIES[name].nominal_in(NOMINAL)
    ((_, finding),) = told([beliefs(**{name.replace(".", "__"): 2.0 * nominal + 0.5})] * 90)
    assert (finding.quantity, finding.unit) == (name, QUANTITIES[name].unit)
