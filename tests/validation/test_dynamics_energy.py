"""Energy: conserved in vacuum to the order of the integrator, and lost only where the model says."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters, UnitParameters
from heave_node.numerics.kinematics import PointMotion

from tests.validation.line_energy import energy_of, power_lost


def pendulum(time_step, *, spectral_radius=1.0, internal_damping=0.0, density=0.0):
    """Return a swinging line of ten segments, released from rest at an angle (a thruster held it), and its start
    energy.
    """
    parameters = CableSimParameters(
        length=50.0,
        segments=10,
        water_density=density,
        cable=CableParameters(axial_stiffness=2e5, internal_damping=internal_damping, added_mass=0.0),
        unit=UnitParameters(mass=100.0, volume=0.0, added_mass=(0.0,) * 3, thrust=(800.0, 300.0, 0.0)),
        solver=SolverParameters(time_step=time_step, spectral_radius=spectral_radius, tolerance=1e-8),
    )
    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(np.zeros(3))
    plant.set_thrust(np.zeros(3))
    return plant


def swing(plant, duration, tick=0.05):
    """Return the energies [J] after each tick and the power lost [W], with the time step as it is."""
    still, energies, lost = PointMotion(), [energy_of(plant).total], [power_lost(plant).total]
    for _ in range(round(duration / tick)):
        plant.advance(tick, still, still, 0.0, 0.0, 0.0, 0.0)
        energies.append(energy_of(plant).total)
        lost.append(power_lost(plant).total)
    return np.array(energies), np.array(lost)


def test_energy_of_the_undamped_chain_in_vacuum_is_kept_to_second_order():
    """The trapezoidal-like member (spectral radius 1) keeps energy but for O(dt^2) that does not grow; halving dt
    quarters it.
    """
    drifts = []
    for step in (0.01, 0.005, 0.0025):
        energies, _ = swing(pendulum(step), 20.0)
        drifts.append(np.max(np.abs(energies - energies[0])))
    swing_size = 100.0 * 9.80665 * 50.0 * 0.2
    assert drifts[-1] < 1e-4 * swing_size
    for coarse, fine in itertools.pairwise(drifts):
        assert math.log2(coarse / fine) == pytest.approx(2.0, abs=0.35)


def test_numerical_damping_only_takes_energy():
    energies, _ = swing(pendulum(0.01, spectral_radius=0.5), 20.0)
    swing_size = 100.0 * 9.80665 * 50.0 * 0.2
    assert 0.0 < energies[0] - energies[-1] < 0.01 * swing_size
    assert np.max(np.diff(energies)) < 1e-5 * swing_size


@pytest.mark.parametrize(("damping", "density"), [(2e4, 0.0), (0.0, 1025.0), (2e4, 1025.0)])
def test_energy_is_lost_only_to_internal_damping_and_drag(damping, density):
    """dE/dt = -(power lost to the named sinks): integrated over the run, to the accuracy of the trapezoidal rule."""
    plant = pendulum(0.002, internal_damping=damping, density=density)
    energies, lost = swing(plant, 10.0, tick=0.01)
    taken = np.concatenate([[0.0], np.cumsum(0.5 * (lost[1:] + lost[:-1]) * 0.01)])
    assert taken[-1] > 1.0
    assert energies[0] - energies == pytest.approx(taken, abs=0.01 * taken[-1] + 0.5)


def test_the_boom_tip_feeds_what_the_line_gains():
    """Work of the top force on the moving boom tip equals the energy gained, in vacuum."""
    plant = pendulum(0.002)
    tick, work, before = 0.01, 0.0, 0.0
    start = energy_of(plant).total
    for k in range(500):
        ends = [
            PointMotion(
                time=t,
                position=np.array([1.0 - math.cos(t), 0.0, 2.0 * (1.0 - math.cos(t))]),
                velocity=np.array([math.sin(t), 0.0, 2.0 * math.sin(t)]),
            )
            for t in (k * tick, (k + 1) * tick)
        ]
        plant.advance(tick, *ends, 0.0, 0.0, 0.0, 0.0)
        after = -plant.top_force @ ends[1].velocity
        work += 0.5 * tick * (before + after)
        before = after
    assert energy_of(plant).total - start == pytest.approx(work, rel=0.01, abs=5.0)


def test_energy_parts_are_what_they_say_at_rest():
    """Elastic energy of a hanging bar T^2 l/(2 EA) summed; potential energy from the positions; nothing kinetic."""
    plant = pendulum(0.01)
    plant = CableDynamics(
        dataclasses.replace(plant.parameters, unit=dataclasses.replace(plant.parameters.unit, thrust=(0.0,) * 3))
    )
    plant.start_at_equilibrium(np.zeros(3))
    energy = energy_of(plant)
    tensions = plant.segment_tensions
    assert energy.kinetic == 0.0
    assert energy.elastic == pytest.approx(float(np.sum(tensions**2)) * 5.0 / (2.0 * 2e5), rel=1e-9)
    masses = np.full(11, 5.0 * 5.4)
    masses[[0, -1]] *= 0.5
    masses[0] += 100.0
    assert energy.potential == pytest.approx(9.80665 * float(masses @ plant.node_positions[:, 2]), rel=1e-9)
