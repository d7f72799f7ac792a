"""What differs between releases of ROS 2, in one place: a change of release is a change of this file.

| what | Jazzy | Kilted, Lyrical | else |
|---|---|---|---|
| events executor | `rclpy.experimental` from 7.1.4 on | `rclpy.experimental` | `rclpy.executors`, or the default one |
| error of the middleware | `rclpy.impl` | `rclpy.impl` | RuntimeError, from which it derives |

Sources: changelogs of rclpy 7.1.4 (backport #1435), 9.0 and 10.0.
"""

from __future__ import annotations

import importlib
import os
from operator import attrgetter
from typing import Any


def first_of(*places: str) -> Any:
    """Return what is found first of `places`, "module:name" each. Raises ImportError where none is there."""
    for place in places:
        module, _, name = place.partition(":")
        try:
            return attrgetter(name)(importlib.import_module(module))
        except (ImportError, AttributeError):
            continue
    raise ImportError(f"this release of ROS 2 has none of {', '.join(places)}")


EventsExecutor: Any = first_of(
    "rclpy.experimental:EventsExecutor", "rclpy.executors:EventsExecutor", "rclpy.executors:SingleThreadedExecutor"
)
"""Executor of the spin loop; the default one, a third as fast, where a release has no events executor."""

RCLError: Any = first_of("rclpy.impl.implementation_singleton:rclpy_implementation.RCLError", "builtins:RuntimeError")
"""What rclpy raises where the middleware refuses."""

DISTRIBUTION = os.environ.get("ROS_DISTRO") or "kilted"
"""Release that runs: that of the sourced installation, or of the wheels."""
