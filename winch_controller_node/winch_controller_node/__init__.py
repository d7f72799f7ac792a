"""The winch controller: models of the loop, estimation, control laws, design and its report.

Importing this package loads nothing else: a name of its face is loaded on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from heave_node.faces import lazy_face

if TYPE_CHECKING:
    from winch_controller_node.core.component import WinchController
    from winch_controller_node.design.design import design_controller
    from winch_controller_node.model.lqr import DesignError
    from winch_controller_node.node_parameters import WinchControllerParameters

__all__ = ["DesignError", "WinchController", "WinchControllerParameters", "design_controller"]
__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "DesignError": "model.lqr",
        "WinchController": "core.component",
        "WinchControllerParameters": "node_parameters",
        "design_controller": "design.design",
    },
)
