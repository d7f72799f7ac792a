"""What every heave node shares: parameters, tick protocol, lifecycle, diagnostics, topics.

Importing this package does not import rclpy, and loads a name of its face only when it is asked for. All of it but the
wing `ros` is pure, so that components and design tools can use it without ROS.

Numpy and scipy compute on one thread where this package is imported before them and OPENBLAS_NUM_THREADS is not set:
the matrices of a tick have at most some forty rows, and threads that wait for one another take ten times as long.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from heave_node.faces import lazy_face

if TYPE_CHECKING:
    from heave_node.numerics.kinematics import PointMotion
    from heave_node.parameters import ParameterError, build_parameters, describe, group, parameter
    from heave_node.run_parameters import RunParameters

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__all__ = ["ParameterError", "PointMotion", "RunParameters", "build_parameters", "describe", "group", "parameter"]
__getattr__, __dir__ = lazy_face(
    __name__,
    {
        **dict.fromkeys(("ParameterError", "build_parameters", "describe", "group", "parameter"), "parameters"),
        "PointMotion": "numerics.kinematics",
        "RunParameters": "run_parameters",
    },
)
