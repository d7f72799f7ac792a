"""The plant component: readings, missing inputs, shadow, errors."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from cable_sim_node.component import CableSim, PlantState
from cable_sim_node.errors import PlantError
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.parameters import SeabedParameters
from cable_sim_node.sensors.instruments import (
    DepthSensorParameters,
    LoadCellParameters,
    SensorsParameters,
    VelocitySensorParameters,
)
from heave_node.numerics.kinematics import PointMotion
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

TICK = 0.05
S300 = CableSimNodeParameters(length=300.0, segments=20, surface=False)


def ramped_sine(amplitude: tuple[float, float, float], omega: float, ramp: float) -> Callable[[int], PointMotion]:
    """Return the boom tip of tick k: a sin(w t), grown from rest by a quintic (twice differentiable)."""
    a = np.array(amplitude)

    def motion(tick: int) -> PointMotion:
        t = tick * TICK
        s = min(t / ramp, 1.0)
        grown, growing = s**3 * (10 - 15 * s + 6 * s * s), 30 * s * s * (1 - s) ** 2 / ramp
        sine, cosine = math.sin(omega * t), math.cos(omega * t)
        return PointMotion(t, a * grown * sine, a * (grown * omega * cosine + growing * sine), np.zeros(3))

    return motion


def drive(sim: CableSim, motion: Callable[[int], PointMotion | None], ticks: int) -> list[PlantState]:
    states = []
    for tick in range(sim.tick, sim.tick + ticks):
        states.append(sim.readings(tick)[0])
        sim.advance(tick, motion(tick + 1), (0.0, 0.0))
    return states


def harmonic(times: np.ndarray, values: np.ndarray, omega: float) -> tuple[float, float, float]:
    """Return mean, amplitude and phase [deg] of the first harmonic."""
    basis = np.column_stack([np.ones_like(times), np.sin(omega * times), np.cos(omega * times)])
    mean, sine, cosine = np.linalg.lstsq(basis, values, rcond=None)[0]
    return float(mean), math.hypot(sine, cosine), math.degrees(math.atan2(cosine, sine))


def test_plant_rests_where_it_starts_and_its_sensors_say_so() -> None:
    quiet = SensorsParameters(
        depth=DepthSensorParameters(noise=0.0, latency=0.0),
        velocity=VelocitySensorParameters(noise=0.0, latency=0.0),
        load_cell=LoadCellParameters(noise=0.0),
    )
    sim = CableSim(dataclasses.replace(S300, sensors=quiet), seed=1, tick_period=TICK)
    depths, tensions = [], []
    for tick in range(1, 201):
        state, readings = sim.readings(tick)
        depths += [(r.time, r.value[0]) for r in readings["depth"]]
        tensions += [r.value[0] for r in readings["load_cell"]]
        sim.advance(tick, PointMotion((tick + 1) * TICK), (0.0, 0.0))
    assert len(depths) == 100
    # Static: weight in water of unit and cable, 25861.5 + 300 * 35.517 N; peer 36516.6 N.
    assert tensions == pytest.approx([36516.6] * 200, abs=0.5)
    assert [depth for _, depth in depths] == pytest.approx([-state.unit.position[2]] * 100, abs=1e-9)


def test_shadow_plant_moves_as_the_plant_does_with_its_winch_locked() -> None:
    motion = ramped_sine((0.0, 0.0, 1.0), 0.8, 10.0)
    locked = drive(CableSim(S300, seed=1, tick_period=TICK), motion, 400)
    sim = CableSim(S300, seed=2, tick_period=TICK)
    for tick in range(1, 401):
        state, _ = sim.readings(tick)
        assert np.array_equal(state.uncompensated.position, locked[tick - 1].unit.position)
        payout = motion(tick + 1).position[2], motion(tick + 1).velocity[2]
        sim.advance(tick, motion(tick + 1), payout)
    assert np.std([s.unit.position[2] for s in locked]) > 0.3


def test_cable_that_is_fed_as_the_boom_tip_heaves_holds_the_unit_still() -> None:
    motion = ramped_sine((0.0, 0.0, 1.0), 0.8, 10.0)
    sim = CableSim(S300, seed=1, tick_period=TICK)
    heave = []
    for tick in range(1, 801):
        heave.append(sim.readings(tick)[0].unit.position[2])
        tip = motion(tick + 1)
        sim.advance(tick, tip, (float(tip.position[2]), float(tip.velocity[2])))
    # What is left is the stretch of the cable that is fed, T/EA = 2.34 mm per metre, two metres peak to peak; the mass
    # on its spring (2.7 rad/s) makes that 1/(1 - (0.8/2.7)^2) = 1.1 times more.
    assert np.ptp(heave) == pytest.approx(1.1 * 2.0 * 36516.6 / 15614500.9, rel=0.05)


def test_missing_boom_tip_is_bridged_counted_and_kept_from_snapping_the_cable() -> None:
    motion = ramped_sine((0.0, 0.0, 1.0), 0.8, 10.0)
    whole = drive(CableSim(S300, seed=1, tick_period=TICK), motion, 600)
    sim = CableSim(S300, seed=1, tick_period=TICK)
    gapped = drive(sim, lambda tick: None if 300 <= tick < 320 else motion(tick), 600)
    assert sim.boom_tip.missing == 20
    swing = np.ptp([s.top_tension for s in whole])
    assert np.ptp([s.top_tension for s in gapped]) < 3.0 * swing
    assert sim.boom_tip.position[2] == pytest.approx(motion(601).position[2], abs=0.01)


@pytest.mark.parametrize("bad", [math.nan, math.inf, 1e6])
def test_boom_tip_that_cannot_be_true_is_taken_for_missing(bad: float) -> None:
    sim = CableSim(S300, seed=1, tick_period=TICK)

    def motion(tick: int) -> PointMotion:
        z = bad if tick == 50 else 0.0
        return PointMotion(tick * TICK, np.array([0.0, 0.0, z]), np.zeros(3), np.zeros(3))

    states = drive(sim, motion, 100)
    assert sim.boom_tip.missing == 1
    assert states[-1].unit.position[2] == pytest.approx(states[0].unit.position[2], abs=1e-6)


def test_first_boom_tip_or_payout_far_from_the_start_is_refused() -> None:
    sim = CableSim(S300, seed=1, tick_period=TICK)
    far = PointMotion(2 * TICK, np.array([0.0, 0.0, 25.0]))
    with pytest.raises(PlantError, match=r"the first boom_tip is 25\.0 m .* boom_tip_height must be the same"):
        sim.advance(1, far, (0.0, 0.0))
    sim.advance(1, None, None)
    with pytest.raises(PlantError, match=r"the first payout is 500\.0 m"):
        sim.advance(2, PointMotion(3 * TICK), (500.0, 0.0))


def test_tick_out_of_order_is_refused() -> None:
    sim = CableSim(S300, seed=1, tick_period=TICK)
    with pytest.raises(PlantError, match="tick 3 was requested, but the plant is at tick 1"):
        sim.readings(3)


def test_cable_hauled_in_to_nothing_is_a_named_error() -> None:
    sim = CableSim(dataclasses.replace(S300, length=20.0, segments=10), seed=1, tick_period=TICK)
    with pytest.raises(PlantError, match="of cable is left"):
        for tick in range(1, 1000):
            sim.advance(tick, PointMotion((tick + 1) * TICK), (-1.0 * tick * TICK, -1.0))


def test_shadow_follows_the_programme_where_told() -> None:
    parameters = dataclasses.replace(S300, shadow_follows_programme=True)
    sim = CableSim(parameters, seed=1, tick_period=TICK)
    for tick in range(1, 1001):
        state, _ = sim.readings(tick)
        still = PointMotion((tick + 1) * TICK)
        sim.advance(tick, still, (0.0, 0.0), programme=min(0.2 * tick * TICK, 5.0))
    assert state.uncompensated.position[2] - state.unit.position[2] == pytest.approx(-5.0, abs=0.02)


def test_linear_model_is_chosen_by_its_name() -> None:
    sim = CableSim(dataclasses.replace(S300, model="linear"), seed=1, tick_period=TICK)
    states = drive(sim, ramped_sine((0.0, 0.0, 1.0), 0.5, 20.0), 3000)
    late = [s for s in states if s.time > 75.0]
    _, amplitude, _ = harmonic(np.array([s.time for s in late]), np.array([s.unit.position[2] for s in late]), 0.5)
    assert amplitude == pytest.approx(abs(1.0 / (1.0 - 0.8959 * 0.25 + 0.1658j * 0.5)), rel=0.01)


NUMBER = st.one_of(st.floats(-3.0, 3.0), st.floats(allow_nan=True, allow_infinity=True))


@settings(max_examples=40, deadline=None, phases=(Phase.explicit, Phase.generate))
@given(
    inputs=st.lists(
        st.tuples(st.one_of(st.none(), st.tuples(NUMBER, NUMBER)), st.one_of(st.none(), st.tuples(NUMBER, NUMBER))),
        min_size=5,
        max_size=40,
    )
)
def test_whatever_comes_in_nothing_but_finite_numbers_or_a_named_error_comes_out(
    inputs: list[tuple[tuple[float, float] | None, tuple[float, float] | None]],
) -> None:
    sim = CableSim(dataclasses.replace(S300, length=100.0, segments=4), seed=1, tick_period=TICK)
    for tick, (tip, winch) in enumerate(inputs, start=1):
        state, readings = sim.readings(tick)
        numbers = [state.node_positions, state.segment_tensions, state.unit.velocity, state.uncompensated.acceleration]
        numbers += [reading.value for reading in (*readings["depth"], *readings["imu"], *readings["load_cell"])]
        assert all(np.isfinite(values).all() for values in numbers)
        assert state.segment_tensions.min() >= 0.0
        motion = None
        if tip is not None:
            motion = PointMotion((tick + 1) * TICK, np.array([0.0, 0.0, tip[0]]), np.array([0.0, 0.0, tip[1]]))
        try:
            sim.advance(tick, motion, winch)
        except PlantError as error:
            assert str(error)
            return


def test_a_landed_start_rests_with_its_shadow_and_says_how_far_the_cable_was_strained():
    sim = CableSim(dataclasses.replace(S300, seabed=SeabedParameters(depth=300.3)), seed=1, tick_period=TICK)
    states = drive(sim, lambda k: PointMotion(k * TICK), 100)
    assert states[0].touchdown
    for state in (states[0], states[-1]):
        assert state.unit.position == pytest.approx(states[0].unit.position, abs=1e-9)
        assert state.uncompensated.position == pytest.approx(states[0].unit.position, abs=1e-9)
    calm = sim.largest_strain
    assert calm == pytest.approx(states[0].segment_tensions.max() / S300.cable.axial_stiffness, rel=1e-6)
    drive(sim, ramped_sine((0.0, 0.0, 0.5), 1.2, 5.0), 200)
    assert sim.largest_strain > 1.2 * calm
