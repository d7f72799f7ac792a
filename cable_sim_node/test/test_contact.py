"""The seabed: what stands on it rests for good or slides as Coulomb says."""

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SeabedParameters, UnitParameters
from heave_node.numerics.kinematics import PointMotion

STILL = PointMotion()
TICK = 0.05
FRICTION = 0.5


def landed(slope=(0.0, 0.0), *, thrust=(0.0, 0.0, 0.0), density=1025.0, out=16.0, **unit):
    """Return a unit on the seabed below a light cable that hangs slack above it, 30 s after it was lowered."""
    plant = CableDynamics(
        CableSimParameters(
            length=100.0,
            segments=20,
            water_density=density,
            cable=CableParameters(mass_per_length=0.05, diameter=0.004, axial_stiffness=1e6),
            unit=UnitParameters(**unit),
            seabed=SeabedParameters(depth=110.0, slope=slope, friction=FRICTION),
        )
    )
    plant.start_at_equilibrium(np.zeros(3))
    payout, last = 0.0, 0.0
    for k in range(round((2.0 * out + 30.0) / TICK)):
        s = min((k + 1) * TICK / (2.0 * out), 1.0)
        after, rate = out * s * s * (3.0 - 2.0 * s), 3.0 * s * (1.0 - s)
        plant.advance(TICK, STILL, STILL, payout, last, after, rate)
        payout, last = after, rate
    plant.set_thrust(thrust)
    return plant


def rest(plant, seconds):
    payout = plant.unstretched_length - plant.parameters.length
    for _ in range(round(seconds / TICK)):
        plant.advance(TICK, STILL, STILL, payout, 0.0, payout, 0.0)


def test_a_unit_on_a_slope_that_friction_holds_is_at_rest_for_good():
    """Coulomb: it stands while the slope is below mu. In two minutes it moves by no more than rounding."""
    plant = landed((0.2, 0.1))
    assert plant.touchdown
    start = plant.unit_position
    rest(plant, 120.0)
    assert plant.unit_position == pytest.approx(start, abs=1e-9)
    assert np.abs(plant.unit_velocity).max() < 1e-9


@pytest.mark.parametrize("share", [0.8, 1.02])
def test_a_push_below_the_coulomb_force_is_held_and_one_above_it_moves_the_unit_off(share):
    """Below mu N, by more than a sudden push overshoots: F/k, and back when it ends.

    Above: x'' = (F - mu N)/M, exact for a unit without drag.
    """
    plant = landed(drag_coefficient=(0.0,) * 3)
    weight = plant.touchdown_force
    start = plant.unit_position
    push = share * FRICTION * weight
    plant.set_thrust((push, 0.0, 0.0))
    rest(plant, 5.0)
    moved = plant.unit_position - start
    if share < 1.0:
        assert moved[0] == pytest.approx(push / SeabedParameters().unit_stiffness, rel=0.01)
        plant.set_thrust((0.0, 0.0, 0.0))
        rest(plant, 5.0)
        assert plant.unit_position[0] == pytest.approx(start[0], abs=1e-4)
        return
    early, speed = moved[0], plant.unit_velocity[0]
    rest(plant, 5.0)
    acceleration = (push - FRICTION * weight) / 6000.0
    assert plant.unit_velocity[0] - speed == pytest.approx(5.0 * acceleration, rel=0.02)
    assert plant.unit_position[0] - start[0] - early == pytest.approx(5.0 * speed + 12.5 * acceleration, rel=0.02)
