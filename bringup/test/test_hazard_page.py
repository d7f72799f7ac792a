"""The page of hazards is made of the tables: each fault, each urgent alarm and each forced change of mode has a row."""

import re
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

import pytest
from heave_bringup.pages.alarms import TABLES
from heave_bringup.pages.hazards import DEVICES, HAZARDS, hazards_of, page
from heave_node.interface.alarm import Severity
from heave_node.interface.fault_kinds import FAULTS, faults_of
from winch_controller_node.core.supervision.modes import Event

ROOT = Path(__file__).parents[2]
NAMES = [one.name for one in HAZARDS]
CODES = {row.code for table in TABLES.values() for row in table.values()}
FORCED = (Event.WINCH_EMERGENCY_STOP, Event.WINCH_FAULT, Event.WINCH_SILENT, Event.SENSOR_LOST, Event.HARM)
"""Events that take a mode from an operator who has not asked for that."""


def unnamed(hazards):
    """Return the codes of high and critical alarms that none of the hazards names."""
    patterns = [pattern for one in hazards for pattern in one.alarms]
    rows = [row for table in TABLES.values() for row in table.values() if row.severity >= Severity.HIGH]
    return [row.code for row in rows if not any(fnmatchcase(row.code, pattern) for pattern in patterns)]


def test_the_page_of_the_documentation_is_the_tables():
    assert (ROOT / "docs" / "hazards.md").read_text() == page(), (
        "python -m heave_bringup.pages.hazards > docs/hazards.md"
    )


def test_every_kind_of_device_has_a_column():
    assert {device for fault in FAULTS.values() for device in fault.devices} == set(DEVICES)


@pytest.mark.parametrize("device", DEVICES)
def test_every_fault_of_a_device_is_the_cause_of_a_hazard(device):
    assert [kind for kind in faults_of(device) if kind != "clear" and not hazards_of(device, kind)] == []


def test_no_hazard_names_a_fault_that_its_device_cannot_have():
    wrong = [(kind, device) for one in HAZARDS for device, kinds in one.causes.items() for kind in kinds]
    assert [pair for pair in wrong if pair[0] not in faults_of(pair[1])] == []


def test_every_urgent_alarm_detects_a_hazard():
    assert unnamed(HAZARDS) == []


def test_an_alarm_that_no_row_names_is_found():
    silent = [replace(one, alarms=tuple(code for code in one.alarms if code != "DRIVE_AT_FAULT")) for one in HAZARDS]
    assert unnamed(silent) == ["DRIVE_AT_FAULT"]


@pytest.mark.parametrize("one", HAZARDS, ids=NAMES)
def test_every_detection_is_an_alarm_that_exists(one):
    assert one.alarms
    assert [pattern for pattern in one.alarms if not any(fnmatchcase(code, pattern) for code in CODES)] == []


def test_every_change_of_mode_that_nobody_requested_is_a_reaction():
    assert [event for event in FORCED if not any(event in one.events for one in HAZARDS)] == []


@pytest.mark.parametrize("one", HAZARDS, ids=NAMES)
def test_every_hazard_has_tests_that_exist(one):
    assert one.tests
    for test in one.tests:
        file, _, name = test.partition("::")
        assert re.search(rf"^def {name}\(", (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE), test


@pytest.mark.parametrize("one", HAZARDS, ids=NAMES)
def test_every_hazard_says_what_is_done_how_soon_and_what_remains(one):
    assert all((one.reaction, one.time, one.residual))
    assert one.causes or one.others or one.alarms
