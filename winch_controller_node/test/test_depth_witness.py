"""What the depth sensor has seen, against motions whose truth is known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.signal import lsim
from winch_controller_node.estimation.depth_witness import (
    CORRELATED,
    LEAST_READINGS,
    LONGEST_GAP,
    LONGEST_SLACK,
    WINDOWS,
    DepthWitness,
    driven_unit,
)
from winch_controller_node.identification.encoder_scale import CLEARLY
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.models import shadow_model

DT = 0.05
CABLE = CableModel(a=0.4, b=0.05)
"""A period of 4 s, damped to 4 %: what swings freely at first still does so at the end."""
COUNT = round(max(WINDOWS) / DT)
NOISE = 0.02
EVERY = 2
"""Ticks from one reading of the depth sensor to the next."""

SHARES = [0.5, -1.0, 2.0, 0.8]
MEAN_PAYOUT, FIRST_PAYOUT = 0.7, 12.0
"""Out before the record begins less the mean depth, and what the encoder reads there [m]."""


def swung(time, motion, start=(0.0, 0.0)):
    """Return heave and rate of a unit under a boom tip's `motion` [m] at each `time` [s]: a x'' + b x' + x = motion."""
    a, b = CABLE.a, CABLE.b
    system = ([[0.0, 1.0], [-1.0 / a, -b / a]], [[0.0], [1.0 / a]], np.eye(2), np.zeros((2, 1)))
    return lsim(system, motion, time, X0=start)[1]


def test_a_driven_unit_is_the_exact_solution_where_the_boom_tip_moves_straight():
    """The exponential of unit and ramp together, tick by tick; one straight line for all time by `lsim`."""
    model, a, b = shadow_model(CABLE, DT), CABLE.a, CABLE.b
    continuous = [[0.0, 1.0, 0.0, 0.0], [-1.0 / a, -b / a, 1.0 / a, 0.0], [0.0, 0.0, 0.0, 1.0], np.zeros(4)]
    tick = expm(DT * np.array(continuous))
    motion = np.random.default_rng(1).standard_normal((200, 2))
    wanted = [np.array([0.3, -0.2])]
    for tip in motion[:-1]:
        wanted.append((tick @ [*wanted[-1], *tip])[:2])
    np.testing.assert_allclose(driven_unit(model.A, model.B, motion, wanted[0]), wanted, atol=1e-12)

    time = DT * np.arange(400)
    straight = np.column_stack([0.2 - 0.1 * time, np.full(len(time), -0.1)])
    unit = driven_unit(model.A, model.B, straight, np.array([0.5, 0.0]))
    np.testing.assert_allclose(unit, swung(time, straight[:, 0], (0.5, 0.0)), atol=1e-9)


class Motion:
    """A unit under boom tip and drum, from before the record on.

    The encoder reads what is true over a share: the depth sensor sees that share of it.
    """

    def __init__(self, *, of_drum=1.0):
        fine, before = 10, 20.0
        time = DT / fine * np.arange(round(before / DT) * fine + COUNT * fine + 1)
        later = time - before
        tip = 0.8 * np.sin(0.7 * later + 0.4) + 0.3 * np.sin(1.1 * later)
        # the drum was stirred near the unit's resonance before the record begins
        stirred = np.where(later < -0.5, 0.3 * np.sin(1.5 * (later + 0.5)), 0.0)
        payout = MEAN_PAYOUT + 0.5 * np.sin(0.9 * later) + 0.2 * np.sin(1.3 * later) + stirred
        uncompensated, by_drum = swung(time, tip), swung(time, -(payout - payout[0])) - [payout[0], 0.0]
        ticks = slice(round(before / DT) * fine, None, fine)
        self.payout, self.unit = payout[ticks], (uncompensated + by_drum)[ticks]
        self.boom_tip = np.column_stack([tip, np.gradient(tip, time)])[ticks]
        self.encoder = FIRST_PAYOUT + (self.payout - self.payout[0]) / of_drum

    def read(self, k, tick, heave_noise=0.0):
        """Return what is read at a `tick`, k after the first: payout, boom tip and depth."""
        return self.encoder[k], self.boom_tip[k], [(tick * DT, heave_noise - self.unit[k, 0])]

    def witness(self, *, noise=0.0, seed=0, every=EVERY, first=0):
        """Return the witness after the record."""
        rng, witness = np.random.default_rng(seed), DepthWitness(CABLE, DT)
        for k in range(COUNT + 1):
            error = noise * rng.standard_normal() if k % every == 0 else 0.0
            payout, boom_tip, depths = self.read(k, first + k, error)
            witness.add(first + k, payout, boom_tip, depths if k % every == 0 else [])
        return witness


@pytest.mark.parametrize("share", SHARES)
def test_the_share_of_the_payout_that_the_unit_shows_is_found(share):
    """Within 4 of its sigmas; so are payout and unit, whose errors are of the order of the noise."""
    truth = Motion(of_drum=share)
    for seen in truth.witness(noise=NOISE).seen():
        assert seen.share == pytest.approx(share, abs=4.0 * seen.sigma)
        assert 0.0 < seen.sigma < 0.1 * max(abs(share), 1.0)
        assert seen.payout == pytest.approx(truth.payout[-1], abs=4.0 * NOISE)
        assert seen.unit[0] == pytest.approx(truth.unit[-1, 0], abs=4.0 * NOISE)
        # at the resonance of 1.6 rad/s a rate is 1.6 times a heave
        assert seen.unit[1] == pytest.approx(truth.unit[-1, 1], abs=1.6 * 4.0 * NOISE)


@pytest.mark.parametrize("share", SHARES)
def test_without_noise_it_is_exact_but_for_the_rate_that_is_taken_from_the_payout(share):
    """Central differences of a sine of 1.3 rad/s are (1.3 dt)^2 / 6 = 0.07 % too small."""
    truth = Motion(of_drum=share)
    for seen in truth.witness(every=1).seen():
        assert seen.share == pytest.approx(share, rel=1e-3)
        assert seen.left < 1e-3
        assert seen.payout == pytest.approx(truth.payout[-1], abs=1e-3)
        np.testing.assert_allclose(seen.unit, truth.unit[-1], atol=2e-3)


def test_its_sigma_is_that_of_noise_of_which_one_reading_in_four_tells_something():
    """White noise makes errors of 1 / sqrt(CORRELATED) sigmas; 100 of them are known to a quarter or better."""
    truth = Motion(of_drum=0.5)
    found = [truth.witness(noise=NOISE, seed=seed).seen() for seed in range(100)]
    for window in range(len(WINDOWS)):
        errors = [(seen[window].share - 0.5) / seen[window].sigma for seen in found]
        assert np.std(errors) == pytest.approx(1.0 / math.sqrt(CORRELATED), rel=0.25)
        assert abs(np.mean(errors)) < 0.2


def test_what_is_left_is_the_noise_over_what_was_to_be_explained():
    seen = Motion().witness(noise=NOISE, every=1).seen()[-1]
    truth = Motion()
    by_boom_tip = swung(DT * np.arange(COUNT + 1), truth.boom_tip[:, 0])[:, 0]
    assert seen.left == pytest.approx(NOISE / np.std(truth.unit[:, 0] - by_boom_tip), rel=0.3)


def interrupted(*, gap=0.0, slack=0.0):
    """Return the witness of a record, and of a second one after a `gap` of the encoder or a `slack` cable [s]."""
    truth, witness = Motion(of_drum=0.5), DepthWitness(CABLE, DT)
    for k in range(COUNT + 1):
        payout, boom_tip, depths = truth.read(k, k)
        is_unread, is_slack = k - COUNT + 100 in range(round(gap / DT)), k - COUNT + 100 in range(round(slack / DT))
        witness.add(k, None if is_unread else payout, boom_tip, depths, is_slack=is_slack)
    return witness


def test_a_reading_of_the_encoder_that_is_missing_interrupts_no_record():
    """One that has jumped is left out; for its tick the drum counts as standing, at 0.05 s of 0.6 m/s."""
    for seen in interrupted(gap=DT).seen():
        assert seen.share == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("interruption", [{"gap": LONGEST_GAP + 2 * DT}, {"slack": LONGEST_SLACK + 2 * DT}])
def test_a_long_gap_or_a_cable_that_is_slack_for_long_begins_a_new_record(interruption):
    """It ends less than 5 s before the end of the record: too late for 6 and 8 s."""
    assert [one is not None for one in interrupted(**interruption).seen()][1:] == [False, False]


def test_a_record_tells_what_its_length_allows():
    truth, witness, told = Motion(of_drum=0.5), DepthWitness(CABLE, DT), []
    for k in range(COUNT + 1):
        witness.add(k, *truth.read(k, k))
        told.append([seen is not None for seen in witness.seen()])
    assert [told.index(known) * DT for known in ([True, False, False], [True, True, False], [True, True, True])] == [
        pytest.approx(window) for window in WINDOWS
    ]


@pytest.mark.parametrize(
    ("every", "told"),
    [
        # 4, 6 and 8 s hold 16, 24 and 32 readings or one more; 8, 12 and 16; 4, 6 and 8
        (5, [True, True, True]),
        (10, [False, True, True]),
        (20, [False, False, False]),
    ],
)
def test_fewer_readings_than_are_needed_tell_nothing(every, told):
    witness = Motion().witness(every=every)
    assert LEAST_READINGS == 12
    assert [seen is not None for seen in witness.seen()] == told


def test_a_record_of_any_tick_says_the_same():
    truth = Motion(of_drum=0.5)
    for seen, later in zip(truth.witness().seen(), truth.witness(first=1_000_000).seen(), strict=True):
        assert later.share == pytest.approx(seen.share, rel=1e-6)


@pytest.mark.parametrize("noise", [0.0, NOISE])
def test_a_drum_that_stands_still_tells_nothing(noise):
    """Any share of nothing explains as much: it is known so badly that no encoder is CLEARLY wrong."""
    truth = Motion()
    truth.encoder[:] = FIRST_PAYOUT
    for seen in truth.witness(noise=noise).seen():
        assert seen.sigma > 100.0
        assert abs(seen.share - 1.0) < CLEARLY * seen.sigma


VALUES = st.lists(st.floats(-1e5, 1e5), min_size=1, max_size=6)


@given(VALUES, VALUES, VALUES, st.sets(st.integers(0, COUNT)), st.integers(1, 15))
def test_whatever_is_read_what_is_seen_is_a_number_or_nothing(payouts, swings, depths, unread, every):
    """Each signal goes round its few values, a single one stands still; the record is full again after the `unread`."""
    witness = DepthWitness(CABLE, DT)
    for k in range(2 * COUNT + 2):
        payout = None if k in unread else payouts[k % len(payouts)]
        read = [(k * DT, depths[k % len(depths)])] if k % every == 0 else []
        witness.add(k, payout, np.full(2, swings[k % len(swings)]), read)
    for seen in witness.seen():
        if seen is not None:
            assert np.all(np.isfinite([seen.share, seen.sigma, seen.left, seen.payout, *seen.unit]))
            assert seen.sigma >= 0.0
            assert seen.left >= 0.0
