"""Slack and snap: against energy, and against itself with other steps and meshes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters, UnitParameters
from cable_sim_node.peers.driven_run import run_driven
from cable_sim_node.peers.reference_systems import s900
from heave_node.numerics.kinematics import PointMotion


@pytest.mark.parametrize("segments", [1, 8])
def test_the_snap_of_a_unit_that_falls_back_is_that_of_its_energy(segments, gallery):
    """Vacuum, light line: W d + KE = k d^2/2 at the lowest point, so the peak is W + sqrt(W^2 + 2 k KE)."""
    mass, length, stiffness = 1000.0, 50.0, 5e6
    plant = CableDynamics(
        CableSimParameters(
            length=length,
            segments=segments,
            water_density=0.0,
            cable=CableParameters(mass_per_length=0.01, axial_stiffness=stiffness),
            unit=UnitParameters(mass=mass, volume=0.0),
            solver=SolverParameters(time_step=0.005),
        )
    )
    plant.start_at_equilibrium(np.zeros(3))
    weight, k, still = mass * 9.80665, stiffness / length, PointMotion()
    times, tensions, slack = [], [], 0
    plant.set_thrust([0.0, 0.0, 3.0 * weight])
    for step in range(400):
        if step == 40:
            plant.set_thrust(np.zeros(3))
            z, v = plant.unit_position[2], plant.unit_velocity[2]
        plant.advance(0.01, still, still, 0.0, 0.0, 0.0, 0.0)
        times.append(plant.time)
        tensions.append(plant.segment_tensions[0])
        slack += plant.slack_segments > 0
    kinetic = 0.5 * mass * v**2 + weight * (z + length)

    def draw(figure):
        axes = figure.subplots()
        axes.plot(times, np.array(tensions) / 1e3)
        axes.axhline((weight + math.sqrt(weight**2 + 2.0 * k * kinetic)) / 1e3, linestyle="--", color="0.5")
        axes.set_xlabel("time [s]")
        axes.set_ylabel("tension [kN]")

    gallery(
        f"snap_{segments}", "A unit thrown up falls back into its line; dashed: peak by conservation of energy.", draw
    )
    assert slack > 50
    assert max(tensions) == pytest.approx(weight + math.sqrt(weight**2 + 2.0 * k * kinetic), rel=0.01)
    assert min(tensions) >= 0.0


def test_snaps_do_not_depend_on_the_step_or_the_mesh():
    """900 m, 3 m at 14 s: slack and snap in every cycle; the peak of 2.1 times the static tension stays within
    1.5 %.
    """
    results = [
        run_driven(
            s900(segments, time_step=step),
            (0.0, 0.0, 3.0),
            2.0 * math.pi / 14.0,
            duration=250.0,
            window=112.0,
            ramp=60.0,
        )
        for segments, step in ((100, 0.05), (100, 0.0125), (50, 0.05), (200, 0.05))
    ]
    amplitudes = [r.unit_heave_amplitude for r in results]
    peaks = [r.tension_max for r in results]
    assert max(amplitudes) / min(amplitudes) < 1.005
    assert max(peaks) / min(peaks) < 1.015
