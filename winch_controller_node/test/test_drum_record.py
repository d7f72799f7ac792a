"""What a drum was ordered and read, and by how much its orders came later than usual."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.adviser.drum.drum_record import FACTOR, START_PAYOUT, DrumRecord, drum_record, lateness
from winch_controller_node.adviser.record import SensorHistory
from winch_controller_node.beliefs.beliefs import EncoderScale
from winch_controller_node.beliefs.drum import drum_of
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05
COUNT = 200


def taken_with(delays):
    """Return sequence and newest order in effect at the end of each tick, for `delays` [ticks] of the orders.

    Order k, of tick k, is in effect from k + its delay on, none before the one sent before it. Before the record
    orders came just as they do in it.
    """
    effect = np.maximum.accumulate(np.arange(len(delays)) + delays)
    place = np.arange(len(delays))
    taken = np.searchsorted(effect, place + 1.0 + 1e-9, side="right") - 1.0
    return 100.0 + place, 100.0 + taken, effect - place


@given(st.floats(0.0, 12.0), st.integers(0, 100))
def test_a_constant_delay_is_never_late(delay, first):
    sequence, taken, _ = taken_with(np.full(COUNT, delay))
    assert not np.any(lateness(sequence + first, taken + first))


@given(st.integers(1, 8), st.floats(1e-4, 0.02), st.integers(0, 2**31))
def test_a_millisecond_about_the_edge_of_a_tick_is_no_lateness(edge, jitter, seed):
    """0.200 s of ticks of 0.05 s lies on an edge: 1 ms is 0.02 of a tick."""
    random = np.random.default_rng(seed)
    sequence, taken, _ = taken_with(edge + random.uniform(-jitter, jitter, COUNT))
    assert not np.any(lateness(sequence, taken))


@given(st.floats(2.0, 8.0), st.floats(1.0, 6.0), st.integers(0, 2**31))
def test_what_is_late_is_known_to_a_tick_beside_what_is_usual(usual, jitter, seed):
    """The winch shows at the end of each tick what is in effect: a bracket of one tick about each moment."""
    random = np.random.default_rng(seed)
    delays = usual + np.where(random.uniform(size=COUNT) < 0.2, random.uniform(0.0, jitter, COUNT), 0.0)
    sequence, taken, true = taken_with(delays)
    late = lateness(sequence, taken)
    known = slice(10, COUNT - 20)
    # beside one usual delay each is within a tick of where it was
    assert np.ptp(late[known] - true[known]) <= 2.0 + 1e-9


@given(st.integers(2, 8), st.integers(2, 8), st.integers(50, 150))
def test_a_delay_that_grows_in_mid_record_is_late_from_there_on(usual, further, at):
    delays = usual + 0.5 + np.where(np.arange(COUNT) >= at, float(further), 0.0)
    sequence, taken, _ = taken_with(delays)
    late = lateness(sequence, taken)[: COUNT - 20]
    steps = late[at:] - late[: at - 1].mean()
    assert steps == pytest.approx(further, abs=1.0)


@given(st.floats(0.5, 8.0), st.sets(st.integers(5, COUNT - 5), max_size=60), st.integers(0, 12))
def test_states_that_do_not_come_make_no_order_late(delay, single, gap):
    """Of an order that is taken meanwhile it is known no better than that."""
    sequence, taken, _ = taken_with(np.full(COUNT, delay))
    taken[list(single)] = np.nan
    taken[80 : 80 + gap] = np.nan
    assert not np.any(lateness(sequence, taken))


@given(st.floats(2.0, 6.0), st.integers(0, 2**31))
def test_no_order_is_taken_before_the_one_before_it(usual, seed):
    random = np.random.default_rng(seed)
    sequence, taken, _ = taken_with(usual + random.uniform(0.0, 5.0, COUNT))
    taken[random.integers(0, COUNT, 30)] = np.nan
    effect = np.arange(COUNT) + lateness(sequence, taken)
    assert np.all(np.diff(effect) >= -1e-12)


@pytest.mark.parametrize("known", [0, 1])
def test_a_winch_that_says_nothing_tells_no_lateness(known):
    taken = np.full(COUNT, np.nan)
    taken[:known] = 5.0
    assert not np.any(lateness(np.arange(COUNT, dtype=float), taken))


def test_numbers_that_do_not_follow_one_another_tell_none():
    """A controller that was restarted counts from 1."""
    sequence, taken, _ = taken_with(np.full(COUNT, 3.5))
    sequence[100:] -= 77.0
    assert not np.any(lateness(sequence, taken))


# the record


def excerpt_with(excerpt_of, count=400, **columns):
    sequence, taken, _ = taken_with(np.full(count, 3.5))
    known = {
        "order_rate": 0.1 * np.ones(count),
        "sequence": sequence,
        "taken": taken,
        "encoder": 0.01 * np.arange(count),
    }
    return excerpt_of(count, **(known | columns))


def test_a_record_is_as_long_as_its_window_with_the_orders_of_the_longest_delay_before_it(excerpt_of):
    record = drum_record(excerpt_with(excerpt_of), 10.0, 12, SensorHistory(), 0.0)
    assert len(record.readings) == 200
    assert len(record.rates) == 212
    assert record.duration == pytest.approx(10.0)
    assert record.readings[-1] == pytest.approx(3.99)


def test_a_record_begins_after_the_brake(excerpt_of):
    brake = np.zeros(400)
    brake[:300] = 1.0
    record = drum_record(excerpt_with(excerpt_of, brake=brake), 10.0, 12, SensorHistory(), 0.0)
    assert len(record.readings) == 400 - 301
    # a braked drum was ordered nothing
    assert not np.any(record.rates[:11])


def test_a_drum_that_is_braked_to_the_end_has_none(excerpt_of):
    assert drum_record(excerpt_with(excerpt_of, brake=np.ones(400)), 10.0, 12, SensorHistory(), 0.0) is None


def test_readings_are_payouts_by_what_is_believed_of_the_encoder(excerpt_of):
    history = SensorHistory(encoder=(EncoderScale(250, 2.0, 2.5, 2.5),))
    record = drum_record(excerpt_with(excerpt_of), 10.0, 12, history, 0.0)
    assert record.readings[-1] == pytest.approx(2.5 + (3.99 - 2.5) / 2.0)
    assert record.readings[0] == pytest.approx(2.0)


def test_a_factor_of_the_encoder_counts_from_its_onset_on():
    """Of a drum that goes at 0.5 m/s: 0.025 m a tick, and twice as much from the reading 50 on."""
    winch = WinchControllerParameters().winch
    theta = np.array([*drum_of(winch), 1.0, 0.0, 0.5])
    rates = np.full(112, 0.5)
    record = DrumRecord(
        np.zeros(112), rates, np.zeros(112), np.zeros(112), np.zeros(100), np.zeros(100, bool), 0.0, DT, onset=50
    )
    thetas = np.array([theta, theta])
    thetas[1, FACTOR] = 2.0
    plain, doubled = record.simulated(thetas)
    np.testing.assert_allclose(np.diff(plain), 0.025, atol=1e-12)
    np.testing.assert_allclose(np.diff(doubled), np.where(np.arange(99) < 49, 0.025, 0.05), atol=1e-12)
    assert record.simulated(thetas[1:])[0, 49] == plain[49]
    assert START_PAYOUT == FACTOR + 1


def jumping():
    """Return a record with a break at reading 30 and an onset at 60, theta of its drum, and what it simulates."""
    theta = np.array([*drum_of(WinchControllerParameters().winch), 1.0, 0.0, 0.5])
    theta[FACTOR] = 0.5
    rates = 0.5 + 0.3 * np.sin(0.1 * np.arange(112))
    none = np.zeros(112)
    record = DrumRecord(none, rates, none, none, np.zeros(100), np.zeros(100, bool), 0.0, DT, onset=60, breaks=(30,))
    return record, theta, record.simulated(theta[None, :])[0]


@pytest.mark.parametrize("missing", [(), (30, 60, 61), tuple(range(25, 35))], ids=str)
@given(at_break=st.floats(-2.0, 2.0), at_onset=st.floats(-2.0, 2.0), noise=st.integers(0, 2**31))
def test_what_is_left_does_not_depend_on_how_far_the_encoder_jumped_at_a_break_or_an_onset(
    missing, at_break, at_onset, noise
):
    record, theta, drum = jumping()
    readings = drum + 0.01 * np.random.default_rng(noise).standard_normal(100)
    readings[list(missing)] = np.nan
    place = np.arange(100)
    jumped = readings + np.where(place >= 30, at_break, 0.0) + np.where(place >= 60, at_onset, 0.0)
    plain, same = (dataclasses.replace(record, readings=one).residuals(theta[None, :]) for one in (readings, jumped))
    np.testing.assert_allclose(same, plain, atol=1e-12)
    # before the first of them a jump is one of the drum
    elsewhere = dataclasses.replace(record, readings=readings + np.where(place >= 10, 1.0, 0.0))
    assert np.ptp(elsewhere.residuals(theta[None, :])[0, :25]) > 0.9


@pytest.mark.parametrize("jump", [-0.4, 0.0, 1.5])
def test_how_far_an_encoder_jumped_at_the_onset_is_known(jump):
    record, theta, drum = jumping()
    jumped = dataclasses.replace(record, readings=drum + np.where(np.arange(100) >= 60, jump, 0.0))
    assert jumped.step(theta) == pytest.approx(jump, abs=1e-12)


@pytest.mark.parametrize("after", [(), (80,)], ids=str)
@given(at_break=st.floats(-2.0, 2.0), at_onset=st.floats(-2.0, 2.0))
def test_the_jump_at_an_onset_is_that_of_the_encoder_there_alone(after, at_break, at_onset):
    record, theta, drum = jumping()
    place = np.arange(100)
    jumped = drum + np.where(place >= 30, at_break, 0.0) + np.where(place >= 60, at_onset, 0.0)
    for one in after:
        jumped += np.where(place >= one, 1.0, 0.0)
    record = dataclasses.replace(record, readings=jumped, breaks=(*record.breaks, *after))
    assert record.step(theta) == pytest.approx(at_onset, abs=1e-9)
