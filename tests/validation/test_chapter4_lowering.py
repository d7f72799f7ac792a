"""Thesis 4.5.5 (chapter 4, example five): lowering from 200 m through resonance with P = sin t, Q = 1 - cos t; current.

P is the heave of the top, Q its motion sideways. No number of figures 4.12 to 4.21 is printed, and neither drag nor the
speed of the current: drag is the defaults', the current 0.2 m/s. The reference is a string, or a bar, of fixed length
under the same drag, solved by itself on a grid: nothing of it stretches and sways at once.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, UnitParameters
from heave_node.numerics.kinematics import PointMotion

from tests.validation.peers.driven_run import lower

DIAMETER, STIFFNESS, MASS_PER_LENGTH = 0.02, 4e9 * 0.25 * math.pi * 0.02**2, 5.2
MASS, ADDED_MASS, WEIGHT = 1900.0, 1600.0, 15_000.0
SYSTEM = CableSimParameters(
    segments=10,
    cable=CableParameters(diameter=DIAMETER, mass_per_length=MASS_PER_LENGTH, axial_stiffness=STIFFNESS),
    unit=UnitParameters(mass=MASS, volume=(MASS - WEIGHT / 9.80665) / 1025.0, added_mass=(ADDED_MASS,) * 3),
)
RHO, OMEGA, TICK = 1025.0, 1.0, 0.1
PERIODS, RISE = 60, 150.0
UNIT_DRAG = 0.5 * RHO * SYSTEM.unit.drag_coefficient[0] * SYSTEM.unit.drag_area[0]
CABLE_DRAG = 0.5 * RHO * SYSTEM.cable.normal_drag * DIAMETER
CABLE_FRICTION = 0.5 * math.pi * RHO * SYSTEM.cable.tangential_drag * DIAMETER
DISPLACED = RHO * 0.25 * math.pi * DIAMETER**2
CABLE_WEIGHT = (MASS_PER_LENGTH - DISPLACED) * 9.80665


def lowered(speed, heave, sway, current=0.0, stop=420.0):
    """Return lengths [m], times [s] and positions of the unit [m] while it is lowered at `speed` [m/s]."""
    plant = CableDynamics(dataclasses.replace(SYSTEM, length=200.0, current=(current, 0.0)))
    plant.start_at_equilibrium(np.zeros(3))

    def motion(t):
        sine, cosine = math.sin(t), math.cos(t)
        return PointMotion(
            t, np.array([sway * (1.0 - cosine), 0.0, heave * sine]), np.array([sway * sine, 0.0, heave * cosine])
        )

    lengths, units = lower(plant, motion, speed, stop, TICK)
    return lengths, TICK * np.arange(1, len(lengths) + 1), units


def harmonic_near(length, record, axis):
    """Return amplitude and mean [m] of the unit along an axis over the period in which it passes a length [m]."""
    lengths, times, units = record
    half = round(math.pi / OMEGA / TICK)
    middle = int(np.searchsorted(lengths, length))
    part = slice(middle - half, middle + half)
    t = times[part] - times[middle]
    terms = np.column_stack((np.ones_like(t), t, np.cos(OMEGA * t), np.sin(OMEGA * t)))
    mean, _, cosine, sine = np.linalg.lstsq(terms, units[part, axis], rcond=None)[0]
    return math.hypot(cosine, sine), mean


def fixed_length(length, pull, mass_per_length, drag_per_length, spacing, current=0.0):
    """Return amplitude and mean [m] of the unit on a line of fixed length whose top moves as cos t, by leapfrog.

    `pull` is the stiffness between neighbours times their distance at labels from the unit [N]: EA, or T of a string.
    """
    parts = round(length / spacing)
    labels, spacing = (np.arange(parts) + 0.5) * length / parts, length / parts
    springs = pull(labels) / spacing
    inertia, drag = np.full(parts, mass_per_length * spacing), np.full(parts, drag_per_length * spacing)
    inertia[0], drag[0] = 0.5 * inertia[0] + MASS + ADDED_MASS, 0.5 * drag[0] + UNIT_DRAG
    x, v = np.zeros(parts + 1), np.zeros(parts)
    step = 2.0 * math.pi / OMEGA / 400
    found = []
    for k in range(400 * PERIODS):
        share = min(k * step / RISE, 1.0)
        x[-1] = share**2 * (3.0 - 2.0 * share) * math.cos(OMEGA * k * step)
        force = springs * np.diff(x)
        force[1:] -= force[:-1].copy()
        relative = current - v
        v += step / inertia * (force + drag * np.abs(relative) * relative)
        x[:-1] += step * v
        found.append(x[0])
    angle = step * np.arange(800)
    terms = np.column_stack((np.ones(800), np.cos(angle), np.sin(angle)))
    mean, cosine, sine = np.linalg.lstsq(terms, np.array(found[-800:]), rcond=None)[0]
    return math.hypot(cosine, sine), mean


def string(length, current=0.0):
    """Return sway and mean of the unit at a fixed length: on a string of tension W + w s."""
    mass = MASS_PER_LENGTH + DISPLACED
    return fixed_length(length, lambda s: WEIGHT + CABLE_WEIGHT * s, mass, CABLE_DRAG, 3.0, current)


def bar(length):
    """Return the heave of the unit at a fixed length: on an elastic bar."""
    return fixed_length(length, lambda s: np.full_like(s, STIFFNESS), MASS_PER_LENGTH, CABLE_FRICTION, 12.0)[0]


def test_the_sway_while_lowering_is_that_of_a_string_of_the_same_length(gallery):
    """Figs 4.13 to 4.19, Q alone: drag leaves 3 to 5 % of the top's metre, less the longer the cable is."""
    record = lowered(0.25, 0.0, 1.0)
    places = (240.0, 320.0, 400.0)
    found = np.array([harmonic_near(length, record, 0) for length in places])

    def draw(figure):
        axes = figure.subplots()
        axes.plot(record[0], record[2][:, 0], linewidth=0.6)
        for sign in (-1.0, 1.0):
            axes.plot(places, [1.0 + sign * string(length)[0] for length in places], "o--", color="0.4")
        axes.set_xlabel("cable length [m]")
        axes.set_ylabel("sway of the unit [m]")

    gallery("chapter4_example5_sway", "Thesis 4.5.5: Q = 1 - cos t, lowering at 0.25 m/s; dots: string.", draw)
    assert found[:, 0] == pytest.approx([string(length)[0] for length in places], rel=0.015)
    # the mean of 1 - cos t
    assert found[:, 1] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("sway", [0.0, 1.0])
def test_the_heave_is_that_of_the_bar_whether_the_top_sways_or_not(sway):
    """Figs 4.12 to 4.18: sway takes nothing from heave at first order, at and beside resonance near 300 m."""
    record = lowered(0.1, 1.0, sway, stop=330.0)
    places = (240.0, 280.0, 300.0, 320.0)
    found = [harmonic_near(length, record, 2)[0] for length in places]
    assert found == pytest.approx([bar(length) for length in places], rel=0.01)


def test_faster_lowering_means_less_motion_with_both():
    """The text: the higher the speed, the shorter the time in the resonant zone."""
    largest = []
    for speed in (0.25, 0.5, 1.0, 2.0):
        record = lowered(speed, 1.0, 1.0)
        largest.append(max(harmonic_near(length, record, 2)[0] for length in np.arange(220.0, 400.0, 5.0)))
    assert largest == sorted(largest, reverse=True)
    assert largest[3] < 0.8 * largest[0]


def test_in_a_weak_current_the_unit_goes_further_the_longer_the_cable_is(gallery):
    """Figs 4.20, 4.21: the drag of a swaying cable bends a string of the same length."""
    current = 0.2
    record = lowered(0.25, 0.0, 1.0, current)
    still = lowered(0.25, 1.0, 1.0)
    drifting = lowered(0.25, 1.0, 1.0, current)
    places = (240.0, 320.0, 400.0)
    expected = [1.0 + string(length, current)[1] for length in places]

    def draw(figure):
        axes = figure.subplots()
        axes.plot(drifting[0], drifting[2][:, 0], linewidth=0.6, label="0.2 m/s, P and Q")
        axes.plot(record[0], record[2][:, 0], linewidth=0.6, label="0.2 m/s, Q")
        axes.plot(places, expected, "o", label="string")
        axes.set_xlabel("cable length [m]")
        axes.set_ylabel("x of the unit [m]")
        axes.legend()

    gallery("chapter4_example5_current", "Thesis 4.5.5, figs 4.20, 4.21: lowering in a weak current.", draw)
    found = [harmonic_near(length, record, 0)[1] for length in places]
    assert found == pytest.approx(expected, rel=0.02)
    offsets = [harmonic_near(length, drifting, 0)[1] for length in places]
    assert offsets == sorted(offsets)
    # the effect of the current is mainly upon the horizontal motion
    for length in places:
        assert harmonic_near(length, drifting, 2)[0] == pytest.approx(harmonic_near(length, still, 2)[0], rel=0.02)


@pytest.mark.parametrize("length", [200.0, 420.0])
def test_the_dynamic_part_of_the_heave_is_what_both_parts_of_the_stretch_leave(length):
    """Thesis 4.5.5: P(1, T) - (L/EA) w_2 - g (m - rho A) L^2/(2 EA), where the text prints = for the first minus.

    A hanging system at rest has none. The printed right side has the two parts of the stretch against one another.
    """
    plant = CableDynamics(dataclasses.replace(SYSTEM, length=length, surface=False))
    plant.start_at_equilibrium(np.zeros(3))
    stretch = -plant.unit_position[2] - length
    unit, own = length / STIFFNESS * WEIGHT, CABLE_WEIGHT * length**2 / (2.0 * STIFFNESS)
    assert stretch - unit - own == pytest.approx(0.0, abs=1e-6)
    assert abs(stretch - (unit - own)) > 0.1 * stretch
