"""Warnings and errors of /diagnostics as intervals: a countdown is one, what is reported once is each."""

from dataclasses import replace

import numpy as np
import pytest
from heave_bags.analyse.events import Interval, diagnostic_alarms, operator_requests
from heave_bags.analyse.reading.fields import Fields


def fields(name, messages):
    count = len(messages)
    return Fields(
        {
            "time": np.arange(count, dtype=float),
            "log_time": np.arange(count),
            "status[0].level": np.full(count, 1, dtype=np.uint8),
            "status[0].name": np.array([name] * count, dtype=object),
            "status[0].message": np.array(messages, dtype=object),
        }
    )


def test_a_countdown_is_one_alarm_with_its_first_words():
    messages = [f"standby: compensation is harmful; tried again in {30 - k} s" for k in range(20)]
    (found,) = diagnostic_alarms(fields("winch_controller: mode", messages))
    assert (found.start, found.end) == (0.0, 20.0)
    assert found.name.endswith("tried again in 30 s")


def test_what_the_controller_has_told_is_not_joined_where_its_figures_differ():
    messages = [f"WINCH_MODEL_UPDATED (event): speed limit {limit} m/s" for limit in (1.2, 1.1)]
    found = diagnostic_alarms(fields("winch_controller: alarms", messages))
    assert [alarm.name.split(": ")[-1] for alarm in found] == ["speed limit 1.2 m/s", "speed limit 1.1 m/s"]


def test_an_event_is_no_warning():
    """The part `alarms` of the controller is a warning whatever it reports."""
    messages = [
        "t = 1.00 s: AUTHORITY_RESTORED (event): authority is 100 %.; t = 1.50 s: SENSOR_DOUBTFUL, MRU (low): 2 Hz."
    ]
    found = diagnostic_alarms(fields("winch_controller: alarms", messages))
    assert [alarm.level for alarm in found] == [0, 1]
    (alone,) = diagnostic_alarms(fields("adviser: alarms", ["AUTHORITY_RESTORED (event): authority is 100 % again."]))
    assert alone.level == 0


@pytest.mark.parametrize(("severity", "level"), [("critical", 2), ("high", 2), ("medium", 1), ("low", 1), ("event", 0)])
def test_an_alarm_of_the_controller_has_the_level_of_its_severity_whatever_that_of_its_part(severity, level):
    """A brake that did not hold stood as a warning in the report: the part of the alarms is at most that."""
    text = f"t = 1.00 s: DRUM_NOT_HELD ({severity}): count moved 0.05 m."
    (alone,) = diagnostic_alarms(fields("winch_controller: alarms", [text]))
    assert alone.level == level


LOST = "SENSOR_LOST, MRU (high): no data for 0.20 s, limit 0.15 s. Compensation fades out."


def told(alarms, sensor=()):
    """Return diagnostics of a second each: what the controller raised since the last, and what it says of the MRU."""
    parts = {"winch_controller: sensor mru": sensor or ["ok"] * len(alarms), "winch_controller: alarms": alarms}
    columns = {"time": np.arange(float(len(alarms))), "log_time": np.arange(len(alarms))}
    for index, (name, messages) in enumerate(parts.items()):
        columns[f"status[{index}].level"] = np.array([message != "ok" for message in messages], dtype=np.uint8)
        columns[f"status[{index}].name"] = np.array([name] * len(messages), dtype=object)
        columns[f"status[{index}].message"] = np.array(messages, dtype=object)
    return Fields(columns)


def spans(*args):
    return [
        (one.name.removeprefix("winch_controller: alarms: ").split(" (")[0], round(one.start, 2), round(one.end, 2))
        for one in diagnostic_alarms(*args)
    ]


def test_an_alarm_of_a_sensor_is_one_from_when_it_was_raised_until_the_sensor_is_well():
    """Diagnostics come once a second, the controller's state in each tick: 1.15 s to 2.9 s."""
    raised = ["ok", "ok", f"t = 1.15 s: {LOST}; t = 1.60 s: SEA_MODEL_UPDATED (event): Hs 2.0 m.", "ok", "ok"]
    state = [Interval(1.05, 1.15, "SENSOR_DOUBTFUL, MRU", 1), Interval(1.15, 2.9, "SENSOR_LOST, MRU", 2)]
    assert spans(told(raised, ["ok", "ok", LOST, "ok", "ok"]), state) == [
        ("SENSOR_LOST, MRU", 1.15, 2.9),
        ("SEA_MODEL_UPDATED", 1.6, 1.6),
    ]


def test_an_alarm_of_a_sensor_lasts_as_long_as_its_part_is_reported_where_no_state_was_recorded():
    raised = ["ok", "ok", f"t = 1.15 s: {LOST}", "ok", "ok"]
    assert spans(told(raised, ["ok", "ok", LOST, LOST, "ok"])) == [("SENSOR_LOST, MRU", 1.15, 4.0)]


def test_an_alarm_lasts_as_long_as_it_is_the_reason_of_the_mode_from_one_mode_to_the_next():
    brief = "DRUM_NOT_HELD: drum turns at -0.20 m/s"
    raised = ["ok", "t = 0.50 s: DRUM_NOT_HELD (critical): drum turns at -0.20 m/s. Nothing holds the load.", "ok"]
    waits = [
        Interval(0.5, 0.9, "emergency_stop", reason=brief),
        Interval(0.9, 7.0, "stopped", reason=f"{brief}; check the cause"),
        Interval(7.0, 9.0, "standby", reason="standby requested"),
    ]
    assert spans(told(raised), waits) == [("DRUM_NOT_HELD", 0.5, 7.0)]


@pytest.mark.parametrize(
    ("code", "restored", "ends"),
    [
        ("AUTHORITY_LIMITED", "AUTHORITY_RESTORED", True),
        ("ADVISER_LOST", "ADVISER_RESTORED", True),
        ("SENSOR_LOST, DEPTH", "SENSOR_RECOVERED, DEPTH", True),
        ("SENSOR_LOST, DEPTH", "SENSOR_RECOVERED, MRU", False),
        ("ADVISER_LOST", "AUTHORITY_RESTORED", False),
    ],
)
def test_an_alarm_ends_when_its_part_is_reported_restored_else_nothing_is_claimed_of_its_end(code, restored, ends):
    raised = [f"t = 1.00 s: {code} (medium): words.", "ok", f"t = 3.50 s: {restored} (event): words.", "ok"]
    assert spans(told(raised))[0] == (code, 1.0, 3.5 if ends else 1.0)


def test_what_is_raised_again_while_it_lasts_is_one_and_afterwards_another():
    """A lost sensor is reported again where what the loop does about it changes."""
    stopping = LOST.replace("0.20", "1.30").replace("Compensation fades out", "Winch is stopping")
    raised = [f"t = 1.00 s: {LOST}", f"t = 2.00 s: {stopping}", "ok", f"t = 4.00 s: {LOST}"]
    state = [Interval(1.0, 3.0, "SENSOR_LOST, MRU", 2), Interval(4.0, 5.0, "SENSOR_LOST, MRU", 2)]
    assert spans(told(raised), state) == [("SENSOR_LOST, MRU", 1.0, 3.0), ("SENSOR_LOST, MRU", 4.0, 5.0)]


def test_two_alarms_of_one_tick_are_two():
    both = "t = 1.00 s: CABLE_SLACK (medium): tension 1 kN.; WINCH_SATURATED (low): at its limits."
    assert [(one.name.split(" (")[0], one.level) for one in diagnostic_alarms(told([both]))] == [
        ("winch_controller: alarms: CABLE_SLACK", 1),
        ("winch_controller: alarms: WINCH_SATURATED", 1),
    ]


def test_a_sensor_that_no_alarm_names_is_shown_as_a_warning_where_the_controller_reports_alarms():
    """While its own cycles are left out the controller loses all sensors for some ticks, and raises that alone."""
    lost = Interval(3.0, 4.0, "SENSOR_LOST, ENCODER", 2)
    assert diagnostic_alarms(told([f"t = 3.00 s: {LOST}"]), [lost])[-1] == replace(lost, level=1)
    assert diagnostic_alarms(told(["ok"]), [lost]) == [lost], "a bag without its alarms"


def test_the_mode_is_no_alarm_where_the_controller_s_state_tells_it_to_the_tick():
    stopped = fields("winch_controller: mode", ["stopped: mru stale"] * 3)
    assert len(diagnostic_alarms(stopped)) == 1
    assert diagnostic_alarms(stopped, has_modes=True) == []


@pytest.mark.parametrize("node", ["winch_controller", "cable_sim"])
def test_what_an_operator_asked_for_is_told_at_its_own_time_and_is_no_alarm(node):
    messages = ["ok", "t = 1.20 s: factor 0.8; t = 1.55 s: speed +0.20 m/s", "ok"]
    asked = fields(f"{node}: operator", messages)
    assert operator_requests(asked) == [Interval(1.2, 1.2, "factor 0.8"), Interval(1.55, 1.55, "speed +0.20 m/s")]
    assert operator_requests(fields("winch_controller: alarms", messages)) == []


def test_a_fault_of_the_winch_and_the_alarm_of_its_drive_are_one():
    words = "WINCH_EMERGENCY_STOP (high): the winch has stopped (emergency stop)."
    drive = fields("virtual_winch: drive", [words] * 3)
    fault = Interval(0.4, 2.4, "WINCH_EMERGENCY_STOP", 2)
    (found,) = diagnostic_alarms(drive, [fault])
    assert found.name == f"virtual_winch: drive: {words}"
    late = Interval(9.0, 10.0, "WINCH_EMERGENCY_STOP", 2)
    assert diagnostic_alarms(drive, [late])[1] == late, "of another time"
    other = fields("winch_controller: alarms", ["t = 0.50 s: WINCH_SATURATED (low): at its limits."])
    assert diagnostic_alarms(other, [fault])[-1] == fault, "another alarm of the winch does not tell of it"
