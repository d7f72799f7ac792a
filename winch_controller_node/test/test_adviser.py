"""Observations of a second in, beliefs out: what is found of records that are drawn from a model."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest
from heave_node.parameters import build_parameters
from winch_controller_node.adviser import component
from winch_controller_node.adviser.component import Adviser
from winch_controller_node.adviser.hypothesis import SEA_PERIOD
from winch_controller_node.adviser.record import SensorHistory
from winch_controller_node.beliefs.beliefs import Belief
from winch_controller_node.beliefs.quantities import with_value
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.observations import READING_COLUMNS, Observations
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05
SECOND = round(1.0 / DT)
PARAMETERS = build_parameters(
    WinchControllerParameters,
    {
        "length": 900.0,
        "cable_model.inertia": 7.34,
        "cable_model.damping": 0.19,
        "sea.significant_wave_height": 2.5,
        "sea.peak_period": 12.0,
    },
    where="test",
)


@pytest.fixture(scope="module")
def design():
    return design_controller(PARAMETERS, tick_period=DT)


def answers(excerpt, adviser=None):
    """Return the answers of an adviser to a record, second by second; each has come into force by the next."""
    adviser = adviser or Adviser(PARAMETERS, tick_period=DT)
    found = []
    for first in range(0, len(excerpt.ticks), SECOND):
        ticks = excerpt.ticks[first : first + SECOND]
        at = excerpt.readings[:, 1] - excerpt.first
        readings = excerpt.readings[(at >= first) & (at < first + SECOND)]
        number = found[-1].number if found else 0
        found.append(adviser.advise(Observations(excerpt.first + first, ticks, excerpt.rows, readings, 0, number)))
    return found


def since(found, owner):
    """Return the second in which something other than nominal is first assumed of an `owner`."""
    seconds = [k for k, one in enumerate(found) if any(name.startswith(f"{owner}.") for name in one.values)]
    return seconds[0] if seconds else np.inf


@pytest.mark.parametrize("seed", [1, 2])
def test_where_all_is_as_believed_every_answer_is_the_same(design, drawn_from, seed):
    found = answers(drawn_from(design, 70.0, seed=seed))
    assert [one.asked for one in found] == list(range(SECOND - 1, 70 * SECOND, SECOND))
    assert {one.number for one in found} == {0}
    assert not any(one.values or one.excluded or one.findings or one.design or one.adopted for one in found)
    assert {one.authority for one in found} == {1.0}


def test_a_record_that_the_core_has_predicted_is_not_judged_again(design, drawn_from, monkeypatch):
    """One whose innovations are large, or not known, is."""
    asked, judge = [], component.Judge
    monkeypatch.setattr(component, "Judge", lambda *given: asked.append(given) or judge(*given))
    excerpt, counts = drawn_from(design, 60.0), []
    of_depth = excerpt.is_row("unit_heave")
    for nis in (np.ones(len(of_depth)), np.where(of_depth, 1.7, 1.0), np.where(of_depth, np.nan, 1.0)):
        excerpt.readings[:, READING_COLUMNS.index("nis")] = nis
        answers(excerpt)
        counts.append(len(asked))
        asked.clear()
    # from 25 s to 60 s, each 5 s
    assert counts == [0, 8, 8]


def mru_twice(name, value, tick):
    return 2.0 * value if name.startswith("mru") and tick >= 45 * SECOND else value


def test_an_mru_that_reads_twice_as_much_is_found_within_20_seconds_with_the_state_to_go_on_from(design, drawn_from):
    """From 45 s on. No model changes, and so no design."""
    found = answers(drawn_from(design, 80.0, change=mru_twice))
    second = since(found, "mru")
    assert 45 < second < 65
    assert set(found[-1].values) == {"mru.scale"}
    assert found[-1].values["mru.scale"].value == pytest.approx(2.0, rel=0.03)
    first = found[second]
    assert (first.number, first.design) == (1, None)
    assert first.adopted.tick == first.asked
    assert first.adopted.estimate.shape == (design.model.order,)
    assert [(one.code, one.quantity) for one in first.findings] == [("differs", "mru.scale")]
    assert all(not one.findings for one in found[second + 1 :])


@pytest.mark.parametrize(("sensor", "factor"), [("mru", -1.0), ("mru", 2.6), ("depth", -1.0), ("depth", 3.0)])
def test_a_sensor_that_is_reversed_or_of_no_scale_is_excluded_and_not_corrected(design, drawn_from, sensor, factor):
    def other(name, value, tick):
        return factor * value if name.startswith(sensor if sensor == "mru" else "unit") and tick >= 800 else value

    found = answers(drawn_from(design, 90.0, change=other))
    assert found[-1].excluded == sensor
    assert not found[-1].values
    assert [(one.code, one.quantity) for answer in found for one in answer.findings] == [("excluded", sensor)]


@pytest.mark.parametrize("is_read", [True, False])
@pytest.mark.parametrize("lost", ["mru", "payout"])
def test_a_depth_sensor_is_not_judged_where_it_is_not_known_what_moved_the_load(design, drawn_from, lost, is_read):
    """It reads 1.6 times the motion from 40 s on, and the other sensor each two seconds, or as before."""

    def other(name, value, tick):
        if tick < 40 * SECOND:
            return value
        if name.startswith(lost):
            return value if is_read or tick % (2 * SECOND) == 0 else None
        return 1.6 * value if name.startswith("unit") else value

    found = answers(drawn_from(design, 80.0, change=other))
    blamed = {one.quantity for answer in found for one in answer.findings}
    assert blamed == ({"depth.scale"} if is_read else set())


@pytest.mark.parametrize("factor", [0.5, 0.7, 2.0])
def test_an_encoder_that_reads_otherwise_all_at_once_is_found_within_five_seconds(design, drawn_from, factor):
    """From 40 s on it counts on in another scale."""
    last = {}

    def other(name, value, tick):
        if name != "payout":
            return value
        before, read = last.get("payout", value), last.get("read", value)
        read += (factor if tick >= 40 * SECOND else 1.0) * (value - before)
        last.update(payout=value, read=read)
        return read

    found = answers(drawn_from(design, 50.0, size=0.6, change=other))
    second = since(found, "encoder")
    assert 40 <= second <= 45
    assert set(found[-1].values) == {"encoder.scale"}
    assert found[-1].values["encoder.scale"].value == pytest.approx(factor, rel=0.05)
    assert found[-1].encoder.scale == found[-1].values["encoder.scale"].value
    assert abs(found[-1].encoder.since - 40 * SECOND) < SECOND


def test_an_operator_who_states_another_sea_has_what_is_believed_of_sensors_kept(design, drawn_from):
    adviser = Adviser(PARAMETERS, tick_period=DT)
    record = drawn_from(design, 60.0, change=lambda n, v, t: 0.7 * v if n.startswith("mru") else v)
    before = answers(record, adviser)[-1]
    assert set(before.values) == {"mru.scale"}
    batch = Observations(1200, record.ticks[-SECOND:], record.rows, record.readings[:0], 1, before.number)
    after = adviser.advise(dataclasses.replace(batch, restated=(("sea.peak_period", 9.0),)))
    assert after.values == before.values
    assert adviser.parameters.sea.peak_period == 9.0


def test_what_cannot_be_designed_for_is_not_in_the_history_of_the_sensors_either(design, drawn_from, monkeypatch):
    """Else readings would be corrected in the adviser's record, and not in the core."""
    adviser = Adviser(PARAMETERS, tick_period=DT)

    def refuse(parameters, length):
        raise DesignError("test")

    monkeypatch.setattr(adviser, "_designed", refuse)
    monkeypatch.setattr(component, "_needs_design", lambda before, after: True)
    found = answers(drawn_from(design, 80.0, change=mru_twice), adviser)
    assert not any(one.values or one.adopted for one in found)
    assert adviser._history == SensorHistory()


@pytest.mark.parametrize("period", [9.0, 11.0])
def test_a_sea_that_was_assumed_gives_way_to_another_though_the_stated_one_would_do_as_well(period, drawn_from):
    """The stated sea is no other culprit: it is a sea as well."""
    there = with_value(PARAMETERS, "sea.peak_period", period)
    adviser = Adviser(PARAMETERS, tick_period=DT)
    answers(drawn_from(design_controller(there, tick_period=DT)), adviser)
    assert adviser._assume({SEA_PERIOD: Belief(SEA_PERIOD, 21.0)})
    assert adviser._is_sea({SEA_PERIOD: period})


FIRST = """
import sys
from winch_controller_node.adviser import component
from winch_controller_node.design.design import design_controller
from winch_controller_node.node_parameters import WinchControllerParameters
loaded = set(sys.modules)
design_controller(WinchControllerParameters(), tick_period=0.05)
print(sorted(set(sys.modules) - loaded))
"""


def test_the_first_design_of_an_adviser_loads_no_library_within_a_tick():
    """In lockstep each run stood still at tick 37, for up to 0.7 s on a busy machine."""
    done = subprocess.run([sys.executable, "-c", FIRST], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
