"""A unit whose added mass and drag depend on the amplitude of its motion, near resonance on its wire."""

import math

import numpy as np
import pytest
from cable_sim_node.parameters import CableParameters, CableSimParameters
from cable_sim_node.physics.hydrodynamics import box_added_mass
from cable_sim_node.unit_parameters import OscillationParameters, UnitParameters
from cable_sim_node.vertical.axial_line import AxialLine, AxialSection, AxialUnit
from cable_sim_node.vertical.linear import heave_transfer_function
from scipy.optimize import brentq

from tests.validation.peers.driven_run import run_driven

DENSITY, MASS, AREA, WIDTH = 1025.0, 12e3, 4.0, 2.0
WIRE = CableParameters(
    diameter=0.028, displaced_diameter=0.0224, mass_per_length=3.2, axial_stiffness=3.17e7, tangential_drag=0.0
)
SOLID = box_added_mass(2.0, 2.0, 2.0, DENSITY)
TABLE = OscillationParameters(
    kc=(0.5, 2.0, 6.0),
    added_mass=(0.6 * SOLID, SOLID, 1.4 * SOLID),
    drag_coefficient=(8.0, 5.0, 3.0),
    width=WIDTH,
)
PERIOD, AMPLITUDE, LENGTH = 7.5, 0.3, 1500.0


def linear_heave(kc):
    """Return the heave of the unit on an elastic bar [m] whose added mass and drag are those of the table at `kc`."""
    added = float(np.interp(kc, TABLE.kc, TABLE.added_mass))
    drag = 0.5 * DENSITY * AREA * float(np.interp(kc, TABLE.kc, TABLE.drag_coefficient))
    line = AxialLine(
        (AxialSection(math.inf, WIRE.axial_stiffness, WIRE.mass_per_length, 1.0),), AxialUnit(MASS + added, 1e5, drag)
    )
    answer = heave_transfer_function(line, LENGTH, [2.0 * math.pi / PERIOD], amplitude=AMPLITUDE)
    return AMPLITUDE * abs(complex(answer.unit_heave[0]))


def test_the_unit_heaves_as_the_linear_bar_does_at_the_kc_of_its_own_heave():
    """The bar's closed form with equivalent drag, and the one KC = 2 pi z/D at which it heaves by z."""
    kc = brentq(lambda guess: 2.0 * math.pi * linear_heave(guess) / WIDTH - guess, 0.1, 20.0)
    wanted = linear_heave(kc)
    parameters = CableSimParameters(
        length=LENGTH,
        segments=20,
        cable=WIRE,
        unit=UnitParameters(mass=MASS, volume=2.0, drag_area=(AREA,) * 3, oscillation=TABLE),
    )
    answer = run_driven(
        parameters, (0.0, 0.0, AMPLITUDE), 2.0 * math.pi / PERIOD, duration=600.0, window=75.0, ramp=30.0
    )
    at_rest = linear_heave(0.0)
    assert abs(at_rest / wanted - 1.0) > 0.1  # a constant coefficient would not do
    assert answer.unit_heave_amplitude == pytest.approx(wanted, rel=0.01)  # as good as an equivalent drag is: 0.7 %
