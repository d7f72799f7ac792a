import dataclasses
import math

import pytest
from cable_sim_node.errors import StaticsError
from cable_sim_node.parameters import CableParameters, CableSimParameters
from heave_statics.reports.hanging import hanging_report
from heave_statics.reports.towing import towing_report

PLANT = CableSimParameters(length=200.0)


def test_a_ship_at_rest_has_the_unit_hanging_below_it():
    (tow,) = towing_report(PLANT, [0.0], boom_tip=(1.0, 2.0, 3.0)).rows
    hanging = hanging_report(PLANT, (1.0, 2.0, 3.0))
    assert (tow.depth, tow.layback, tow.sideways) == pytest.approx((-hanging.unit[2], 0.0, 0.0), abs=1e-9)
    assert tow.shape.top_tension == pytest.approx(hanging.largest_tension)


def test_a_heavy_unit_on_a_thin_cable_tows_at_the_angle_of_its_drag_to_its_weight():
    # by hand: the cable neither weighs nor drags, so it is straight along the sum of the unit's drag and weight
    cable = CableParameters(diameter=1e-4, mass_per_length=1e-4, normal_drag=0.0, tangential_drag=0.0)
    plant = dataclasses.replace(PLANT, cable=cable)
    (tow,) = towing_report(plant, [2.0]).rows
    drag, weight = 0.5 * 1025.0 * 1.5 * 0.5 * 2.0**2, (3000.0 - 1025.0 * 0.354) * 9.80665
    assert tow.layback / tow.depth == pytest.approx(drag / weight, rel=1e-3)
    assert math.tan(tow.shape.top_angle) == pytest.approx(drag / weight, rel=1e-3)


@pytest.mark.parametrize("degrees", [0.0, 90.0, 215.0])
def test_towing_is_hanging_in_the_opposite_current_whatever_the_course(degrees):
    course, speed = math.radians(degrees), 1.2
    (tow,) = towing_report(PLANT, [speed], course=course).rows
    flow = (-speed * math.cos(course), -speed * math.sin(course))
    hanging = hanging_report(dataclasses.replace(PLANT, current=flow))
    assert tow.depth == pytest.approx(-hanging.unit[2], abs=1e-6)
    assert tow.layback == pytest.approx(-(hanging.unit[0] * math.cos(course) + hanging.unit[1] * math.sin(course)))
    assert math.hypot(tow.layback, tow.sideways) == pytest.approx(math.hypot(*hanging.unit[:2]))


def test_a_current_from_starboard_carries_the_unit_to_port():
    # course +x, so port is +y
    (tow,) = towing_report(dataclasses.replace(PLANT, current=(0.0, 0.5)), [1.0]).rows
    assert tow.sideways > 1.0
    (tow,) = towing_report(dataclasses.replace(PLANT, current=(0.5, 0.0)), [1.0], course=math.radians(90.0)).rows
    assert tow.sideways < -1.0


def test_a_faster_ship_has_its_unit_higher_and_farther_behind():
    report = towing_report(PLANT, [0.5, 1.0, 1.5, 2.0])
    depths, laybacks = [tow.depth for tow in report.rows], [tow.layback for tow in report.rows]
    assert depths == sorted(depths, reverse=True)
    assert laybacks == sorted(laybacks)
    assert [tow["speed_mps"] for tow in report.values()["tows"]] == [0.5, 1.0, 1.5, 2.0]
    assert len(report.table().splitlines()) == 5


@pytest.mark.parametrize("speed", [-1.0, math.nan, math.inf])
def test_a_speed_that_cannot_be_is_refused(speed):
    with pytest.raises(StaticsError, match="towing speed"):
        towing_report(PLANT, [speed])
