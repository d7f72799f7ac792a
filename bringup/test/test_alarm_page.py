"""The page of alarms is made of the tables, and the tables hold what the nodes raise."""

import re
from pathlib import Path

import pytest
from heave_bringup.pages.alarms import TABLES, page
from heave_node.interface.alarm import Severity

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "alarms.md"
PACKAGES = {
    "Controller and adviser": "winch_controller_node/winch_controller_node",
    "In front of the controller": "extras/devices/heave_devices",
    "Cable, unit and virtual winch": "cable_sim_node/cable_sim_node",
    "Sea and vessel": "wave_vessel_node/wave_vessel_node",
    "Recorder": "bags/heave_bags/record",
    "Every node": "node_base/heave_node",
}
ROWS = [(title, row) for title, table in TABLES.items() for row in table.values()]


def test_the_page_of_the_documentation_is_the_tables():
    assert PAGE.read_text() == page(), "python -m heave_bringup.pages.alarms > docs/alarms.md"


def test_every_alarm_of_every_table_is_on_the_page():
    text = PAGE.read_text()
    assert [row.code for _, row in ROWS if f"`{row.code.partition(', ')[0]}`" not in text] == []


def test_a_cell_refers_only_to_a_row_of_the_same_code():
    rows = [line.split("|") for line in PAGE.read_text().splitlines() if line.startswith("|`")]
    codes = [row[1].partition(",")[0] for row in rows]
    referring = [number for number, row in enumerate(rows) if "as above" in row]
    assert referring
    assert [rows[number] for number in referring if codes[number - 1] != codes[number]] == []


def test_a_code_means_one_thing_in_all_packages():
    packages = [{row.code for row in table.values()} for table in TABLES.values()]
    assert len(set().union(*packages)) == sum(map(len, packages))


@pytest.mark.parametrize("title", TABLES)
def test_every_alarm_is_raised_somewhere(title):
    """By its code, the part apart, and by its reason."""
    files = (file for file in (ROOT / PACKAGES[title]).rglob("*.py") if not file.name.endswith("alarms.py"))
    text = "".join(file.read_text() for file in files)
    text += (ROOT / "cable_sim_node/cable_sim_node/alarms.py").read_text()  # faults by number
    for row in TABLES[title].values():
        code = row.code.partition(", ")[0].removeprefix(f"{row.part.upper()}_")
        assert code in text
        assert re.search(rf'[":] ?{row.reason}"', text), row.name


@pytest.mark.parametrize("row", [row for _, row in ROWS], ids=[row.name for _, row in ROWS])
def test_an_alarm_that_asks_for_somebody_says_what_to_do_in_few_words(row):
    """ISA-18.2: without an action of the operator it is no alarm. One line of a screen holds some 25 words."""
    assert (row.severity is Severity.EVENT) or row.action or row.consequence
    assert row.severity < Severity.MEDIUM or row.action
    for words in (row.state, row.consequence, row.action):
        assert not words.endswith(".")
        assert len(words.split()) <= 30
