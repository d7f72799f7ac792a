"""A record in columns: what one sensor alone has read, its step, and what a delay of it makes."""

import numpy as np
import pytest
from winch_controller_node.adviser.columns import DELAY, FACTOR, JUDGED, STEP, in_columns
from winch_controller_node.adviser.record import SensorHistory
from winch_controller_node.beliefs.beliefs import Correction
from winch_controller_node.design.design import design_controller
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05
TICKS = 400
OMEGA = 0.7


@pytest.fixture(scope="module")
def measurements():
    return design_controller(WinchControllerParameters(), tick_period=DT).measurements


def heave(tick):
    return np.sin(OMEGA * DT * tick)


@pytest.fixture
def excerpt(excerpt_of, measurements):
    """Return a record in which each sensor reads a sine, the unit's rate grows, and the first command is 1."""
    names = tuple(known.name for known in measurements)
    readings = [
        {"tick": tick, "row": name, "value": heave(tick) + k, "share": 0.1 * k}
        for tick in range(TICKS)
        for k, name in enumerate(names)
    ]
    rates, missing = np.arange(TICKS) / TICKS, np.arange(TICKS) / 7.0
    return excerpt_of(TICKS, readings, names, command=np.ones(TICKS), unit_rate=-rates, missing_push=missing)


def test_the_first_column_is_the_record_as_it_is_and_the_only_one_with_commands(excerpt, measurements):
    columns = in_columns(excerpt, measurements, SensorHistory())
    np.testing.assert_allclose(columns.data.values[:, 0], excerpt.readings[:, 3] - excerpt.readings[:, 4])
    # that of the tick before the record is not in its first state
    assert list(columns.data.commands[:2, 0]) == [0.0, 1.0]
    assert not np.any(columns.data.commands[:, 1:])


def test_each_sensor_has_its_columns_from_each_onset_on_and_the_encoder_for_the_whole_record(excerpt, measurements):
    """An encoder that changes on the way is found from the drum."""
    columns = in_columns(excerpt, measurements, SensorHistory(), onsets=(10.0, 5.0))
    assert columns.onsets == (0, TICKS - 1 - 200, TICKS - 1 - 100)
    assert set(columns.index) == {
        (s, kind, first)
        for s, kinds in JUDGED.items()
        for kind in kinds
        for first in ((0,) if s == "encoder" else columns.onsets)
    }
    for (sensor, _, first), column in columns.index.items():
        mine = excerpt.is_of(sensor) & (excerpt.readings[:, 1] >= first)
        assert not np.any(columns.data.values[~mine, column])


def test_a_factor_on_a_sensor_is_a_multiple_of_its_column(excerpt, measurements):
    """1 + w times what the MRU reads is the record and w times its column; the encoder's counts from its start."""
    columns = in_columns(excerpt, measurements, SensorHistory(), onsets=(5.0,))
    first = columns.onsets[-1]
    mru = excerpt.is_of("mru") & (excerpt.readings[:, 1] >= first)
    np.testing.assert_allclose(columns.data.values[mru, columns.index["mru", FACTOR, first]], excerpt.readings[mru, 3])
    column = columns.data.values[excerpt.is_of("encoder"), columns.index["encoder", FACTOR, 0]]
    np.testing.assert_allclose(column, heave(np.arange(TICKS)) - heave(0), atol=1e-12)


def test_an_offset_is_one_of_the_heave_alone(excerpt, measurements):
    columns = in_columns(excerpt, measurements, SensorHistory(), onsets=())
    np.testing.assert_array_equal(columns.data.values[:, columns.index["mru", STEP, 0]], excerpt.is_row("mru_heave"))


def test_a_delay_is_made_up_for_by_the_slope_of_what_was_read(excerpt, measurements):
    """f(t - d) + d f'(t) is f(t) to (omega d)^2 / 2 of its size: 0.2 % for 2 ticks."""
    late = excerpt.readings.copy()
    mine = excerpt.is_of("mru")
    late[mine, 3] += heave(late[mine, 1] - 2.0) - heave(late[mine, 1])
    delayed = type(excerpt)(excerpt.first, excerpt.ticks, excerpt.rows, late, DT)
    columns = in_columns(delayed, measurements, SensorHistory(), onsets=())
    made_up = columns.data.values[:, 0] + 2.0 * columns.data.values[:, columns.index["mru", DELAY, 0]]
    inner = mine & (late[:, 1] > 1) & (late[:, 1] < TICKS - 2)
    wanted = excerpt.readings[:, 3] - excerpt.readings[:, 4]
    np.testing.assert_allclose(made_up[inner], wanted[inner], atol=1.1 * (OMEGA * 2.0 * DT) ** 2)
    # a delay that is assumed already is compensated from its tick on
    history = SensorHistory((("mru", 100, Correction(delay=2.0 * DT)),))
    assumed = in_columns(delayed, measurements, history, onsets=()).data.values[:, 0]
    since = late[:, 1] >= 100
    np.testing.assert_allclose(assumed[mine & since], made_up[mine & since], atol=1e-12)
    np.testing.assert_allclose(assumed[~since], columns.data.values[~since, 0])


def test_drag_and_slack_of_a_step_go_by_the_state_that_it_begins_with(excerpt, measurements):
    """So they do in the loop's filter; at the first tick nothing else is known."""
    data = in_columns(excerpt, measurements, SensorHistory()).data
    np.testing.assert_allclose(data.unit_speed[1:], np.arange(TICKS - 1) / TICKS)
    np.testing.assert_allclose(data.missing_push[1:], np.arange(TICKS - 1) / 7.0)


def test_a_reading_that_states_its_noise_is_weighed_by_that(excerpt, measurements):
    readings = excerpt.readings.copy()
    readings[5, 6] = 0.5
    stated = type(excerpt)(excerpt.first, excerpt.ticks, excerpt.rows, readings, DT)
    variances = in_columns(stated, measurements, SensorHistory()).data.variances
    assert variances[5] == 0.25
    assert variances[4] == measurements[4 % len(measurements)].sigma ** 2
