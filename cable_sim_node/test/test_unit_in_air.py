"""A unit with a box hangs in air, half wet or under water: statics, modes and the run start from one share of it."""

import dataclasses
import math

import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters
from cable_sim_node.reports.modes import modes_report
from cable_sim_node.unit_parameters import BoxParameters, UnitParameters
from cable_sim_node.vertical.axial_line import axial_line
from heave_statics.reports.hanging import hanging_report
from heave_statics.reports.towing import towing_report

GRAVITY, DENSITY = 9.80665, 1025.0
MASS, VOLUME, HEIGHT, TIP, STIFFNESS = 40e3, 8.0, 4.0, 25.0, 9.3e7
BOX = BoxParameters(length=5.0, breadth=4.0, height=HEIGHT, slamming=0.0)
UNIT = UnitParameters(mass=MASS, volume=VOLUME, added_mass=(2e4, 2e4, 3e4), box=BOX)
LIGHT = CableParameters(diameter=0.001, mass_per_length=1e-3, axial_stiffness=STIFFNESS)
"""Its weight, 0.25 N of 25 m, is left out by hand."""


def hung(length, **given):
    return dataclasses.replace(CableSimParameters(length=length, segments=4, cable=LIGHT, unit=UNIT), **given)


def by_hand(length):
    """Return the depth of the underside [m], the wet share and the pull [N]: z = -tip + L (1 + T/EA), T = M g - s B."""
    weight, buoyancy = MASS * GRAVITY, DENSITY * VOLUME * GRAVITY
    in_air, in_water = (length * (1.0 + pull / STIFFNESS) - TIP for pull in (weight, weight - buoyancy))
    half_wet = in_air / (1.0 + length * buoyancy / (STIFFNESS * HEIGHT))
    depth = in_air if in_air <= 0.0 else in_water if in_water >= HEIGHT else half_wet
    share = min(max(depth / HEIGHT, 0.0), 1.0)
    return depth, share, weight - share * buoyancy


PLACES = pytest.mark.parametrize("length", [17.0, 25.0, 27.0, 28.9, 40.0])


@PLACES
def test_statics_weighs_what_is_wet(length):
    depth, share, pull = by_hand(length)
    report = hanging_report(hung(length), (0.0, 0.0, TIP))
    assert report.largest_tension == pytest.approx(pull, rel=1e-5)
    assert -report.unit[2] == pytest.approx(depth, abs=1e-4)
    assert report.values()["unit_wet_percent"] == pytest.approx(100.0 * share, abs=1e-2)
    assert report.unit_weight == pytest.approx(pull, rel=1e-5)
    where = "in air" if share == 0.0 else "in water" if share == 1.0 else f"{100.0 * share:.1f} % under water"
    assert f"weight of the unit {where} [kN]" in report.table()


@PLACES
def test_a_run_starts_at_the_same_tension(length):
    plant = CableDynamics(hung(length))
    plant.start_at_equilibrium([0.0, 0.0, TIP])
    assert plant.top_tension == pytest.approx(hanging_report(hung(length), (0.0, 0.0, TIP)).largest_tension, rel=1e-6)


@PLACES
def test_a_ship_that_lies_still_tows_the_same(length):
    (tow,) = towing_report(hung(length), [0.0], boom_tip=(0.0, 0.0, TIP)).rows
    assert tow.shape.top_tension == pytest.approx(by_hand(length)[2], rel=1e-5)


@PLACES
def test_modes_swing_the_added_mass_of_what_is_wet(length):
    """T = 2 pi sqrt((M + s A33) L/EA)."""
    share = by_hand(length)[1]
    period = 2.0 * math.pi * math.sqrt((MASS + share * 3e4) * length / STIFFNESS)
    report = modes_report(hung(length), sea_period=8.0, boom_tip=(0.0, 0.0, TIP))
    assert report.heave[0].period == pytest.approx(period, rel=1e-4)
    assert report.natural_periods[-1] == pytest.approx(period, rel=1e-4)
    assert report.natural_periods[0] == pytest.approx(
        2.0 * math.pi * math.sqrt(MASS * report.resonances.lengths[0] / STIFFNESS), rel=1e-4
    )


def test_without_a_box_or_a_surface_the_water_is_everywhere():
    everywhere = hung(17.0, surface=False)
    bare = hung(17.0, unit=dataclasses.replace(UNIT, box=BoxParameters()))
    for parameters in (everywhere, bare):
        assert hanging_report(parameters, (0.0, 0.0, TIP)).largest_tension == pytest.approx(311.85e3, abs=10.0)
        assert axial_line(parameters, TIP).unit.weight == pytest.approx(311.85e3, abs=10.0)
