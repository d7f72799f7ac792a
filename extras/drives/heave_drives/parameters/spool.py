"""Parameters of drum, rope and reeving."""

from __future__ import annotations

import math
from dataclasses import dataclass

from heave_node.parameters import Checked, parameter

LAYER_PITCH = 0.5 * math.sqrt(3.0)
"""Radius from layer to layer, in rope diameters: round rope in the grooves of the layer below."""


@dataclass(frozen=True)
class SpoolParameters(Checked):
    """Drum, rope and reeving."""

    drum_radius: float = parameter(0.5, "m", 0.01, 20.0, "Radius from the drum's axis to its surface.")
    rope_diameter: float = parameter(0.047, "m", 0.001, 0.5, "Diameter of the rope.")
    turns_per_layer: int = parameter(0, "", 0, 1000, "Turns of rope in a layer; 0: the radius does not change.")
    rope_at_zero: float = parameter(0.0, "m", 0.0, 50_000.0, "Rope on the drum at payout 0.")
    falls: int = parameter(1, "", 1, 32, "Falls of rope that carry the load (reeving).")

    def check_rope(self, payout_maximum: float) -> None:
        """Raise ValueError where `payout_maximum` [m] needs more rope than there is on the drum."""
        needed = self.falls * payout_maximum
        if self.turns_per_layer > 0 and needed > self.rope_at_zero:
            raise ValueError(
                f"payout_maximum = {payout_maximum:g} m with {self.falls} falls needs {needed:g} m of rope; "
                f"spool.rope_at_zero = {self.rope_at_zero:g} m"
            )

    def radius_of_layer(self, layer: int) -> float:
        """Return the radius of the rope's centre line in a layer [m], counted from 0."""
        return self.drum_radius + self.rope_diameter * (0.5 + LAYER_PITCH * layer)
