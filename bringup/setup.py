"""colcon's view of heave_bringup; name, version, description and licence are in package.xml."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cmake"))
from colcon_package import set_up

set_up(scripts=["heave = heave_bringup.cli:main", "ship_clock = heave_bringup.external.ship_clock:main"])
