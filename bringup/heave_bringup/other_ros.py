"""Another ROS on PYTHONPATH, as a sourced /opt/ros leaves it: it hides the one that the suite was installed with."""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from pathlib import Path


def leave_out_other_ros(environment: MutableMapping[str, str], path: list[str]) -> str:
    """Take folders with another ROS off PYTHONPATH and `path`; return in words which, "" where there is none.

    Where the suite has no ROS but that of PYTHONPATH, as built by colcon, that one stays.

    Parameters
    ----------
    environment : of this process, and of those that it starts
    path : where modules are looked for, in place
    """
    given = [folder for folder in environment.get("PYTHONPATH", "").split(os.pathsep) if folder]
    others = [folder for folder in given if _has_ros(folder)]
    if not others or not any(_has_ros(folder) for folder in path if folder and folder not in given):
        return ""
    environment["PYTHONPATH"] = os.pathsep.join(folder for folder in given if folder not in others)
    path[:] = [folder for folder in path if folder not in others]
    return f"PYTHONPATH names another ROS, {', '.join(others)}: left out, for it hides the one of this installation"


def _has_ros(folder: str) -> bool:
    return (Path(folder) / "rclpy").is_dir()
