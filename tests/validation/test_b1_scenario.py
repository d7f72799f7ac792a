"""The shipped scenario b1_thesis, sea, vessel and plant as components, gives the thesis's uncontrolled motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_sim_node.component import CableSim
from heave_bringup.scenarios import load_scenario
from scipy import stats
from wave_vessel_node.component import WaveVessel


@pytest.mark.slow
def test_uncontrolled_sigma_is_that_of_the_lyapunov_equation_within_its_confidence_interval() -> None:
    """Expected: 0.2551 m, the Lyapunov equation of thesis 6.3.6 with white noise of intensity pi (printed: 0.255 m)."""
    scenario = load_scenario("b1_thesis")
    tick_period, seed = scenario.run.tick_period, scenario.run.seed
    sea = WaveVessel(scenario.parameters["wave_vessel"], seed=seed, tick_period=tick_period)
    plant = CableSim(scenario.parameters["cable_sim"], seed=seed, tick_period=tick_period)
    ticks = round(scenario.run.duration / tick_period)
    heave = np.empty(ticks)
    for tick in range(1, ticks + 1):
        heave[tick - 1] = plant.state().unit.position[2]
        plant.advance(tick, sea.step(tick).boom_tip, (0.0, 0.0))
    heave = heave[round(scenario.run.transient / tick_period) :]
    # Blocks of nearly five minutes, long against the memory of the system: their variances are independent.
    variances = np.array([block.var() for block in np.array_split(heave - heave.mean(), 12)])
    low, high = stats.t.interval(0.999, len(variances) - 1, variances.mean(), stats.sem(variances))
    assert low < 0.2551**2 < high
    assert math.sqrt(high) - math.sqrt(low) < 0.15, "an interval that says something"
