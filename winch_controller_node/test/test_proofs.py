"""Proofs by nominal values and raw readings: twins by NumPy and SciPy, and a load that is moved as it should not be."""

import math

import numpy as np
import pytest
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import MruReading
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal, stats
from winch_controller_node.core.supervision.proofs import SHORTEST, CountCheck, Driven, MotionProof, Proofs, Standing
from winch_controller_node.interface.readings import Measurements, ScalarReading, WinchOrder, WinchReading
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.comparison import CERTAIN, Fit, fitted
from winch_controller_node.model.nominal_load import NominalLoad
from winch_controller_node.model.simulated_unit import SimulatedUnit
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import EntryParameters

TICK = 0.05
CABLE = CableModel(a=7.2, b=0.05, stiffness=17.5e3, static_tension=98.6e3, unit_weight=70e3)
"""The 900 m of the benchmarks, in round figures."""
SEA = 2.0 * math.pi / 9.0
"""Frequency of a wave of 9 s [rad/s]."""


def heave(time):
    """Return heave and rate of two waves of 0.5 and 0.3 m, not quite of one frequency."""
    w, v = SEA, 1.31 * SEA
    return 0.5 * math.sin(w * time) + 0.3 * math.sin(v * time), 0.5 * w * math.cos(w * time) + 0.3 * v * math.cos(
        v * time
    )


def mru(time, scale=1.0, status=MruStatus.OK):
    z, rate = heave(time)
    return (MruReading(time, scale * z, scale * rate, status=status),)


def truth(seconds, cable=CABLE):
    """Return times, boom tip and unit under a locked drum, by SciPy."""
    time = np.arange(0.0, seconds, TICK)
    tip = np.array([heave(t)[0] for t in time])
    unit = signal.lsim(([1.0], [cable.a, cable.b, 1.0]), tip, time)[1]
    return time, tip, unit


def braked(proof, seconds, scale=1.0, *, tension=1.0, depth=1.0, seed=1, cable=CABLE):
    """Lead a load under a locked drum past a proof; the sensors' signs and scales are as given, None: not there."""
    rng = np.random.default_rng(seed)
    load = NominalLoad(CABLE, 900.0, TICK)
    for k, (time, tip, unit) in enumerate(zip(*truth(seconds, cable), strict=True)):
        load.step(mru(time, scale))
        force = (
            ()
            if tension is None
            else (ScalarReading(time, 98.6e3 + tension * 17.5e3 * (tip - unit) + 100.0 * rng.normal()),)
        )
        down = () if depth is None or k % 2 else (ScalarReading(time, 900.0 - depth * unit + 0.02 * rng.normal()),)
        if load.is_known:
            proof.add(load, force, down)
    return load


# the fit


def test_a_fit_is_that_of_numpy_with_all_columns_at_once():
    rng = np.random.default_rng(1)
    t = TICK * np.arange(400)
    x = np.cumsum(rng.normal(size=400))
    y = 0.8 * x + 3.0 - 0.2 * t + 2.0 * np.sin(0.4 * t + 1.0) + rng.normal(size=400)
    columns = np.stack([x, np.ones_like(t), t, np.cos(0.4 * t), np.sin(0.4 * t)], axis=1)
    (slope, *_), *_ = np.linalg.lstsq(columns, y, rcond=None)
    fit = fitted(y, x, TICK, 0.4)
    assert fit.scale == pytest.approx(slope, rel=1e-9)
    # partial correlation: of what either is off the other columns
    rest = [v - columns[:, 1:] @ np.linalg.lstsq(columns[:, 1:], v, rcond=None)[0] for v in (x, y)]
    assert fit.correlation == pytest.approx(stats.pearsonr(*rest).statistic, rel=1e-9)


def test_the_standard_error_of_white_residuals_is_that_of_scipy():
    rng = np.random.default_rng(2)
    x = np.sin(0.3 * np.arange(400)) + 0.001 * np.arange(400)
    y = 0.7 * x + rng.normal(size=400)
    line = stats.linregress(x, y)
    fit = fitted(y, x, 1.0, 0.0)
    assert fit.certainty == pytest.approx(line.slope / line.stderr, rel=0.1)


@pytest.mark.parametrize("memory", [0.0, 0.8, 0.95])
def test_the_error_of_the_slope_is_no_smaller_than_what_slopes_scatter_by_whatever_the_memory_of_the_residual(memory):
    """By 300 draws: the slope over the stated error has a standard deviation of about 1, as Student's t has."""
    rng = np.random.default_rng(3)
    x = np.sin(SEA * TICK * np.arange(400))
    ratios = []
    for _ in range(300):
        rest = signal.lfilter([1.0], [1.0, -memory], rng.normal(size=600))[200:]
        fit = fitted(rest, x, TICK, 0.0)
        ratios.append(fit.certainty)
    assert 0.5 < np.std(ratios) < 1.4
    assert np.max(np.abs(ratios)) < CERTAIN


def test_what_does_not_move_proves_nothing():
    assert not fitted(np.ones(100), np.arange(100.0) ** 2, TICK, 0.0).proves
    assert not fitted(np.arange(100.0), np.ones(100), TICK, 0.0).is_sure


# the nominal load


def test_the_nominal_unit_is_that_of_scipy():
    time, _, unit = truth(60.0)
    load = NominalLoad(CABLE, 900.0, TICK)
    found = []
    for t in time:
        load.step(mru(t))
        found.append(load.unit)
    # the rate of the first tick is that of the wave, which SciPy's unit at rest does not know
    assert np.max(np.abs(np.array(found) - unit)[200:]) < 0.02


def test_noise_of_the_heave_shakes_a_short_cable_by_less_than_half_of_what_it_would_unblended():
    short = CableModel(a=0.13, b=0.001, stiffness=52e3, static_tension=36.5e3, unit_weight=25e3)
    rng, load, plain = np.random.default_rng(1), NominalLoad(short, 300.0, TICK), SimulatedUnit(short, TICK)
    blended, unblended = [], []
    for k in range(1200):
        z, rate = 0.01 * rng.normal(), 0.005 * rng.normal()
        load.step((MruReading(k * TICK, z, rate),))
        blended.append(load.stretch)
        unblended.append(z - plain.state[0])
        plain.step(np.array([z, rate]))
    assert np.std(blended) < 0.5 * np.std(unblended)


def test_a_motion_without_rate_a_slower_one_and_one_that_is_late_are_followed():
    for every, with_rate, late in ((1, False, 0.0), (4, True, 0.0), (1, True, 0.2), (2, True, 0.05)):
        load, off = NominalLoad(CABLE, 900.0, TICK), []
        for k in range(800):
            readings = ()
            if k % every == 0 and k * TICK >= late:
                z, rate = heave(k * TICK - late)
                readings = (MruReading(k * TICK - late, z, rate if with_rate else math.nan),)
            load.step(readings)
            if k > 100:
                off.append(load.heave - heave(load.time)[0])
        assert np.max(np.abs(off)) < 0.02
        assert load.is_known


def test_an_mru_that_is_lost_or_says_that_it_is_invalid_is_not_known():
    load = NominalLoad(CABLE, 900.0, TICK)
    for k in range(100):
        load.step(mru(k * TICK))
    assert load.is_known
    for k in range(100, 120):
        load.step(mru(k * TICK, status=MruStatus.INVALID))
    assert not load.is_known


def test_wire_that_is_paid_out_makes_the_cable_softer():
    load = NominalLoad(CABLE, 900.0, TICK)
    load.pay_out(450.0)
    assert load.cable.stiffness == pytest.approx(17.5e3 / 1.5)
    assert load.cable.a == pytest.approx(7.2 * 1.5)


# the proof of the MRU


@pytest.mark.parametrize(("tension", "depth"), [(1.0, 1.0), (1.0, None), (None, 1.0)])
@pytest.mark.parametrize("seed", range(3))
def test_a_sound_mru_is_proved_and_a_reversed_one_is_named_by_either_witness(tension, depth, seed):
    for scale, standing in ((1.0, Standing.PROVED), (-1.0, Standing.REVERSED), (0.3, Standing.SCALED)):
        proof = MotionProof(TICK)
        braked(proof, 25.0, scale, tension=tension, depth=depth, seed=seed)
        assert proof.standing is standing
        assert proof.fit.scale == pytest.approx(1.0 / scale, rel=0.2)


def test_a_proof_comes_within_the_time_that_the_estimate_settles_in():
    proof = MotionProof(TICK)
    braked(proof, SHORTEST + 2.5)
    assert proof.standing is Standing.PROVED


def test_one_witness_that_is_wired_the_other_way_does_not_outweigh_one_that_proves():
    proof = MotionProof(TICK)
    braked(proof, 25.0, tension=-1.0)
    assert (proof.standing, proof.witness) == (Standing.PROVED, "depth sensor")


def test_without_a_witness_or_with_one_that_says_nothing_it_is_said():
    proof = MotionProof(TICK)
    braked(proof, 15.0, tension=None, depth=None)
    assert (proof.standing, proof.witness) == (Standing.ALONE, "")
    proof = MotionProof(TICK)
    braked(proof, 30.0, tension=0.0, depth=None)
    assert proof.standing is Standing.OPEN
    proof = MotionProof(TICK)
    braked(proof, 75.0, tension=0.0, depth=None)
    assert (proof.standing, proof.witness) == (Standing.ALONE, "load cell")


def test_in_calm_water_there_is_nothing_to_prove():
    proof, load = MotionProof(TICK), NominalLoad(CABLE, 900.0, TICK)
    rng = np.random.default_rng(1)
    for k in range(600):
        load.step((MruReading(k * TICK, 0.01 * rng.normal(), 0.005 * rng.normal()),))
        if load.is_known:
            proof.add(load, (ScalarReading(k * TICK, 98.6e3 + 100.0 * rng.normal()),), ())
    assert proof.standing is Standing.QUIET


def test_a_free_swing_that_a_stop_has_left_does_not_hide_the_motion():
    """0.4 m of it, half of the sea's own."""
    proof, load = MotionProof(TICK), NominalLoad(CABLE, 900.0, TICK)
    for time, tip, unit in zip(*truth(25.0), strict=True):
        load.step(mru(time))
        swing = 0.4 * math.cos(time / math.sqrt(CABLE.a))
        if load.is_known:
            proof.add(load, (ScalarReading(time, 98.6e3 + 17.5e3 * (tip - unit - swing)),), ())
    assert proof.standing is Standing.PROVED
    assert proof.fit.scale == pytest.approx(1.0, rel=0.1)


def test_what_was_certain_is_not_forgotten_for_a_record_that_says_nothing_and_is_for_one_that_says_another_thing():
    proof = MotionProof(TICK)
    braked(proof, 25.0)
    proof.restart()
    braked(proof, 25.0, tension=0.0, depth=None)
    assert proof.standing is Standing.PROVED
    proof.restart()
    braked(proof, 25.0, -1.0)
    assert proof.standing is Standing.REVERSED
    proof.reset()
    assert proof.standing is Standing.OPEN


# the count


def counted(steps, rates, period=TICK):
    check, count = CountCheck(), 0.0
    for k, (step, rate) in enumerate(zip(steps, rates, strict=True)):
        count += step
        if found := check.step(WinchReading(k * period, count, rate, False)):
            return k * period, found
    return None


@given(st.lists(st.floats(-2.0, 2.0), min_size=50, max_size=200), st.booleans())
def test_a_count_that_goes_by_its_speed_is_never_told(rates, is_mean):
    """Whether the speed is the mean of the interval or that at its end."""
    rates = signal.lfilter([0.2], [1.0, -0.8], rates)
    steps = np.array(rates) * TICK
    if not is_mean:
        steps[1:] = 0.5 * (rates[1:] + rates[:-1]) * TICK
    assert counted(steps, rates) is None


def test_a_count_that_drifts_from_its_speed_is_told():
    time = TICK * np.arange(400)
    rates = 0.2 * np.sin(SEA * time)
    at, found = counted(rates * TICK + 0.15 * TICK, rates)
    assert found.code == "COUNT_SPEED_DISAGREE"
    assert at < 5.0
    assert counted(rates * TICK, 0.0 * rates) is None, "a drive that states no speed"
    assert counted(rates * TICK, math.nan * rates) is None
    assert counted(-rates * TICK, rates)[1].code == "COUNT_SPEED_DISAGREE"


# together


def controlled(parameters=None, *, seconds=40.0, scale=1.0, tension=1.0, asks=None):
    """Lead a load under the brake past all proofs, and return what came of it last, and all alarms."""
    proofs = Proofs(parameters or WinchControllerParameters(length=900.0), CABLE, TICK)
    alarms, proven = [], None
    driven = Driven(waits=True, hangs=True)
    for k, (time, tip, unit) in enumerate(zip(*truth(seconds), strict=True)):
        if asks is not None and time >= asks:
            proofs.ask(consent=True)
            asks = None
        scalar = (
            {} if tension is None else {"load_cell": (ScalarReading(time, 98.6e3 + tension * 17.5e3 * (tip - unit)),)}
        )
        raw = Measurements(mru(time, scale), scalar, WinchReading(time, 0.0, 0.0, brake=True))
        proven = proofs.step(raw, driven)
        alarms += proven.alarms
        proofs.note(WinchOrder(k, 0.0, 0.0, brake=True))
    return proven, [alarm.code for alarm in alarms]


def test_compensation_may_begin_once_the_mru_is_proved_and_not_before():
    proven, alarms = controlled(seconds=SHORTEST - 1.0)
    assert "proving the MRU" in proven.gate
    assert alarms == []
    assert controlled() == (controlled(seconds=30.0)[0]._replace(alarms=()), [])
    assert controlled()[0].gate == ""


def test_a_reversed_mru_is_refused_whatever_an_operator_consents_to():
    for asks in (None, 35.0):
        proven, alarms = controlled(scale=-1.0, asks=asks)
        assert "MRU REVERSED" in proven.gate
        assert set(alarms) == {"MRU_REVERSED"}


def test_without_a_witness_an_operators_consent_is_asked_for():
    assert "MRU UNPROVED" in controlled(tension=None)[0].gate
    assert controlled(tension=None)[1] == ["MRU_UNPROVED"]
    assert controlled(tension=None, asks=20.0)[0].gate == ""
    assert "MRU SCALE UNPROVED" in controlled(scale=0.3)[0].gate
    assert controlled(scale=0.3, asks=30.0)[0].gate == ""
    stated = WinchControllerParameters(length=900.0, entry=EntryParameters(accept_unproved=True))
    assert controlled(stated, tension=None, seconds=SHORTEST + 2.0)[0].gate == ""
    assert controlled(stated, tension=None)[1] == []


def test_what_the_envelope_ended_for_harm_is_proved_again_without_the_old_consent():
    proofs = Proofs(WinchControllerParameters(length=900.0), CABLE, TICK)
    proofs.ask(consent=True)
    harm = Driven(waits=False, hangs=True, taken_over="LOAD_SWUNG_HIGHER")
    proofs.step(Measurements(mru(0.0)), harm)
    assert not proofs.consent
    assert "proving the MRU" in proofs.step(Measurements(), harm).gate


@pytest.mark.parametrize(
    ("scale", "certainty", "refutes"),
    [
        (0.6, 5.0, False),
        (0.59, 5.0, False),
        (2.1, 6.0, False),
        (2.1, 27.0, True),
        (0.5, 27.0, True),
        (-0.3, -6.0, True),
    ],
)
def test_a_slope_that_is_outside_by_chance_says_nothing_against_the_mru(scale, certainty, refutes):
    """A sound MRU was named for a slope of 0.597 with a standard error of 0.12, in waves of 0.42 m over 300 m."""
    fit = Fit(scale, math.copysign(0.7, scale), certainty)
    assert fit.refutes is refutes
    assert not fit.proves or not refutes
