"""How far the peaks of the tension stay below those of a Gaussian signal, by runs of the plant.

Quadratic drag holds the highest waves of a resonance down: the standard deviation of the linear model is right, its
peaks are not. The kurtosis of the tension gives the difference (`figures.expected_largest`), and settles in records
that are far too short for their largest value.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from cable_sim_node.line.dynamics import CableDynamics
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion
from heave_node.numerics.randomness import random_stream

from heave_bringup.lift.figures import GAUSSIAN
from heave_bringup.lift.response import OMEGAS, PhaseScene

RECORD, RECORDS = 600.0, 4
"""Longest record [s], and their number."""
SETTLE = 60.0
"""Time of a record that does not count [s]."""
STEP = 0.1
"""From one motion of the boom tip to the next [s]."""
SEGMENTS = 8
LARGEST_CHANGE = 0.1
"""Share by which the cable may get longer in a record."""


def kurtosis(scene: PhaseScene, length: float, height: float) -> float:
    """Return the kurtosis of the top tension with the winch locked on its mean speed, at most that of a Gaussian.

    Parameters
    ----------
    scene : of the phase
    length : of cable out in the middle of the records [m]
    height : significant wave height [m]
    """
    rate = scene.phase.rate
    record = min(RECORD, max(LARGEST_CHANGE * length / max(abs(rate), 1e-9), 3.0 * SETTLE))
    moments = np.array([_moments(scene, length, rate, height, record, seed) for seed in range(1, RECORDS + 1)])
    second, fourth = moments.mean(axis=0)
    return float(min(fourth / second**2, GAUSSIAN)) if second > 0.0 else GAUSSIAN


def _moments(
    scene: PhaseScene, length: float, rate: float, height: float, record: float, seed: int
) -> tuple[float, float]:
    """Return the second and fourth moments of the tension of one record about its trend."""
    plant = scene.plant
    still = replace(
        plant, length=length - 0.5 * rate * record, segments=SEGMENTS, seabed=replace(plant.seabed, depth=0.0)
    )
    dynamics = CableDynamics(still)
    mean = np.array([0.0, 0.0, plant.boom_tip_height])
    dynamics.start_at_equilibrium(mean, 0.0)
    time = np.asarray(STEP * np.arange(round(record / STEP) + 1), dtype=np.float64)
    heave, speed = _heave(scene, height, time, seed)
    up = np.array([0.0, 0.0, 1.0])
    tips = [PointMotion(t, mean + z * up, v * up) for t, z, v in zip(time, heave, speed, strict=True)]
    tension = np.empty(time.size - 1)
    for k in range(time.size - 1):
        dynamics.advance(STEP, tips[k], tips[k + 1], rate * time[k], rate, rate * time[k + 1], rate)
        tension[k] = dynamics.top_tension
    counted = tension[round(SETTLE / STEP) :]
    place = np.arange(counted.size)
    swing = counted - np.polyval(np.polyfit(place, counted, 1), place)
    return float(np.mean(swing**2)), float(np.mean(swing**4))


def _heave(scene: PhaseScene, height: float, time: Array, seed: int) -> tuple[Array, Array]:
    """Return heave and heave rate of the boom tip: components at random places of their bands, so that none repeats."""
    random = random_stream(seed, "lift/peaks")
    step = OMEGAS[1] - OMEGAS[0]
    omega = OMEGAS + step * (random.random(OMEGAS.size) - 0.5)
    amplitude = height * np.sqrt(2.0 * scene.density * step)
    angle = np.outer(time, omega) + 2.0 * np.pi * random.random(OMEGAS.size)
    ramp = np.clip(time / (0.5 * SETTLE), 0.0, 1.0)
    smooth, slope = ramp**2 * (3.0 - 2.0 * ramp), 6.0 * ramp * (1.0 - ramp) / (0.5 * SETTLE)
    heave, rate = np.cos(angle) @ amplitude, -np.sin(angle) @ (omega * amplitude)
    return smooth * heave, smooth * rate + slope * heave
