"""A tick of what is sensed: arbitrary readings, parts beside libraries, and no block of memory."""

import ctypes
import math

import numpy as np
import pytest
from heave_core.sense_table import NOISE_READINGS
from heave_node.interface.sensors import MruReading
from heave_node.parameters import build_parameters
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.estimation.loop_tick import TENSION_MEMORY, CommandShares
from winch_controller_node.core.estimation.sense_design import GATES, STEPS
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.readings import Measurements, ScalarReading, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import HealthParameters

from tests.core_parts import Sensing
from tests.gates import EncoderGate, MeanTension, SensorNoise, SensorTiming

DT = 0.05
ANY = st.floats(allow_nan=True, allow_infinity=True)
USUAL = st.floats(-3.0, 3.0)
READ = st.one_of(USUAL, USUAL, ANY)
AGE = st.one_of(st.just(0.0), st.just(0.0), st.floats(-2.0, 2.0), st.just(math.nan))


@pytest.fixture(scope="module")
def design():
    return design_controller(WinchControllerParameters(), tick_period=DT)


def delivered(tick, mru, depths, tension, winch):
    """Return what is delivered at a tick."""
    now = DT * tick
    samples = tuple(MruReading(now - age, heave, rate, 0.01, 0.02, status) for age, heave, rate, status in mru)
    scalar = {
        "depth": tuple(ScalarReading(now - age, 300.0 + value) for age, value in depths),
        "load_cell": tuple(ScalarReading(now, 6e4 + 1e3 * value) for value in tension),
    }
    report = None if winch is None else WinchReading(now - winch[0], winch[1], 0.0, winch[2])
    return Measurements(mru=samples, scalar=scalar, winch=report)


TICKS = st.lists(
    st.tuples(
        st.lists(st.tuples(AGE, READ, READ, st.sampled_from([0, 0, 0, 1, 2, 9])), max_size=3),
        st.lists(st.tuples(AGE, READ), max_size=2),
        st.lists(READ, max_size=2),
        st.one_of(st.none(), st.tuples(AGE, READ, st.booleans())),
    ),
    min_size=1,
    max_size=30,
)


@settings(max_examples=60, deadline=None)
@given(ticks=TICKS, stands=st.booleans())
def test_whatever_is_read_the_estimate_is_a_number_and_every_reading_is_counted(design, ticks, stands):
    estimation = Sensing(design)
    came = dict.fromkeys(("mru", "depth", "load_cell", "encoder"), 0)
    for number, (mru, depths, tension, winch) in enumerate(ticks, start=1):
        given_ = delivered(number, mru, depths, tension, winch)
        tick = estimation.step(number, given_, CommandShares(0.1, 0.0), unit_stands=stands)
        for name, readings in (("mru", mru), ("depth", depths), ("load_cell", tension)):
            came[name] += len(readings)
        assert np.all(np.isfinite(tick.estimate))
        assert isinstance(tick.number, int)
        assert all(math.isfinite(getattr(tick, name)) for name in ("tip", "unit", "free", "payout", "mean_command"))
        assert {tick.knows_tip, tick.has_depth, tick.sees_landing, tick.has_encoder, tick.knows_sea} <= {0.0, 1.0}
        assert len(tick.depths) <= len(depths)
    for state in estimation.observer.states(number):
        assert state.accepted >= 0
        if state.sensor != "encoder":
            assert state.accepted + state.refused == came[state.sensor]


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**16), count=st.integers(40, 300))
def test_noise_is_the_median_of_third_differences_as_numpy_has_it(seed, count):
    values = np.cumsum(np.random.default_rng(seed).standard_normal(count))
    noise = SensorNoise(1e-6, DT)
    found = [noise.add(float(value)) for value in values][-1]
    differences = np.abs(np.diff(values, 3))
    judged = len(differences) - len(differences) % GATES["noise_updated"]
    expected = np.median(differences[max(0, judged - NOISE_READINGS) : judged]) / (0.6745 * math.sqrt(20.0))
    assert found == pytest.approx(expected, rel=1e-12)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**16), gap=st.integers(3, 60), late=st.floats(0.0, 0.9))
def test_an_encoder_after_a_gap_is_held_against_the_way_that_numpy_interpolates(seed, gap, late):
    rates = np.random.default_rng(seed).uniform(-1.0, 1.0, gap + 1)
    times, gate = DT * np.arange(1, gap + 2), EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    gate.pass_tick(times[0], rates[0])
    gate.judge(times[0], ScalarReading(times[0] - late * DT, 0.0), rates[0])
    for time, rate in zip(times[1:], rates[1:], strict=True):
        gate.pass_tick(time, rate)
    far = 100.0
    assert gate.judge(times[-1], ScalarReading(times[-1] - late * DT, far), rates[-1]) is None
    before, after = np.interp(times[[0, -1]] - late * DT, times, DT * np.cumsum(rates))
    assert gate.jump == pytest.approx(far - (after - before), abs=1e-9)
    assert STEPS["at_once"] < 3


def test_the_mean_tension_over_its_memory_is_that_of_scipy():
    """Once as many ticks have come as it remembers, each weighs dt/T."""
    values = 5e4 + 1e3 * np.random.default_rng(2).standard_normal(3000)
    mean, first = MeanTension(tick_period=DT), round(TENSION_MEMORY / DT)
    for value in values[:first]:
        mean.add(float(value), 0.0, unit_stands=False)
    assert mean.mean.value == pytest.approx(np.mean(values[:first]), rel=1e-12)
    start, weight = mean.mean.value, DT / TENSION_MEMORY
    for value in values[first:]:
        mean.add(float(value), 0.0, unit_stands=False)
    filtered, _ = lfilter([weight], [1.0, weight - 1.0], values[first:], zi=[(1.0 - weight) * start])
    assert mean.mean.value == pytest.approx(filtered[-1], rel=1e-12)


def allocated():
    """Return the bytes that C has allocated in this process."""

    class Info(ctypes.Structure):
        _fields_ = [(name, ctypes.c_size_t) for name in "abcdefghij"]

    mallinfo = ctypes.CDLL(None).mallinfo2
    mallinfo.restype = Info
    return mallinfo().h


# samples that are refused


@pytest.mark.parametrize("refused", [("heave",), ("heave", "heave_rate")])
def test_a_sample_is_refused_once_however_many_of_its_readings_are(refused):
    """Counted twice, the samples accepted would become fewer than none, which no message can carry."""
    controller = WinchController(build_parameters(WinchControllerParameters, {}, where="test"), tick_period=0.05)
    gate = controller.observer.gates["mru"]
    for tick in range(1, 400):
        sample = MruReading(0.05 * tick, 0.01 * (tick % 2), 0.01 * (tick % 3), 0.0, 0.0, 0, tick)
        controller.step(tick, Measurements(mru=(sample,)))
    before = gate.state(20.0)
    far = sample._replace(time=20.0, **dict.fromkeys(refused, 0.25))
    controller.step(400, Measurements(mru=(far,)))
    after = gate.state(20.0)
    assert (after.accepted, after.refused) == (before.accepted, before.refused + 1)


@pytest.mark.parametrize("rate", [0.7, math.nan])
def test_an_operator_who_acknowledges_a_step_of_the_mru_has_it_read_again(rate):
    """A swell of 1 m and 9 s, by heave alone too; its reference is set 1.5 m higher in the run, and stays there."""
    controller = WinchController(build_parameters(WinchControllerParameters, {}, where="test"), tick_period=0.05)
    stepped, asked, end = 600, 900, 1400
    seen = []
    for tick in range(1, end):
        phase = 2.0 * math.pi / 9.0 * 0.05 * tick
        heave = math.sin(phase) + (1.5 if tick >= stepped else 0.0)
        sample = MruReading(0.05 * tick, heave, rate * math.cos(phase) * 2.0 * math.pi / 9.0 / 0.7, 0.0, 0.0, 0, tick)
        if tick == asked:
            controller.set_mode("standby")
        controller.step(tick, Measurements(mru=(sample,)))
        seen.append(controller.observer.gates["mru"].is_lost)
    assert not any(seen[: stepped - 2])
    assert all(seen[stepped + 5 : asked - 1])
    assert not any(seen[-100:])


def test_a_lost_sensor_is_named_by_each_cause_as_it_becomes_known_and_by_each_once():
    """Readings are held up for 0.3 s: none for six ticks, then old ones; then for a while each second one is no number.

    The last one in time is that of tick 200; an age above three intervals of 0.05 s is too much.
    """
    controller = WinchController(build_parameters(WinchControllerParameters, {}, where="test"), tick_period=DT)
    named = []
    for tick in range(1, 700):
        late = 6 if 200 < tick <= 400 or tick > 600 else 0
        time = DT * (tick - late)
        phase = 2.0 * math.pi / 9.0 * time
        heave = math.nan if 300 < tick <= 350 and tick % 2 else math.sin(phase)
        sample = MruReading(time, heave, math.cos(phase) * 2.0 * math.pi / 9.0, 0.0, 0.0, 0, tick)
        is_held = 200 < tick <= 206 or 600 < tick <= 606
        alarms = controller.step(tick, Measurements(mru=() if is_held else (sample,))).alarms
        named += [(tick, alarm.name, alarm.values) for alarm in alarms if "SENSOR_LOST, MRU" in alarm.name]
    stale, delayed = "SENSOR_LOST, MRU: stale", "SENSOR_LOST, MRU: delayed"
    assert [one[:2] for one in named] == [(204, stale), (207, delayed), (604, stale), (607, delayed)]
    found = [named[1][2][name] for name in ("age", "since", "limit")]
    assert found == pytest.approx([0.3, 207 * DT, 0.15])
