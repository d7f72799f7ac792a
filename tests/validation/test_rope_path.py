"""Compliance of boom and sheaves: a spring k2 above a cable of stiffness k1, against the closed forms of two in series.

The sources print none of it. Vacuum; the cable is light except where the elastic bar is the reference. Last, the loop
that friction of the sheaves gives the load cell in the plant.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.component import CableSim
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.parameters import (
    CableParameters,
    CableSimParameters,
    CompensatorParameters,
    RopePathParameters,
    SolverParameters,
    UnitParameters,
)
from cable_sim_node.sensors.instruments import LoadCellParameters, SensorsParameters
from heave_node.numerics.kinematics import PointMotion
from heave_node.parameters import ParameterError

from tests.validation.peers.driven_run import run_driven
from tests.validation.peers.reference_systems import s900

MASS, LENGTH, AXIAL = 3000.0, 300.0, 1.5e7
CABLE, BOOM = AXIAL / LENGTH, 1e5
SERIES = 1.0 / (1.0 / CABLE + 1.0 / BOOM)


def light_line(stiffness=BOOM, *, segments=5, **solver):
    return CableSimParameters(
        length=LENGTH,
        segments=segments,
        water_density=0.0,
        cable=CableParameters(mass_per_length=1e-3, axial_stiffness=AXIAL),
        unit=UnitParameters(mass=MASS, volume=0.0),
        rope_path=RopePathParameters(stiffness=stiffness),
        solver=SolverParameters(**solver),
    )


def rung(parameters, force, duration, tick=0.01):
    """Return the heave of a unit about its rest [m] and the give of the rope path [m] after a step of `force` [N]."""
    plant, still = CableDynamics(parameters), PointMotion()
    plant.start_at_equilibrium(np.zeros(3))
    rest, seen = plant.unit_position[2], []
    assert plant.node_positions[-1] == pytest.approx(np.zeros(3), abs=1e-12)
    plant.set_thrust([0.0, 0.0, force])
    for _ in range(round(duration / tick)):
        plant.advance(tick, still, still, 0.0, 0.0, 0.0, 0.0)
        seen.append((plant.unit_position[2] - rest, plant.node_positions[-1][2]))
    return np.array(seen).T


def test_boom_and_cable_are_springs_in_series():
    """1/k = 1/k1 + 1/k2 in what a force lifts, k2's share, and the period 2 pi sqrt(M/k): 1.885 s, not 1.539 s."""
    force, tick = 2000.0, 0.01
    heave, give = rung(light_line(spectral_radius=1.0, time_step=0.005), force, 60.0)
    assert heave.max() == pytest.approx(2.0 * force / SERIES, rel=2e-4)
    assert give.max() == pytest.approx(2.0 * force / BOOM, rel=2e-3)
    about = heave - force / SERIES
    up = np.flatnonzero((about[:-1] < 0.0) & (about[1:] >= 0.0))
    crossings = up + about[up] / (about[up] - about[up + 1])
    assert np.mean(np.diff(crossings)) * tick == pytest.approx(2.0 * math.pi * math.sqrt(MASS / SERIES), rel=2e-4)


def test_a_rigid_path_is_none_at_all():
    heave, _ = rung(light_line(1e12, spectral_radius=1.0, time_step=0.005), 2000.0, 5.0)
    none, _ = rung(light_line(0.0, spectral_radius=1.0, time_step=0.005), 2000.0, 5.0)
    assert heave == pytest.approx(none, abs=1e-6)


@pytest.mark.parametrize("period", [6.0, 12.0])
def test_a_long_line_under_a_soft_boom_is_the_elastic_bar_on_a_spring(period):
    """S900 in vacuum, boom of 500 kN/m: u_L = z k2/(k2 - D), D the bar's dynamic stiffness at its top (Rao, bars)."""
    boom, omega = 5e5, 2.0 * math.pi / period
    parameters = dataclasses.replace(
        s900(100),
        water_density=0.0,
        unit=UnitParameters(mass=125e3, volume=0.0, added_mass=(0.0,) * 3),
        rope_path=RopePathParameters(stiffness=boom),
    )
    ea, mass, length = parameters.cable.axial_stiffness, parameters.cable.mass_per_length, parameters.length
    found = run_driven(parameters, (0.0, 0.0, 0.2), omega, duration=600.0, window=120.0, ramp=400.0, tick=0.1)
    k = omega * math.sqrt(mass / ea)
    slope = 125e3 * omega**2 / (ea * k)
    up = math.cos(k * length) - slope * math.sin(k * length)
    pull = ea * k * (math.sin(k * length) + slope * math.cos(k * length)) / up
    top = boom / (boom - pull)
    assert abs(top - 1.0) > 0.03
    assert found.unit_heave_amplitude == pytest.approx(0.2 * abs(top / up), rel=2e-3)
    assert found.tension_amplitude == pytest.approx(0.2 * abs(top * pull), rel=2e-3)


def test_a_snap_under_a_soft_boom_has_the_energy_of_both_springs():
    """W + sqrt(W^2 + 2 k KE) with k of the two in series."""
    parameters = light_line(time_step=0.005)
    plant, still, tensions, slack = CableDynamics(parameters), PointMotion(), [], 0
    plant.start_at_equilibrium(np.zeros(3))
    weight = MASS * parameters.gravity
    slack_at = plant.unit_position[2] + weight / SERIES
    plant.set_thrust([0.0, 0.0, 3.0 * weight])
    for step in range(600):
        if step == 80:
            plant.set_thrust(np.zeros(3))
            above, speed = plant.unit_position[2] - slack_at, plant.unit_velocity[2]
        plant.advance(0.01, still, still, 0.0, 0.0, 0.0, 0.0)
        tensions.append(plant.largest_top_tension)
        slack += plant.slack_segments > 0
    kinetic = 0.5 * MASS * speed**2 + weight * above
    assert slack > 50
    assert max(tensions[80:]) == pytest.approx(weight + math.sqrt(weight**2 + 2.0 * SERIES * kinetic), rel=0.01)


def test_a_compensator_and_a_rope_path_that_gives_are_not_both_the_spring():
    with pytest.raises((ValueError, ParameterError), match="both a spring under the boom tip"):
        dataclasses.replace(light_line(), compensator=CompensatorParameters(stiffness=1e3))


@pytest.mark.parametrize("amplitude", [0.02, 0.2])
def test_the_load_cell_has_the_loop_of_the_friction_over_payout(gallery, amplitude):
    """A slow drum, 300 m system: H (2 a - H/k) a cycle, H = 2 T sinh f; 0.2 m of cable weighs 7 N of 36.5 kN."""
    friction, stiffness, period, tick = 0.05, 2e6, 120.0, 0.05
    sensors = dataclasses.replace(SensorsParameters(), load_cell=LoadCellParameters(noise=0.0))
    path = RopePathParameters(friction=friction, stiffness=stiffness)
    plant = CableSim(CableSimNodeParameters(segments=10, rope_path=path, sensors=sensors), seed=1, tick_period=tick)
    payouts, read, pulls, omega = [], [], [], 2.0 * math.pi / period
    for k in range(1, round(2.5 * period / tick) + 1):
        state, delivered = plant.readings(k)
        payouts.append(plant.payout.position[0])
        read.append(delivered["load_cell"][-1].value[0])
        pulls.append(state.top_tension)
        t = k * tick
        rise = min(t / (0.25 * period), 1.0)
        angle = omega * t
        payout = (amplitude * rise * math.sin(angle), amplitude * rise * omega * math.cos(angle))
        if rise < 1.0:
            payout = (payout[0], payout[1] + amplitude / (0.25 * period) * math.sin(angle))
        plant.advance(k, PointMotion((k + 1) * tick), payout)
    last = slice(-round(period / tick) - 1, None)

    def draw(figure):
        axes = figure.subplots()
        axes.plot(np.array(payouts[last]), np.array(pulls[last]) / 1e3, label="top tension")
        axes.plot(np.array(payouts[last]), np.array(read[last]) / 1e3, label="load cell, f = 0.05")
        axes.set_xlabel("payout [m]")
        axes.set_ylabel("tension [kN]")
        axes.legend()

    gallery(
        f"load_cell_loop_{round(1e3 * amplitude)}_mm", "Load cell behind sheaves while the drum goes to and fro.", draw
    )
    height = 2.0 * float(np.mean(pulls[last])) * math.sinh(friction)
    area = -float(np.trapezoid(read[last], payouts[last]))
    assert area == pytest.approx(height * (2.0 * amplitude - height / stiffness), rel=0.01)
