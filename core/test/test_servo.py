"""The drum under its set-points beside scipy: the linear servo by `lsim`, its limits by quadrature of its equation."""

import math

import numpy as np
import pytest
from heave_core.watch import Drum, DrumOrders, drum_records, run_of, sent_points
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import lsim

from tests.core_parts import drum_error, drum_ordered

DT, AHEAD, COUNT = 0.05, 10, 100
NOTHING = np.zeros(AHEAD + COUNT)
UNKNOWN = np.full(AHEAD + COUNT, math.nan)


COMPARED = 40


def orders_of(drum):
    """Return what watches a `drum`, which is assumed and nominal."""
    kept = {"kept": COUNT + 2 * AHEAD, "ahead": AHEAD - 1, "checked": COUNT + 1, "ordered": COMPARED}
    limits = {"least_seen": 0.8, "settled": 50.0, "least_motion": 0.004}
    return DrumOrders({**kept, **limits, "run": run_of(0.0, DT)[0], "assumed": drum, "nominal": drum})


def waves(size, seed=1):
    """Return rates of two waves, at most some 1.5 times `size` [m/s]; none before the record begins."""
    time, phase = DT * np.arange(COUNT), np.random.default_rng(seed).uniform(0.0, 6.0)
    return np.concatenate([np.zeros(AHEAD), size * (np.sin(1.7 * time + phase) + 0.5 * np.sin(2.9 * time))])


def record(drum, rates, *, payouts=NOTHING, tensions=UNKNOWN, start=(0.0, 0.0), gain=0.0, late=NOTHING):
    """Return the readings of one drum."""
    drums = np.array([drum], dtype=float)
    return drum_records(sent_points(payouts, rates, late, tensions), drums, np.array([start]), gain, COUNT, DT)[0]


@settings(max_examples=40, deadline=None)
@given(
    lag=st.floats(0.02, 2.0),
    delay=st.floats(0.0, 0.45),
    gain=st.floats(0.5, 1.5),
    start=st.tuples(st.floats(-100.0, 100.0), st.floats(-1.0, 1.0)),
    seed=st.integers(0, 1000),
)
def test_a_servo_within_its_limits_is_the_linear_lag_behind_its_delay(lag, delay, gain, start, seed):
    rates = waves(0.5, seed)
    found = record(Drum(lag, delay, gain), rates, start=start)
    # set-points as they act, on a grid that has each of their steps
    fine = 200
    times = DT / fine * np.arange(COUNT * fine + 1)
    acting = np.floor((times - round(delay / DT * fine) * DT / fine) / DT + 1e-9).astype(int)
    acting = np.clip(acting + AHEAD, 0, len(rates) - 1)
    system = ([[0.0, 1.0], [0.0, -1.0 / lag]], [[0.0], [gain / lag]], [[1.0, 0.0]], [[0.0]])
    _, exact, _ = lsim(system, rates[acting], times, X0=start, interp=False)
    # the delay is rounded to the grid: half a step of it at the largest change of a rate
    assert found == pytest.approx(exact[fine::fine], abs=1e-6 + 0.75 * gain * DT / fine)


@pytest.mark.parametrize(
    ("field", "limit"), [("acceleration_out", 0.4), ("acceleration_in", 0.4), ("acceleration_in", 0.2)]
)
def test_a_limit_of_the_acceleration_holds_as_a_quadrature_has_it(field, limit):
    rates = waves(0.6)
    found = record(Drum(0.15, 0.0, **{field: limit}), rates)
    least = -limit if field == "acceleration_in" else -math.inf
    most = limit if field == "acceleration_out" else math.inf
    state, exact = np.zeros(2), []
    for rate in rates[AHEAD:]:
        slope = lambda _, x, v=rate: [x[1], min(max((v - x[1]) / 0.15, least), most)]  # noqa: E731
        state = solve_ivp(slope, (0.0, DT), state, rtol=1e-9, atol=1e-11, max_step=0.002).y[:, -1]
        exact.append(state[0])
    assert found == pytest.approx(np.array(exact), abs=2e-5)


def test_a_position_loop_holds_a_payout_as_a_quadrature_has_it():
    gain, lag, payouts = 1.5, 0.2, np.full(AHEAD + COUNT, 0.7)
    found = record(Drum(lag, 0.0), NOTHING, payouts=payouts, gain=gain)
    times = DT * np.arange(1, COUNT + 1)
    exact = solve_ivp(
        lambda _, x: [x[1], (gain * (0.7 - x[0]) - x[1]) / lag], (0.0, times[-1]), [0.0, 0.0], t_eval=times
    )
    # it steps by 5 ms
    assert found == pytest.approx(exact.y[0], abs=2e-3)


@settings(max_examples=40, deadline=None)
@given(size=st.floats(0.1, 3.0), speed=st.floats(0.1, 1.0), power=st.floats(1e4, 1e5), seed=st.integers(0, 1000))
def test_a_drum_keeps_its_limits_whatever_it_is_sent(size, speed, power, seed):
    random, tension = np.random.default_rng(seed), 1e5
    rates, tensions = size * random.standard_normal(AHEAD + COUNT), np.full(AHEAD + COUNT, tension)
    drum = Drum(0.1, 0.1, speed_out=speed, speed_in=speed, acceleration_out=2.0, acceleration_in=2.0, power=power)
    travel = np.diff(record(drum, rates, tensions=tensions)) / DT
    assert np.max(np.abs(travel)) <= min(speed, power / tension) + 1e-9
    assert np.max(np.abs(np.diff(travel))) <= 2.0 * DT + 1e-9


@settings(max_examples=40, deadline=None)
@given(
    start=st.tuples(st.floats(-50.0, 50.0), st.floats(-0.5, 0.5)), lag=st.floats(0.1, 0.5), seed=st.integers(0, 1000)
)
def test_payout_and_rate_at_the_start_are_those_that_the_first_readings_show(start, lag, seed):
    """The readings are of the drum itself: half of them say how it began, and with that what the last one is."""
    drum, rates = Drum(lag, 0.1), waves(0.5, seed)
    orders, readings = orders_of(drum), record(drum, rates, start=start)
    for rate, reading in zip(rates, [*[math.nan] * (AHEAD - 1), start[0], *readings], strict=True):
        orders.add(0.0, rate, math.nan, reading, False)
    assert drum_error(orders) == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(share=st.floats(-2.0, 2.0), lag=st.floats(0.1, 0.5), seed=st.integers(0, 1000))
def test_what_an_encoder_reads_of_its_orders_is_numpys_least_squares(share, lag, seed):
    """The encoder reads `share` times what the drum does, and noise."""
    drum, rates = Drum(lag, 0.1), waves(0.5, seed)
    orders, path = orders_of(drum), record(drum, rates)
    read = share * path + 0.01 * np.random.default_rng(seed).standard_normal(COUNT)
    for rate, reading in zip(rates, [*[math.nan] * (AHEAD - 1), 0.0, *read], strict=True):
        orders.add(0.0, rate, math.nan, reading, False)
    ordered = drum_ordered(orders)
    (wanted, _), rest, *_ = np.polyfit(path[-COMPARED:], read[-COMPARED:], 1, full=True)
    if ordered is not None:
        assert ordered.share == pytest.approx(wanted, abs=1e-9)
        assert ordered.left == pytest.approx(math.sqrt(rest[0] / COMPARED) / np.std(read[-COMPARED:]), abs=1e-9)
        assert ordered.payout == pytest.approx(read[-COMPARED - 1] + path[-1] - path[-COMPARED - 1], abs=1e-9)
        assert not ordered.is_limited


def test_play_of_the_gear_holds_the_reading_while_the_drum_turns_back():
    rates = np.concatenate([np.full(AHEAD + 50, 0.2), np.full(50, -0.2)])
    plain, loose = (record(Drum(1e-3, 0.0, backlash=play), rates) for play in (0.0, 0.03))
    assert loose[:50] == pytest.approx(plain[:50] - 0.015, abs=1e-9)
    assert np.ptp(loose[49:52]) == 0.0, "it stands while the play is taken up"
    assert loose[60:] == pytest.approx(plain[60:] + 0.015, abs=1e-9)


def test_arrays_of_another_shape_are_refused_in_one_line():
    drums, starts = np.array([Drum(0.1, 0.0)]), np.zeros((1, 2))
    for sent, some in ((np.zeros((4, 9)), drums), (np.zeros((3, 20)), drums), (np.zeros((4, 20)), drums[:, :12])):
        with pytest.raises(
            ValueError, match=r"^drum: set-points \(.*\) for 10 ticks, drums \(1, 1[23]\), starts \(1, 2\)$"
        ):
            drum_records(sent, some, starts, 0.0, 10, DT)
