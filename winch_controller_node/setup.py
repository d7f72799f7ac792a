"""colcon's view of winch_controller_node; name, version, description and licence are in package.xml."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cmake"))
from colcon_package import set_up

set_up(
    scripts=[
        "winch_controller = winch_controller_node.node:main",
        "winch_adviser = winch_controller_node.adviser_node:main",
        "winch_envelope = winch_controller_node.envelope_node:main",
    ]
)
