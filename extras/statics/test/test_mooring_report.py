import dataclasses
import math

import pytest
from cable_sim_node.errors import StaticsError
from cable_sim_node.parameters import CableParameters, CableSimParameters
from heave_statics.reports.mooring import mooring_report

PLANT = CableSimParameters(length=100.0)
WEIGHT = PLANT.cable.weight_in_fluid(1025.0)


def test_the_pull_at_an_offset_brings_the_ship_to_that_offset():
    # two solvers: both ends held, and one end pulled
    held = mooring_report(PLANT, 90.0, offsets=[20.0, 35.0, 42.0]).rows
    pulled = mooring_report(PLANT, 90.0, pulls=[cable.pull for cable in held]).rows
    assert [cable.offset for cable in pulled] == pytest.approx([20.0, 35.0, 42.0], abs=1e-5)
    assert [c.shape.top_tension for c in pulled] == pytest.approx([c.shape.top_tension for c in held], rel=1e-6)


def test_a_moored_cable_is_the_catenary():
    # inextensible catenary of parameter a = H/w, tangent to the bottom where L^2 = h^2 + 2 h a: x = a asinh(L/a)
    height, length = 80.0, 100.0
    a = (length**2 - height**2) / (2.0 * height)
    plant = dataclasses.replace(PLANT, cable=CableParameters(axial_stiffness=1e12))
    (cable,) = mooring_report(plant, height, offsets=[a * math.asinh(length / a)]).rows
    weight = plant.cable.weight_in_fluid(1025.0)
    assert cable.pull == pytest.approx(weight * a, rel=1e-6)
    assert math.degrees(cable.anchor_angle) == pytest.approx(90.0, abs=1e-3)
    assert cable.shape.top_tension == pytest.approx(weight * (a + height), rel=1e-6)  # T = w (a + y)
    assert cable.below == pytest.approx(0.0, abs=1e-4)


def test_a_cable_that_would_lie_on_the_bottom_is_said_to():
    report = mooring_report(PLANT, 90.0, offsets=[0.0, 42.0])
    assert report.rows[0].below > 1.0
    assert report.table().count("is not modelled") == 1
    assert "offset 0.00 m: the cable sags" in report.table()


def test_the_direction_turns_the_whole_picture():
    east = mooring_report(PLANT, 90.0, pulls=[500.0]).rows[0]
    north = mooring_report(PLANT, 90.0, pulls=[500.0], direction=math.radians(90.0)).rows[0]
    assert north.offset == pytest.approx(east.offset, rel=1e-9)
    assert north.shape.positions[-1, 1] == pytest.approx(east.shape.positions[-1, 0], rel=1e-9)


def test_the_height_of_the_boom_tip_counts():
    plant = dataclasses.replace(PLANT, surface=False)
    low, high = (
        mooring_report(plant, 90.0 - height, offsets=[30.0], boom_tip_height=height).rows[0] for height in (0.0, 5.0)
    )
    assert high.shape.top_tension == pytest.approx(low.shape.top_tension, rel=1e-9)


def test_a_current_leans_on_the_cable():
    still = mooring_report(PLANT, 90.0, offsets=[30.0]).rows[0]
    flow = mooring_report(dataclasses.replace(PLANT, current=(0.5, 0.0)), 90.0, offsets=[30.0]).rows[0]
    assert flow.pull != pytest.approx(still.pull, rel=0.05)


def test_the_values_have_their_units():
    (cable,) = mooring_report(PLANT, 90.0, offsets=[30.0]).values()["cables"]
    assert cable["offset_m"] == pytest.approx(30.0, abs=1e-6)
    assert cable["top_tension_n"] - cable["anchor_tension_n"] < WEIGHT * 100.0


def test_a_pull_that_is_no_number_is_refused():
    with pytest.raises(StaticsError, match="finite"):
        mooring_report(PLANT, 90.0, pulls=[math.nan])
