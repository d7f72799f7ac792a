"""Laying a cable: on an irregular seabed, the situations A to D of Pinto's figure 1; on a change of course.

The figure is a sketch: neither it nor the text gives a depth, a speed, an angle, a height or a payout, so that no
number of it can be reproduced. What the text says of each situation follows from exact kinematics instead: in still
water the cable hangs as a straight line at the critical angle a and moves along with the ship; its lower end is where
that line meets the bottom; what has been laid is as long as the bottom. The cable is the light-armoured one of table 1.
"""

import math

import numpy as np
import pytest
from cable_sim_node.errors import StaticsError
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import (
    CableParameters,
    CableSimParameters,
    SeabedParameters,
    SeabedProfileParameters,
    SolverParameters,
    UnitParameters,
)
from cable_sim_node.physics.seabed import Seabed
from heave_node.numerics.constants import SEAWATER_DENSITY
from heave_node.numerics.kinematics import PointMotion
from heave_statics.laying import covering_payout, critical_angle
from heave_statics.system import StaticSection
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from tests.validation.peers.driven_run import smooth_start

WEIGHT, DIAMETER = 10.96, 0.0264
LIGHT = CableParameters(
    diameter=DIAMETER,
    displaced_diameter=math.sqrt(4.0 * (1.64 - WEIGHT / 9.80665) / (math.pi * SEAWATER_DENSITY)),
    mass_per_length=1.64,
    axial_stiffness=1.5e7,
    normal_drag=2.12,
    tangential_drag=0.01,
)
SECTION = StaticSection(1.0, 1.5e7, WEIGHT, 0.5 * SEAWATER_DENSITY * 2.12 * DIAMETER, 0.0)
DEPTH, TICK, SPEED_UP = 20.0, 0.1, 20.0

# --- the rule of the text, in exact kinematics


@given(angle=st.floats(0.05, 1.5), rise=st.floats(-1.4, 1.4), speed=st.floats(0.1, 5.0))
def test_the_payout_that_covers_a_slope_is_what_is_laid_and_what_hangs_more(angle, rise, speed):
    """Two positions of the line z = -(x_ship - x) tan a and of the bottom z = -h + x tan b, 1 s apart."""
    if rise > angle - 1e-2:
        with pytest.raises(StaticsError, match="more slowly"):
            covering_payout(angle, max(rise, angle), speed)
        return

    def laid_and_hanging(ship):
        x = (ship * math.tan(angle) - 100.0) / (math.tan(angle) - math.tan(rise))
        return x / math.cos(rise) + (ship - x) / math.cos(angle)

    payout = covering_payout(angle, rise, speed)
    assert payout == pytest.approx(laid_and_hanging(speed) - laid_and_hanging(0.0), rel=1e-7)
    # A: flat, the ship's speed; B: down, more; C: up and less steep than the cable, less
    assert (payout - speed) * rise <= 1e-15


def test_the_ship_slows_down_where_the_bottom_is_steeper_than_the_cable_hangs():
    """D: at 1 m/s the cable hangs at 34 deg, and no payout covers a bottom of 45 deg; at 0.5 m/s it hangs at 60."""
    with pytest.raises(StaticsError, match=r"rises by 45\.0 deg and the cable hangs at 34\.2 deg at 1 m/s"):
        covering_payout(critical_angle(SECTION, 1.0), math.radians(45.0), 1.0)
    angle = critical_angle(SECTION, 0.5)
    assert math.degrees(angle) == pytest.approx(60.3, abs=0.1)
    assert 0.0 < covering_payout(angle, math.radians(45.0), 0.5) < 0.5


# --- the plant on such a bottom


class Lay:
    """A cable laid on hills along x with the plant's solver.

    The cable starts at rest, straight down to an anchor at x = 0; the ship reaches its speed within SPEED_UP.
    """

    def __init__(self, distance, height, speed):
        profile = SeabedProfileParameters(distance=distance, height=height)
        self.parameters = CableSimParameters(
            length=DEPTH + 1.0,
            segments=14,
            cable=LIGHT,
            unit=UnitParameters(mass=5000.0, volume=0.0, added_mass=(0.0,) * 3, drag_coefficient=(0.0,) * 3),
            seabed=SeabedParameters(depth=DEPTH, friction=0.8, stiffness=2e3, damping=200.0, profile=profile),
            solver=SolverParameters(time_step=TICK),
        )
        self.bottom = Seabed(self.parameters.seabed)
        self.speed, self.angle = speed, critical_angle(SECTION, speed)
        places = np.arange(-60.0, 600.0, 0.05)
        heights = np.array([self.bottom.height((x, 0.0)) for x in places])
        arc = np.append(0.0, np.cumsum(np.hypot(np.diff(places), np.diff(heights))))
        self.arc = lambda x: float(np.interp(x, places, arc))

    def ship(self, t):
        """Return the ship's way [m] and speed [m/s]."""
        way, rate = smooth_start(t, SPEED_UP)
        return self.speed * way, self.speed * rate

    def touchdown(self, ship):
        """Return where the straight line from the ship at x = `ship` meets the bottom."""
        return brentq(
            lambda x: (ship - x) * math.tan(self.angle) + self.bottom.height((x, 0.0)), ship - 4.0 * DEPTH, ship
        )

    def covering(self, ship):
        """Return the payout [m] that covers the bottom from x = 0 on; before, that of a taut line."""
        x = self.touchdown(ship)
        if x <= 0.0:
            return math.hypot(DEPTH, ship) - DEPTH
        return self.arc(x) - self.arc(0.0) + (ship - x) / math.cos(self.angle) - DEPTH

    def run(self, way, payout, track=lambda x: (x, 0.0), watch=None):
        """Lay until the ship has gone `way` [m] along its `track`, with the `payout` of its way; return the plant.

        `watch` is called with the plant and the way after each tick.
        """
        plant = CableDynamics(self.parameters)
        plant.start_at_equilibrium(np.zeros(3))

        def motion(t):
            x, v = self.ship(t)
            place = np.array([*track(x), 0.0])
            return PointMotion(t, place, v * (np.array([*track(x + 1e-4), 0.0]) - place) / 1e-4)

        def paid(t):
            out = [payout(self.ship(max(at, 0.0))[0]) for at in (t - 0.05, t, t + 0.05)]
            return out[1], (out[2] - out[0]) / 0.1 if t > 0.0 else 0.0

        t, ends = 0.0, (motion(0.0), paid(0.0))
        while self.ship(t)[0] < way:
            after = (motion(t + TICK), paid(t + TICK))
            plant.advance(TICK, ends[0], after[0], *ends[1], *after[1])
            t, ends = t + TICK, after
            if watch is not None:
                watch(plant, self.ship(t)[0])
        return plant

    def clearances(self, plant, start, end):
        """Return how high the cable is above the bottom [m] between two places."""
        x = plant.node_positions
        inside = (x[:, 0] > start) & (x[:, 0] < end)
        assert inside.sum() > 5
        return np.array([self.bottom.clearance(node) for node in x[inside]])


DOWN_AND_UP = ((60.0, 90.0, 120.0, 150.0), (0.0, -5.0, -5.0, 0.0))
"""Down by 5 m over 30 m, flat, up again: slopes of 0.25 at most, 14 degrees."""
STEP = ((60.0, 62.0, 64.0, 66.0), (0.0, 3.0, 7.0, 10.0))
"""Up by 10 m over 6 m: 66 degrees at most."""


@pytest.mark.slow
@pytest.mark.long
def test_the_right_payout_covers_a_valley_and_the_ships_speed_leaves_a_span():
    """B and C. With the payout of the kinematics the cable lies on the bottom all along, as long as the bottom is."""
    lay = Lay(*DOWN_AND_UP, 1.0)
    covered = lay.run(190.0, lay.covering)
    x = covered.node_positions
    chord = x[-1] - x[-8]
    assert math.atan2(chord[2], chord[0]) == pytest.approx(lay.angle, abs=0.01)
    assert np.abs(lay.clearances(covered, 50.0, 155.0)).max() < 0.1
    ends = [int(np.argmin(np.abs(x[:, 0] - place))) for place in (55.0, 155.0)]
    laid = float(np.diff(covered.material_coordinates[ends])[0])
    assert laid == pytest.approx(lay.arc(x[ends[1], 0]) - lay.arc(x[ends[0], 0]), abs=0.3)
    # the ship's speed is too little on the way down: the cable is drawn off the bottom there
    start = lay.covering(85.0) - 85.0
    level = lay.run(130.0, lambda ship: lay.covering(ship) if ship < 85.0 else ship + start)
    assert lay.clearances(level, 50.0, lay.touchdown(130.0) - 3.0).max() > 0.5


@pytest.mark.slow
@pytest.mark.long
def test_a_slope_steeper_than_the_cable_hangs_is_spanned_and_a_slower_ship_covers_it():
    """D. The straight line meets the crest first; what spans the foot is too short for it, whatever comes after."""
    fast = Lay(*STEP, 1.0)
    start = fast.covering(80.0) - 80.0  # the bottom is level before and after
    spanned = fast.run(110.0, lambda ship: fast.covering(ship) if ship < 80.0 else ship + start)
    assert fast.clearances(spanned, 50.0, 70.0).max() > 1.0
    slow = Lay(*STEP, 0.4)
    assert math.degrees(slow.angle) > 68.0
    covered = slow.run(90.0, slow.covering)
    assert slow.clearances(covered, 50.0, 70.0).max() < 0.1


def test_a_change_of_course_while_laying_cuts_the_corner_and_leaves_the_top_tension():
    """A quarter turn of 120 m at 2 m/s with the payout of the ship's way; by hand, without inertia and friction along.

    T_s = w z_s in any shape: the top carries w D throughout. The line's tangent leans inwards by b s at the arc s from
    the bottom, where lateral drag w s sin^2 a (cos a/R - b) turns it: b = sin^2 a cos a/(R (1 + sin^2 a)). So the cable
    lies (D cos a)^2/(2 R (1 + sin^2 a)) inside the ship's track. Then it is straight again, along the new course.
    """
    radius, start = 120.0, 120.0
    lay = Lay((60.0, 90.0), (0.0, 0.0), 2.0)
    arc = 0.5 * math.pi * radius

    def track(way):
        turned = min(max(way - start, 0.0), arc) / radius
        ahead, after = min(way, start), max(way - start - arc, 0.0)
        return ahead + radius * math.sin(turned), radius * (1.0 - math.cos(turned)) + after

    pulls = []

    def watch(plant, way):
        if start + 20.0 < way < start + arc:
            pulls.append(plant.top_tension)

    plant = lay.run(start + arc + 100.0, lay.covering, track, watch)
    assert np.mean(pulls) == pytest.approx(WEIGHT * DEPTH, rel=0.01)
    x, a = plant.node_positions, lay.angle
    from_centre = x[:, :2] - np.array([start, radius])
    angle = np.arctan2(from_centre[:, 0], -from_centre[:, 1])
    middle = (np.abs(x[:, 2] + DEPTH) < 0.1) & (angle > 0.7) & (angle < 1.1)
    cut = (DEPTH * math.cos(a)) ** 2 / (2.0 * radius * (1.0 + math.sin(a) ** 2))
    assert radius - np.linalg.norm(from_centre[middle], axis=1) == pytest.approx(cut, rel=0.01)
    chord = x[-1] - x[-20]
    assert math.atan2(chord[2], math.hypot(chord[0], chord[1])) == pytest.approx(a, abs=0.01)
    assert math.atan2(chord[1], chord[0]) == pytest.approx(0.5 * math.pi, abs=0.01)
