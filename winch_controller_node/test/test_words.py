"""Each finding has a sentence: what, value and what to do; the winch, and the sea, one for all that is new of them."""

import pytest
from heave_node.interface.codes import WINCH_LEARNT
from winch_controller_node.adviser.report import Report
from winch_controller_node.beliefs.beliefs import Finding
from winch_controller_node.beliefs.quantities import QUANTITIES
from winch_controller_node.beliefs.words import SEA_LABELS, SENTENCES, WINCH_LABELS, sentences

TOLD = [name for name in QUANTITIES if name != "mru.bias_sigma"]
"""What a drift is held with is no finding of its own."""

SENSORS = ("mru", "depth", "encoder")


@pytest.mark.parametrize("name", TOLD)
def test_each_quantity_that_differs_has_one_sentence_with_its_owner_and_its_value(name):
    quantity = QUANTITIES[name]
    # a power is said in kW
    size = 1e3 if quantity.unit == "W" else 1.0
    (told,) = sentences([Finding("differs", name, 1.25 * size, quantity.unit, size, 60.0, 100)])
    assert quantity.owner in told
    assert "{" not in told
    # a wander has no size that a person can use
    assert name == "mru.bias_drift" or any(value in told for value in ("1.25", "1.250", "1.2", "1"))


@pytest.mark.parametrize("name", [name for name in TOLD if name not in WINCH_LABELS and name not in SEA_LABELS])
def test_each_quantity_that_is_nominal_again_has_a_sentence(name):
    (told,) = sentences([Finding("nominal", name, 1.0, "", 1.2)])
    assert QUANTITIES[name].owner in told


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("code", ["excluded", "recovered"])
def test_a_sensor_that_is_excluded_or_used_again_is_named(code, sensor):
    (told,) = sentences([Finding(code, sensor)])
    assert told.startswith(sensor)


@pytest.mark.parametrize("owner", ["winch", "cable", "mru"])
def test_what_was_found_and_cannot_be_designed_for_is_named_and_said_not_to_be_used(owner):
    (told,) = sentences([Finding("refused", owner)])
    assert told.startswith(owner)
    assert "not used" in told


def test_all_that_is_new_of_the_winch_is_one_sentence_and_so_is_that_of_the_sea():
    findings = [Finding("differs", name, 0.5, QUANTITIES[name].unit, 1.0) for name in (*WINCH_LABELS, *SEA_LABELS)]
    winch, sea = sentences(findings)
    assert winch.startswith(WINCH_LEARNT)
    assert all(label in winch for label in WINCH_LABELS.values())
    assert all(label in sea for label in SEA_LABELS.values())


def test_nothing_new_says_nothing():
    assert sentences(()) == []


def test_every_quantity_is_in_one_of_the_tables():
    assert {*SENTENCES, *WINCH_LABELS, *SEA_LABELS} == set(TOLD)


def test_the_report_knows_no_quantity_without_a_sentence():
    from winch_controller_node.adviser import report  # noqa: PLC0415

    assert {*report.RELATIVE, *report.ABSOLUTE} <= set(TOLD)
    assert Report.__name__ == "Report"
