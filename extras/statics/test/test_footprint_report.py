import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.errors import NoEquilibriumError, StaticsError
from cable_sim_node.parameters import CableParameters, CableSimParameters
from heave_statics.reports.footprint import footprint_report

PLANT = CableSimParameters(length=300.0, cable=CableParameters(axial_stiffness=1e12))
WEIGHT = PLANT.cable.weight_in_fluid(1025.0)


def test_in_still_water_the_reach_is_that_of_the_flattest_catenary():
    # thrust H lays the cable along the bottom: a = H/w, L = sqrt(h^2 + 2 h a), x = a asinh(L/a)
    height, thrust = 100.0, 2000.0
    a = thrust / WEIGHT
    length = math.sqrt(height**2 + 2.0 * height * a)
    report = footprint_report(PLANT, height, thrust)
    assert length < PLANT.length
    # a polygon of 120 corners lies within (pi/120)^2/2 of its circle
    assert report.area.radius == pytest.approx(a * math.asinh(length / a), rel=4e-4)
    assert max(point.length for point in report.area.points) == pytest.approx(length, rel=1e-6)


def test_the_height_of_the_boom_tip_counts():
    low, high = (footprint_report(PLANT, 100.0 - h, 2000.0, boom_tip_height=h) for h in (0.0, 10.0))
    assert high.area.radius == pytest.approx(low.area.radius, rel=1e-9)


def test_the_limit_of_tension_makes_the_reach_smaller():
    free = footprint_report(PLANT, 100.0, 2000.0)
    tension = max(point.tension for point in free.area.points)
    limited = footprint_report(PLANT, 100.0, 2000.0, tension_limit=0.8 * tension)
    assert np.all(limited.area.radius < free.area.radius)
    assert max(point.tension for point in limited.area.points) <= 0.8 * tension * (1.0 + 1e-6)


def test_the_pull_that_lifts_the_unit_is_its_weight_in_water_unless_said():
    report = footprint_report(PLANT, 280.0, 2000.0)
    assert report.limits.vertical_pull == pytest.approx((3000.0 - 1025.0 * 0.354) * 9.80665)
    with pytest.raises(NoEquilibriumError, match="300 m of cable"):
        footprint_report(dataclasses.replace(PLANT, length=300.0), 305.0, 2000.0)


def test_table_and_values_name_every_heading():
    report = footprint_report(PLANT, 100.0, 2000.0)
    values = report.values()
    assert [entry["heading_deg"] for entry in values["headings"]] == pytest.approx(15.0 * np.arange(24))
    assert [entry["reach_m"] for entry in values["headings"]] == pytest.approx(report.area.radius)
    assert "heading deg" in report.table()
    assert f"{report.area.radius[0]:.2f}" in report.table()


def test_a_thrust_that_cannot_be_is_refused():
    with pytest.raises(StaticsError, match="must be positive"):
        footprint_report(PLANT, 100.0, 0.0)
