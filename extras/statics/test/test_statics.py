import math

import numpy as np
import pytest
from cable_sim_node.errors import NoEquilibriumError, StaticsError
from cable_sim_node.physics.current import Current
from heave_statics.footprint import FootprintLimits, footprint
from heave_statics.problems import mooring_cable, submerged_cable, towing_cable
from heave_statics.shape import cut_at_height, shape_from
from heave_statics.system import PointLoad, StaticSection, static_cable
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

STIFFNESS, WEIGHT = 5.0e5, 4.0
SECTION = StaticSection(200.0, STIFFNESS, WEIGHT, normal_drag=15.0, tangential_drag=1.0)


def turned(vector, angle):
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1], *vector[2:]])


def outer_forces(shape):
    """Sum of all forces on the cable: ends, weight, point loads, drag [N]."""
    lengths = shape.cable.segments[:, 0]
    return (
        shape.start_force
        + shape.end_force
        + lengths @ (shape.cable.steady_loads + shape.drag)
        + shape.cable.nodes[:, :3].sum(axis=0)
    )


SPEED, ANGLE = st.floats(0.0, 3.0), st.floats(0.0, 2.0 * math.pi)
# a weightless slack part between loads has no one shape; that is tested by itself
HEAVY_OR_BUOYANT = st.one_of(st.floats(0.01, 6.0), st.floats(-6.0, -0.01))


@settings(phases=(Phase.explicit, Phase.generate), max_examples=20, deadline=None)
@given(st.floats(5.0, 230.0), st.floats(-1.0, 1.0), ANGLE, SPEED, ANGLE, HEAVY_OR_BUOYANT)
def test_a_submerged_cable_meets_both_ends_and_all_forces_balance(distance, slope, heading, speed, current, weight):
    cable = static_cable(
        [StaticSection(200.0, STIFFNESS, weight, 15.0, 1.0)], [PointLoad(70.0, (20.0, 0.0, -100.0))], segments=40
    )
    height = distance * slope
    end = turned(np.array([math.sqrt(distance**2 - height**2), 0.0, height]), heading)
    flow = Current(speed * np.array([math.cos(current), math.sin(current)]))
    shape = submerged_cable(cable, (0.0, 0.0, 0.0), end, flow)
    assert shape.positions[-1] == pytest.approx(end, abs=1e-5)
    scale = 200.0 + float(np.abs(shape.tension).max())
    assert outer_forces(shape) == pytest.approx(np.zeros(3), abs=1e-9 * scale)
    assert np.all(shape.tension >= 0.0)


@settings(phases=(Phase.explicit, Phase.generate), max_examples=25, deadline=None)
@given(ANGLE, SPEED, ANGLE, st.floats(40.0, 190.0))
def test_turning_everything_about_the_vertical_turns_the_answer(angle, speed, heading, distance):
    cable = static_cable([SECTION], segments=30)
    end = np.array([distance, 0.0, 30.0])
    flow = speed * np.array([math.cos(heading), math.sin(heading)])
    shape = submerged_cable(cable, np.zeros(3), end, Current(flow))
    other = submerged_cable(cable, np.zeros(3), turned(end, angle), Current(turned(flow, angle)))
    expected = np.array([turned(point, angle) for point in shape.positions])
    assert other.positions == pytest.approx(expected, abs=1e-4)


@settings(phases=(Phase.explicit, Phase.generate), max_examples=25, deadline=None)
@given(st.floats(-500.0, 500.0), st.floats(-500.0, 500.0), SPEED, ANGLE)
def test_a_horizontal_shift_shifts_the_answer(x, y, speed, heading):
    cable = static_cable([SECTION], [PointLoad(0.0, (0.0, 0.0, -300.0), axis_drag=(5.0, 5.0, 5.0))], segments=30)
    flow = Current([[0.0, 0.0], [speed * math.cos(heading), speed * math.sin(heading)]], [0.0, 200.0])
    shape = towing_cable(cable, (0.0, 0.0, 0.0), flow)
    other = towing_cable(cable, (x, y, 0.0), flow)
    assert other.positions == pytest.approx(shape.positions + np.array([x, y, 0.0]), abs=1e-6)


@settings(phases=(Phase.explicit, Phase.generate), max_examples=30, deadline=None)
@given(
    st.tuples(*[st.floats(-400.0, 400.0)] * 3).filter(lambda v: np.linalg.norm(v) > 50.0), SPEED, ANGLE, SPEED, ANGLE
)
def test_the_jacobian_of_the_whole_cable_is_that_of_finite_differences(start, speed, heading, below, other):
    cable = static_cable(
        [StaticSection(60.0, 2e5, 5.0, 8.0, 1.0), StaticSection(40.0, 3e5, 2.0, 4.0, 0.5)],
        [PointLoad(30.0, (0.0, 0.0, -80.0), body_drag=3.0), PointLoad(0.0, axis_drag=(10.0, 20.0, 5.0))],
        segments=12,
    )
    flow = Current(
        [
            [speed * math.cos(heading), speed * math.sin(heading)],
            [below * math.cos(other), below * math.sin(other)],
        ],
        [20.0, 180.0],
    )
    point = np.array([0.0, 0.0, -100.0, *start])

    def ends(at):
        shape = shape_from(cable, flow, at[:3], at[3:])
        return None if shape is None else np.concatenate((shape.positions[-1], shape.end_force))

    shape = shape_from(cable, flow, point[:3], point[3:])
    if shape is None or np.linalg.norm(shape.lower, axis=1).min() < 20.0:
        return
    for column in range(6):
        step = np.zeros(6)
        step[column] = 1e-3
        change = [ends(point + step), ends(point - step), ends(point + 2 * step), ends(point - 2 * step)]
        if any(value is None for value in change):
            return
        slope = (8.0 * (change[0] - change[1]) - (change[2] - change[3])) / 12e-3
        scale = np.abs(shape.partials[:, column]).max() + 1e-3
        assert shape.partials[:, column] == pytest.approx(slope, abs=2e-4 * scale)


def least_tension(shape):
    """Return the smallest tension anywhere: tension vectors run straight from end to end of a segment."""
    change = shape.upper - shape.lower
    along = -np.sum(shape.lower * change, axis=1) / np.maximum(np.sum(change**2, axis=1), 1e-12)
    nearest = shape.lower + np.clip(along, 0.0, 1.0)[:, None] * change
    return np.linalg.norm(nearest, axis=1).min()


@settings(phases=(Phase.explicit, Phase.generate), max_examples=30, deadline=None)
@given(st.tuples(*[st.floats(-300.0, 300.0)] * 3).filter(lambda v: np.linalg.norm(v) > 20.0))
def test_the_end_position_is_the_gradient_of_the_complementary_energy(start):
    # Castigliano's theorem: what makes the search under dead loads a convex one
    cable = static_cable([SECTION], [PointLoad(90.0, (30.0, 0.0, -200.0))], segments=6)
    still, origin, tension = Current(), np.zeros(3), np.array(start)
    shape = shape_from(cable, still, origin, tension)
    # Where the tension passes through zero the compliance across has no bound, and neither has its rounding.
    assume(least_tension(shape) > 1e-2)
    for axis, unit in enumerate(np.eye(3)):
        above, below = (shape_from(cable, still, origin, tension + sign * 1e-2 * unit).energy for sign in (1.0, -1.0))
        assert shape.positions[-1, axis] == pytest.approx((above - below) / 2e-2, abs=2e-2)
    compliance = shape.partials[:3, 3:]
    assert compliance == pytest.approx(compliance.T, abs=1e-9 * np.abs(compliance).max())
    assert np.linalg.eigvalsh(compliance).min() > 0.0


def test_looking_from_the_other_end_gives_the_same_cable():
    flow = Current([[0.8, 0.1], [0.2, 0.4]], [0.0, 150.0])
    sections = [StaticSection(80.0, 4e5, 3.0, 12.0, 1.0), StaticSection(60.0, 6e5, 6.0, 20.0, 1.0)]
    load, back = PointLoad(50.0, (0.0, 0.0, -90.0)), PointLoad(90.0, (0.0, 0.0, -90.0))
    start, end = np.array([0.0, 0.0, -100.0]), np.array([90.0, 10.0, -20.0])
    shape = submerged_cable(static_cable(sections, [load], segments=140), start, end, flow)
    mirror = submerged_cable(static_cable(sections[::-1], [back], segments=140), end, start, flow)
    assert mirror.positions[::-1] == pytest.approx(shape.positions, abs=1e-6)
    assert mirror.end_force == pytest.approx(shape.start_force, abs=1e-4)


def test_the_three_problems_agree_on_one_cable():
    # what submerged finds for the forces, towing and mooring turn back into the same shape
    cable = static_cable([SECTION], segments=60)
    flow = Current([[0.9, 0.0], [0.3, 0.5]], [0.0, 150.0])
    start, end = np.array([0.0, 0.0, -120.0]), np.array([60.0, -40.0, 0.0])
    shape = submerged_cable(cable, start, end, flow)
    moored = mooring_cable(cable, start, 0.0, shape.end_force[:2], flow)
    assert moored.positions == pytest.approx(shape.positions, abs=1e-5)
    towed = towing_cable(cable, end, flow, free_force=shape.start_force)
    assert towed.positions == pytest.approx(shape.positions, abs=1e-5)


def test_a_tow_in_still_water_is_weight_and_stretch():
    cable = static_cable([SECTION], [PointLoad(0.0, (0.0, 0.0, -1000.0))])
    shape = towing_cable(cable, (3.0, 4.0, 1.0))
    # by hand: L + (P L + w L^2/2)/EA
    stretch = (1000.0 * 200.0 + 0.5 * WEIGHT * 200.0**2) / STIFFNESS
    assert shape.positions[0] == pytest.approx([3.0, 4.0, 1.0 - 200.0 - stretch], abs=1e-9)
    assert shape.top_tension == pytest.approx(1000.0 + 200.0 * WEIGHT)
    assert shape.top_angle == pytest.approx(0.0, abs=1e-12)
    assert shape.stretched_length == pytest.approx(200.0 + stretch)


def test_a_buoyant_free_end_streams_upwards():
    cable = static_cable([SECTION], [PointLoad(0.0, (0.0, 0.0, 5000.0))])
    shape = towing_cable(cable, (0.0, 0.0, -300.0))
    assert shape.positions[0, 2] > -110.0
    assert shape.end_force[2] == pytest.approx(-5000.0 + 200.0 * WEIGHT)


def test_a_weightless_slack_cable_in_still_water_is_refused():
    with pytest.raises(StaticsError, match="weightless"):
        submerged_cable(static_cable([StaticSection(100.0, 1e5, 0.0)]), (0, 0, 0), (80.0, 0, 0))


def test_a_weightless_taut_cable_is_a_spring():
    shape = submerged_cable(static_cable([StaticSection(100.0, 1e5, 0.0)]), (0, 0, 0), (101.0, 0, 0))
    assert shape.end_force == pytest.approx([1e5 * 0.01, 0.0, 0.0], rel=1e-9)


def test_a_weightless_cable_in_a_cross_current_is_the_classical_bow():
    # normal drag only, on a short sag: every small piece feels rho C d U^2/2 across itself times cos^2 of its slope
    cable = static_cable([StaticSection(100.5, 1e9, 0.0, 20.0, 0.0)], segments=400)
    shape = submerged_cable(cable, (0, 0, 0), (100.0, 0, 0), Current((0.0, 1.0)))
    # no force acts along a weightless cable without tangential drag: tension is the same all along
    assert np.ptp(shape.tension) == pytest.approx(0.0, abs=2e-3 * shape.tension.max())
    # parabola: sag = sqrt(3/8 * slack * span), tension = q span^2/(8 sag) to the order of the slope squared
    sag = math.sqrt(0.375 * 0.5 * 100.0)
    assert shape.positions[:, 1].max() == pytest.approx(sag, rel=0.02)
    assert shape.tension.max() == pytest.approx(20.0 * 100.0**2 / (8.0 * sag), rel=0.04)


@settings(phases=(Phase.explicit, Phase.generate), max_examples=12, deadline=None)
@given(
    st.lists(st.tuples(st.floats(50.0, 400.0), st.sampled_from([0.0, -2.0, 5.0, 40.0])), min_size=1, max_size=3),
    st.lists(st.tuples(st.floats(0.2, 1.5), ANGLE), min_size=2, max_size=4),
    st.floats(0.1, 1.0),
    ANGLE,
)
def test_sections_even_weightless_ones_in_any_sheared_current_are_in_equilibrium(pieces, profile, share, heading):
    sections = [StaticSection(length, 1e7, weight, 12.0, 1.0) for length, weight in pieces]
    cable = static_cable(sections, segments=30)
    velocities = [(speed * math.cos(angle), speed * math.sin(angle)) for speed, angle in profile]
    flow = Current(velocities, 150.0 * np.arange(len(profile)))
    start = np.array([0.0, 0.0, -cable.length])
    end = start + share * cable.length * np.array([0.8 * math.cos(heading), 0.8 * math.sin(heading), 0.6])
    for shape in (
        submerged_cable(cable, start, end, flow),
        mooring_cable(cable, start, end[2], (500.0, 100.0), flow),
        towing_cable(cable, end, flow, free_force=(0.0, 0.0, -2000.0)),
    ):
        scale = cable.length + float(shape.tension.max())
        assert outer_forces(shape) == pytest.approx(np.zeros(3), abs=1e-8 * scale)
        assert shape.positions[-1, 2] == pytest.approx(end[2], abs=1e-4 * cable.length)


def test_a_slack_weightless_part_in_still_water_is_said_to_be_undetermined():
    cable = static_cable([StaticSection(100.0, 1e6, 0.0), StaticSection(50.0, 1e6, 20.0)])
    with pytest.raises(NoEquilibriumError, match="weightless part"):
        submerged_cable(cable, (0, 0, 0), (20.0, 0, 0))


def test_strong_current_and_a_slack_cable_are_reached():
    cable = static_cable([StaticSection(300.0, 1e8, 2.25, 20.0, 0.5)], segments=80)
    for speed in (1.0, 5.0, 10.0):
        shape = submerged_cable(cable, (0, 0, -100.0), (20.0, 0, -100.0), Current((0.0, speed)))
        assert shape.positions[-1] == pytest.approx([20.0, 0.0, -100.0], abs=1e-4)
        # nearly all of it streams with the current
        assert shape.positions[:, 1].max() > 100.0


def test_mooring_reports_a_load_that_it_needs():
    with pytest.raises(StaticsError, match="give it a load"):
        mooring_cable(static_cable([StaticSection(100.0, 1e5, 0.0)]), (0, 0, 0), 50.0, (0.0, 0.0))


@pytest.mark.parametrize(
    ("section", "message"),
    [
        (StaticSection(0.0, 1e5, 1.0), "length"),
        (StaticSection(10.0, -1.0, 1.0), "axial_stiffness"),
        (StaticSection(10.0, 1e5, math.nan), "finite"),
        (StaticSection(10.0, 1e5, 1.0, -1.0), "drag"),
    ],
)
def test_a_bad_section_is_refused_by_name(section, message):
    with pytest.raises(StaticsError, match=message):
        static_cable([section])


def test_bad_loads_currents_and_points_are_refused():
    with pytest.raises(StaticsError, match="not on the cable"):
        static_cable([SECTION], [PointLoad(201.0)])
    with pytest.raises(StaticsError, match="increasing"):
        Current([[0.0, 0.0], [1.0, 0.0]], [10.0, 10.0])
    with pytest.raises(StaticsError, match="finite"):
        Current((math.nan, 0.0))
    with pytest.raises(StaticsError, match="end"):
        submerged_cable(static_cable([SECTION]), (0, 0, 0), (1.0, math.inf, 0.0))


def test_the_crossing_of_a_height_is_on_the_curve():
    shape = towing_cable(static_cable([SECTION], [PointLoad(0.0, (50.0, 0.0, -400.0))], segments=20), (0, 0, 0))
    crossing = cut_at_height(shape, -77.7)
    assert crossing is not None
    assert crossing.position[2] == pytest.approx(-77.7, abs=1e-9)
    fine = towing_cable(static_cable([SECTION], [PointLoad(0.0, (50.0, 0.0, -400.0))], segments=2000), (0, 0, 0))
    assert crossing.label == pytest.approx(np.interp(-77.7, fine.positions[:, 2], fine.cable.labels), abs=1e-4)
    assert cut_at_height(shape, 5.0) is None


def test_the_footprint_stops_at_the_length_and_tension_limits():
    cable = static_cable([StaticSection(130.0, 1e12, WEIGHT)], segments=40)
    short = footprint(cable, (0, 0, 0), -100.0, FootprintLimits(800.0, 1e5, 1e4), headings=4, directions=40)
    assert short.points[0].length == pytest.approx(130.0, rel=1e-6)
    assert short.points[0].vertical_pull > 0.0
    weak = footprint(cable, (0, 0, 0), -100.0, FootprintLimits(800.0, 900.0, 1e4), headings=4, directions=40)
    assert np.all(weak.radius < short.radius)
    assert all(point.tension <= 900.0 * (1.0 + 1e-6) for point in weak.points)


def test_a_current_shifts_the_footprint_downstream():
    cable = static_cable([SECTION], segments=40)
    area = footprint(
        cable, (0, 0, 0), -100.0, FootprintLimits(800.0, 1e5, 1e4), Current((0.3, 0.0)), headings=4, directions=60
    )
    downstream, across, upstream, other_side = area.radius
    assert downstream > across > 0.0
    assert downstream > upstream
    assert across == pytest.approx(other_side, rel=1e-6)
