"""colcon's view of heave_studies; name, version, description and licence are in package.xml."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "cmake"))
from colcon_package import set_up

set_up(
    parts={
        "heave.commands": [
            "identify = heave_studies.commands.identify",
            "qualify = heave_studies.commands.qualify",
            "study = heave_studies.commands.study",
            "whatif = heave_studies.commands.whatif",
        ],
        "heave.record_extras": [
            "kappa = heave_studies.kappa:add_to_record",
            "baseline = heave_studies.baseline:add_to_record",
        ],
    }
)
