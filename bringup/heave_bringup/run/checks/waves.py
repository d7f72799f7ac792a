"""The sea on cable and unit, looked at before any node starts."""

from __future__ import annotations

from cable_sim_node.component import NO_COMPONENTS
from cable_sim_node.parameters import CableSimParameters
from heave_node.parameters import ParameterError
from wave_vessel_node.component import WaveVessel

from heave_bringup.scenarios import Scenario


def check_waves(scenario: Scenario) -> None:
    """Refuse a `scenario` whose sea is to act on cable and unit and has no components; it is not made for others.

    Raises ParameterError with the cause.
    """
    plant: CableSimParameters = scenario.parameters["cable_sim"]
    if plant.wave.source != "sea":
        return
    run = scenario.run
    sea = WaveVessel(scenario.parameters["wave_vessel"], seed=run.seed, tick_period=run.tick_period)
    if not len(sea.waves().frequency):
        raise ParameterError(f"{scenario.path}: cable_sim: {NO_COMPONENTS}")
