import numpy as np
import pytest
from cable_sim_node.physics.drag import segment_drag
from hypothesis import assume, given, settings
from hypothesis import strategies as st

NORMAL, TANGENTIAL = 20.0, 3.0
COMPONENT = st.floats(-1.0, 1.0).map(lambda value: round(value, 6))
VECTOR = st.tuples(COMPONENT, COMPONENT, COMPONENT)


def drag(chord, flow, feed=0.0):
    scratch = np.empty((3, 3)), np.empty((3, 3))
    return np.array(segment_drag(np.asarray(chord, float), tuple(map(float, flow)), feed, NORMAL, TANGENTIAL, *scratch))


def test_drag_across_and_along_follows_the_printed_formulae():
    # thesis Eq. 2.46, 2.47 by hand: flow 45 degrees to a vertical cable
    assert drag([0.0, 0.0, 2.0], [0.5, 0.0, 0.5]) == pytest.approx([20.0 * 0.25, 0.0, 3.0 * 0.25])


@given(VECTOR, VECTOR)
def test_drag_is_that_of_the_two_components_in_any_direction(chord, flow):
    assume(np.linalg.norm(chord) > 0.1)
    e = np.array(chord) / np.linalg.norm(chord)
    along = e * (e @ flow)
    across = flow - along
    expected = NORMAL * np.linalg.norm(across) * across + TANGENTIAL * np.linalg.norm(along) * along
    assert drag(chord, flow) == pytest.approx(expected, abs=1e-12)


@settings(max_examples=60, deadline=None)
@given(VECTOR, VECTOR, st.floats(-1.0, 1.0))
def test_drag_derivatives_are_those_of_finite_differences(chord, flow, feed):
    chord, flow = 3.0 * np.array(chord), np.array(flow)
    assume(np.linalg.norm(chord) > 0.5)
    along = float(flow @ chord) / np.linalg.norm(chord)
    across = np.linalg.norm(flow - along * chord / np.linalg.norm(chord))
    assume(across > 0.05 and abs(along + feed) > 0.05)
    by_chord, by_flow = np.empty((3, 3)), np.empty((3, 3))
    segment_drag(chord, tuple(map(float, flow)), feed, NORMAL, TANGENTIAL, by_chord, by_flow)
    step = 1e-5
    for axis, unit in enumerate(np.eye(3)):
        change = drag(chord + step * unit, flow, feed) - drag(chord - step * unit, flow, feed)
        assert by_chord[:, axis] == pytest.approx(change / (2.0 * step), abs=1e-4)
        change = drag(chord, flow + step * unit, feed) - drag(chord, flow - step * unit, feed)
        assert by_flow[:, axis] == pytest.approx(change / (2.0 * step), abs=1e-4)


@given(VECTOR, VECTOR, VECTOR, VECTOR)
def test_the_linear_drag_of_12_4_5_is_the_derivative_with_a_minus_in_its_projections(slope, change, flow, motion):
    """Thesis F_x1, F_y1, F_z1 below Eq. 12.28 for an unstretched cable; a and b print a plus before both products.

    Beside differences of our drag. The printed a has a part along the cable, twice the flow's.
    """
    t0, t1, water, velocity = map(np.array, (slope, change, flow, motion))
    assume(np.linalg.norm(t0) > 0.1)
    t0 = t0 / np.linalg.norm(t0)
    t1 = t1 - (t1 @ t0) * t0
    a = water - (water @ t0) * t0
    size = np.linalg.norm(a)
    assume(size > 0.05 and abs(water @ t0) > 0.05)
    printed = water + (water @ t0) * t0
    b = -velocity - (water @ t0) * t1 - (water @ t1 - velocity @ t0) * t0
    linear = NORMAL * (a * (a @ b) / size + b * size)

    def across(step):
        scratch = np.empty((3, 3)), np.empty((3, 3))
        relative = tuple(map(float, water - step * velocity))
        return np.array(segment_drag(t0 + step * t1, relative, 0.0, NORMAL, 0.0, *scratch))

    assert across(0.0) == pytest.approx(NORMAL * size * a, abs=1e-9)
    assert np.linalg.norm(NORMAL * np.linalg.norm(printed) * printed - across(0.0)) > 0.1
    assert linear == pytest.approx((across(1e-6) - across(-1e-6)) / 2e-6, abs=1e-3)
