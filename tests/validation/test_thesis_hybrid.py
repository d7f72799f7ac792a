"""Thesis 6.1.4: a passive spring-like compensator in series with the active winch, as scenario hybrid_900.

"The passive component compensates a part of the heave motion and boosts the system's reliability while the active
system removes the residual effect of the heave motion."
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario
from winch_controller_node.design.design import assumed_cable


def test_the_controller_believes_the_springs_in_series() -> None:
    parameters = load_scenario("hybrid_900").parameters
    spring, plant = parameters["cable_sim"].compensator, parameters["cable_sim"]
    both = 1.0 / (plant.length / plant.cable.axial_stiffness + 1.0 / spring.stiffness)
    assumed = assumed_cable(parameters["winch_controller"], plant.length)
    assert assumed.stiffness == pytest.approx(both, rel=1e-3)
    inertia = plant.unit.mass + plant.unit.added_mass[2] + plant.length * plant.cable.mass_per_length / 3.0
    assert assumed.a == pytest.approx(inertia / both, rel=0.15)
    # "its performance becomes poorer when the period of the boom tip motion increases"
    omega = 2.0 * math.pi / np.array([6.0, 10.0, 14.0, 18.0])
    share = np.abs(1.0 / (1.0 - assumed.a * omega**2 + 1j * assumed.b * omega))
    assert np.all(np.diff(share) > 0.0)
    assert share[0] < 0.05
    assert share[-1] > 0.2


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_the_passive_part_takes_most_of_the_heave_and_the_winch_the_rest() -> None:
    hybrid, active = run("hybrid_900"), run("b3_deep_900")
    after = 100.0
    nothing, passive = (float(record.column("uncompensated", after=after).std()) for record in (active, hybrid))
    assert passive < 0.12 * nothing, "what remains when the winch fails"
    assert hybrid.unit_sigma(after) < 0.2 * passive
    assert hybrid.unit_sigma(after) < active.unit_sigma(after)
    assert hybrid.column("payout_rate", after=after).std() < active.column("payout_rate", after=after).std()


def run(name: str) -> LoopRecord:
    """Run a scenario for four minutes on ten segments; both have the same sea."""
    scenario = load_scenario(name, settings=("cable_sim.segments=10",))
    return ClosedLoop(replace(loop_parameters(scenario), duration=240.0)).run()
