"""The axial model and the three-dimensional solver, written apart, on the same vertical problems."""

import dataclasses

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, ClumpsParameters, SectionsParameters
from cable_sim_node.vertical.axial import simulate_axial
from cable_sim_node.vertical.axial_line import axial_line
from heave_node.numerics.kinematics import PointMotion

PERIOD = 0.05
S300 = CableSimParameters(segments=30)
SECTIONED = dataclasses.replace(
    S300,
    sections=SectionsParameters((60.0,), (0.06,), (0.0,), (9.0,), (8e6,)),
    clumps=ClumpsParameters((150.0,), (800.0,), (0.2,), (0.0,), (0.5,)),
)


def smooth(time, duration):
    share = np.clip(time / duration, 0.0, 1.0)
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def run_dynamics(parameters, heave, payout):
    """Return unit heave [m] and top tension [N] at every sample."""
    cable = CableDynamics(
        dataclasses.replace(parameters, solver=dataclasses.replace(parameters.solver, time_step=0.01))
    )
    cable.start_at_equilibrium(np.array([0.0, 0.0, heave[0]]))
    rate, feed = np.gradient(heave, PERIOD), np.gradient(payout, PERIOD)
    start = cable.unit_position[2] - heave[0]
    unit, tension = [cable.unit_position[2] - start], [cable.top_tension]
    motions = [
        PointMotion(k * PERIOD, np.array([0.0, 0.0, z]), np.array([0.0, 0.0, v]))
        for k, (z, v) in enumerate(zip(heave, rate, strict=True))
    ]
    for k in range(len(heave) - 1):
        cable.advance(PERIOD, motions[k], motions[k + 1], payout[k], feed[k], payout[k + 1], feed[k + 1])
        unit.append(cable.unit_position[2] - start)
        tension.append(cable.top_tension)
    return np.array(unit), np.array(tension)


TIME = np.arange(0.0, 60.0, PERIOD)
HEAVE = {
    "none": np.zeros_like(TIME),
    "regular": smooth(TIME, 15.0) * np.sin(1.256 * TIME),
    "two waves": smooth(TIME, 15.0) * (0.7 * np.sin(0.7 * TIME) + 0.4 * np.sin(1.6 * TIME + 1.0)),
}
PAYOUT = {
    "locked": np.zeros_like(TIME),
    "steady": 1.0 * (TIME - 5.0 * smooth(TIME, 10.0)) * smooth(TIME, 10.0),
    "periodic": 2.0 * smooth(TIME, 10.0) * np.sin(0.5 * TIME),
    "hauled in": -1.5 * TIME * smooth(TIME, 10.0),
}
CASES = [
    (S300, "regular", "locked"),
    (S300, "two waves", "steady"),
    (S300, "none", "periodic"),
    (S300, "two waves", "hauled in"),
    (SECTIONED, "regular", "steady"),
]


@pytest.mark.parametrize(
    ("parameters", "heave", "payout"), CASES, ids=["locked", "steady", "periodic", "in", "sections"]
)
def test_axial_and_three_dimensional_solver_agree(parameters, heave, payout):
    axial = simulate_axial(
        axial_line(parameters),
        parameters.length,
        HEAVE[heave],
        PERIOD,
        payout=PAYOUT[payout],
        segments=60,
        largest_step=0.005,
    )
    unit, tension = run_dynamics(parameters, HEAVE[heave], PAYOUT[payout])

    moved = max(np.ptp(axial.unit_heave + PAYOUT[payout]), 0.05)
    # both start alike; the axial run moves with its first sample's speed, which is nothing here
    assert unit == pytest.approx(axial.unit_heave, abs=1e-4 * moved)
    swing = np.ptp(axial.top_tension)
    assert np.sqrt(np.mean((tension - axial.top_tension) ** 2)) < 6e-4 * swing


STIFFENING = dataclasses.replace(
    S300, cable=CableParameters(axial_stiffness=2e6, stiffness_quadratic=20.0, stiffness_cubic=300.0)
)


# of the stiffening cable the bar knows one slope, half-way up; the line knows the slope at every segment
