"""What the wire itself decides: 12 t on 1,500 m, boom tip 0.3 m at 7.5 s, winch locked, near the heave resonance.

The plant beside a chain of the same masses with a complex stiffness, solved at one frequency: describing function of a
Jenkin element at each segment's own swing, drag by its equivalent (8/(3 pi)) w a. 1.175 m, 1.39 m with 15 % less EA
and 1.08 m with a loss factor of 5 % are figures for this system from outside this suite, the last with complex EA.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters
from cable_sim_node.unit_parameters import UnitParameters

from tests.validation.peers.driven_run import run_driven

EA, LENGTH, SEGMENTS, FREQUENCY, BOOM = 3.45e7, 1500.0, 20, 2.0 * math.pi / 7.5, 0.3
MASS, ADDED, VOLUME, DIAMETER, CABLE_MASS, DENSITY, GRAVITY = 12e3, 12e3, 3.0, 0.028, 3.4, 1025.0, 9.80665
LOSS, SWING = 0.05, 0.2


def system(stiffness=EA, **cable):
    return CableSimParameters(
        length=LENGTH,
        segments=SEGMENTS,
        surface=False,
        cable=CableParameters(
            diameter=DIAMETER, mass_per_length=CABLE_MASS, axial_stiffness=stiffness, tangential_drag=0.02, **cable
        ),
        unit=UnitParameters(
            mass=MASS,
            volume=VOLUME,
            added_mass=(ADDED,) * 3,
            drag_coefficient=(1.5,) * 3,
            drag_area=(6.0,) * 3,
        ),
        solver=SolverParameters(time_step=0.025),
    )


def amplitude_of(parameters):
    run = run_driven(parameters, (0.0, 0.0, BOOM), FREQUENCY, duration=300.0, window=60.0, ramp=60.0)
    return run.unit_heave_amplitude


def jenkin(ratio, sticks):
    """Return what a Jenkin element adds to a stiffness of 1 in the first harmonic; `ratio` limit/(k amplitude)."""
    if ratio >= 1.0:
        return complex(sticks)
    angle = math.acos(1.0 - 2.0 * ratio)
    return sticks / math.pi * complex(angle - 0.5 * math.sin(2.0 * angle), 4.0 * ratio * (1.0 - ratio))


def harmonic_amplitude(stiffness=EA, complex_part=0.0, friction=(0.0, 0.0)):
    """Return the unit's amplitude [m] of the chain; `friction` is k and m."""
    sticks, slides = friction
    size, area = LENGTH / SEGMENTS, 0.25 * math.pi * DIAMETER**2
    masses = np.full(SEGMENTS, CABLE_MASS * size)
    masses[0] = 0.5 * CABLE_MASS * size + MASS + ADDED
    weights = (CABLE_MASS - DENSITY * area) * GRAVITY
    mean = (MASS - DENSITY * VOLUME) * GRAVITY + weights * size * (np.arange(SEGMENTS) + 0.5)
    drag = np.full(SEGMENTS, 0.5 * math.pi * DENSITY * 0.02 * DIAMETER * size)
    drag[0] = 0.5 * drag[0] + 0.5 * DENSITY * 1.5 * 6.0
    motion, extra = np.full(SEGMENTS, 1.0 + 0.0j), np.zeros(SEGMENTS, complex)
    for _ in range(200):
        springs = stiffness / size * (1.0 + 1j * complex_part + extra)
        damping = 8.0 / (3.0 * math.pi) * drag * np.abs(motion) * FREQUENCY**2
        matrix = np.diag(-masses * FREQUENCY**2 + 1j * damping + springs + np.append(0.0, springs[:-1]))
        matrix -= np.diag(springs[:-1], 1) + np.diag(springs[:-1], -1)
        force = np.zeros(SEGMENTS, complex)
        force[-1] = springs[-1] * BOOM
        motion = 0.5 * motion + 0.5 * np.linalg.solve(matrix, force)
        swing = stiffness / size * np.abs(np.diff(np.append(motion, BOOM)))
        if sticks > 0.0:
            extra = np.array([jenkin(slides * t / (sticks * s), sticks) for t, s in zip(mean, swing, strict=True)])
    return abs(motion[0])


def test_stiffness_decides_the_swing_near_resonance():
    """Bedding-in by 15 % of EA is as much as 18 % of the unit's motion."""
    assert amplitude_of(system()) == pytest.approx(1.175, rel=2e-3)
    assert amplitude_of(system(0.85 * EA)) == pytest.approx(1.39, rel=3e-3)
    assert harmonic_amplitude() == pytest.approx(1.175, rel=5e-3)
    assert harmonic_amplitude(0.85 * EA) == pytest.approx(1.39, rel=5e-3)


def test_a_loss_factor_of_five_percent_takes_eight_percent_off():
    """By complex stiffness, and by internal damping that is the same at this one frequency."""
    assert harmonic_amplitude(complex_part=LOSS) == pytest.approx(1.08, rel=5e-3)
    assert amplitude_of(system(internal_damping=LOSS * EA / FREQUENCY)) == pytest.approx(1.08, rel=5e-3)


@pytest.mark.parametrize("swing", [0.1, 0.2, 0.4])
@pytest.mark.parametrize("loss", [0.02, 0.05, 0.1])
def test_a_rope_with_hysteresis_answers_as_its_describing_function(loss, swing):
    sticks = math.pi * loss / (1.0 - 0.5 * math.pi * loss)
    measured = amplitude_of(system(loss_factor=loss, loss_swing=swing))
    assert measured == pytest.approx(harmonic_amplitude(friction=(sticks, 0.5 * sticks * swing)), rel=0.01)


def test_a_rope_whose_stiffness_was_measured_in_swings_loses_as_its_complex_stiffness_does():
    """EA over 1 + k/2, so that the rope has EA where it loses most; the swing is that of this system."""
    sticks = math.pi * LOSS / (1.0 - 0.5 * math.pi * LOSS)
    softer = system(EA / (1.0 + 0.5 * sticks), loss_factor=LOSS, loss_swing=0.17)
    assert amplitude_of(softer) == pytest.approx(1.08, rel=0.01)
