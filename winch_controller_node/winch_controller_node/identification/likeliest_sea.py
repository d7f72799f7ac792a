"""Which sea the readings tell: the last two minutes are estimated anew under each that may be there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from winch_controller_node.estimation.loop_estimation import SEA_SENSORS
from winch_controller_node.estimation.sea_adaptation import PossibleSeas, distance, neighbours, no_lower_while_it_grows
from winch_controller_node.identification.suspicions import SETTLING, Designer, likelihood
from winch_controller_node.model.estimator import RecordedTick
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import SeaModelParameters, VesselModelParameters

SHORTEST = 2.0 * SETTLING
"""A shorter record [s] does not tell one sea from another."""

WORTH, FARTHER = 10.0, 60.0
"""Another sea is believed where it makes the record likelier by a factor of exp(WORTH) at least, and of exp(FARTHER)
for each factor of e by which its periods differ from those believed at first: two minutes are some fifteen waves, by
chance of another period.
"""

REFINEMENTS = (1.2, 1.1)
"""Factors, up and down, by which the likeliest sea is then changed."""


def likeliest_sea(
    parameters: WinchControllerParameters,
    seas: PossibleSeas,
    record: Sequence[RecordedTick],
    design_for: Designer,
    tick_period: float,
) -> SeaModelParameters | None:
    """Return the sea that foresees a `record` best; None where that in force does about as well.

    Parameters
    ----------
    parameters : believed, but for the sea
    seas : that may be there
    record : of SEA_SENSORS; a short one tells nothing, and what the moments say is returned
    design_for : designs for parameters
    tick_period : [s]
    """
    # its scale and lever arm are known by the motion of the unit alone
    mru = replace(parameters.sensors.mru, scale_sigma=0.0, lever_arm_sigma=0.0)
    believed = replace(parameters, sensors=replace(parameters.sensors, use=SEA_SENSORS, mru=mru))

    def told(sea: SeaModelParameters) -> float:
        design = design_for(replace(believed, sea=sea), (1.0, 1.0))
        return likelihood(design, record, tick_period) - FARTHER * distance(sea, seas.believed)

    is_told = len(record) * tick_period >= SHORTEST
    found = _best(seas, told, parameters.vessel) if is_told else seas.stretched
    return None if found is None else no_lower_while_it_grows(found, seas)


def _best(
    seas: PossibleSeas, told: Callable[[SeaModelParameters], float], vessel: VesselModelParameters
) -> SeaModelParameters | None:
    """Return that of the `seas` and neighbours of which most is `told`; None: that in force does about as well."""

    def best_of(trials: Sequence[tuple[float, SeaModelParameters]]) -> tuple[float, SeaModelParameters]:
        return max(trials, key=lambda trial: trial[0])

    in_force = (told(seas.in_force), seas.in_force)
    best = best_of([in_force, *((told(sea), sea) for sea in seas.others)])
    for factor in REFINEMENTS:
        near = neighbours(best[1], factor, seas.seen, vessel)
        best = best_of([best, *((told(sea), sea) for sea in near)])
    return best[1] if best[0] > in_force[0] + WORTH else None
