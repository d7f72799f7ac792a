"""Cable without tension: laid down on itself, folded, thrown about, and drawn taut again."""

import itertools
import math

import numpy as np
import pytest
from cable_sim_node.line import layout as at
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.line.forces.direction import FOLDED, direction_of
from cable_sim_node.line.observation import evaluate
from cable_sim_node.parameters import CableParameters, CableSimParameters, SeabedParameters, UnitParameters
from heave_node.numerics.kinematics import PointMotion
from hypothesis import given
from hypothesis import strategies as st

TICK = 0.05


def rise(s):
    s = min(max(s, 0.0), 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * s * s * (1.0 - s) ** 2


def lay_down_and_move_off(plant, heave, period):
    """Lay 30 m of cable on a unit that stands 10 m below, move 25 m to the side, draw it taut; heave all the while.

    Returns the largest number of Newton iterations of a tick, and the largest speed of a node [m/s].
    """
    omega = 2.0 * math.pi / period

    def tip(t):
        grown, growing = rise(t / 10.0)
        off, leaving = rise((t - 170.0) / 60.0)
        sine, cosine = math.sin(omega * t), math.cos(omega * t)
        velocity = heave * (growing / 10.0 * sine + grown * omega * cosine)
        return PointMotion(
            t, np.array([25.0 * off, 0.0, heave * grown * sine]), np.array([25.0 * leaving / 60.0, 0.0, velocity])
        )

    def payout(t):
        out, leaving = rise(t / 150.0)
        back, coming = rise((t - 250.0) / 135.0)
        return 40.0 * out - 36.0 * back, 40.0 * leaving / 150.0 - 36.0 * coming / 135.0

    most, fastest, before = 0, 0.0, 0
    for k in range(round(405.0 / TICK)):
        start, end = k * TICK, (k + 1) * TICK
        plant.advance(TICK, tip(start), tip(end), *payout(start), *payout(end))
        most, before = max(most, plant.newton_iterations - before), plant.newton_iterations
        fastest = max(fastest, float(np.abs(plant.node_velocities[:-1]).max()))
    return most, fastest


@pytest.mark.slow
@pytest.mark.parametrize("bending", [0.0, 2000.0])
@pytest.mark.parametrize("heave", [0.5, pytest.param(1.0, marks=pytest.mark.long), 2.0])
@pytest.mark.parametrize("segments", [20, pytest.param(50, marks=pytest.mark.long)])
def test_a_cable_laid_down_exactly_vertically_can_be_moved_off_and_drawn_taut(heave, segments, bending):
    """The 300 m system with heave alone and no current: nodes come to lie in one point.

    A tick of 25 ms is 2,000 Newton iterations of 50 segments with a quarter of a microsecond for each; with bending,
    500. Nothing drives a node faster than a few times the boom tip's speed, and the free fall of its slack.
    """
    for period in (6.0, 10.0):
        plant = CableDynamics(
            CableSimParameters(
                segments=segments,
                cable=CableParameters(bending_stiffness=bending),
                seabed=SeabedParameters(depth=310.0),
            )
        )
        plant.start_at_equilibrium(np.zeros(3))
        most, fastest = lay_down_and_move_off(plant, heave, period)
        assert most < 500
        assert fastest < 3.0 * heave * 2.0 * math.pi / period + 2.0
        assert plant.slack_segments == 0


# --- direction of a segment


def test_a_taut_segment_points_along_its_chord():
    for ratio in (FOLDED, 0.9, 1.0, 1.2):
        assert direction_of.py_func(ratio)[0] * ratio == pytest.approx(1.0, abs=1e-15)


@given(st.floats(1e-4, 1.5))
def test_the_direction_is_a_unit_vector_at_most_and_changes_smoothly(ratio):
    """The derivative is that of the formula (central differences), also where one piece of it meets the other."""
    factor, turning = direction_of.py_func(ratio)
    assert 0.0 < factor * ratio <= 1.0 + 1e-15
    assert factor <= 1.5 / FOLDED
    h = 1e-6
    slope = (direction_of.py_func(ratio + h)[0] - direction_of.py_func(ratio - h)[0]) / (2.0 * h)
    assert turning * ratio == pytest.approx(slope, abs=1e-4)


@given(
    chords=st.tuples(*[st.tuples(*[st.floats(-1.0, 1.0)] * 3)] * 3),
    share=st.sampled_from([0.0, 1e-9, 0.3, 0.9]),
)
def test_hinge_forces_are_the_gradient_of_their_energy_however_the_line_is_folded(chords, share):
    """Force = -dE/dx of E = (1/2) B |d_i - d_{i-1}|^2, by central differences; nothing else acts on this line."""
    stiffness, length = 500.0, 2.0
    plant = CableDynamics(
        CableSimParameters(
            length=3.0 * length,
            segments=3,
            water_density=0.0,
            cable=CableParameters(bending_stiffness=stiffness),
            unit=UnitParameters(mass=10.0),
        )
    )
    plant.start_at_equilibrium(np.zeros(3))
    line = plant._line
    line.write(at.WEIGHT, np.zeros((3, 1)))
    line.numbers[at.UNIT_FORCE : at.UNIT_FORCE + 3] = 0.0
    folded = share * length / math.sqrt(3.0) * np.array(chords)
    nodes = np.vstack([[0.0, 0.0, 0.0], np.cumsum(folded, axis=0)])

    def direction(chord):
        r = np.linalg.norm(chord) / length
        f = 1.0 / r if r >= FOLDED else (1.5 - 0.5 * (r / FOLDED) ** 2) / FOLDED
        return f * chord / length

    def energy(x):
        d = [direction(x[i + 1] - x[i]) for i in range(3)]
        return sum(0.5 * stiffness / length * float((b - a) @ (b - a)) for a, b in itertools.pairwise(d))

    line.write(at.X, nodes)
    evaluate(line)
    residual = line.read(at.RX, 3, 4)
    for node, axis in itertools.product(range(3), range(3)):
        moved = np.zeros((4, 3))
        moved[node, axis] = 1e-5
        slope = (energy(nodes + moved) - energy(nodes - moved)) / 2e-5
        assert residual[node, axis] == pytest.approx(slope, rel=1e-5, abs=1e-4)
