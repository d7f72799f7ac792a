"""All nodes of a run in one process: `python -m heave_bringup.run.composed NODE ... [--publish] --ros-args ...`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from heave_node.ros.process import run_composed
from heave_node.ros.transport.parents_death import exit_at_once

from heave_bringup.nodes import PROCESS_BY_NAME

PUBLISH = "--publish"


def program(names: Sequence[str], *, is_public: bool) -> list[str]:
    """Return the module, and its arguments up to those of ROS, that runs the nodes of these `names` in one process.

    `is_public` says that other processes get every message.
    """
    return ["heave_bringup.run.composed", *names, *([PUBLISH] if is_public else [])]


def main() -> None:
    """Run the nodes until their run ends."""
    ros = sys.argv.index("--ros-args")
    own = sys.argv[1:ros]
    nodes = [PROCESS_BY_NAME[name].node_type() for name in own if name != PUBLISH]
    exit_at_once(run_composed(nodes, [sys.argv[0], *sys.argv[ros:]], is_public=PUBLISH in own))


if __name__ == "__main__":
    main()
