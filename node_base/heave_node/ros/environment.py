"""The process environment that the middleware needs; one definition for nodes, tests and tools."""

from __future__ import annotations

import os
import sys
from importlib import resources


def prepare_environment() -> None:
    """Set what the user has not set: ament's prefix, discovery on this machine only, and quick discovery.

    Must run before `rclpy.init`. With ROS 2 from wheels the ament index lies in the Python environment; on a sourced
    ROS 2 installation nothing changes but
    the discovery settings.
    """
    os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    # Announcements until all have started: a process finds the others within a tenth of a second.
    profile = resources.files("heave_node") / "fastdds_profile.xml"
    os.environ.setdefault("FASTDDS_DEFAULT_PROFILES_FILE", str(profile))
