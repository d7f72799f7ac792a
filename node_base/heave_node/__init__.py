"""What every heave node shares: parameters, tick protocol, lifecycle, diagnostics, topics.

Importing this package does not import rclpy, and loads a name of its face only when it is asked for. All of it but the
wing `ros` is pure, so that components and design tools can use it without ROS.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from heave_node.faces import lazy_face

if TYPE_CHECKING:
    from heave_node.numerics.kinematics import PointMotion
    from heave_node.parameters import ParameterError, build_parameters, describe, group, parameter
    from heave_node.run_parameters import RunParameters

__all__ = ["ParameterError", "PointMotion", "RunParameters", "build_parameters", "describe", "group", "parameter"]
__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "ParameterError": "parameters",
        "PointMotion": "numerics.kinematics",
        "RunParameters": "run_parameters",
        "build_parameters": "parameters",
        "describe": "parameters",
        "group": "parameters",
        "parameter": "parameters",
    },
)
