"""What the node reports of itself in diagnostics."""

from types import SimpleNamespace

import pytest
from winch_controller_node.interface.alarms import ALARMS

pytest.importorskip("rclpy")
pytest.importorskip("heave_msgs")

from heave_node.interface.codes import SensorLevel
from heave_node.ros.diagnostics import Level
from winch_controller_node.core.supervision.modes import Event
from winch_controller_node.interface.readings import SensorState
from winch_controller_node.node import ADVISER, WinchControllerNode


def parts_of(mode, *, is_inhibited=False, reason="", sensors=(), adviser=None):
    """Return the parts that `diagnose` says, the mode first."""
    report = SimpleNamespace(
        mode=mode, is_inhibited=is_inhibited, reason=reason, authority=0.0, sensors=sensors, solver_status="free"
    )
    node = SimpleNamespace(
        outputs_of_tick=SimpleNamespace(report=report),
        controller=SimpleNamespace(depth=300.0, preview=SimpleNamespace(has_come=False)),
        source=SimpleNamespace(health=dict),
        _changes={},
        _reported={},
        _has_adviser=adviser is not None,
        adviser=adviser,
        _diagnose_commands=lambda: None,
    )
    return WinchControllerNode.diagnose(node)


def health_of(mode, *, is_inhibited=False, reason=""):
    """Return level and words of the mode, as `diagnose` says them."""
    part = parts_of(mode, is_inhibited=is_inhibited, reason=reason)[0]
    return part.level, part.message


@pytest.mark.parametrize(
    ("mode", "is_inhibited", "level"),
    [
        ("standby", False, Level.OK),
        ("standby", True, Level.ERROR),
        ("compensating", False, Level.OK),
        ("fade_out", False, Level.WARN),
        ("fade_out", True, Level.ERROR),
        ("stopped", False, Level.ERROR),
    ],
)
def test_standing_by_is_an_error_where_the_guard_keeps_compensation_off(mode, is_inhibited, level):
    found, words = health_of(mode, is_inhibited=is_inhibited, reason="the unit swings more than off")
    assert found == level
    assert words == f"{mode}: the unit swings more than off"


@pytest.mark.parametrize("mode", ["fade_out", "stopping", "stopped", "standby"])
@pytest.mark.parametrize("event", [Event.ASK_STOPPED, Event.ASK_STANDBY, Event.ASK_MANUAL])
def test_a_rest_that_was_asked_for_is_no_error_unless_there_is_harm(mode, event):
    assert health_of(mode, reason=event.value)[0] == Level.OK
    assert health_of(mode, is_inhibited=True, reason=event.value)[0] == Level.ERROR


def test_an_emergency_stop_is_an_error_whoever_asked_for_it():
    assert health_of("emergency_stop", reason=Event.ASK_EMERGENCY_STOP.value)[0] == Level.ERROR


def test_a_lost_sensor_says_what_to_do_and_one_that_is_well_is_ok():
    lost = SensorState("mru", SensorLevel.LOST, "frozen", 0.2, 10, 3, ALARMS.alarm("SENSOR_LOST, MRU: frozen"))
    well = SensorState("depth", SensorLevel.OK, "", 0.2, 10, 0)
    words = {part.part: part.message for part in parts_of("compensating", sensors=(lost, well)) if part is not None}
    assert words["sensor mru"] == str(ALARMS.alarm("SENSOR_LOST, MRU: frozen"))
    assert words["sensor depth"] == "ok"


@pytest.mark.parametrize(("is_well", "level"), [(True, Level.OK), (False, Level.WARN)])
def test_an_adviser_that_is_not_well_is_a_warning_and_a_run_without_one_says_nothing_of_it(is_well, level):
    adviser = SimpleNamespace(is_well=is_well, words="no answer for 4 s", values={"answers": "7"})
    (part,) = [one for one in parts_of("compensating", adviser=adviser) if one is not None and one.part == ADVISER]
    assert (part.level, part.message, part.values) == (level, "no answer for 4 s", {"answers": "7"})
    assert ADVISER not in {one.part for one in parts_of("compensating") if one is not None}
