"""The reverse problem of thesis 6.4: the particulars of cable and unit from the a and b of Eqs. 6.2 and 6.3.

The thesis states it and prints no equation. With k = EA/L a unit of effective mass M on a cable of mass m a metre has
a = (M + m L/3)/k by Rayleigh, and b = (C + c L/4)/k of Eq. 6.3, with rho C_D S/2 of the unit and (pi/2) rho C_tau d a
metre of cable: a share of the cable's drag of (s/L)^2, that works on s/L. Two numbers give two particulars, the other
ones given; none distinguishes a system from one of twice all masses, drags and stiffness. Only a tension does.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.vertical.axial import simulate_axial
from winch_controller_node.model.models import PlantBelief

from tests.validation.test_thesis_histories import SEA, STEP, boom_tip, identified

CABLE, LENGTH, RHO = SEA.cable, SEA.length, SEA.water_density
STIFFNESS = CABLE.axial_stiffness / LENGTH


def effective_mass(a):
    """Return the mass of the unit with its water [kg] that gives `a` [s^2]."""
    return a * STIFFNESS - CABLE.mass_per_length * LENGTH / 3.0


def drag_area(b):
    """Return the drag coefficient of the unit times its area [m^2] that gives `b` of Eq. 6.3 [s^2/m]."""
    cable = 0.5 * math.pi * RHO * CABLE.tangential_drag * CABLE.diameter * LENGTH
    return (b * STIFFNESS - cable / 4.0) / (0.5 * RHO)


@pytest.mark.parametrize("a", [7.339769, 7.326944])
def test_the_printed_a_gives_the_printed_mass(a):
    """Figs 6.12, 6.13: 126.5 and 126.2 t for the effective mass of 125 t that 6.2.6 prints."""
    assert effective_mass(a) == pytest.approx(125e3, rel=0.013)


def test_the_printed_b_does_not_give_the_printed_drag():
    """Fig 6.13 prints b = 0.0719, which is C_D S = 1.63 m^2, where 6.2.6 prints 1 m^2 and C_D = 1."""
    assert drag_area(0.0719096) == pytest.approx(1.63, abs=0.01)


def test_the_identified_coefficients_give_the_particulars_back():
    found = [identified(seed, "quadratic") for seed in (1, 2)]
    mass, area = (
        float(np.mean([of(f) for f in found])) for of in (lambda f: effective_mass(f.a), lambda f: drag_area(f.b))
    )
    assert mass == pytest.approx(SEA.unit.mass + SEA.unit.added_mass[2], rel=0.005)
    assert area == pytest.approx(SEA.unit.drag_coefficient[2] * SEA.unit.drag_area[2], rel=0.05)


def test_only_a_tension_distinguishes_a_system_from_one_of_twice_everything():
    """Masses, drags, weights and EA twice as large: the same motion, twice the tension."""
    unit, cable = SEA.unit, SEA.cable
    double = math.sqrt(2.0)
    plants = (
        PlantBelief(cable, unit, RHO, SEA.gravity),
        PlantBelief(
            dataclasses.replace(
                cable,
                diameter=2.0 * cable.diameter,
                displaced_diameter=double * (cable.displaced_diameter or cable.diameter),
                mass_per_length=2.0 * cable.mass_per_length,
                axial_stiffness=2.0 * cable.axial_stiffness,
            ),
            dataclasses.replace(
                unit,
                mass=2.0 * unit.mass,
                volume=2.0 * unit.volume,
                added_mass=tuple(2.0 * m for m in unit.added_mass),
                drag_area=tuple(2.0 * s for s in unit.drag_area),
            ),
            RHO,
            SEA.gravity,
        ),
    )
    tip = boom_tip(1)[1][:2000]
    one, other = (
        simulate_axial(plant.line(LENGTH), LENGTH, tip, STEP, segments=20, largest_step=0.05, allow_slack=False)
        for plant in plants
    )
    assert other.unit_heave == pytest.approx(one.unit_heave, abs=1e-9)
    assert plants[1].line(LENGTH).static_top_tension(LENGTH) == pytest.approx(
        2.0 * plants[0].line(LENGTH).static_top_tension(LENGTH), rel=1e-12
    )
    assert other.top_tension == pytest.approx(2.0 * one.top_tension, rel=1e-6, abs=1e-3)
