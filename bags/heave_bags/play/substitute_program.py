"""The program that plays a bag in the place of a node, by name: naming it loads no ROS."""

from __future__ import annotations

from pathlib import Path

SUBSTITUTE = "heave_bags.play.substitute_node"
"""Module that plays a bag in the place of a node."""


def program(node: str, bag: Path) -> list[str]:
    """Return the module that plays `bag` in the place of `node`, and its arguments; more of ROS may follow."""
    return [
        *(SUBSTITUTE, node, "--ros-args"),
        *("-r", f"__node:={node}_from_bag"),  # the parameters of the node itself do not concern its substitute
        *("-p", f"bag:={bag}"),
    ]
