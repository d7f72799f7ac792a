"""The plant: cable, subsea unit, seabed, current, the virtual winch, and the sensors on them.

Importing this package loads nothing else: a name of its face is loaded on first use. Every module but the
`node` modules is pure (no ROS).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from heave_node.faces import lazy_face

if TYPE_CHECKING:
    from cable_sim_node.component import CableSim
    from cable_sim_node.errors import PlantError
    from cable_sim_node.node_parameters import CableSimNodeParameters
    from cable_sim_node.winch.component import VirtualWinch
    from cable_sim_node.winch.parameters import WinchParameters

__all__ = ["CableSim", "CableSimNodeParameters", "PlantError", "VirtualWinch", "WinchParameters"]
__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "CableSim": "component",
        "CableSimNodeParameters": "node_parameters",
        "PlantError": "errors",
        "VirtualWinch": "winch.component",
        "WinchParameters": "winch.parameters",
    },
)
