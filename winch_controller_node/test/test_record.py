"""The last minutes as the adviser keeps them, and the assumed corrections of its sensors."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.adviser.record import LENGTH, TICK, VALUE, Record, SensorHistory, payouts
from winch_controller_node.beliefs.beliefs import AS_READ, Correction, EncoderScale

DT = 0.05
BATCH = 20


def filled(batch_of, count, **each):
    record = Record(DT)
    for k in range(count):
        record.add(batch_of(BATCH * k, **each))
    return record


def test_batches_that_follow_one_another_are_one_record(batch_of):
    record = Record(DT)
    for k in range(4):
        record.add(batch_of(100 + BATCH * k, command=float(k)))
    excerpt = record.last(2.0)
    assert record.duration == pytest.approx(4.0)
    assert (excerpt.first, excerpt.last) == (140, 179)
    assert list(excerpt.tick_column("command")) == BATCH * [2.0] + BATCH * [3.0]


def test_a_part_of_a_second_is_a_whole_batch(batch_of):
    assert len(filled(batch_of, 5).last(1.5).ticks) == 2 * BATCH


def test_what_is_longer_than_the_record_is_all_of_it(batch_of):
    assert len(filled(batch_of, 5).last(60.0).ticks) == 5 * BATCH


@pytest.mark.parametrize("another", [{"first": 4 * BATCH, "epoch": 1}, {"first": 5 * BATCH}, {"first": 3 * BATCH}])
def test_a_jump_of_the_state_or_a_batch_that_is_missing_begins_a_new_record(batch_of, another):
    record = filled(batch_of, 4)
    record.add(batch_of(**another))
    assert record.duration == pytest.approx(1.0)
    assert record.last(60.0).first == another["first"]


def test_no_more_than_two_minutes_are_kept(batch_of):
    record = filled(batch_of, 200)
    assert LENGTH - 1.0 <= record.duration <= LENGTH + 1.0
    assert record.last(LENGTH).last == 200 * BATCH - 1


def test_readings_stand_in_the_order_of_their_own_ticks_however_late_they_came(batch_of):
    late = [
        {"tick": 3, "delivered": 3, "row": "mru_heave", "value": 1.0},
        {"tick": 1, "delivered": 5, "row": "unit_heave", "value": 2.0},
        {"tick": 3, "delivered": 7, "row": "unit_heave", "value": 3.0},
    ]
    record = Record(DT)
    record.add(batch_of(0, readings=late))
    assert list(record.last(1.0).readings[:, VALUE]) == [2.0, 1.0, 3.0]


def test_measurements_are_chosen_and_numbered_anew_and_what_is_older_than_the_record_is_left_out(excerpt_of):
    readings = [
        {"tick": 9, "row": "mru_heave", "value": 1.0},
        {"tick": 12, "row": "payout", "value": 2.0},
        {"tick": 13, "row": "unit_heave", "value": 3.0},
        {"tick": 40, "row": "unit_heave", "value": 4.0},
    ]
    chosen = excerpt_of(10, readings, first=10).of(("unit_heave", "mru_heave"))
    assert [(row[VALUE], row[2]) for row in chosen.readings] == [(3.0, 0.0), (4.0, 0.0)]
    # one stamped for after the end belongs to the last tick
    assert list(chosen.readings[:, TICK]) == [13.0, 19.0]


# assumed properties of sensors


def of_sensors(excerpt_of):
    readings = [
        {"tick": tick, "row": row, "value": value}
        for tick in range(4)
        for row, value in (("mru_heave", 3.0), ("mru_heave_rate", 6.0), ("unit_heave", 5.0), ("payout", 7.0))
    ]
    return excerpt_of(4, readings)


def values(excerpt, history, row):
    mine = excerpt.is_row(row)
    return list(excerpt.corrected(history)[mine])


def test_a_correction_is_of_its_sensor_from_its_tick_on_and_of_a_rate_without_the_offset(excerpt_of):
    excerpt = of_sensors(excerpt_of)
    history = SensorHistory((("mru", 2, Correction(scale=2.0, offset=1.0)),))
    assert values(excerpt, history, "mru_heave") == [3.0, 3.0, 1.0, 1.0]
    assert values(excerpt, history, "mru_heave_rate") == [6.0, 6.0, 3.0, 3.0]
    assert values(excerpt, history, "unit_heave") == [5.0] * 4


def test_a_later_correction_takes_the_place_of_the_one_before(excerpt_of):
    excerpt = of_sensors(excerpt_of)
    history = SensorHistory((("depth", 1, Correction(scale=-1.0)), ("depth", 3, AS_READ)))
    assert values(excerpt, history, "unit_heave") == [5.0, -5.0, -5.0, 5.0]
    assert history.correction("depth") == AS_READ
    assert history.correction("mru") == AS_READ


@given(
    st.lists(st.floats(0.2, 5.0) | st.floats(-5.0, -0.2), min_size=1, max_size=4),
    st.integers(0, 2**31),
)
def test_the_payout_is_that_of_the_drum_whatever_scales_the_encoder_has_had_one_after_the_other(scales, seed):
    """It counts on in another scale: no step where one begins, and what the drum does in between is exact."""
    random = np.random.default_rng(seed)
    drum = np.cumsum(random.normal(0.0, 0.05, 200)) + 1.0
    since = np.linspace(0, 200, len(scales) + 1).astype(int)[:-1]
    read, position, known = np.empty(200), 0.7, []
    for tick in range(200):
        scale = scales[int(np.searchsorted(since, tick, side="right")) - 1]
        position += scale * (drum[tick] - drum[tick - 1]) if tick else 0.0
        read[tick] = position
        if tick in since:
            known.append(EncoderScale(tick, scale, position, drum[tick]))
    found = payouts(read, np.arange(200), known)
    np.testing.assert_allclose(found, drum, atol=1e-9)


def test_an_encoder_without_a_scale_of_its_own_reads_the_payout():
    assert list(payouts(np.array([1.0, math.pi]), np.arange(2), ())) == [1.0, math.pi]
    assert SensorHistory().encoder_scale == 1.0
