"""Sea state to boom-tip motion, and what the motion reference unit reports of it.

Importing this package loads nothing else: a name of its face is loaded on first use. Every module but `node`
is pure (no ROS).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from heave_node.faces import lazy_face

if TYPE_CHECKING:
    from wave_vessel_node.component import WaveVessel
    from wave_vessel_node.parameters import WaveVesselParameters

__all__ = ["WaveVessel", "WaveVesselParameters"]
__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "WaveVessel": "component",
        "WaveVesselParameters": "parameters",
    },
)
