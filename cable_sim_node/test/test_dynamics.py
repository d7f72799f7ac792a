"""The solver as an object: copies, bad input named, invariance, features switched on one by one."""

import copy
import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.errors import BadMotionError, NoEquilibriumError, PlantError
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import (
    CableParameters,
    CableSimParameters,
    CompensatorParameters,
    SeabedParameters,
    UnitParameters,
)
from heave_node.numerics.kinematics import PointMotion
from heave_node.parameters import ParameterError, build_parameters
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.validation.peers.driven_run import first_harmonic, ramped_sine, run_driven
from tests.validation.peers.reference_systems import s300

STILL = PointMotion()


def driven(plant, motion, ticks, tick=0.05, first=0):
    for k in range(first, first + ticks):
        plant.advance(tick, motion(k * tick), motion((k + 1) * tick), 0.0, 0.0, 0.0, 0.0)


def started(parameters, boom_tip=(0.0, 0.0, 0.0)):
    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(boom_tip)
    return plant


def test_a_copy_runs_on_bit_for_bit_and_shares_nothing():
    motion = ramped_sine((1.0, 0.5, 1.0), 1.0, 5.0)
    plant = started(s300(20, (0.4, 0.0)))
    driven(plant, motion, 50)
    branch = copy.deepcopy(plant)
    driven(plant, motion, 50, first=50)
    assert not np.array_equal(branch.node_positions, plant.node_positions)
    driven(branch, motion, 50, first=50)
    assert np.array_equal(branch.node_positions, plant.node_positions)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_motion_that_is_not_a_number_is_refused_and_changes_nothing(bad):
    plant = started(s300(20))
    before = plant.node_positions
    wrong = PointMotion(position=np.array([0.0, bad, 0.0]))
    with pytest.raises(BadMotionError, match="must be finite"):
        plant.advance(0.05, STILL, wrong, 0.0, 0.0, 0.0, 0.0)
    with pytest.raises(BadMotionError):
        plant.advance(0.05, STILL, STILL, 0.0, 0.0, bad, 0.0)
    with pytest.raises(BadMotionError):
        plant.advance(0.0, STILL, STILL, 0.0, 0.0, 0.0, 0.0)
    with pytest.raises(BadMotionError):
        plant.set_thrust([0.0, bad, 0.0])
    assert np.array_equal(plant.node_positions, before)


def test_a_payout_that_jumps_between_intervals_is_refused_and_changes_nothing():
    plant = started(s300(20))
    plant.advance(0.05, STILL, STILL, 0.0, 0.0, 0.02, 0.8)
    before = copy.deepcopy(plant._line)
    with pytest.raises(BadMotionError, match=r"at t = 0\.05 s: payout_start 0\.03 m differs from .* 0\.02 m"):
        plant.advance(0.05, STILL, STILL, 0.03, 0.8, 0.07, 0.8)
    for name, value in plant._line._asdict().items():
        assert np.array_equal(value, getattr(before, name)), name
    # rounding of a sum is no jump
    plant.advance(0.05, STILL, STILL, 0.02 + 1e-12, 0.8, 0.06, 0.8)
    assert plant.unstretched_length == pytest.approx(300.06, abs=1e-12)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"segments": 0}, "segments = 0"),
        ({"cable.axial_stiffness": 0.0}, "cable.axial_stiffness = 0.0"),
        ({"length": -3.0}, "length = -3.0"),
        ({"unit.mass": math.nan}, "unit.mass = nan"),
        ({"sections.length": [10.0]}, "sections.diameter"),
        ({"clumps.position": [10.0]}, "clumps.mass"),
        ({"current_profile.depth": [0.0, 0.0]}, "current_profile"),
        ({"cable.diamter": 0.1}, "did you mean cable.diameter"),
    ],
)
def test_bad_parameters_are_refused_with_their_name(values, words):
    with pytest.raises(ParameterError, match=words):
        build_parameters(CableSimParameters, values, where="test")


def test_a_unit_that_lifts_its_whole_cable_does_not_hang():
    with pytest.raises(NoEquilibriumError, match="does not hang"):
        started(dataclasses.replace(s300(20), unit=UnitParameters(mass=3000.0, volume=10.0)))


@settings(max_examples=20, deadline=None)
@given(
    shift=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(-50.0, 50.0)),
    turn=st.floats(-math.pi, math.pi),
)
def test_motion_does_not_depend_on_place_or_heading(shift, turn):
    """Rigid translation, and rotation about the vertical of motion and current together."""
    rotation = np.array(
        [[math.cos(turn), -math.sin(turn), 0.0], [math.sin(turn), math.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    base = ramped_sine((1.0, 0.4, 1.0), 1.3, 3.0)

    def moved(t):
        motion = base(t)
        return PointMotion(t, rotation @ motion.position + np.array(shift), rotation @ motion.velocity, np.zeros(3))

    current = rotation @ np.array([0.6, 0.1, 0.0])
    round_unit = UnitParameters(drag_coefficient=(0.0, 0.0, 1.5))  # drag by axis is not the same in all headings
    one = started(dataclasses.replace(s300(8, (0.6, 0.1)), unit=round_unit))
    two = started(dataclasses.replace(s300(8, (current[0], current[1])), unit=round_unit), shift)
    driven(one, base, 60)
    driven(two, moved, 60)
    assert two.node_positions - np.array(shift) == pytest.approx(one.node_positions @ rotation.T, abs=1e-5)


@settings(max_examples=15, deadline=None)
@given(
    amplitude=st.tuples(*[st.floats(-6.0, 6.0)] * 3),
    omega=st.floats(0.2, 4.0),
    length=st.floats(5.0, 900.0),
    segments=st.integers(1, 30),
    mass=st.floats(100.0, 2e5),
    diameter=st.floats(0.005, 0.2),
    stiffness=st.floats(1e5, 1e9),
    current=st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)),
    damping=st.floats(0.0, 1e6),
)
def test_any_legal_system_stays_finite_and_never_pushes(
    amplitude, omega, length, segments, mass, diameter, stiffness, current, damping
):
    """Storm motions that make the line slack and snap included."""
    parameters = CableSimParameters(
        length=length,
        segments=segments,
        current=current,
        cable=CableParameters(
            diameter=diameter,
            mass_per_length=2.5e3 * diameter**2,
            axial_stiffness=stiffness,
            internal_damping=damping,
        ),
        unit=UnitParameters(mass=mass, volume=0.5 * mass / 1025.0, added_mass=(mass,) * 3),
    )
    try:
        plant = started(parameters)
    except NoEquilibriumError:
        return
    motion = ramped_sine(amplitude, omega, 2.0)
    for k in range(100):
        plant.advance(0.05, motion(k * 0.05), motion((k + 1) * 0.05), 0.0, 0.0, 0.0, 0.0)
        assert np.min(plant.segment_tensions) >= 0.0
        assert plant.top_tension >= 0.0
    assert np.all(np.isfinite(plant.node_positions))


def test_halving_the_step_quarters_the_error():
    """Second order in time, in smooth motion: Richardson's ratio of differences is 4."""

    def heave(step):
        result = run_driven(
            s300(20, time_step=step, spectral_radius=0.8),
            (1.0, 0.0, 1.0),
            1.256,
            duration=40.0,
            window=10.0,
            ramp=10.0,
            tick=0.1,
        )
        return result.unit[:, 2]

    coarse, middle, fine = heave(0.1), heave(0.05), heave(0.025)
    ratio = np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)
    assert math.log2(ratio) == pytest.approx(2.0, abs=0.3)


def test_a_tick_cut_into_parts_gives_the_same_as_inner_steps():
    """The inner step fixes the result, not the length of the intervals (up to the cubic in between)."""
    motion = ramped_sine((0.0, 0.0, 1.0), 0.8, 5.0)
    one, two = started(s300(20, time_step=0.05)), started(s300(20, time_step=0.05))
    driven(one, motion, 200, tick=0.05)
    driven(two, motion, 100, tick=0.1)
    assert one.unit_position == pytest.approx(two.unit_position, abs=1e-5)


@pytest.mark.parametrize("time_step", [0.05, 0.0125])
def test_the_units_acceleration_is_that_of_its_motion_at_the_same_time(time_step):
    """The second derivative of a harmonic motion is -w^2 times it: neither early nor late by 0.5 ms."""
    omega, tick = 1.256, 0.05
    motion = ramped_sine((1.0, 0.0, 1.0), omega, 40.0)
    plant = started(s300(20, time_step=time_step))
    driven(plant, motion, 1800)
    times, positions, accelerations = [], [], []
    for k in range(1800, 2400):
        driven(plant, motion, 1, first=k)
        times.append((k + 1) * tick)
        positions.append(plant.unit_position[2])
        accelerations.append(plant.unit_acceleration[2])
    _, amplitude, phase = first_harmonic(np.array(times), np.array(positions), omega)
    _, size, lead = first_harmonic(np.array(times), np.array(accelerations), omega)
    assert size == pytest.approx(omega**2 * amplitude, rel=2e-3)
    late = math.remainder(phase + math.pi - lead, 2.0 * math.pi) / omega
    assert late == pytest.approx(0.0, abs=0.5e-3)


def test_a_unit_in_free_fall_accelerates_with_gravity():
    """In a vacuum, above a cable that went slack: g exactly, less than which an IMU reads as nothing."""
    plant = started(dataclasses.replace(s300(20), water_density=0.0))
    assert plant.unit_acceleration == pytest.approx(np.zeros(3), abs=1e-6)
    plant.set_thrust((0.0, 0.0, 1e5))
    for _ in range(20):
        plant.advance(0.05, STILL, STILL, 0.0, 0.0, 0.0, 0.0)
    plant.set_thrust((0.0, 0.0, 0.0))
    assert plant.segment_tensions[0] == 0.0
    assert plant.unit_acceleration == pytest.approx([0.0, 0.0, -9.80665], abs=1e-9)


def test_a_thruster_holds_the_unit_against_its_weight_sideways():
    """Static deflection of the unit under a small side force is force times length over tension, in still water."""
    plant = started(dataclasses.replace(s300(60), unit=UnitParameters(thrust=(100.0, 0.0, 0.0))))
    unit = UnitParameters().weight_in_fluid(1025.0)
    w = CableParameters().weight_in_fluid(1025.0)
    # integral of F ds / (W + w s), stretched
    offset = 100.0 / w * math.log((unit + w * 300.0) / unit) + 100.0 * 300.0 / CableParameters().axial_stiffness
    assert plant.unit_position[0] == pytest.approx(offset, rel=1e-3)


# --- seabed


def landing(**seabed):
    return dataclasses.replace(s300(30), seabed=SeabedParameters(depth=310.0, **seabed))


def test_the_unit_lands_and_the_seabed_carries_what_the_cable_no_longer_does():
    """At rest on the bottom: penetration = (weight in water - tension)/stiffness."""
    plant = started(landing())
    tick, payout, rate = 0.05, 0.0, 0.0
    for k in range(3000):
        s = min((k + 1) * tick / 100.0, 1.0)
        after, new = 12.0 * s**3 * (10 - 15 * s + 6 * s * s), 12.0 * 30.0 * s**2 * (1 - s) ** 2 / 100.0
        plant.advance(tick, STILL, STILL, payout, rate, after, new)
        payout, rate = after, new
    assert plant.touchdown
    weight = UnitParameters().weight_in_fluid(1025.0)
    penetration = -plant.unit_position[2] - 310.0
    pull = plant.segment_tensions[0]
    assert penetration == pytest.approx((weight - pull) / 1e6, rel=0.05)
    assert np.linalg.norm(plant.unit_velocity) < 1e-3
    assert plant.touchdown_force == pytest.approx(weight - pull, rel=0.05)


# --- bending


def stiff(segments=100, current=(0.1, 0.0), **cable):
    """A weightless line, uniformly taut by a thruster, across a current."""
    return CableSimParameters(
        length=100.0,
        segments=segments,
        current=current,
        gravity=0.0,
        cable=CableParameters(tangential_drag=0.0, bending_stiffness=5e5, **cable),
        unit=UnitParameters(thrust=(0.0, 0.0, -2000.0), volume=0.0, drag_coefficient=(0.0,) * 3),
    )


def test_a_stiff_line_bends_as_a_tensioned_beam_under_uniform_load():
    """M'' = T y'' + q with M = EI y'' and no moment at the ends.

    So y'' = -(q/T) (1 - cosh(k (s - L/2))/cosh(k L/2)), k^2 = T/EI, whatever holds the ends.
    """
    plant = started(stiff())
    x = plant.node_positions
    bend = np.diff(x[:, 0], 2)
    load = 0.5 * 1025.0 * 1.2 * 0.047 * 0.1**2
    k = math.sqrt(2000.0 / 5e5)
    s = np.arange(1, 100) - 50.0
    expected = load / 2000.0 * (1.0 - np.cosh(k * s) / math.cosh(k * 50.0))
    assert np.abs(bend) == pytest.approx(expected, abs=0.003 * expected.max())
    driven(plant, lambda t: STILL, 200)
    assert plant.node_positions == pytest.approx(x, abs=1e-7)


# --- compensator


def test_the_compensator_stops_at_its_stroke():
    spring = CompensatorParameters(stiffness=500.0, damping=100.0, stroke=0.4)
    plant = started(dataclasses.replace(s300(10), compensator=spring))
    motion = ramped_sine((0.0, 0.0, 1.5), 1.0, 10.0)
    strokes = []
    for k in range(1200):
        plant.advance(0.05, motion(k * 0.05), motion((k + 1) * 0.05), 0.0, 0.0, 0.0, 0.0)
        strokes.append(plant.compensator_stroke)
    assert 0.2 <= max(strokes) < 0.25
    assert min(strokes) > -0.25


def test_a_compensator_set_for_another_load_is_named():
    spring = CompensatorParameters(stiffness=1e3, preload=1e5, stroke=2.0)
    with pytest.raises(PlantError, match="static top tension"):
        started(dataclasses.replace(s300(10), compensator=spring))
