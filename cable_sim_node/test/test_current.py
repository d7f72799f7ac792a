import math

import numpy as np
import pytest
from cable_sim_node.errors import StaticsError
from cable_sim_node.line.grid import build_line
from cable_sim_node.parameters import CableSimParameters, CurrentProfileParameters
from cable_sim_node.physics.current import Current, current_at, current_of
from hypothesis import given
from hypothesis import strategies as st

SPEED = st.floats(-3.0, 3.0)
PROFILE = st.lists(
    st.tuples(st.integers(-50, 3000), SPEED, SPEED), min_size=1, max_size=6, unique_by=lambda row: row[0]
)


def test_a_profile_is_straight_between_its_points_and_constant_beyond():
    current = Current([[1.0, 0.0], [0.0, 0.5]], [0.0, 100.0])
    expected = {-10.0: (1.0, 0.0), 0.0: (1.0, 0.0), 25.0: (0.75, 0.125), 100.0: (0.0, 0.5), 300.0: (0.0, 0.5)}
    for depth, (x, y) in expected.items():
        flow, _ = current_at(depth, current.profile, 2.0)
        assert flow == pytest.approx((2.0 * x, 2.0 * y, 0.0))
    assert current_at(25.0, current.profile, 1.0)[1] == pytest.approx((-0.01, 0.005, 0.0))
    assert current_at(300.0, current.profile, 1.0)[1] == (0.0, 0.0, 0.0)


@given(PROFILE, st.floats(-100.0, 3500.0))
def test_the_look_up_is_linear_interpolation(rows, depth):
    depths, x, y = np.array(sorted(rows), dtype=float).T
    current = Current(np.column_stack((x, y)), depths)
    assert current.at(depth) == pytest.approx(
        [np.interp(depth, depths, x), np.interp(depth, depths, y), 0.0], abs=1e-12
    )


@given(PROFILE, st.tuples(SPEED, SPEED), st.floats(-100.0, 3500.0))
def test_a_moving_frame_sees_the_difference(rows, velocity, depth):
    depths, x, y = np.array(sorted(rows), dtype=float).T
    current = Current(np.column_stack((x, y)), depths)
    assert current.shifted(velocity).at(depth) == pytest.approx(current.at(depth) - [*velocity, 0.0], abs=1e-12)


def test_the_current_of_parameters_is_their_profile_or_uniform():
    parameters = CableSimParameters(current_profile=CurrentProfileParameters((0.0, 100.0), (1.0, 0.0), (0.0, 0.5)))
    assert current_of(parameters).at(50.0) == pytest.approx([0.5, 0.25, 0.0])
    assert current_at(50.0, build_line(parameters, 300.0).water, 0.5)[0] == pytest.approx((0.25, 0.125, 0.0))
    assert current_of(CableSimParameters(current=(0.3, -0.2))).at(7.0) == pytest.approx([0.3, -0.2, 0.0])


@pytest.mark.parametrize(
    ("velocities", "depths", "words"),
    [
        ([[0.0, 0.0], [1.0, 0.0]], [10.0, 10.0], "increasing"),
        ([math.nan, 0.0], [0.0], "finite"),
        ([[0.0, 0.0]], [0.0, 10.0], "one velocity"),
    ],
)
def test_a_current_that_cannot_be_is_refused(velocities, depths, words):
    with pytest.raises(StaticsError, match=words):
        Current(velocities, depths)


def test_still_water_is_known_as_such():
    assert Current().is_still
    assert not Current((0.0, 0.1)).is_still
