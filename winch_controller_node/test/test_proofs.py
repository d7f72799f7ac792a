"""Proofs by nominal values and raw readings: twins by NumPy and SciPy, and a load that is moved as it should not be."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import MruReading
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal, stats
from winch_controller_node.core.supervision.proof_design import CERTAIN, SHORTEST, WINDOW
from winch_controller_node.core.supervision.proofs import Standing
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Measurements, ScalarReading, WinchOrder, WinchReading
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import EntryParameters

from tests.core_parts import Driven, Proofs, SimulatedUnit

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


HANGS = Driven(waits=True, hangs=True)
NOTHING = Measurements()


def made(parameters=None, cable=CABLE):
    return Proofs(parameters or WinchControllerParameters(length=900.0), cable, TICK)


def braked(proofs, seconds, scale=1.0, *, cable=CABLE, tension=1.0, depth=1.0, seed=1, noise=100.0, swing=0.0):
    """Lead a load under a locked drum past the proofs; the sensors' signs and scales are as given, None: not there."""
    rng, begun = np.random.default_rng(seed), float(proofs.state["load"]["time"][0])
    begun = begun + TICK if math.isfinite(begun) else 0.0
    for k, (time, tip, forced) in enumerate(zip(*truth(seconds, cable), strict=True)):
        now, unit = begun + time, forced - swing * math.cos(time / math.sqrt(CABLE.a))
        scalar = {}
        if tension is not None:
            force = 98.6e3 + tension * cable.stiffness * (tip - unit) + noise * rng.normal()
            scalar["load_cell"] = (ScalarReading(now, force),)
        if depth is not None and k % 2 == 0:
            scalar["depth"] = (ScalarReading(now, 900.0 - depth * unit + 0.02 * rng.normal()),)
        reading = mru(time, scale)[0]._replace(time=now)
        proofs.step(Measurements((reading,), scalar), HANGS)


# the fit


def low_passed(values):
    """Return `values` through the low-pass of both sides of a comparison: of the first ones it is the mean."""
    found, kept = [values[0]], math.exp(-TICK / 0.25)
    for count, value in enumerate(values[1:], start=1):
        found.append(value + min(kept, count / (count + 1)) * (found[-1] - value))
    return np.array(found)


@pytest.mark.parametrize("slope", [0.8, 1.2])
def test_a_fit_is_that_of_numpy_with_all_columns_at_once(slope):
    """Of the tension on that of the nominal load, beside an offset, a trend and a free swing."""
    proofs, rng, records = made(), np.random.default_rng(1), []
    for time, *_ in zip(*truth(15.0), strict=True):
        load = proofs.state["load"]
        before = 17.5e3 * float(load["heave"][0] - load["unit"][0])
        noise = 2e3 * rng.normal()
        force = 98.6e3 + 50.0 * time + slope * (0.0 if math.isnan(before) else before) + noise
        proofs.step(Measurements(mru(time), {"load_cell": (ScalarReading(time, force),)}), HANGS)
        if load["read_time"][0] > 1.0:
            records.append((time, force, 17.5e3 * float(load["heave"][0] - load["unit"][0])))
        if proofs.fit.correlation:
            break  # at the first look
    t, force, expected = np.array(records).T
    count = int(proofs.state["expected"]["count"][0])
    assert count == len(t)
    y, x = low_passed(force), low_passed(expected)
    frequency, t = 1.0 / math.sqrt(CABLE.natural_a), TICK * np.arange(count)
    columns = np.stack([x, np.ones_like(t), t, np.cos(frequency * t), np.sin(frequency * t)], axis=1)
    assert TICK * count == pytest.approx(SHORTEST, abs=1.5 * TICK)
    (wanted, *_), *_ = np.linalg.lstsq(columns, y, rcond=None)
    assert proofs.fit.scale == pytest.approx(wanted, rel=1e-9)
    # partial correlation: of what either is off the other columns
    others = columns[:, 1:]
    rest = [v - others @ np.linalg.lstsq(others, v, rcond=None)[0] for v in (x, y)]
    assert proofs.fit.correlation == pytest.approx(stats.pearsonr(*rest).statistic, rel=1e-9)


def test_a_record_that_says_nothing_of_the_load_is_not_certain_whatever_its_memory():
    """By 60 draws: the slope over the stated error scatters by about 1, as Student's t does."""
    ratios = []
    for seed in range(60):
        proofs = made()
        braked(proofs, WINDOW + 3.0, tension=0.0, depth=None, seed=seed)
        ratios.append(proofs.fit.certainty)
    assert 0.4 < np.std(ratios) < 1.6
    assert np.max(np.abs(ratios)) < CERTAIN


# the nominal load


def moved(readings, cable=CABLE, length=900.0):
    """Return what the proofs have of the load after each tick of `readings`: boom tip, unit, time of both, known."""
    proofs, found = made(WinchControllerParameters(length=length), cable), []
    for one in readings:
        proofs.step(Measurements(one), HANGS)
        load = proofs.state["load"][0]
        found.append((load["heave"], load["unit"], load["time"], load["read_time"]))
    return np.array(found).T


def test_the_nominal_unit_is_that_of_scipy():
    time, _, unit = truth(60.0)
    _, found, *_ = moved(mru(t) for t in time)
    # the rate of the first tick is that of the wave, which SciPy's unit at rest does not know
    assert np.max(np.abs(found - unit)[200:]) < 0.02


def test_noise_of_the_heave_shakes_a_short_cable_by_less_than_half_of_what_it_would_unblended():
    short = CableModel(a=0.13, b=0.001, stiffness=52e3, static_tension=36.5e3, unit_weight=25e3)
    rng, plain, unblended, readings = np.random.default_rng(1), SimulatedUnit(short, TICK), [], []
    for k in range(1200):
        z, rate = 0.01 * rng.normal(), 0.005 * rng.normal()
        readings.append((MruReading(k * TICK, z, rate),))
        unblended.append(z - plain.state[0])
        plain.step(np.array([z, rate]))
    tip, unit, *_ = moved(readings, short, 300.0)
    assert np.std(tip - unit) < 0.5 * np.std(unblended)


def test_a_motion_without_rate_a_slower_one_and_one_that_is_late_are_followed():
    for every, with_rate, late in ((1, False, 0.0), (4, True, 0.0), (1, True, 0.2), (2, True, 0.05)):
        readings = []
        for k in range(800):
            z, rate = heave(k * TICK - late)
            one = MruReading(k * TICK - late, z, rate if with_rate else math.nan)
            readings.append((one,) if k % every == 0 and k * TICK >= late else ())
        tip, _, time, known = moved(readings)
        assert np.max(np.abs(tip[101:] - [heave(t)[0] for t in time[101:]])) < 0.02
        assert known[-1] > 1.0


def test_an_mru_that_is_lost_or_says_that_it_is_invalid_is_not_known():
    readings = [mru(k * TICK, status=MruStatus.OK if k < 100 else MruStatus.INVALID) for k in range(120)]
    *_, known = moved(readings)
    assert known[99] > 1.0
    assert known[-1] < 1.0


def test_wire_that_is_paid_out_makes_the_cable_softer():
    proofs = made()
    for k in range(2):
        proofs.step(Measurements(winch=WinchReading(k * TICK, 450.0, 0.0, brake=True)), HANGS)
    assert proofs.design["stiffness"][0] == pytest.approx(17.5e3 / 1.5)
    assert proofs.design["frequency"][0] == pytest.approx(1.0 / math.sqrt(7.2 * 1.5), rel=1e-2)


def test_one_stamp_that_cannot_be_does_not_end_the_proof():
    """A clock that was wrong once: all readings after it would else come too late."""
    proofs = made()
    late = Driven(waits=True, hangs=True, latest=0.1)
    wrong = Measurements((MruReading(1e9, 0.0, 0.0),), {"load_cell": (ScalarReading(1e9, 98.6e3),)})
    proofs.step(wrong, late)
    braked(proofs, 25.0)
    assert proofs.standing is Standing.PROVED


# the proof of the MRU

STANDINGS = {1.0: Standing.PROVED, -1.0: Standing.REVERSED, **dict.fromkeys((0.3, 0.5, 2.0), Standing.SCALED)}
"""What is known of an MRU that reads so many times the motion."""


@pytest.mark.parametrize(("tension", "depth"), [(1.0, 1.0), (1.0, None), (None, 1.0)])
@pytest.mark.parametrize("seed", range(3))
def test_a_sound_mru_is_proved_and_a_reversed_one_is_named_by_either_witness(tension, depth, seed):
    for scale, standing in STANDINGS.items():
        proof = made()
        braked(proof, 25.0, scale, tension=tension, depth=depth, seed=seed)
        assert proof.standing is standing
        assert proof.fit.scale == pytest.approx(1.0 / scale, rel=0.2)


def test_a_proof_comes_within_the_time_that_the_estimate_settles_in():
    proof = made()
    braked(proof, SHORTEST + 2.5)
    assert proof.standing is Standing.PROVED


def test_one_witness_that_is_wired_the_other_way_does_not_outweigh_one_that_proves():
    proof = made()
    braked(proof, 25.0, tension=-1.0)
    assert (proof.standing, proof.witness) == (Standing.PROVED, "depth sensor")


def test_without_a_witness_or_with_one_that_says_nothing_it_is_said():
    proof = made()
    braked(proof, 15.0, tension=None, depth=None)
    assert (proof.standing, proof.witness) == (Standing.ALONE, "")
    proof = made()
    braked(proof, 30.0, tension=0.0, depth=None)
    assert proof.standing is Standing.OPEN
    proof = made()
    braked(proof, 75.0, tension=0.0, depth=None)
    assert (proof.standing, proof.witness) == (Standing.ALONE, "load cell")
    # a wrong map of the MRU ends here too, where to fit a sensor or to wait, all that was said, does not help
    alarm = ALARMS.alarm("MRU_UNPROVED: alone", why="its correlation with the load cell is 0.00")
    assert "Check the MRU's map" in str(alarm)


def test_in_calm_water_there_is_nothing_to_prove():
    proof, rng = made(), np.random.default_rng(1)
    for k in range(600):
        reading = MruReading(k * TICK, 0.01 * rng.normal(), 0.005 * rng.normal())
        scalar = {"load_cell": (ScalarReading(k * TICK, 98.6e3 + 100.0 * rng.normal()),)}
        proof.step(Measurements((reading,), scalar), HANGS)
    assert proof.standing is Standing.QUIET


def test_a_free_swing_that_a_stop_has_left_does_not_hide_the_motion():
    """0.4 m of it, half of the sea's own."""
    proof = made()
    braked(proof, 25.0, depth=None, swing=0.4)
    assert proof.standing is Standing.PROVED
    assert proof.fit.scale == pytest.approx(1.0, rel=0.1)


def test_what_was_certain_is_not_forgotten_for_a_record_that_says_nothing_and_is_for_one_that_says_another_thing():
    proof, stands = made(), Driven(waits=True, hangs=False)
    braked(proof, 25.0)
    proof.step(NOTHING, stands)  # another record
    braked(proof, 25.0, tension=0.0, depth=None)
    assert proof.standing is Standing.PROVED
    proof.step(NOTHING, stands)
    braked(proof, 25.0, -1.0)
    assert proof.standing is Standing.REVERSED


def other(stiffness=1.0, mass=1.0):
    """Return the cable of a rope and a load other than nominal."""
    return replace(CABLE, a=CABLE.a * mass / stiffness, b=CABLE.b / stiffness, stiffness=CABLE.stiffness * stiffness)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("cable", [other(0.5), other(1.8), other(mass=0.5)], ids=["soft", "stiff", "light"])
def test_an_mru_is_not_refuted_by_a_load_or_a_cable_other_than_nominal(cable, seed):
    """Slopes of 0.5 to 2.6; load cell and depth sensor together are the boom tip by a plausible stiffness."""
    proof = made()
    braked(proof, 40.0, cable=cable, seed=seed)
    assert proof.standing in {Standing.OPEN, Standing.PROVED}
    proof = made()
    braked(proof, 40.0, -1.0, cable=cable, seed=seed)
    assert proof.standing is Standing.REVERSED


def test_both_witnesses_prove_together_what_hangs_on_a_nominal_cable():
    proof = made()
    braked(proof, 25.0, cable=other(mass=0.5))
    assert (proof.standing, proof.witness) == (Standing.PROVED, "load cell with depth sensor")
    assert proof.fit.scale == pytest.approx(1.0, rel=0.05)


def test_a_depth_sensor_that_reads_no_motion_keeps_no_reversed_mru_open():
    """It may wait for a clearer record, for three windows."""
    proof = made()
    braked(proof, 75.0, -1.0, depth=0.0)
    assert proof.standing is Standing.REVERSED
    proof = made()
    braked(proof, 75.0, 2.0, depth=0.0)
    assert proof.standing is not Standing.PROVED


# the count


def counted(steps, rates, period=TICK):
    proofs, count = made(), 0.0
    for k, (step, rate) in enumerate(zip(steps, rates, strict=True)):
        count += step
        if found := proofs.step(Measurements(winch=WinchReading(k * period, count, rate, False)), HANGS).alarms:
            return k * period, found[0]
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
    proofs, alarms, proven = made(parameters), [], None
    for k, (time, tip, unit) in enumerate(zip(*truth(seconds), strict=True)):
        if asks is not None and time >= asks:
            proofs.ask(consent=True)
            asks = None
        scalar = (
            {} if tension is None else {"load_cell": (ScalarReading(time, 98.6e3 + tension * 17.5e3 * (tip - unit)),)}
        )
        raw = Measurements(mru(time, scale), scalar, WinchReading(time, 0.0, 0.0, brake=True))
        proven = proofs.step(raw, HANGS)
        alarms += proven.alarms
        proofs.note(WinchOrder(k, 0.0, 0.0, brake=True))
    return proven, [alarm.name for alarm in alarms]


def test_compensation_may_begin_once_the_mru_is_proved_and_not_before():
    proven, alarms = controlled(seconds=SHORTEST - 1.0)
    assert "proving the MRU" in proven.gate
    assert alarms == []
    assert controlled() == (controlled(seconds=30.0)[0]._replace(alarms=()), [])
    assert controlled()[0].gate == ""


def test_a_reversed_mru_is_refused_whatever_an_operator_consents_to():
    for asks in (None, 35.0):
        proven, alarms = controlled(scale=-1.0, asks=asks)
        assert "MRU_REVERSED" in proven.gate
        assert set(alarms) == {"MRU_REVERSED"}


def test_without_a_witness_an_operators_consent_is_asked_for():
    assert "MRU_UNPROVED" in controlled(tension=None)[0].gate
    assert controlled(tension=None)[1] == ["MRU_UNPROVED: alone"]
    assert controlled(tension=None, asks=20.0)[0].gate == ""
    assert "MRU_UNPROVED: the load cell shows 3.33 times" in controlled(scale=0.3)[0].gate
    assert controlled(scale=0.3, asks=30.0)[0].gate == ""
    stated = WinchControllerParameters(length=900.0, entry=EntryParameters(accept_unproved=True))
    assert controlled(stated, tension=None, seconds=SHORTEST + 2.0)[0].gate == ""
    assert controlled(stated, tension=None)[1] == []


def test_what_the_envelope_ended_for_harm_is_proved_again_without_the_old_consent():
    proofs = made()
    proofs.ask(consent=True)
    harm = Driven(waits=False, hangs=True, taken_over="LOAD_SWUNG_HIGHER")
    proofs.step(Measurements(mru(0.0)), harm)
    assert not proofs.consent
    assert "proving the MRU" in proofs.step(Measurements(), harm).gate


@pytest.mark.parametrize(("scale", "noise", "is_refuted"), [(0.5, 2e3, True), (0.5, 9e3, False)])
def test_a_slope_that_is_outside_by_chance_says_nothing_against_the_mru(scale, noise, is_refuted):
    """A sound MRU was named for a slope of 0.597 with a standard error of 0.12, in waves of 0.42 m over 300 m."""
    proofs = made()
    braked(proofs, 25.0, tension=scale, depth=None, noise=noise, seed=0)
    assert proofs.fit.scale < 0.6
    assert abs(proofs.fit.certainty) > CERTAIN
    assert (proofs.standing is Standing.SCALED) is is_refuted
    assert proofs.standing is not Standing.PROVED
