"""What an alarm promises is what the code does: figures in its words, and rows that something can raise."""

from __future__ import annotations

import pytest
from heave_core.sense_table import News, Reason
from winch_controller_node.core.estimation.observation import Observer
from winch_controller_node.core.estimation.sense_design import GATES, SENSOR
from winch_controller_node.core.estimation.sensor_health import ABSENT, REASONS, REJECTED_WORDS
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.core_parts import part


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
