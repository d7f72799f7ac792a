"""Stamps of hardware in simulated time, against clocks whose offset, drift and delays are made up here."""

import numpy as np
import pytest
from heave_node.tick.clock_rule import ClockRule, parse_clock
from heave_node.tick.external_clock import ExternalClock
from hypothesis import given, settings
from hypothesis import strategies as st

SECOND = 1_000_000_000


def play(clock: ExternalClock, *, offset: float, drift: float, delays: np.ndarray, rate: float = 20.0) -> np.ndarray:
    """Return by how much the clock's answers differ from the true times of measurement [s].

    Hardware whose clock shows (t - offset)/(1 + drift) measures at `rate` [Hz]; each message comes after its delay [s].
    """
    errors = []
    for k, delay in enumerate(delays, start=1):
        time = k / rate
        stamp = round((time - offset) / (1.0 + drift) * SECOND)
        errors.append(clock.simulated_time(stamp, round((time + delay) * SECOND)) / SECOND - time)
    return np.array(errors)


@settings(max_examples=15)
@given(
    offset=st.floats(-2e9, -100.0),
    drift=st.floats(-100e-6, 100e-6),
    least=st.floats(0.0, 0.02),
    seed=st.integers(0, 1000),
)
def test_an_own_clock_is_read_to_within_its_least_delay_and_a_millisecond(offset, drift, least, seed):
    # delays of a busy machine: exponential beyond the least one (mean 2 ms); the least of 20 is 0.1 ms above it
    delays = least + np.random.default_rng(seed).exponential(0.002, 20 * 60)
    clock = ExternalClock()
    errors = play(clock, offset=offset, drift=drift, delays=delays)
    assert clock.rule is ClockRule.OWN
    assert np.abs(errors[400:] - least).max() < 1e-3
    assert clock.drift == pytest.approx(drift, abs=20e-6)
    assert clock.jitter == pytest.approx(0.002, rel=0.3), "the standard deviation of that distribution is its mean"


@pytest.mark.parametrize("lasting", [5, 20])
@pytest.mark.parametrize("drift", [-30e-6, 30e-6])
def test_messages_that_were_late_for_a_while_leave_no_wrong_offset(lasting, drift):
    """Late by 0.3 s with true stamps: a regression had them 0.14 s too new meanwhile, and 0.1 s too old after."""
    delays = 0.01 + np.random.default_rng(1).exponential(0.002, 20 * 180)
    delays[20 * 70 : 20 * (70 + lasting)] += 0.3
    errors = play(ExternalClock(), offset=-1e6, drift=drift, delays=delays)
    assert np.abs(errors[400:] - 0.01).max() < 2e-3


def test_a_better_offset_puts_no_message_before_one_that_was_measured_earlier():
    """The first two of a run come 50 ms late, the third with the second: it was taken for one out of order."""
    errors = play(ExternalClock(), offset=-1.7e9, drift=0.0, delays=np.array([0.05, 0.05, 0.03, 0.03, 0.01]), rate=50.0)
    assert np.diff(errors).min() > -1.0 / 50.0
    assert errors[-1] == pytest.approx(0.01, abs=1e-6)


def test_a_drift_of_days_does_not_add_up():
    clock = ExternalClock(ClockRule.OWN)
    errors = play(clock, offset=-1.7e9, drift=50e-6, delays=np.zeros(200_000), rate=1.0)
    assert np.abs(errors[100:]).max() < 1e-5


@pytest.mark.parametrize("step", [-5.0, 5.0, 3600.0])
def test_a_clock_that_is_set_is_read_anew_within_ten_messages(step):
    clock = ExternalClock(ClockRule.OWN)
    play(clock, offset=-1e9, drift=0.0, delays=np.full(200, 0.01))
    errors = play(clock, offset=-1e9 - step, drift=0.0, delays=np.full(200, 0.01))
    assert np.abs(errors[10:]).max() < 0.02


def test_simulated_time_passes_unchanged_and_its_delay_is_shown():
    clock = ExternalClock()
    errors = play(clock, offset=0.0, drift=0.0, delays=np.tile([0.01, 0.03], 100))
    assert clock.rule is ClockRule.SIMULATED
    assert np.abs(errors).max() < 1e-9
    assert clock.jitter == pytest.approx(0.01, rel=0.05)
    assert clock.violations == 0


def test_a_message_without_stamp_is_of_its_arrival():
    clock = ExternalClock()
    assert clock.simulated_time(0, 7 * SECOND) == 7 * SECOND
    assert clock.rule is ClockRule.NONE


@pytest.mark.parametrize(
    ("declared", "stamp", "words"),
    [
        ("simulated", 1_700_000_000 * SECOND, "its stamps are 1.69999e+09 s ahead of simulated time"),
        ("simulated", 0, "its messages have no stamp: their time of arrival is used"),
        ("own", 0, "its messages have no stamp: their time of arrival is used"),
        ("none", SECOND, "its messages are stamped, but it is declared to send no stamps: they are ignored"),
    ],
)
def test_what_does_not_fit_the_declaration_is_said(declared, stamp, words):
    clock = ExternalClock(ClockRule(declared))
    clock.simulated_time(stamp, 10_000 * SECOND)
    assert clock.violation == words
    assert clock.violations == 1


def test_a_declaration_names_node_and_clock():
    assert parse_clock("virtual_winch=own") == ("virtual_winch", (ClockRule.OWN, 0.0))
    assert parse_clock("mru=none:0.04") == ("mru", (ClockRule.NONE, 0.04))
    with pytest.raises(ValueError, match=r"must be NODE=CLOCK\[:LATENCY\], CLOCK one of detect, simulated, own, none"):
        parse_clock("virtual_winch=utc")


@pytest.mark.parametrize("rule", [ClockRule.SIMULATED, ClockRule.OWN, ClockRule.NONE])
def test_a_latency_that_is_declared_is_taken_off_whatever_the_clock(rule):
    """A sensor that measures 46 ms before it stamps, or before its message comes where it has no stamp."""
    clock, answers = ExternalClock(rule, 0.046), []
    for k in range(1, 400):
        measured = 100.0 + 0.05 * k
        stamped = measured + 0.046
        stamp = {ClockRule.SIMULATED: stamped, ClockRule.OWN: stamped + 1.7e9, ClockRule.NONE: 0.0}[rule]
        answers.append(clock.simulated_time(round(stamp * SECOND), round(stamped * SECOND)) / SECOND - measured)
    assert answers == pytest.approx(len(answers) * [0.0], abs=1e-6)
    assert "latency of 46 ms taken off" in clock.describe()


def test_a_delay_of_simulated_stamps_is_shown_as_it_is_and_not_as_its_spread():
    clock = ExternalClock()
    for k in range(100):
        clock.simulated_time(100 * SECOND + k, 100 * SECOND + k + round((0.92 + 0.06 * (k % 2)) * SECOND))
    assert "920.0 to 980.0 ms behind at arrival" in clock.describe()
