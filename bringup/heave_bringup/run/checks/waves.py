"""Sea, depth and boom tip, on which vessel and plant must agree, looked at before any node starts."""

from __future__ import annotations

import math

from cable_sim_node.component import NO_COMPONENTS
from cable_sim_node.node_parameters import CableSimNodeParameters
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.parameters import ParameterError
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.sea_registry import NEED_NO_PERIOD, SPECTRUM_FILE
from wave_vessel_node.source_registry import SOURCES

from heave_bringup.scenarios import Scenario

_HIGHEST_OF_DEPTH = 0.78
"""Largest height of a wave as a share of the depth in which it breaks (McCowan 1894; DNV-RP-C205, 3.4.6)."""


def check_waves(scenario: Scenario) -> list[str]:
    """Refuse a `scenario` whose sea cannot act on cable and unit, or whose boom tip stands at two heights.

    Returns what its depth makes of the waves, in words. Raises ParameterError with the cause.
    """
    plant: CableSimNodeParameters = scenario.parameters["cable_sim"]
    vessel: WaveVesselParameters = scenario.parameters["wave_vessel"]
    heights = (plant.boom_tip_height, vessel.boom_tip_height)
    if heights[0] != heights[1]:
        raise ParameterError(
            f"{scenario.path}: boom_tip_height is {heights[0]:g} m in cable_sim and {heights[1]:g} m in wave_vessel: "
            "set system.boom_tip_height, which both take"
        )
    if plant.wave.source == "sea":
        sea = WaveVessel(vessel, seed=scenario.run.seed, tick_period=scenario.run.tick_period)
        if not len(sea.waves().frequency):
            raise ParameterError(f"{scenario.path}: cable_sim: {NO_COMPONENTS}")
    return _of_depth(scenario, plant, vessel)


def _of_depth(scenario: Scenario, plant: CableSimNodeParameters, vessel: WaveVesselParameters) -> list[str]:
    """Refuse waves that break by the depth of the seabed; return that they feel it where they act on the unit."""
    depth, wave = plant.seabed.depth, plant.wave
    warnings: list[str] = []
    has_sea = SOURCES[vessel.boom_tip_source].has_sea and vessel.spectrum not in (SPECTRUM_FILE, *NEED_NO_PERIOD)
    seas = [("sea", vessel.significant_wave_height, vessel.peak_period)] if has_sea else []
    seas += [("regular", 2.0 * wave.amplitude, wave.period)] if wave.source == "regular" else []
    for source, height, period in seas if depth > 0.0 else ():
        if height > _HIGHEST_OF_DEPTH * depth:
            raise ParameterError(
                f"{scenario.path}: waves of {height:g} m break in seabed.depth = {depth:g} m: they are at most "
                f"{_HIGHEST_OF_DEPTH:g} of it"
            )
        length = STANDARD_GRAVITY * period**2 / (2.0 * math.pi)
        if wave.source == source and depth < 0.5 * length:
            warnings.append(
                f"cable_sim: the waves on cable and unit are those of deep water, but seabed.depth = {depth:g} m is "
                f"less than half of their length of {length:.3g} m"
            )
    return warnings
