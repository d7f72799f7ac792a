"""colcon's view of heave_drives; name, version, description and licence are in package.xml."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "cmake"))
from colcon_package import set_up

set_up(
    parts={
        "heave.drives": [
            "electric = heave_drives.registry:ELECTRIC",
            "pump_controlled = heave_drives.registry:PUMP_CONTROLLED",
            "valve_controlled = heave_drives.registry:VALVE_CONTROLLED",
        ],
        "heave.scenarios": ["drives = heave_drives"],
    }
)
