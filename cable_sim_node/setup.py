"""colcon's view of cable_sim_node; name, version, description and licence are in package.xml."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cmake"))
from colcon_package import set_up

set_up(scripts=["cable_sim = cable_sim_node.node:main", "virtual_winch = cable_sim_node.winch_node:main"])
