"""How high a unit hangs above the seabed."""

from __future__ import annotations

from heave_node.numerics.arrays import Array

from cable_sim_node.errors import StaticsError
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.seabed import Seabed


def clearance_of(parameters: CableSimParameters, unit: Array) -> float | None:
    """Return the height [m] of a `unit` at x, y, z [m] above the seabed of the `parameters`, None where there is none.

    Raises StaticsError for a unit below the seabed.
    """
    seabed = parameters.seabed
    if not seabed.depth > 0.0:
        return None
    clearance = Seabed(seabed).clearance(unit)
    if clearance < 0.0:
        raise StaticsError(
            f"the unit would hang {-clearance:.3g} m below the seabed: reduce length ({parameters.length:g} m) "
            f"or increase seabed.depth ({seabed.depth:g} m)"
        )
    return clearance
