"""Recorder, replay, analysis and report of heave-compensation runs.

Importing this package loads nothing else: a name of its face is loaded on first use. Recording, playing and
substitution import rclpy; reading and analysing need no ROS.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from heave_node.faces import lazy_face

if TYPE_CHECKING:
    from heave_bags.analyse.read_run import read_run
    from heave_bags.errors import BagError
    from heave_bags.mcap.bag_writer import BagWriter
    from heave_bags.mcap.reader import Bag

__all__ = ["Bag", "BagError", "BagWriter", "read_run"]
__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "Bag": "mcap.reader",
        "BagError": "errors",
        "BagWriter": "mcap.bag_writer",
        "read_run": "analyse.read_run",
    },
)
