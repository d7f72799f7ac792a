"""A run starts from where its unit is: hanging, landed, with cable along the bottom, half lifted, buoyant; at rest."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from cable_sim_node.errors import NoEquilibriumError, PlantError
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import (
    CableParameters,
    CableSimParameters,
    CompensatorParameters,
    SeabedParameters,
    UnitParameters,
)
from heave_node.numerics.kinematics import PointMotion
from heave_statics.reports.mooring import mooring_report

S300 = CableSimParameters(length=300.0, segments=20)
WEIGHT = S300.cable.weight_in_fluid(S300.water_density)
"""Weight of a metre of cable in water [N]."""
UNIT = S300.unit.weight_in_fluid(S300.water_density)
STIFFNESS = S300.cable.axial_stiffness


def started(depth: float, parameters: CableSimParameters = S300, **seabed: object) -> CableDynamics:
    plant = CableDynamics(dataclasses.replace(parameters, seabed=SeabedParameters(depth=depth, **seabed)))
    plant.start_at_equilibrium(np.zeros(3))
    return plant


def drift(plant: CableDynamics, seconds: float) -> float:
    """Return how far any node moves [m] while the boom tip stands still."""
    before, still = plant.node_positions, PointMotion()
    for _ in range(round(seconds / 0.5)):
        plant.advance(0.5, still, still, 0.0, 0.0, 0.0, 0.0)
    return float(np.abs(plant.node_positions - before).max())


@pytest.mark.parametrize("depth", [300.15, 300.3, 300.55])
def test_a_lift_that_has_begun_shares_the_weight_between_cable_and_seabed(depth: float) -> None:
    """The elastic bar: tension T at the unit stretches L by (T + w L/2) L/EA, and the ground gives way by (W - T)/k."""
    plant = started(depth)
    length, ground = S300.length, S300.seabed.unit_stiffness
    # T L/EA - (W - T)/k = depth - L - w L^2/(2 EA)
    gap = depth - length - WEIGHT * length**2 / (2.0 * STIFFNESS)
    tension = (gap + UNIT / ground) / (length / STIFFNESS + 1.0 / ground)
    assert 0.0 < tension < UNIT
    assert plant.touchdown_force == pytest.approx(UNIT - tension, rel=1e-6)
    assert plant.top_tension == pytest.approx(tension + WEIGHT * length, rel=1e-6)
    assert drift(plant, 60.0) < 1e-8


@pytest.mark.parametrize("bending", [0.0, 1e3])
def test_what_is_longer_than_the_way_down_lies_on_the_seabed(bending: float) -> None:
    """Still water: the top carries what hangs, to half a segment at the touchdown, and nothing pulls along."""
    cable = dataclasses.replace(S300.cable, bending_stiffness=bending)
    plant = started(250.0, dataclasses.replace(S300, cable=cable))
    assert plant.top_tension == pytest.approx(250.0 * WEIGHT, abs=0.5 * 15.0 * WEIGHT)
    assert plant.unit_position[0] == pytest.approx(50.0, abs=0.1 if bending == 0.0 else 5.0)
    # half of the lowest segment lies on the unit's node
    assert plant.touchdown_force == pytest.approx(UNIT + 0.5 * 15.0 * WEIGHT, rel=1e-4)
    assert drift(plant, 60.0) < 1e-7


def test_a_landed_unit_on_a_taut_cable_in_a_current_is_the_moored_one() -> None:
    """`heave static --mooring` of a cable held where the unit stands, which knows nothing of this solver."""
    parameters = dataclasses.replace(S300, current=(0.5, 0.0), segments=60)
    plant = started(299.5, parameters)
    x, _, z = plant.unit_position
    (held,) = mooring_report(parameters, -z, offsets=[-x]).rows
    assert plant.top_tension == pytest.approx(held.shape.top_tension, rel=3e-4)  # 60 segments
    assert abs(plant.top_force[0]) == pytest.approx(abs(held.pull), rel=3e-3)
    assert drift(plant, 60.0) < 1e-7


@pytest.mark.parametrize(
    ("slope", "friction", "current"), [((0.2, 0.1), 0.5, (0.0, 0.0)), ((0.6, 0.0), 0.3, (0.3, 0.2))]
)
def test_on_a_slope_it_rests_where_friction_and_cable_hold_it(
    slope: tuple[float, float], friction: float, current: tuple[float, float]
) -> None:
    plant = started(280.0, dataclasses.replace(S300, current=current), slope=slope, friction=friction)
    assert plant.is_on_seabed
    assert drift(plant, 60.0) < 1e-6


def test_a_buoyant_unit_floats_above_the_bight_of_its_cable() -> None:
    """Buoyancy B lifts B/w of cable below the unit: it floats 2 B/w above the cable's full length, less the stretch."""
    buoyant = dataclasses.replace(S300.unit, volume=3.2)
    plant = CableDynamics(dataclasses.replace(S300, unit=buoyant))
    plant.start_at_equilibrium(np.zeros(3))
    lift = -buoyant.weight_in_fluid(S300.water_density)
    assert plant.unit_position[2] == pytest.approx(-300.0 + 2.0 * lift / WEIGHT, abs=15.0)  # the bight is at a node
    assert plant.top_tension == pytest.approx(300.0 * WEIGHT - lift, rel=1e-9)
    assert drift(plant, 60.0) < 1e-9


def test_a_unit_that_would_float_up_is_refused_with_the_reason() -> None:
    plant = CableDynamics(dataclasses.replace(S300, unit=UnitParameters(volume=4.0)))
    with pytest.raises(NoEquilibriumError, match="does not hang"):
        plant.start_at_equilibrium(np.zeros(3))


def test_a_compensator_takes_what_a_landed_unit_leaves_on_the_cable() -> None:
    spring = CompensatorParameters(stiffness=2e4)
    plant = started(300.3, dataclasses.replace(S300, compensator=spring))
    assert drift(plant, 30.0) < 1e-6
    weak = dataclasses.replace(S300, compensator=dataclasses.replace(spring, preload=1e3))
    with pytest.raises(PlantError, match="into the seabed"):
        started(300.3, weak)


def test_strain_is_that_of_the_top_segment_under_all_the_weight() -> None:
    soft = dataclasses.replace(S300, cable=CableParameters(axial_stiffness=2e5))
    plant = CableDynamics(soft)
    plant.start_at_equilibrium(np.zeros(3))
    below = UNIT + WEIGHT * (300.0 - 0.5 * 15.0)  # the top segment carries what hangs below its middle
    assert plant.largest_strain == pytest.approx(below / 2e5, rel=1e-9)
