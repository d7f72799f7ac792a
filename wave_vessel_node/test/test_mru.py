import math

import numpy as np
import pytest
from heave_node.interface.codes import MruStatus
from heave_node.interface.faults import FaultParameters
from hypothesis import given, settings
from hypothesis import strategies as st
from wave_vessel_node.mru.mru import DrivenOscillator, MotionReferenceUnit, high_pass_response
from wave_vessel_node.parameters import MruParameters
from wave_vessel_node.vessel.motion import PITCH, ROLL, VesselMotions

DT = 0.05


def run(parameters, ticks, heave=lambda t: (0.0, 0.0, 0.0), unit=None, first=1, six=None):
    """Return the readings of `ticks` ticks, None where there is none; `six` is the vessel's motion in all of them.

    The unit looks at seven ticks at a time.
    """
    unit, readings = unit or MotionReferenceUnit(parameters, seed=1, tick_period=DT), []
    for start in range(first, first + ticks, 7):
        block = range(start, min(start + 7, first + ticks))
        motions = VesselMotions.still(block, DT)
        if six is not None:
            motions.six[:] = six
        unit.look(motions, np.array([heave(tick * DT) for tick in block]))
        readings += [unit.step(tick) for tick in block]
    return readings


def attitude(roll, pitch):
    six = np.zeros((3, 6))
    six[0, [ROLL, PITCH]] = roll, pitch
    return six


def sine(omega, amplitude=1.0):
    return lambda t: (
        amplitude * math.sin(omega * t),
        amplitude * omega * math.cos(omega * t),
        -amplitude * omega**2 * math.sin(omega * t),
    )


SILENT = {"noise": 0.0, "rate_noise": 0.0}


def fault(kind, start, duration=0.0, magnitude=0.0):
    return FaultParameters((kind,), (start,), (duration,), (magnitude,))


def test_a_perfect_unit_says_the_truth_at_the_time_of_its_stamp():
    heave = sine(0.7)
    for tick, reading in enumerate(run(MruParameters(**SILENT), 50, heave), start=1):
        assert reading.time == pytest.approx(tick * DT)
        assert reading.sequence == tick
        assert reading.status == MruStatus.OK
        assert (reading.heave, reading.heave_rate, reading.heave_acceleration) == pytest.approx(heave(tick * DT))


def test_a_unit_that_measures_no_rate_states_heave_and_attitude_as_one_that_does():
    """With the same noise; rate and acceleration, and the accuracy of the rate, are NaN."""
    heave = sine(0.7)
    whole, alone = (run(MruParameters(measures_rate=measures), 50, heave) for measures in (True, False))
    assert [(one.time, one.heave, one.roll, one.pitch) for one in alone] == [
        (one.time, one.heave, one.roll, one.pitch) for one in whole
    ]
    assert all(map(math.isnan, np.ravel([one[2:3] + one[7:8] + one[9:] for one in alone])))


def test_noise_is_white_and_has_the_stated_deviation():
    readings = run(MruParameters(noise=0.02, rate_noise=0.03), 20000)
    heave = np.array([reading.heave for reading in readings])
    # chi-square: 5 sigma of a standard deviation from n samples is 5 / sqrt(2 n); of a correlation 5 / sqrt(n)
    assert heave.std() == pytest.approx(0.02, rel=5 / math.sqrt(40000))
    assert np.std([reading.heave_rate for reading in readings]) == pytest.approx(0.03, rel=5 / math.sqrt(40000))
    for lag in (1, 2, 7):
        assert abs(np.corrcoef(heave[:-lag], heave[lag:])[0, 1]) < 5 / math.sqrt(20000)


@given(st.floats(0.08, 2.5))
@settings(max_examples=10, deadline=None)
def test_the_high_pass_answers_as_its_formula_says(omega):
    cut_off, damping = 2 * math.pi / 60.0, 0.7071
    taken = DrivenOscillator(cut_off, damping, value_gain=cut_off**2, rate_gain=2.0 * damping * cut_off, period=DT)
    taken.start(0.0, omega)
    count = 24000  # 1200 s: transients e^(-zeta omega_c t) are 1e-38
    time = np.arange(1, count + 1) * DT
    offsets = taken.run(np.sin(omega * time), omega * np.cos(omega * time), np.zeros(count))
    output = np.sin(omega * time) - offsets[:, 0]
    late = time > 600.0
    basis = np.column_stack((np.sin(omega * time[late]), np.cos(omega * time[late])))
    (in_phase, quadrature), *_ = np.linalg.lstsq(basis, output[late], rcond=None)
    assert complex(in_phase, quadrature) == pytest.approx(
        complex(high_pass_response(omega, cut_off, damping)), abs=1e-5
    )


def test_rates_of_the_high_pass_are_derivatives_of_its_heave():
    parameters = MruParameters(high_pass_period=60.0, **SILENT)
    readings = run(parameters, 400, sine(0.8))
    heave = np.array([reading.heave for reading in readings])
    rate = np.array([reading.heave_rate for reading in readings])
    acceleration = np.array([reading.heave_acceleration for reading in readings])
    # Simpson over two ticks, error h^5/90 of the fourth derivative
    np.testing.assert_allclose(heave[2:] - heave[:-2], DT / 3 * (rate[2:] + 4 * rate[1:-1] + rate[:-2]), atol=1e-8)
    np.testing.assert_allclose(
        rate[2:] - rate[:-2], DT / 3 * (acceleration[2:] + 4 * acceleration[1:-1] + acceleration[:-2]), atol=1e-8
    )


def test_scale_and_lever_arm_errors_enter_the_reading():
    parameters = MruParameters(scale_error=0.05, lever_arm_error=(0.2, -0.3, 0.1), **SILENT)
    reading = run(parameters, 1, lambda t: (1.0, 0.0, 0.0), six=attitude(0.05, 0.02))[0]
    # heave of a point: heave - x pitch + y roll
    assert reading.heave == pytest.approx(1.05 * (1.0 - 0.2 * 0.02 - 0.3 * 0.05))
    assert (reading.roll, reading.pitch) == (0.05, 0.02)


def test_latency_delays_the_reading_and_the_stamp_says_so():
    heave = sine(0.7)
    readings = run(MruParameters(latency=0.15, **SILENT), 20, heave)
    assert readings[:3] == [None] * 3
    assert readings[10].time == pytest.approx(11 * DT - 0.15)
    assert readings[10].heave == pytest.approx(heave(11 * DT - 0.15)[0])


@pytest.mark.parametrize(
    ("error", "stamp", "measured"),
    [
        (0.1, 1.0, 0.9),  # a delay that the stamp does not account for
        (0.12, 17 * DT + 0.12, 17 * DT),  # of parts of a tick: it comes with the next tick
        (-0.13, 20 * DT - 0.13, 20 * DT),  # early: readings are newer than they say, by any time
    ],
)
def test_a_stamp_error_moves_the_stamp_and_a_late_one_the_reading(error, stamp, measured):
    heave = sine(0.7)
    reading = run(MruParameters(stamp_error=error, **SILENT), 20, heave)[-1]
    assert reading.time == pytest.approx(stamp)
    assert reading.heave == pytest.approx(heave(measured)[0])


def test_the_rate_sets_which_ticks_have_a_reading():
    readings = run(MruParameters(rate=5.0, **SILENT), 40)
    assert [tick for tick, reading in enumerate(readings, 1) if reading] == list(range(4, 41, 4))
    assert [reading.sequence for reading in readings if reading] == list(range(1, 11))


def test_a_gap_loses_samples_and_their_numbers():
    readings = run(MruParameters(faults=fault("gap", 0.5, 0.25), **SILENT), 30)
    missing = [tick for tick, reading in enumerate(readings, 1) if reading is None]
    assert missing == [10, 11, 12, 13, 14]
    assert readings[14].sequence == 15


def test_a_spike_is_one_wrong_reading():
    readings = run(MruParameters(faults=fault("spike", 0.5, magnitude=3.0), **SILENT), 20)
    assert [round(reading.heave, 9) for reading in readings].count(3.0) == 1
    assert readings[9].heave == 3.0


def test_a_unit_that_is_turned_over_says_heave_rate_and_acceleration_with_the_wrong_sign_and_no_other():
    six = attitude(0.1, 0.2)
    right = run(MruParameters(), 20, sine(1.0), six=six)
    turned = run(MruParameters(faults=fault("scale", 0.5, magnitude=-1.0)), 20, sine(1.0), six=six)
    assert turned[:9] == right[:9]
    for one, other in zip(turned[9:], right[9:], strict=True):
        for name in ("heave", "heave_rate", "heave_acceleration"):
            assert getattr(one, name) == -getattr(other, name), name
        assert (one.roll, one.pitch) == (other.roll, other.pitch) == (0.1, 0.2)


def test_after_a_restart_the_unit_is_silent_then_settling_then_right():
    parameters = MruParameters(
        high_pass_period=10.0,
        faults=fault("restart", 5.0),
        restart_duration=2.0,
        settling_periods=10.0,
        restart_bias=0.05,
        **SILENT,
    )
    readings = run(parameters, 4000, sine(0.8))
    reference = run(MruParameters(high_pass_period=10.0, **SILENT), 4000, sine(0.8))
    assert all(reading is None for reading in readings[100:139])
    settling = [reading for reading in readings[140:] if reading.status == MruStatus.SETTLING]
    assert len(settling) * DT == pytest.approx(100.0, abs=2 * DT)
    early = max(abs(a.heave - b.heave) for a, b in zip(readings[140:240], reference[140:240], strict=True))
    late = max(abs(a.heave - b.heave) for a, b in zip(readings[2200:], reference[2200:], strict=True))
    assert early > 0.02
    assert late < 1e-4


def test_faults_can_be_injected_while_running():
    unit = MotionReferenceUnit(MruParameters(**SILENT), seed=1, tick_period=DT)
    unit.faults.inject("jump", start=0.2, duration=0.1, magnitude=0.5)
    readings = run(None, 10, unit=unit)
    assert [reading.heave for reading in readings] == [0, 0, 0, 0.5, 0.5, 0, 0, 0, 0, 0]
    assert all(reading.heave_rate == 0.0 for reading in readings)


def test_a_faulty_unit_may_say_no_numbers_or_speak_at_another_rate():
    readings = run(MruParameters(faults=fault("nan", 0.2, 0.1), **SILENT), 10)
    assert [math.isnan(reading.heave) and math.isnan(reading.roll) for reading in readings] == [
        tick in (4, 5) for tick in range(1, 11)
    ]
    readings = run(MruParameters(faults=fault("rate", 0.5, 1.0, 4.0), **SILENT), 40)
    spoke = [tick for tick, reading in enumerate(readings, 1) if reading]
    assert spoke == [*range(1, 10), 10, 15, 20, 25, *range(30, 41)]


def test_a_transport_delay_holds_readings_back_with_honest_stamps():
    unit = MotionReferenceUnit(MruParameters(**SILENT), seed=1, tick_period=DT)
    unit.faults.inject("delay", start=0.5, duration=0.5, magnitude=0.2)
    readings = run(None, 30, sine(0.7), unit=unit)
    assert readings[9:13] == [None] * 4
    assert readings[15].time == pytest.approx(16 * DT - 0.2)
    assert readings[15].heave == pytest.approx(math.sin(0.7 * (16 * DT - 0.2)))
    assert readings[19].time == pytest.approx(20 * DT)
    stamps = [reading.time for reading in readings if reading]
    assert stamps == sorted(set(stamps))


def test_jitter_makes_readings_late_and_keeps_their_stamps():
    readings = run(MruParameters(faults=fault("jitter", 0.0, 10.0, 0.3), **SILENT), 100, sine(0.7))
    came = [(tick * DT - reading.time, reading) for tick, reading in enumerate(readings, 1) if reading]
    lates = {round(late / DT) for late, _ in came}  # one that is older than the last one is not delivered
    assert {0, 1, 2, 3} <= lates <= set(range(7))
    assert all(reading.heave == pytest.approx(math.sin(0.7 * reading.time)) for _, reading in came)
    stamps = [reading.time for _, reading in came]
    assert stamps == sorted(set(stamps))


def test_faults_do_not_change_the_noise_of_other_readings():
    plain = run(MruParameters(), 100)
    gap = run(MruParameters(faults=fault("gap", 1.0, 1.0)), 100)
    assert [r.heave for r in plain[60:]] == [r.heave for r in gap[60:]]


def test_a_rate_changes_no_other_number():
    often, seldom = run(MruParameters(), 40), run(MruParameters(rate=5.0), 40)
    assert [r.heave for r in seldom if r] == [r.heave for r in often[3::4]]


@pytest.mark.parametrize(("kind", "magnitude"), [("drive", 0.0), ("delay", 11.0)])
def test_faults_that_the_unit_cannot_have_are_refused(kind, magnitude):
    with pytest.raises(ValueError, match=r"mru.faults: (a fault of kind drive|the magnitude of kind delay)"):
        MruParameters(faults=fault(kind, 1.0, 1.0, magnitude))


def test_readings_come_in_whole_steps_of_the_resolution():
    exact = run(MruParameters(), 200, sine(0.7))
    coarse = run(MruParameters(resolution=0.01, rate_resolution=0.02), 200, sine(0.7))
    for one, other in zip(coarse, exact, strict=True):
        assert one.heave == pytest.approx(0.01 * round(other.heave / 0.01))
        assert one.heave_rate == pytest.approx(0.02 * round(other.heave_rate / 0.02))
        assert one.heave_acceleration == other.heave_acceleration


def test_noise_that_wanders_has_its_deviation_and_time_and_disturbs_no_other_number():
    time = 1.0
    plain, wandering = run(MruParameters(), 20_000), run(MruParameters(wander=0.05, wander_time=time), 20_000)
    error = np.array([one.heave - other.heave for one, other in zip(wandering, plain, strict=True)])
    # 1,000 s hold 500 independent samples of a Gauss-Markov process of 1 s: 5 sigma are 5 / sqrt(2 * 500)
    assert error.std() == pytest.approx(0.05, rel=5 / math.sqrt(1000))
    late = round(time / DT)
    assert np.corrcoef(error[:-late], error[late:])[0, 1] == pytest.approx(math.exp(-1.0), abs=5 / math.sqrt(500))
    assert [one.heave_rate for one in wandering] == [one.heave_rate for one in plain]


@pytest.mark.parametrize("period", [0.0, 10.0])
def test_a_restart_in_the_middle_of_what_was_looked_at_is_that_of_its_tick(period):
    """A unit that looks at one tick at a time knows nothing of what comes: it reads the same."""
    parameters = MruParameters(high_pass_period=period, wander=0.1)
    readings = []
    for size in (1, 40):
        unit = MotionReferenceUnit(parameters, seed=3, tick_period=DT)
        said = []
        for start in range(1, 121, size):
            block = range(start, start + size)
            unit.look(VesselMotions.still(block, DT), np.array([sine(0.8)(tick * DT) for tick in block]))
            for tick in block:
                if tick == 50:
                    unit.faults.inject("restart", start=tick * DT, duration=0.5)
                said.append(unit.step(tick))
        readings.append(said)
    one, other = readings
    assert one == other
    assert one[48] is not None
    assert one[50] is None
