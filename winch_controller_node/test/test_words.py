"""Each finding has an alarm: code and values; the winch, and the sea, one for all that is new of them."""

from __future__ import annotations

import pytest
from heave_core.sense_table import News, Reason
from winch_controller_node.beliefs.beliefs import Finding
from winch_controller_node.beliefs.quantities import QUANTITIES
from winch_controller_node.beliefs.words import alarms_of
from winch_controller_node.core.estimation.observation import Observer
from winch_controller_node.core.estimation.sense_design import GATES, SENSOR
from winch_controller_node.core.estimation.sensor_health import ABSENT, REASONS, REJECTED_WORDS
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.core_parts import part

REPORTED = [name for name in QUANTITIES if name != "mru.bias_sigma"]
"""Quantities with a finding of their own; the noise of a drift has none."""

LABELS = {name: one.label for name, one in QUANTITIES.items() if one.owner in ("winch", "sea")}

SENSORS = ("mru", "depth", "encoder")


@pytest.mark.parametrize("name", REPORTED)
def test_each_quantity_that_differs_has_one_alarm_with_its_owner_and_its_value(name):
    quantity = QUANTITIES[name]
    # a power is said in kW
    size = 1e3 if quantity.unit == "W" else 1.0
    (alarm,) = alarms_of([Finding("differs", name, 1.25 * size, quantity.unit, size, 60.0, 100)])
    assert alarm.row.part == quantity.owner
    # a wander has no size that a person can use
    assert name == "mru.bias_drift" or any(value in str(alarm) for value in ("1.25", "1.250", "1.2", "1"))


@pytest.mark.parametrize("name", [name for name, one in QUANTITIES.items() if one.alarm])
def test_each_quantity_that_is_nominal_again_has_an_alarm(name):
    owner = QUANTITIES[name].owner
    (alarm,) = alarms_of([Finding("nominal", name, 1.0, "", 1.2)])
    assert (alarm.name, alarm.row.part) == (f"NOMINAL, {owner.upper()}", owner)


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize(
    ("code", "name"), [("excluded", "SENSOR_LOST, {}: excluded"), ("recovered", "SENSOR_RECOVERED, {}")]
)
def test_a_sensor_that_is_excluded_or_used_again_is_named(code, name, sensor):
    (alarm,) = alarms_of([Finding(code, sensor)])
    assert alarm.name == name.format(sensor.upper())


@pytest.mark.parametrize("owner", ["winch", "cable", "mru"])
def test_what_was_found_and_cannot_be_designed_for_is_named(owner):
    (alarm,) = alarms_of([Finding("refused", owner)])
    assert alarm.name == f"NOT_DESIGNABLE, {owner.upper()}"


def test_all_that_is_new_of_the_winch_is_one_alarm_and_so_is_that_of_the_sea():
    findings = [Finding("differs", name, 0.5, QUANTITIES[name].unit, 1.0) for name in LABELS]
    winch, sea = alarms_of(findings)
    assert (winch.code, sea.code) == ("WINCH_MODEL_UPDATED", "SEA_MODEL_UPDATED")
    for name, label in LABELS.items():
        assert label
        assert label in (winch if name.startswith("winch") else sea).values["changes"]


def test_nothing_new_says_nothing():
    assert alarms_of(()) == []


def test_every_quantity_has_words_or_an_alarm_of_its_own():
    assert [name for name, one in QUANTITIES.items() if bool(one.label) != bool(one.alarm)] == REPORTED


# alarms of sensors


@pytest.mark.parametrize("sensor", ["mru", "encoder", "depth", "load_cell", "velocity", "imu"])
@pytest.mark.parametrize("reason", [ABSENT, *filter(None, REASONS.values())])
def test_a_sensor_has_a_row_for_what_it_can_be_lost_for_and_for_no_more(sensor, reason):
    """A status is the MRU's alone; jumps of MRU, encoder and depth are looked for; no spike of the encoder is."""
    is_status = reason.startswith("status")
    can_be = (sensor == "mru" or not is_status) and (reason != "jump" or sensor in ("mru", "encoder", "depth"))
    can_be = can_be and not (sensor == "encoder" and reason == "spike")
    can_be = can_be and not (sensor == "encoder" and reason == "frozen")  # the drum may stand
    named = "status" if reason == "status invalid" else reason
    assert (f"SENSOR_LOST, {sensor.upper()}: {named}" in ALARMS) is can_be


def test_every_reason_to_reject_a_reading_has_words():
    assert set(REJECTED_WORDS) >= set(REASONS.values()) - {"", "frozen", "stale", "delayed"}, (
        "one that is frozen, or whose data are old, is lost at once"
    )


def test_a_sensor_that_jumps_so_often_that_it_is_lost_is_not_reported_as_one_whose_jump_was_subtracted():
    design = design_controller(WinchControllerParameters(), tick_period=0.05)
    observer = Observer(design, design.make_estimator())
    place = SENSOR["depth"]
    gate = observer.state["gates"][0, place : place + 1]
    for _ in range(GATES["bad_in_a_row"]):
        part("take_back")(observer.design["health"], gate, Reason.JUMP, True)
    observer.state[0]["gates"][place]["news"] = News.SENSOR_WORSE
    assert [alarm.name for alarm in observer.alarms(News.SENSOR_WORSE)] == ["SENSOR_LOST, DEPTH: jump"]
