"""Cable above the water's surface weighs what it weighs in air, and has neither drag nor added mass there."""

import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import (
    CableParameters,
    CableSimParameters,
    CurrentProfileParameters,
    WaveKinematicsParameters,
)
from cable_sim_node.unit_parameters import UnitParameters
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.numerics.kinematics import PointMotion
from heave_statics.reports.hanging import hanging_report

DENSITY, LENGTH, TICK = 1025.0, 100.0, 0.05
THICK = CableParameters(diameter=0.1, mass_per_length=20.0, axial_stiffness=5e8)
UNIT = UnitParameters(mass=5e3, volume=0.5)
IN_AIR = 20.0 * STANDARD_GRAVITY
IN_WATER = (20.0 - DENSITY * math.pi / 4.0 * 0.01) * STANDARD_GRAVITY
UNIT_WEIGHT = (5e3 - DENSITY * 0.5) * STANDARD_GRAVITY


def hung(height, *, unit=UNIT, **given):
    plant = CableDynamics(CableSimParameters(length=LENGTH, segments=20, cable=THICK, unit=unit, **given))
    plant.start_at_equilibrium([0.0, 0.0, height])
    return plant


@pytest.mark.parametrize("height", [0.0, 3.0, 12.5, 60.0])
def test_the_top_bears_the_weight_in_air_of_what_is_above_water(height):
    """W + w_water (L - h) + w_air h, by hand; a stretch of 0.1 mm over a metre is left out."""
    by_hand = UNIT_WEIGHT + IN_WATER * (LENGTH - height) + IN_AIR * height
    assert hung(height).top_tension == pytest.approx(by_hand, rel=1e-4)


@pytest.mark.parametrize("height", [3.0, 12.5])
def test_heave_static_gives_the_same_tension(height):
    parameters = CableSimParameters(length=LENGTH, segments=20, cable=THICK, unit=UNIT)
    report = hanging_report(parameters, (0.0, 0.0, height))
    assert report.largest_tension == pytest.approx(hung(height).top_tension, rel=1e-6)


def test_a_line_with_a_part_in_air_stays_at_rest():
    plant = hung(12.5)
    start, rests = plant.unit_position, PointMotion(0.0, np.array([0.0, 0.0, 12.5]))
    for _ in range(200):
        plant.advance(TICK, rests, rests, 0.0, 0.0, 0.0, 0.0)
    assert plant.unit_position == pytest.approx(start, abs=1e-9)


def test_the_tension_rises_by_the_buoyancy_of_what_is_lifted_out():
    """Lifted slowly by 5 m, or hauled in by 5 m: (w_air - w_water) 5 m more, less what is hauled in."""
    raised, hauled = hung(10.0), hung(10.0)
    before, more = raised.top_tension, (IN_AIR - IN_WATER) * 5.0
    tip = PointMotion(0.0, np.array([0.0, 0.0, 10.0]))
    still, payout, last = tip, 0.0, 0.0
    for k in range(4000):
        s = min((k + 1) / 3000.0, 1.0)
        rise, rate = 5.0 * s**3 * (10.0 - 15.0 * s + 6.0 * s * s), 150.0 * s * s * (1.0 - s) ** 2 / 150.0
        after = PointMotion(0.0, np.array([0.0, 0.0, 10.0 + rise]), np.array([0.0, 0.0, rate]))
        raised.advance(TICK, tip, after, 0.0, 0.0, 0.0, 0.0)
        hauled.advance(TICK, still, still, payout, last, -rise, -rate)
        tip, payout, last = after, -rise, -rate
    assert raised.top_tension - before == pytest.approx(more, rel=2e-3)
    # what is hauled in hung in air, and as much comes out of the water: the wet part is shorter by it
    assert hauled.top_tension - before == pytest.approx(-5.0 * IN_WATER, rel=2e-3)


def test_a_current_pushes_only_what_is_below_the_surface():
    """By moments about the top: drag of the wet part (1/2) rho C_N d U^2 (L - h), and what hangs on it."""
    dry, wet = hung(50.0, current=(0.5, 0.0)), hung(50.0, current=(0.5, 0.0), surface=False)
    pull = 0.5 * DENSITY * 1.2 * 0.1 * 0.25
    unit = 0.5 * DENSITY * 1.5 * 0.5 * 0.25
    assert dry.top_force[0] == pytest.approx(pull * (LENGTH - 50.0) + unit, rel=2e-3)
    assert wet.top_force[0] == pytest.approx(pull * LENGTH + unit, rel=2e-3)


def test_current_and_wave_leave_a_dry_line_alone():
    """All of the cable in air, below it a unit that water does not act on: the line stays at rest."""
    current = CurrentProfileParameters(depth=(0.0, 10.0), velocity_x=(1.0, 0.0), velocity_y=(0.0, 0.0))
    wave = WaveKinematicsParameters("regular", amplitude=1.0, period=8.0)
    bare = UnitParameters(mass=5e3, volume=0.0, added_mass=(0.0,) * 3, drag_coefficient=(0.0,) * 3)
    plant = hung(LENGTH + 50.0, unit=bare, current_profile=current, wave=wave)
    rests, weight = PointMotion(0.0, np.array([0.0, 0.0, LENGTH + 50.0])), 5e3 * STANDARD_GRAVITY + IN_AIR * LENGTH
    for _ in range(100):
        plant.advance(TICK, rests, rests, 0.0, 0.0, 0.0, 0.0)
        assert plant.top_tension == pytest.approx(weight, rel=1e-6)


def test_where_there_is_no_surface_the_fluid_surrounds_everything():
    by_hand = UNIT_WEIGHT + IN_WATER * LENGTH
    assert hung(60.0, surface=False).top_tension == pytest.approx(by_hand, rel=1e-9)
