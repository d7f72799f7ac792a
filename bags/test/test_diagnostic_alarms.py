"""Warnings and errors of /diagnostics as intervals: a countdown is one, what is reported once is each."""

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


def test_an_alarm_that_lasts_is_shown_from_when_it_was_raised_on():
    """Diagnostics come once a second: the sensor is reported lost at 2 s, and its alarm says since when."""
    lost = "SENSOR_LOST, MRU (high): no data for 0.20 s, limit 0.15 s. Compensation fades out."
    parts = {"winch_controller: sensor mru": ["ok", "ok", lost, lost], "winch_controller: alarms": ["ok"] * 4}
    parts["winch_controller: alarms"][2] = f"t = 1.15 s: {lost}; t = 1.60 s: SEA_MODEL_UPDATED (event): Hs 2.0 m."
    columns = {"time": np.arange(4.0), "log_time": np.arange(4)}
    for index, (name, messages) in enumerate(parts.items()):
        columns[f"status[{index}].level"] = np.array([message != "ok" for message in messages], dtype=np.uint8)
        columns[f"status[{index}].name"] = np.array([name] * 4, dtype=object)
        columns[f"status[{index}].message"] = np.array(messages, dtype=object)
    found = {one.name.split(" (")[0]: (one.start, one.end) for one in diagnostic_alarms(Fields(columns))}
    assert found == {
        "winch_controller: alarms: SENSOR_LOST, MRU": (1.15, 2.15),
        "winch_controller: alarms: SEA_MODEL_UPDATED": (1.6, 2.6),
        "winch_controller: sensor mru: SENSOR_LOST, MRU": (1.15, 4.0),
    }


def test_the_mode_is_no_alarm_where_the_controller_s_state_tells_it_to_the_tick():
    told = fields("winch_controller: mode", ["stopped: mru stale"] * 3)
    assert len(diagnostic_alarms(told)) == 1
    assert diagnostic_alarms(told, has_modes=True) == []


@pytest.mark.parametrize("node", ["winch_controller", "cable_sim"])
def test_what_an_operator_asked_for_is_told_at_its_own_time_and_is_no_alarm(node):
    messages = ["ok", "t = 1.20 s: factor 0.8; t = 1.55 s: speed +0.20 m/s", "ok"]
    told = fields(f"{node}: operator", messages)
    assert operator_requests(told) == [Interval(1.2, 1.2, "factor 0.8"), Interval(1.55, 1.55, "speed +0.20 m/s")]
    assert operator_requests(fields("winch_controller: alarms", messages)) == []
