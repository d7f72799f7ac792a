"""Slack and snap: against energy, and against itself with other steps and meshes."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters, UnitParameters
from heave_node.numerics.kinematics import PointMotion

from tests.validation.peers.driven_run import ramped_sine, run_driven
from tests.validation.peers.reference_systems import s300, s900


@pytest.mark.parametrize("segments", [1, 8])
def test_the_snap_of_a_unit_that_falls_back_is_that_of_its_energy(segments):
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

    assert slack > 50
    assert max(tensions) == pytest.approx(weight + math.sqrt(weight**2 + 2.0 * k * kinetic), rel=0.01)
    assert min(tensions) >= 0.0


DAMPING_TIME = 0.01
"""Internal damping over axial stiffness [s]: that of the catalogue's wires."""


def snapping(length, amplitude, period, *, damped=True, segments=50, time_step=0.05):
    """Return the largest top tension of each cycle [N], and that at the ticks: a 3 t unit on a wire that goes slack."""
    omega, tick = 2.0 * math.pi / period, 0.05
    parameters = s300(segments, time_step=time_step)
    damping = DAMPING_TIME * parameters.cable.axial_stiffness if damped else 0.0
    cable = dataclasses.replace(parameters.cable, internal_damping=damping)
    plant = CableDynamics(dataclasses.replace(parameters, length=length, cable=cable))
    plant.start_at_equilibrium(np.zeros(3))
    motion = ramped_sine((0.0, 0.0, amplitude), omega, 5.0 * period)
    peaks, seen, ticks = [], [], round(period / tick)
    for k in range(25 * ticks):
        plant.advance(tick, motion(k * tick), motion((k + 1) * tick), 0.0, 0.0, 0.0, 0.0)
        peaks.append(plant.largest_top_tension)
        seen.append(plant.top_tension)
    return (np.array(values).reshape(-1, ticks).max(axis=1)[10:] for values in (peaks, seen))


@pytest.mark.parametrize(
    ("case", "tolerance"),
    [((300.0, 3.0, 5.0), 0.01), ((900.0, 2.0, 6.0), 0.01), ((2000.0, 3.0, 8.0), 0.01), ((100.0, 1.5, 4.0), 0.02)],
)
def test_the_peaks_of_snaps_are_those_of_a_refined_run(case, tolerance):
    """With the loss of a wire the peak has a limit, to which steps of 1.6 ms and twice the segments come: mean over
    cycles.
    """
    peaks, seen = snapping(*case)
    refined, _ = snapping(*case, segments=100, time_step=0.0016)
    assert peaks.mean() == pytest.approx(refined.mean(), rel=tolerance)
    assert np.all(peaks >= seen)


def test_without_loss_the_peaks_of_snaps_are_bound_by_step_and_mesh():
    """Waves in the cable never die away, and the peak has no limit: it is only near that of the refined run."""
    peaks, seen = snapping(300.0, 3.0, 5.0, damped=False)
    refined, _ = snapping(300.0, 3.0, 5.0, damped=False, segments=100, time_step=0.0016)
    assert peaks.mean() == pytest.approx(refined.mean(), rel=0.07)
    assert peaks.max() > 1.01 * seen.max()  # a snap passes between two ticks


def test_snaps_with_the_loss_of_a_wire_do_not_depend_on_the_step_or_the_mesh():
    """900 m, 3 m at 14 s: slack and snap in every cycle; the peak of 2.1 times the static tension stays within
    1.5 %.
    """
    omega = 2.0 * math.pi / 14.0

    def run(segments, step):
        parameters = s900(segments, time_step=step)
        damping = DAMPING_TIME * parameters.cable.axial_stiffness
        cable = dataclasses.replace(parameters.cable, internal_damping=damping)
        return run_driven(
            dataclasses.replace(parameters, cable=cable),
            (0.0, 0.0, 3.0),
            omega,
            duration=250.0,
            window=112.0,
            ramp=60.0,
        )

    results = [run(*case) for case in ((100, 0.05), (100, 0.0125), (50, 0.05), (200, 0.05))]
    amplitudes = [r.unit_heave_amplitude for r in results]
    peaks = [r.tension_max for r in results]
    assert max(amplitudes) / min(amplitudes) == pytest.approx(1.0, abs=0.005)
    assert max(peaks) / min(peaks) == pytest.approx(1.0, abs=0.015)
