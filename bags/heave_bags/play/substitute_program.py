"""The program that plays a bag in the place of a node, by name: naming it loads no ROS."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

SUBSTITUTE = "heave_bags.play.substitute_node"
"""Module that plays a bag in the place of a node."""

_BAG = "bag:="
"""Before the path of the bag among the arguments."""


def program(node: str, bag: Path) -> list[str]:
    """Return the module that plays `bag` in the place of `node`, and its arguments; more of ROS may follow."""
    return [
        *(SUBSTITUTE, node, "--ros-args"),
        *("-r", f"__node:={node}_from_bag"),  # the parameters of the node itself do not concern its substitute
        *("-p", f"{_BAG}{bag}"),
    ]


def bag_played(arguments: Sequence[str]) -> Path:
    """Return the bag that a `program` plays, by its module and arguments."""
    return Path(next(one.removeprefix(_BAG) for one in arguments if one.startswith(_BAG)))
