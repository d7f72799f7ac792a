"""Correction of a sensor's readings: core and adviser apply the same one."""

from __future__ import annotations

from typing import NamedTuple

from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.beliefs.quantities import DEPTH_SCALE, MRU_DELAY, MRU_OFFSET, MRU_SCALE
from winch_controller_node.node_parameters import WinchControllerParameters


class Correction(NamedTuple):
    """What a sensor reads is taken as (reading - offset) / scale at its stamp less delay; of a rate without the offset.

    Attributes
    ----------
    scale : reading over truth [-]
    offset : of a reading [in its unit]
    delay : of its stamp behind the truth [s]
    """

    scale: float = 1.0
    offset: float = 0.0
    delay: float = 0.0


AS_READ = Correction()
"""Nothing is corrected."""


def corrections(beliefs: Beliefs, nominal: WinchControllerParameters) -> dict[str, Correction]:
    """Return the corrections of MRU and depth sensor under `beliefs` about the `nominal`, not of the encoder."""
    return {
        "mru": Correction(
            beliefs.value(MRU_SCALE, nominal), beliefs.value(MRU_OFFSET, nominal), beliefs.value(MRU_DELAY, nominal)
        ),
        "depth": Correction(beliefs.value(DEPTH_SCALE, nominal)),
    }
