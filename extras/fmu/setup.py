"""colcon's view of heave_fmu; name, version, description and licence are in package.xml."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "cmake"))
from colcon_package import set_up

set_up(
    parts={
        "heave.commands": [
            "fmu = heave_fmu.commands.fmu",
        ],
        "heave.replacements": [
            "fmu = heave_fmu.drive:program",
        ],
    }
)
