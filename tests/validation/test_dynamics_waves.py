"""Waves along the line: speeds, fronts, dispersion and cut-off of the chain, decay in water (thesis 4.3, 12.4)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters, UnitParameters
from heave_node.numerics.kinematics import PointMotion

from tests.validation.peers.driven_run import first_harmonic, ramped_sine, smooth_rise, smooth_start

EA, MU, LENGTH, TENSION = 1.5614508e7, 5.4, 300.0, 36_000.0


def taut_wire(segments, *, time_step, length=LENGTH, density=0.0, pull=(0.0, 0.0, -TENSION), **cable):
    """Return a wire without weight, its unit too heavy to move, pulled by a thruster to a uniform tension."""
    own = {"mass_per_length": MU, "axial_stiffness": EA, "added_mass": 0.0, "normal_drag": 0.0, "tangential_drag": 0.0}
    cable = CableParameters(**(own | cable))
    unit = UnitParameters(mass=1e9, volume=0.0, added_mass=(0.0,) * 3, drag_coefficient=(0.0,) * 3, thrust=pull)
    plant = CableDynamics(
        CableSimParameters(
            length=length,
            segments=segments,
            water_density=density,
            gravity=0.0,
            cable=cable,
            unit=unit,
            solver=SolverParameters(time_step=time_step, spectral_radius=1.0, tolerance=1e-9),
        )
    )
    plant.start_at_equilibrium(np.zeros(3))
    return plant


def smooth_step(size, direction, rise):
    """Return a boom-tip motion that goes `size` m in `direction` in `rise` s and stays."""

    def motion(t):
        way, slope = smooth_rise(t / rise)
        return PointMotion(t, direction * size * way, direction * size * slope / rise)

    return motion


def arrival(plant, motion, node, axis, tick, duration, size):
    """Return when node `node` first passes half of `size` along `axis`."""
    before, rest = 0.0, plant.node_positions[node, axis]
    for k in range(1, round(duration / tick) + 1):
        plant.advance(tick, motion((k - 1) * tick), motion(k * tick), 0.0, 0.0, 0.0, 0.0)
        now = plant.node_positions[node, axis] - rest
        if now >= 0.5 * size:
            return (k - 1 + (0.5 * size - before) / (now - before)) * tick
        before = now
    raise AssertionError("no wave came")


def test_an_axial_pulse_runs_at_the_root_of_stiffness_over_mass():
    """sqrt(EA/m), of the unstretched wire: material coordinates."""
    segments, rise, size = 300, 0.03, 0.01
    plant = taut_wire(segments, time_step=2e-4)
    node = segments // 2
    distance = LENGTH - plant.material_coordinates[node]
    time = arrival(plant, smooth_step(size, np.array([0.0, 0.0, 1.0]), rise), node, 2, 2e-3, 0.2, size)
    assert distance / (time - 0.5 * rise) == pytest.approx(math.sqrt(EA / MU), rel=5e-3)


def test_a_transverse_pulse_runs_at_the_root_of_tension_over_mass():
    """sqrt(T/((1 + e) m)) in unstretched length per second (thesis 12.4.3)."""
    segments, rise, size = 300, 0.5, 0.05
    plant = taut_wire(segments, time_step=2.5e-3)
    node = segments // 2
    distance = LENGTH - plant.material_coordinates[node]
    time = arrival(plant, smooth_step(size, np.array([1.0, 0.0, 0.0]), rise), node, 0, 5e-3, 4.0, size)
    strain = TENSION / EA
    assert distance / (time - 0.5 * rise) == pytest.approx(math.sqrt(TENSION / (1.0 + strain) / MU), rel=5e-3)


def wave_field(segments, omega, *, time_step, duration, **wire):
    """Return complex transverse amplitudes of all nodes, from the top, driven sideways by 1 mm; read before
    reflections return.
    """
    plant = taut_wire(segments, time_step=time_step, **wire)
    period = 2.0 * math.pi / omega
    motion = ramped_sine((1e-3, 0.0, 0.0), omega, 3.0 * period)
    tick, times, nodes = period / 20.0, [], []
    for k in range(1, int(duration / tick) + 1):
        plant.advance(tick, motion((k - 1) * tick), motion(k * tick), 0.0, 0.0, 0.0, 0.0)
        if k * tick > duration - 2.0 * period:
            times.append(k * tick)
            nodes.append(plant.node_positions[::-1, 0])
    record, field = np.array(times), np.array(nodes)
    fits = [first_harmonic(record, field[:, j], omega) for j in range(field.shape[1])]
    return np.array([size * complex(math.cos(phase), math.sin(phase)) for _, size, phase in fits])


@pytest.mark.parametrize("share", [0.3, 0.6, 0.85])
def test_the_chain_disperses_as_the_lumped_chain_does(share):
    """omega = (2/l) sqrt(l T/m) sin(k l/2) with m the mass of a segment; below the cut-off 2 sqrt(T/(l m))."""
    segments, length = 120, 1200.0
    spacing = length / segments
    tension_term = TENSION / (1.0 + TENSION / EA)
    cutoff = 2.0 * math.sqrt(tension_term / (spacing * MU * spacing))
    omega = share * cutoff
    expected = 2.0 * math.asin(share)
    group = 0.5 * cutoff * spacing * math.cos(0.5 * expected)
    field = wave_field(segments, omega, time_step=0.1 / omega, duration=min(0.8 * length / group, 25.0), length=length)
    phases = np.unwrap(np.angle(field[1:8]))
    measured = -np.polyfit(np.arange(7), phases, 1)[0]
    assert measured == pytest.approx(expected, rel=0.01)


def test_above_the_cutoff_the_chain_lets_nothing_through():
    """At 1.2 of the cut-off, sinh replaces sin: each node moves exp(-2 arcosh 1.2) of the last, in opposite phase."""
    segments, length = 60, 600.0
    tension_term = TENSION / (1.0 + TENSION / EA)
    cutoff = 2.0 * math.sqrt(tension_term / MU) / 10.0
    field = wave_field(segments, 1.2 * cutoff, time_step=0.005, duration=12.0, length=length)
    # further down the last of the ramp's transient, which creeps at the cut-off itself, is no longer small beside it
    ratio = field[1:4] / field[0:3]
    assert np.abs(ratio[:2]) == pytest.approx(math.exp(-2.0 * math.acosh(1.2)), rel=0.02)
    assert np.all(ratio.real < 0.0)


def test_transverse_waves_decay_in_water_as_equation_4_10():
    """Amplitude exp(-Im sqrt((w^2 m - i w c)/T) s) with added mass; quadratic drag of amplitude A is c = (8/3 pi)
    rho C d w A/2.

    A decays along the cable, so decay is compared over the first tenth of the way, where A has fallen by a few
    percent only. 4.10 is printed without sqrt(-1) before its root: undamped waves would die out within a wave length.
    """
    segments, length, omega, size = 400, 1000.0, 2.0, 1e-3
    rho, drag, d = 1025.0, 60.0, 0.047
    field = np.abs(
        wave_field(
            segments, omega, time_step=0.01, duration=20.0, length=length, added_mass=1.0, density=rho, normal_drag=drag
        )
    )
    mass = MU + rho * 0.25 * math.pi * d**2
    spacing = length / segments
    tension = TENSION / (1.0 + TENSION / EA)
    amplitude, expected = size, [size]
    for _ in range(40):
        c = 8.0 / (3.0 * math.pi) * 0.5 * rho * drag * d * omega * amplitude
        amplitude *= math.exp(-spacing * abs(np.sqrt((omega**2 * mass - 1j * omega * c) / tension).imag))
        expected.append(amplitude)
    assert field[40] < 0.9 * size
    assert field[:41] == pytest.approx(expected, rel=0.01)
    assert field[40] > 5.0 * size * math.exp(-40.0 * spacing * omega * math.sqrt(mass / tension))


def test_on_the_line_the_tensile_front_keeps_the_shape_and_the_transverse_front_the_strain():
    """Thesis 12.4.4 on the plant: the top of a slanting wire begins to move sideways at 0.1 m/s, in 0.1 s.

    The tensile front leaves the part v along the wire and the strain v/c; the transverse front the rest, and a turn.
    """
    soft, along = 1.6e6, np.array([math.sin(0.6), 0.0, math.cos(0.6)])
    plant = taut_wire(300, time_step=5e-4, pull=tuple(-TENSION * along), axial_stiffness=soft)
    rest, strain = np.diff(plant.node_positions, axis=0), TENSION / soft
    speed, rise, duration, tick = np.array([0.1, 0.0, 0.0]), 0.1, 0.5, 2e-3

    def motion(t):
        way, rate = smooth_start(t, rise)
        return PointMotion(t, speed * way, speed * rate)

    for k in range(round(duration / tick)):
        plant.advance(tick, motion(k * tick), motion((k + 1) * tick), 0.0, 0.0, 0.0, 0.0)
    tensile, transverse = math.sqrt(soft / MU), math.sqrt(TENSION / (1.0 + strain) / MU)
    fraction = (LENGTH - plant.material_coordinates[:-1]) / duration
    behind, between = fraction < 0.7 * transverse, (fraction > 1.3 * transverse) & (fraction < 0.7 * tensile)
    turn = (np.diff(plant.node_positions, axis=0) - rest) / (LENGTH / 300)
    part = (speed @ along) * along
    stretched = (speed @ along) / tensile
    assert between.sum() > 100
    assert behind.sum() > 15
    velocities = plant.node_velocities[:-1]
    # dr_s = r_s/(1 + e) de (12.24); behind the transverse front de = 0 (12.21, 12.22)
    assert turn[between] == pytest.approx(np.tile(along * stretched, (between.sum(), 1)), abs=0.02 * stretched)
    assert velocities[between] == pytest.approx(np.tile(part, (between.sum(), 1)), abs=0.02 * 0.1)
    assert turn[behind] @ along == pytest.approx(stretched, rel=0.02)
    assert velocities[behind] == pytest.approx(np.tile(speed, (behind.sum(), 1)), abs=0.02 * 0.1)
    across = speed - part
    assert turn[behind] @ across == pytest.approx(across @ across / transverse, rel=0.02)
