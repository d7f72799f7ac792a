"""The unit's added mass, drag and buoyancy where they depend on its motion and its place, by hand calculation."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.line.forces.body import entering
from cable_sim_node.parameters import CableParameters, CableSimParameters, SeabedParameters, SolverParameters
from cable_sim_node.unit_parameters import BoxParameters, OscillationParameters, UnitParameters
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.numerics.kinematics import PointMotion

from tests.validation.peers.driven_run import first_harmonic, ramped_sine

DENSITY, TICK = 1025.0, 0.05
STIFF = CableParameters(diameter=0.004, mass_per_length=0.05, axial_stiffness=2e10, tangential_drag=0.0)
"""A cable so light and stiff that the unit moves as the boom tip does, and the top tension is the unit's."""


def plant_of(unit, *, length=50.0, tip=0.0, cable=STIFF, seabed=0.0, step=0.05):
    plant = CableDynamics(
        CableSimParameters(
            length=length,
            segments=4,
            cable=cable,
            unit=unit,
            seabed=SeabedParameters(depth=seabed),
            solver=SolverParameters(time_step=step),
        )
    )
    plant.start_at_equilibrium([0.0, 0.0, tip])
    return plant


def driven(plant, amplitude, omega, *, tip=0.0, seconds=400.0, window=60.0):
    """Return the top tension's parts in phase with the boom tip and with its speed [N], at the end of a run."""
    motion = ramped_sine((0.0, 0.0, amplitude), omega, 20.0)
    count, first = round(seconds / TICK), round((seconds - window) / TICK)
    height, times, tensions = np.array([0.0, 0.0, tip]), [], []

    def at(t):
        moved = motion(t)
        return PointMotion(t, moved.position + height, moved.velocity, moved.acceleration)

    start = at(0.0)
    for k in range(1, count + 1):
        end = at(k * TICK)
        plant.advance(TICK, start, end, 0.0, 0.0, 0.0, 0.0)
        start = end
        if k > first:
            times.append(end.time)
            tensions.append(plant.top_tension)
    _, size, phase = first_harmonic(np.array(times), np.array(tensions), omega)
    return size * math.cos(phase), size * math.sin(phase)


@pytest.mark.parametrize("amplitude", [0.5, 1.0])
def test_added_mass_and_drag_are_those_of_the_table_at_the_kc_of_the_motion(amplitude):
    """KC = 2 pi a/D. In phase the tension is -(m + A) w^2 a, with the speed 8/(3 pi) (1/2) rho C_D S (w a)^2."""
    width, omega, area = 4.0, 0.8, 9.0
    table = OscillationParameters(
        kc=(0.5, 2.5), added_mass=(10e3, 20e3), drag_coefficient=(8.0, 4.0), width=width, memory=60.0
    )
    unit = UnitParameters(mass=5e4, volume=1.0, drag_area=(area,) * 3, oscillation=table)
    in_phase, with_speed = driven(plant_of(unit), amplitude, omega)
    share = (2.0 * math.pi * amplitude / width - 0.5) / 2.0
    added, drag = 10e3 + share * 10e3, 0.5 * DENSITY * area * (8.0 - 4.0 * share)
    assert -in_phase / (omega**2 * amplitude) - 5e4 == pytest.approx(added, rel=0.01)
    assert with_speed / (8.0 / (3.0 * math.pi) * (omega * amplitude) ** 2) == pytest.approx(drag, rel=0.01)


def test_a_unit_that_sinks_steadily_has_the_drag_of_the_end_of_the_table():
    """Weight W in water of unit and cable; steady sinking at v: T = W - (1/2) rho C_D S v^2."""
    table = OscillationParameters(kc=(0.0, 10.0), added_mass=(1e3, 1e3), drag_coefficient=(9.0, 1.5), width=2.0)
    plant = plant_of(UnitParameters(mass=5e3, volume=0.5, drag_area=(4.0,) * 3, oscillation=table))
    weight = plant.top_tension
    still = PointMotion()
    for k in range(1200):
        payout = max(k - 20, 0) * TICK
        rate = float(k >= 20)
        plant.advance(TICK, still, still, payout, rate, max(k - 19, 0) * TICK, float(k >= 19))
    paid_out = 1181 * TICK * STIFF.weight_in_fluid(DENSITY)
    assert plant.top_tension == pytest.approx(weight + paid_out - 0.5 * DENSITY * 1.5 * 4.0, rel=0.005)


BOX = BoxParameters(length=3.0, breadth=3.0, height=2.0, slamming=5.0)


@pytest.mark.parametrize("height", [3.0, -0.5, -1.5, -4.0])
def test_a_unit_half_in_water_has_half_of_its_buoyancy(height):
    """Its weight in air less that of the water that the wet share of its box displaces."""
    unit = UnitParameters(mass=1e4, volume=4.0, box=BOX)
    weight = 1e4 * STANDARD_GRAVITY + 50.0 * STIFF.weight_in_fluid(DENSITY)
    plant = plant_of(unit, tip=50.0 + height)
    wet = min(max(-plant.unit_position[2] / 2.0, 0.0), 1.0)
    assert plant.top_tension == pytest.approx(weight - wet * DENSITY * 4.0 * STANDARD_GRAVITY, rel=1e-3)
    rests = PointMotion(0.0, np.array([0.0, 0.0, 50.0 + height]))
    for _ in range(100):
        plant.advance(TICK, rests, rests, 0.0, 0.0, 0.0, 0.0)
    assert plant.unit_velocity[2] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("height", "added", "end"), [(2.0, 12e3, 12e3 / (0.5 * DENSITY * 5.0 * 9.0)), (0.5, 60e3, 0.5)]
)
def test_a_unit_dropped_into_the_water_is_slowed_by_slam_and_the_added_mass_that_it_gains(height, added, end):
    """(m + A h/e) h'' = m g - c h'^2 until h = e, c = (1/2) rho C_s A_p; without buoyancy and drag.

    So h'^2 = m g/c + (2 g above - m g/c) (m/(m + A))^(2 c e/A). A high box has all of its added mass at e = A/c; then
    that is von Karman's ((m + c h) h')' = m g: no momentum is lost. A low one has it when its top is under, at e.
    """
    mass, above = 1e4, 2.0
    box = replace(BOX, height=height)
    unit = UnitParameters(mass=mass, volume=0.0, added_mass=(added,) * 3, drag_coefficient=(0.0,) * 3, box=box)
    plant = plant_of(unit, tip=50.0 + above, step=0.005)
    rests = PointMotion(0.0, np.array([0.0, 0.0, 50.0 + above]))
    before = after = (above, 0.0)
    payout = 0.0
    while after[0] > -end:  # the cable is paid out faster than the unit falls, and is slack
        plant.advance(0.01, rests, rests, payout, 10.0 * float(payout > 0.0), payout + 0.1, 10.0)
        payout += 0.1
        before, after = after, (float(plant.unit_position[2]), float(plant.unit_velocity[2]))
    speed = np.interp(end, [-before[0], -after[0]], [-before[1], -after[1]])
    slam, falls = 0.5 * DENSITY * 5.0 * 9.0, 2.0 * STANDARD_GRAVITY * above
    steady = mass * STANDARD_GRAVITY / slam
    square = steady + (falls - steady) * (mass / (mass + added)) ** (2.0 * slam * end / added)
    assert speed == pytest.approx(math.sqrt(square), rel=0.01)


def lowered_at(speed, box, added, *, until):
    """Lower a unit of 10 t at `speed` by a stiff rope; return heights of its underside and how much less it pulls."""
    cable = CableParameters(
        diameter=0.004, mass_per_length=0.05, axial_stiffness=2e8, internal_damping=1.2e7, tangential_drag=0.0
    )
    unit = UnitParameters(mass=1e4, volume=0.0, added_mass=(added,) * 3, drag_coefficient=(0.0,) * 3, box=box)
    plant = plant_of(unit, length=20.0, tip=22.0, cable=cable, step=0.01)
    rests = PointMotion(0.0, np.array([0.0, 0.0, 22.0]))
    payout, rate, heights, lost = 0.0, 0.0, [], []
    while plant.unit_position[2] > until:
        faster = min(rate + 1.0 * TICK, speed)
        further = payout + 0.5 * (rate + faster) * TICK
        plant.advance(TICK, rests, rests, payout, rate, further, faster)
        payout, rate = further, faster
        if rate == speed:
            heights.append(plant.unit_position[2])
            lost.append(1e4 * STANDARD_GRAVITY - plant.top_tension)
    return np.array(heights), np.array(lost)


@pytest.mark.parametrize(
    ("slamming", "height", "added", "end"),
    [
        (5.0, 2.0, 12e3, 12e3 / (0.5 * DENSITY * 5.0 * 9.0)),  # all of its added mass after 0.52 m
        (5.0, 0.5, 24e3, 0.5),  # its top is under before that
        (1.0, 2.0, 12e3, 2.0),
    ],
)
def test_a_unit_lowered_into_the_water_is_slammed_by_half_rho_cs_a_v2_while_it_enters(slamming, height, added, end):
    """Lowered at v by a stiff rope: T = m g - (1/2) rho C_s A_p v^2 until its top is under or its added mass whole."""
    box = replace(BOX, height=height, slamming=slamming)
    heights, lost = lowered_at(1.0, box, added, until=-3.2)
    slam = 0.5 * DENSITY * slamming * 9.0
    assert lost[(heights > 0.05) & (heights < 0.5)] == pytest.approx(0.0, abs=100.0)
    assert np.mean(lost[(heights < -0.3) & (heights > 0.05 - end)]) == pytest.approx(slam, rel=0.01)
    assert lost[heights < -end - 0.7] == pytest.approx(0.0, abs=0.01 * slam)


@pytest.mark.parametrize("sunk", [0.01, 0.1, 0.3])
def test_a_plate_that_is_lower_than_a_step_is_deep_is_slammed_for_as_long_as_it_enters(sunk):
    """5 cm high: the steps' shares times their lengths are 5 cm, wherever they fall."""
    for first in (-0.5, -0.47, -0.4321):
        shares = [entering.py_func(first + k * sunk, sunk, 0.05) for k in range(round(1.0 / sunk))]
        assert sum(shares) * sunk == pytest.approx(0.05)
    assert [entering.py_func(depth, 0.0, 0.05) for depth in (-0.01, 0.02, 0.06)] == [0.0, 1.0, 0.0]
