"""colcon's view of heave_devices; name, version, description and licence are in package.xml."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "cmake"))
from colcon_package import set_up

set_up(
    parts={
        "heave.commands": [
            "adapt = heave_devices.commands.adapt",
            "import = heave_devices.commands.import_sea",
        ],
        "heave.motion_sources": ["crane = heave_devices.crane.in_front:CRANE"],
    }
)
