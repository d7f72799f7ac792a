"""Alarms: a row of a table, what is raised from it, and the line by which it is read again."""

import math

import pytest
from heave_node.interface.alarm import AlarmRow, Severity, alarm_table, alarms_in, read_alarms
from heave_node.interface.codes import time_key

STALE = AlarmRow(
    "SENSOR_LOST, MRU",
    Severity.HIGH,
    "mru",
    "no data for {age:.1f} s",
    "Compensation fades out",
    "Check power",
    "stale",
)
SLACK = AlarmRow("CABLE_SLACK", Severity.MEDIUM, "cable", "tension {tension:.1f} kN")
TABLE = alarm_table(STALE, SLACK)


def test_the_line_of_an_alarm_is_code_severity_state_consequence_and_action():
    alarm = TABLE.alarm("SENSOR_LOST, MRU: stale", age=1.25)
    assert str(alarm) == "SENSOR_LOST, MRU (high): no data for 1.2 s. Compensation fades out. Check power."
    assert (alarm.name, alarm.severity, alarm.values) == ("SENSOR_LOST, MRU: stale", Severity.HIGH, {"age": 1.25})
    assert alarm.brief == "SENSOR_LOST, MRU: no data for 1.2 s"
    assert str(TABLE.alarm("CABLE_SLACK", tension=8.0)) == "CABLE_SLACK (medium): tension 8.0 kN."


@pytest.mark.parametrize(
    ("value", "limit", "shown"),
    [
        (-0.0231, 0.0225, "-0.023 m, limit 0.022 m"),
        (0.304, 0.3, "+0.304 m, limit 0.300 m"),
        (0.4, 0.3, "+0.40 m, limit 0.30 m"),
        (0.3, 0.3, "+0.30 m, limit 0.30 m"),
    ],
)
def test_a_value_beyond_its_limit_is_not_shown_as_the_limit(value, limit, shown):
    row = AlarmRow("DRUM_OFF", Severity.HIGH, "winch", "off by {by:+.2f} m, limit {limit:.2f} m")
    assert alarm_table(row).alarm("DRUM_OFF", by=value, limit=limit).brief == f"DRUM_OFF: off by {shown}"


def test_alarms_are_read_from_the_lines_of_several():
    raised = [TABLE.alarm("SENSOR_LOST, MRU: stale", age=1.0), TABLE.alarm("CABLE_SLACK", tension=2.0)]
    found = alarms_in(f"winch_controller: alarms: {'; '.join(map(str, raised))}")
    assert [(one.code, one.severity, one.text) for one in found] == [(a.code, a.severity, a.text) for a in raised]
    assert math.isnan(found[0].time)


def test_alarms_with_their_times_are_read_from_a_line():
    raised = [TABLE.alarm("SENSOR_LOST, MRU: stale", age=1.25), TABLE.alarm("CABLE_SLACK", tension=8.0)]
    line = "; ".join(f"{time_key(time)}: {alarm}" for time, alarm in zip((1.05, 2.0), raised, strict=True))
    for text in (line, f"winch_controller: alarms: {line}"):
        found = alarms_in(text)
        assert [(one.time, one.code, one.text) for one in found] == [
            (1.05, "SENSOR_LOST, MRU", raised[0].text),
            (2.0, "CABLE_SLACK", raised[1].text),
        ]


def test_a_line_with_a_code_that_no_table_has_any_more_is_read():
    (read,) = alarms_in("t = 3.00 s: MRU_STALE (high): no data for 0.31 s.")
    assert (read.code, read.severity, read.time) == ("MRU_STALE", Severity.HIGH, 3.0)


@pytest.mark.parametrize(
    "text", ["", "frozen: its readings do not change", "SENSOR_LOST, MRU: no severity", "x (high): y"]
)
def test_a_text_without_a_code_holds_no_alarm(text):
    assert alarms_in(text) == []


def test_a_value_that_is_missing_or_unknown_is_refused():
    for values in ({}, {"age": 1.0, "limit": 2.0}):
        with pytest.raises(ValueError, match="SENSOR_LOST, MRU: stale takes the values"):
            TABLE.alarm("SENSOR_LOST, MRU: stale", **values)


def test_a_code_is_in_a_table_once_and_in_capitals():
    with pytest.raises(ValueError, match="SENSOR_LOST, MRU: stale"):
        alarm_table(STALE, STALE)
    with pytest.raises(ValueError, match="stale"):
        alarm_table(AlarmRow("stale", Severity.LOW, "mru", "x"))


EACH = """
each:
  mru: {loss: high, lost: Compensation fades out}
  imu: {loss: low, lost: Nothing}
SENSOR_LOST:
  parts: [mru, imu]
  severity: <loss>
  consequence: <lost>
  reasons:
    stale: {state: "no data for {age:.1f} s", action: Check <part>}
    jumps:
      - {parts: [imu], state: it jumps}
      - {parts: [mru], severity: low, state: heave jumps}
CABLE_SLACK: {severity: medium, part: cable, state: "tension {tension:.1f} kN"}
"""


def test_a_file_holds_a_row_for_each_code_and_one_for_each_part_and_reason(tmp_path):
    file = tmp_path / "alarms.yaml"
    file.write_text(EACH)
    table = read_alarms(file)
    stale = "no data for {age:.1f} s"
    assert list(table.values()) == [
        AlarmRow("SENSOR_LOST, MRU", Severity.HIGH, "mru", stale, "Compensation fades out", "Check mru", "stale"),
        AlarmRow("SENSOR_LOST, IMU", Severity.LOW, "imu", stale, "Nothing", "Check imu", "stale"),
        AlarmRow("SENSOR_LOST, IMU", Severity.LOW, "imu", "it jumps", "Nothing", reason="jumps"),
        AlarmRow("SENSOR_LOST, MRU", Severity.LOW, "mru", "heave jumps", "Compensation fades out", reason="jumps"),
        SLACK,
    ]
    assert table["SENSOR_LOST, IMU: jumps"] in table.of_code("SENSOR_LOST, IMU")


@pytest.mark.parametrize(
    ("was", "becomes", "fault"),
    [
        ("state: it", "words: it", "unexpected keyword argument 'words'"),
        ("severity: medium, ", "", "'severity'"),
        ("medium", "grave", "'GRAVE'"),
        ("<lost>", "<gone>", "'gone'"),
    ],
)
def test_a_row_that_is_not_complete_is_refused_with_file_and_code(tmp_path, was, becomes, fault):
    file = tmp_path / "alarms.yaml"
    file.write_text(EACH.replace(was, becomes))
    with pytest.raises(ValueError, match=rf"alarms.yaml: \S+: missing or unknown: .*{fault}"):
        read_alarms(file)
