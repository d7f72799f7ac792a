"""Every parameter, as a table: what is found, how it is worded, and the page that holds it."""

import json
from pathlib import Path

import pytest
import yaml
from heave_bringup.cli import main
from heave_bringup.nodes import ENVELOPE, NODES
from heave_bringup.pages.parameters import PAGE_COLUMNS, STATED, all_rows, matching, page, range_words, value_words
from heave_node.parameters import describe
from heave_node.system_parameters import own_name

PAGE = Path(__file__).parents[2] / "docs" / "parameters.md"
ROWS = all_rows()


def test_the_page_is_that_of_the_code():
    assert PAGE.read_text() == page(), "python -m heave_bringup.pages.parameters > docs/parameters.md"


def test_what_the_page_states_once_is_the_same_everywhere():
    """The lists of faults of every device, except the kinds it knows; the MRU of controller and envelope."""

    def shown(row):
        return value_words(row.info, row.info.default), row.info.unit, range_words(row.info), row.meaning

    lists = [row for row in ROWS if STATED.fullmatch(row.info.name)]
    names = {row.info.name.rpartition(".")[2] for row in lists}
    assert names == {"kind", "start", "duration", "magnitude", "fitted", "scale_error"}
    for name in names - {"kind"}:
        assert len({shown(row) for row in lists if row.info.name.endswith(f".{name}")}) == 1
    of_controller = {row.info.name: shown(row) for row in ROWS if row.node == "winch_controller"}
    of_envelope = [row for row in ROWS if row.node == ENVELOPE and not row.shared]
    assert of_envelope
    assert [row.info.name for row in of_envelope if of_controller[f"sensors.{row.info.name}"] != shown(row)] == []


def test_every_parameter_of_every_node_has_a_row_with_a_meaning():
    of_controller = {row.info for row in ROWS if row.node == "winch_controller"}
    for node in NODES:
        rows = [row for row in ROWS if row.node == node.name]
        # the envelope alone has groups of the controller, which are there once
        own = [info for info in describe(node.parameters_type()) if node.name != ENVELOPE or info not in of_controller]
        assert [row.info.name for row in rows] == [info.name for info in own]
        assert all(row.meaning.endswith(".") for row in rows)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.node}.{row.info.name}")
def test_a_default_is_written_as_a_scenario_would_write_it_and_is_allowed(row):
    read = yaml.safe_load(value_words(row.info, row.info.default))
    if isinstance(read, str) and row.info.type is float:
        read = float(read)  # YAML 1.1 reads 1e-07 as text
    assert row.info.check(read, where="page") == row.info.default


def test_a_shared_name_is_the_one_that_sets_it():
    shared = [row for row in ROWS if row.shared]
    assert len(shared) > 50
    assert all(own_name(row.node, row.shared) == row.info.name for row in shared)


def names(pattern):
    return [f"{row.node}.{row.info.name}" for row in matching(ROWS, pattern)]


def test_a_pattern_is_a_part_of_the_name_or_has_wildcards_or_is_a_word_of_the_meaning():
    assert names("virtual_winch.speed_limit") == ["virtual_winch.speed_limit"]
    assert "winch_controller.winch.speed_limit" in names("SPEED_LIMIT")
    assert names("mpc.*horizon") == ["winch_controller.mpc.horizon"]
    assert names("system.sea.peak_period") == ["wave_vessel.peak_period", "winch_controller.sea.peak_period"]
    assert "winch_controller.factor" in names("fraction of the boom tip's motion")
    assert "wave_vessel.mru.faults.kind" in names("freeze"), "a value to choose"
    assert names("whale") == []


def test_the_command_prints_what_it_finds(capsys):
    assert main(["params", "winch_controller", "factor"]) == 0
    said = capsys.readouterr().out
    assert "factor" in said
    assert "[0, 1]" in said
    assert "May be changed during a run." in said
    assert main(["params", "speed_limit", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {row["unit"] for row in found} == {"m/s"}
    assert {row["node"] for row in found} == {"virtual_winch", "winch_controller"}


def test_the_command_refuses_what_it_does_not_find_with_the_nearest_name(capsys):
    assert main(["params", "sped_limt"]) == 2
    assert capsys.readouterr().err == "heave: no parameter fits sped_limt; did you mean speed_limit?\n"
    assert main(["params", "whale", "x"]) == 2
    assert "there is no node whale; known: cable_sim," in capsys.readouterr().err


def test_a_bar_in_a_text_does_not_split_a_cell():
    assert all(
        len(line.replace("\\|", "").split("|")) == len(PAGE_COLUMNS) + 2
        for line in page().splitlines()
        if line.startswith("|")
    )
