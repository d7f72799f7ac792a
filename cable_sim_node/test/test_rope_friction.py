"""Hysteresis of a wire rope: the loop's exact area, at any frequency; rest; pay-out; snaps; convergence in the step.

The loop of a spring EA beside a Jenkin element whose limit is the share m of the elastic tension T_0 + EA x is a
parallelogram with flanks of slope k EA; its corners follow by hand, and its area by the shoelace formula.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.line import layout as at
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters
from cable_sim_node.physics.tension_law import friction_of
from cable_sim_node.unit_parameters import UnitParameters
from heave_node.numerics.kinematics import PointMotion

from tests.validation.peers.driven_run import ramped_sine, run_driven

LENGTH, EA, MASS, GRAVITY = 100.0, 3.45e7, 1e4, 9.80665
LOSS, SWING = 0.05, 0.2


def rope(loss=LOSS, segments=1, step=0.05, **values):
    """Return a unit of 10 t on a light rope in a vacuum."""
    return CableSimParameters(
        length=LENGTH,
        segments=segments,
        water_density=0.0,
        cable=CableParameters(
            mass_per_length=1e-2, axial_stiffness=EA, loss_factor=loss, loss_swing=SWING, diameter=0.028
        ),
        unit=UnitParameters(mass=MASS, volume=0.0, added_mass=(0.0,) * 3),
        solver=SolverParameters(time_step=step),
        **values,
    )


def loop_area(tension, swing, loss):
    """Return the exact area of the loop over strain [N] at mean `tension` [N] and strain amplitude `swing`."""
    sticks, slides = friction_of(loss, SWING)
    mean = tension / EA
    down = (sticks * swing - slides * (2.0 * mean + swing)) / (sticks + slides)
    up = (slides * (2.0 * mean - swing) - sticks * swing) / (sticks - slides)
    if down <= -swing:
        return 0.0
    x = np.array([swing, down, -swing, up])
    y = EA * slides * np.array([mean + swing, -mean - down, -mean + swing, mean + up])
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def driven(parameters, amplitude, period, tick=0.01, cycles=6):
    """Return strain and tension [N] of the single segment over the last cycle."""
    motion = ramped_sine((0.0, 0.0, amplitude), 2.0 * math.pi / period, 2.0 * period)
    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(np.zeros(3))
    count, record = round(cycles * period / tick), []
    for k in range(count):
        plant.advance(tick, motion(k * tick), motion((k + 1) * tick), 0.0, 0.0, 0.0, 0.0)
        nodes, tensions = plant.nodes_and_tensions()
        record.append((np.linalg.norm(nodes[1] - nodes[0]) / LENGTH - 1.0, tensions[0]))
    return np.array(record[-round(period / tick) :]).T


@pytest.mark.parametrize("period", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("share", [0.15, 0.2, 0.4])
def test_a_cycle_loses_the_exact_area_of_its_loop_at_any_frequency(period, share):
    """Tension amplitude over mean tension is a w^2/g: the area is within what a tick cuts off the corners."""
    amplitude = share * GRAVITY * (period / (2.0 * math.pi)) ** 2
    strain, tension = driven(rope(), amplitude, period, tick=0.002 * period)
    area = 0.5 * abs(float(np.sum(strain * np.roll(tension, -1) - tension * np.roll(strain, -1))))
    swing = 0.5 * float(np.ptp(strain))
    mean = EA * 0.5 * float(strain.max() + strain.min())
    assert area == pytest.approx(loop_area(mean, swing, LOSS), rel=0.01)


def test_the_largest_loss_is_the_loss_factor():
    """Over 2 pi times the energy of the swing with the stiffness EA (1 + k/2) that it then has, but for A^2/4 = 1 %."""
    sticks, _ = friction_of(LOSS, SWING)
    tension = MASS * GRAVITY
    swings = tension / EA * np.linspace(0.12, 0.6, 49)
    loss = [loop_area(tension, swing, LOSS) / (math.pi * EA * (1.0 + 0.5 * sticks) * swing**2) for swing in swings]
    assert max(loss) == pytest.approx(LOSS, rel=0.012)
    assert swings[int(np.argmax(loss))] == pytest.approx(SWING * tension / EA, rel=0.06)


def test_small_swings_stick_and_lose_nothing():
    strain, tension = driven(rope(), 0.3 * SWING * GRAVITY * (10.0 / (2.0 * math.pi)) ** 2, 10.0)
    slope = np.polyfit(strain, tension, 1)[0]
    assert slope == pytest.approx(EA * (1.0 + friction_of(LOSS, SWING)[0]), rel=1e-4)


def test_a_cable_without_loss_knows_nothing_of_friction():
    """Bit for bit, whatever its swing parameter is."""
    other = dataclasses.replace(rope(0.0), cable=dataclasses.replace(rope(0.0).cable, loss_swing=0.7))
    np.testing.assert_array_equal(driven(rope(0.0), 0.5, 5.0, cycles=1), driven(other, 0.5, 5.0, cycles=1))


@pytest.mark.parametrize("depth", [0.0, 99.0])
def test_a_line_with_friction_starts_exactly_at_rest(depth):
    plant = CableDynamics(rope(segments=70, seabed=dataclasses.replace(CableSimParameters().seabed, depth=depth)))
    plant.start_at_equilibrium(np.zeros(3))
    start = plant.unit_position
    for _ in range(400):
        plant.advance(0.05, PointMotion(), PointMotion(), 0.0, 0.0, 0.0, 0.0)
    assert plant.unit_position == pytest.approx(start, abs=1e-8)
    assert plant.top_tension == pytest.approx(float(plant.segment_tensions[-1]), abs=0.1)


def test_pay_out_and_haul_in_keep_friction_within_its_limit():
    """Nodes are born and die; tension at births does not jump, and lies within m of the elastic one."""
    plant = CableDynamics(rope(segments=20))
    plant.start_at_equilibrium(np.zeros(3))
    slides, tensions, segments = friction_of(LOSS, SWING)[1], [plant.top_tension], set()
    payouts = 15.0 * np.sin(np.linspace(0.0, 2.0 * math.pi, 2001)) ** 2
    rates = np.gradient(payouts, 0.05)
    rates[[0, -1]] = 0.0
    for k in range(2000):
        plant.advance(0.05, PointMotion(), PointMotion(), payouts[k], rates[k], payouts[k + 1], rates[k + 1])
        tensions.append(plant.top_tension)
        segments.add(plant.segments)
        n = plant.segments
        strains = np.linalg.norm(np.diff(plant.node_positions, axis=0), axis=1) * plant._line.column(at.PER_LENGTH, n)
        friction = plant.segment_tensions / (EA * (strains - 1.0)) - 1.0
        assert np.all(np.abs(friction) <= slides + 2e-4)
    assert len(segments) > 3
    assert np.max(np.abs(np.diff(tensions))) < 0.02 * MASS * GRAVITY


def test_a_rope_that_snaps_never_pushes():
    plant = CableDynamics(rope(loss=0.2, segments=20))
    plant.start_at_equilibrium(np.zeros(3))
    motion = ramped_sine((0.0, 0.0, 1.5), 2.0 * math.pi / 2.0, 4.0)
    least, slack = math.inf, 0
    for k in range(400):
        plant.advance(0.05, motion(0.05 * k), motion(0.05 * (k + 1)), 0.0, 0.0, 0.0, 0.0)
        least, slack = min(least, float(plant.segment_tensions.min())), max(slack, plant.slack_segments)
    assert slack > 0
    assert least >= 0.0


def test_a_smaller_step_changes_a_swing_ever_less():
    """Driven near its resonance: each halving of the step leaves at most half of the difference, but for roundoff."""
    length = 1500.0
    parameters = dataclasses.replace(rope(), length=length)
    frequency = 0.85 * math.sqrt(EA / (MASS * length))
    run = {"duration": 200.0, "window": 60.0, "ramp": 60.0}
    sizes = [
        run_driven(
            dataclasses.replace(parameters, solver=SolverParameters(time_step=step)), (0.0, 0.0, 0.3), frequency, **run
        ).unit_heave_amplitude
        for step in (0.05, 0.025, 0.0125, 0.00625)
    ]
    changes = np.abs(np.diff(sizes)) / sizes[-1]
    assert changes[0] < 2e-3
    assert np.all(changes[1:] <= 0.6 * changes[:-1] + 1e-6)
