import dataclasses
import math

import pytest
from cable_sim_node.errors import StaticsError
from cable_sim_node.parameters import CableParameters, CableSimParameters
from heave_statics.reports.laying import laying_report
from scipy.integrate import solve_ivp

PLANT = CableSimParameters(cable=CableParameters(axial_stiffness=1e12, tangential_drag=0.0))
WEIGHT = PLANT.cable.weight_in_fluid(1025.0)


@pytest.mark.parametrize("height", [0.0, 20.0])
def test_without_a_current_the_cable_is_zajacs_straight_line(height):
    (laid,) = laying_report(PLANT, 280.0, [1.5], boom_tip_height=height).rows
    angle = laid.critical_angle
    # normal drag carries the weight across the cable (Zajac)
    assert WEIGHT * math.cos(angle) == pytest.approx(0.5 * 1025.0 * 1.2 * 0.047 * (1.5 * math.sin(angle)) ** 2)
    assert laid.laying.departure_angle == pytest.approx(angle, rel=1e-4)
    assert laid.laying.suspended_length == pytest.approx((280.0 + height) / math.sin(angle), rel=1e-4)
    assert laid.behind == pytest.approx((280.0 + height) / math.tan(angle), rel=1e-4)
    # without tangential drag the tension is the weight of the depth
    assert laid.laying.tension == pytest.approx(WEIGHT * (280.0 + height), rel=1e-4)


def test_a_cable_that_lands_with_tension_follows_zajacs_equation():
    # Zajac 1957: T da/ds = w cos a - D (V sin a)^2, dT/ds = w sin a, from the bottom, where the cable lies flat: a = 0
    depth, speed, bottom_tension = 280.0, 1.5, 2000.0
    drag = 0.5 * 1025.0 * 1.2 * 0.047

    def slope(s, state):
        _, _, angle, tension = state
        across = WEIGHT * math.cos(angle) - drag * (speed * math.sin(angle)) ** 2
        return [math.cos(angle), math.sin(angle), across / tension, WEIGHT * math.sin(angle)]

    def surface(s, state):
        return state[1] - depth

    surface.terminal = True
    answer = solve_ivp(slope, (0.0, 5000.0), [0.0, 0.0, 0.0, bottom_tension], events=surface, rtol=1e-10, atol=1e-8)
    (laid,) = laying_report(PLANT, depth, [speed], bottom_tension=bottom_tension).rows
    assert laid.behind == pytest.approx(answer.y[0, -1], rel=1e-4)
    assert laid.laying.suspended_length == pytest.approx(answer.t[-1], rel=1e-4)
    assert laid.laying.departure_angle == pytest.approx(answer.y[2, -1], rel=1e-4)
    assert laid.laying.tension == pytest.approx(bottom_tension + WEIGHT * depth, rel=1e-6)


def test_a_cable_that_lands_with_a_trace_of_tension_is_laid_as_one_without():
    free, trace = (laying_report(PLANT, 280.0, [1.5], bottom_tension=t).rows[0] for t in (0.0, 5.0))
    assert trace.behind == pytest.approx(free.behind, abs=1.0)
    assert trace.laying.departure_angle == pytest.approx(free.laying.departure_angle, rel=1e-4)


@pytest.mark.parametrize("degrees", [0.0, 130.0])
def test_a_current_from_starboard_carries_the_touchdown_to_port(degrees):
    course = math.radians(degrees)
    to_port = (-0.3 * math.sin(course), 0.3 * math.cos(course))
    (laid,) = laying_report(dataclasses.replace(PLANT, current=to_port), 280.0, [1.0], course=course).rows
    (still,) = laying_report(PLANT, 280.0, [1.0], course=course).rows
    assert laid.sideways > 10.0
    assert still.sideways == pytest.approx(0.0, abs=1e-6)


def test_table_and_values_name_every_speed():
    report = laying_report(PLANT, 280.0, [0.5, 1.0])
    assert [laid["speed_mps"] for laid in report.values()["lays"]] == [0.5, 1.0]
    assert len(report.table().splitlines()) == 3


def test_on_a_slope_the_payout_is_what_covers_it():
    """Zajac: V cos((a + b)/2)/cos((a - b)/2); steeper than the cable hangs: refused."""
    (up,), (flat,), (down,) = (laying_report(PLANT, 280.0, [1.5], rise=rise).rows for rise in (0.1, 0.0, -0.1))
    rise = math.atan(0.1)
    assert up.payout == pytest.approx(
        1.5 * math.cos(0.5 * (up.critical_angle + rise)) / math.cos(0.5 * (up.critical_angle - rise))
    )
    assert flat.payout == pytest.approx(1.5)
    assert up.payout < flat.payout < down.payout
    (given,) = laying_report(PLANT, 280.0, [1.5], rise=2.0, payout_speed=1.4).rows
    assert given.payout == 1.4
    with pytest.raises(StaticsError, match=r"at 1\.5 m/s: it would span the foot of the slope; lay more slowly"):
        laying_report(PLANT, 280.0, [1.5], rise=2.0)


def test_what_cannot_be_laid_is_refused():
    with pytest.raises(StaticsError, match="above 0"):
        laying_report(PLANT, 280.0, [0.0])
    with pytest.raises(StaticsError, match="sinks"):
        laying_report(dataclasses.replace(PLANT, cable=CableParameters(mass_per_length=1.0)), 280.0, [1.0])
