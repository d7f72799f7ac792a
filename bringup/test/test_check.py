"""An external node held against its contract, and the page that says what the contract is."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from heave_bringup.external import contract
from heave_bringup.external.check import Heard, Plan, WinchTrial, judge_topic, judge_winch
from heave_bringup.external.contract import COMMAND, CONTRACTS, MRU, STATE
from heave_node.cdr.definitions import schema_text
from heave_node.interface.topics import ALL_TOPICS
from heave_node.tick.clock_rule import ClockRule

PAGE = Path(__file__).parents[2] / "docs" / "contract.md"


def heard(**changes) -> Heard:
    """Return what a node says that does everything right: 20 Hz for 5 s, stamps 20 ms old."""
    times = np.arange(100) * 0.05
    values = {
        "publishers": ["/mine"],
        "types": ["heave_msgs/msg/MruSample"],
        "arrivals": list(times),
        "clock": list(times + 0.05),
        "stamps": list(times + 0.03),
        "counter": list(range(1, 101)),
    }
    return Heard(**(values | changes))


def test_a_node_that_does_everything_right_is_as_the_contract_says():
    assert all(finding.is_good for finding in judge_topic(MRU, heard()))


def test_a_rate_that_the_contract_leaves_open_is_not_expected_to_be_any():
    (found,) = [finding for finding in judge_topic(replace(MRU, rate=0.0), heard()) if finding.what == "rate"]
    assert found.words.startswith("20.0 Hz, jitter")


@pytest.mark.parametrize(
    ("changes", "what", "words"),
    [
        ({"publishers": []}, "publisher", "it has no publisher"),
        ({"publishers": ["/mine", "/other"]}, "publisher", "/mine, /other"),
        ({"types": ["std_msgs/msg/String"]}, "type", "std_msgs/msg/String"),
        ({"refusals": ["Best effort publisher and reliable subscription"]}, "quality of service", "Best effort"),
        ({"arrivals": []}, "messages", "none received"),
        ({"arrivals": list(np.arange(100) * 0.2)}, "rate", "5.0 Hz (expected 10)"),
        ({"stamps": [*np.arange(1, 100) * 0.05, 0.0]}, "clock", "its messages have no stamp"),
        ({"clock": list(np.arange(100) * 0.05 + 0.6)}, "clock", "up to 0.57 s older than the clock"),
        ({"stamps": list(4.9 + np.arange(100) * -1e-3), "clock": [4.92] * 100}, "clock", "stamps do not increase"),
        ({"bad": {"heave": 3}}, "numbers", "heave 3 times"),
        ({"counter": [1, 2, *range(4, 102)]}, "sequence", "1 of 99 steps are not 1"),
    ],
)
def test_what_is_wrong_is_named(changes, what, words):
    (wrong,) = [finding for finding in judge_topic(MRU, heard(**changes)) if not finding.is_good]
    assert wrong.what == what
    assert words in wrong.words


@pytest.mark.parametrize(
    ("stamps", "rule", "words"),
    [
        (1.7e9 + np.arange(100) * 0.05, "detect", "own clock: offset -1699999999.9"),
        (1.7e9 + np.arange(100) * 0.05, "simulated", "ahead of simulated time"),
        (np.zeros(100), "detect", "no stamp: time of arrival"),
        (np.arange(100) * 0.05 + 0.03, "none", "declared to send no stamps"),
        (np.arange(100) * 0.05 + 0.03, "simulated", "simulated time; jitter 0.0 ms"),
    ],
)
def test_each_clock_of_the_contract_is_told_and_one_that_is_not_the_declared_one_is_wrong(stamps, rule, words):
    found = judge_topic(MRU, heard(stamps=list(stamps)), ClockRule(rule))
    (clock,) = [finding for finding in found if finding.what == "clock"]
    assert words in clock.words
    assert clock.is_good == (rule == "detect" or words.startswith("simulated"))


PLAN = Plan(braked=4.0, released=8.0, silent=10.5, acknowledged=11.5, end=14.0)


def trial(
    fault_of_silence: int = 1, release_of_silence: int = 1, *, brakes_alone: bool = True, obeys: bool = True
) -> list[WinchTrial]:
    """Return what a winch says that reacts within 0.7 s."""
    said = []
    for time in np.arange(0.0, PLAN.end, 0.05):
        phase = PLAN.phase(time - 0.7)
        is_alone = phase in ("silent", "braked again")
        brake = (phase.startswith("braked") or (is_alone and brakes_alone)) if obeys else False
        told = round(time / 0.05)
        fault, release = (fault_of_silence, release_of_silence) if is_alone else (0, 0)
        said.append(WinchTrial(float(time), told, told - 4, brake, fault, release))
    return said


def test_a_winch_that_brakes_releases_and_stops_by_itself_is_as_the_contract_says():
    assert all(finding.is_good for finding in judge_winch(PLAN, trial()))


@pytest.mark.parametrize(
    ("said", "what"),
    [
        (trial(brakes_alone=False), "stops without commands"),
        (trial(fault_of_silence=0), "reports why it stopped"),
        (trial(release_of_silence=0), "says what it waits for"),
        (trial(obeys=False), "brakes on command"),
        ([], "brakes on command"),
    ],
)
def test_a_winch_that_does_not_do_as_it_must_is_named(said, what):
    assert what in [finding.what for finding in judge_winch(PLAN, said) if not finding.is_good]


def test_the_page_is_what_the_code_says():
    assert PAGE.read_text() == contract.page(), "python -m heave_bringup.external.contract > docs/contract.md"


def test_every_topic_that_the_loop_needs_of_a_node_stands_in_its_contract():
    for one in CONTRACTS:
        needed = {topic for topic in ALL_TOPICS if topic.publisher == one.node and topic.is_needed}
        assert {port.topic for port in one.publishes if port.is_required} == needed


def test_every_field_that_is_checked_is_one_of_its_message():
    for port in (COMMAND, STATE, MRU):
        text = schema_text(port.topic.type)
        for name, largest in port.numbers:
            assert f"float64 {name}" in text
            assert math.isfinite(largest)
