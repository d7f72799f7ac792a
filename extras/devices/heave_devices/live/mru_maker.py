"""Samples of a motion sensor put together to what the suite calls `mru`: one for each heave that comes."""

from __future__ import annotations

import math

from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import MruReading

from heave_devices.live.taker import Recent, Taken
from heave_devices.live.tip_motion import TipMotion
from heave_devices.maps.device_map import DeviceMap

_BESIDE = ("heave_rate", "heave_acceleration", "roll", "pitch", "roll_rate", "pitch_rate")


class MruMaker:
    """Makes readings of the boom tip.

    Parameters
    ----------
    device : the map
    """

    def __init__(self, device: DeviceMap) -> None:
        self._tip = TipMotion(device.lever_arm)
        self._has_arm = any(device.lever_arm)
        self._recent = Recent(_BESIDE, device.timeout)
        self._sigma = {name: channel.sigma for name, channel in device.channels.items()}
        self.sequence = 0

    def take(self, taken: Taken) -> MruReading | None:
        """Return the reading that a sample, `taken`, completes; None where it holds no heave, nor calls it invalid."""
        time = taken.time
        beside = self._recent.take(taken)
        if not taken.has_any(["heave"]):
            return None
        self.sequence += 1
        roll, pitch = beside["roll"], beside["pitch"]
        turning = (beside["roll_rate"], beside["pitch_rate"])
        heave = taken.values.get("heave", math.nan)
        heave, rate = self._tip.carry(time, heave, beside["heave_rate"], (roll, pitch), turning)
        is_known = math.isfinite(heave)
        return MruReading(
            time,
            heave,
            rate,
            roll if math.isfinite(roll) else 0.0,
            pitch if math.isfinite(pitch) else 0.0,
            int(taken.status if is_known else MruStatus.INVALID),
            self.sequence,
            math.nan if self._has_arm else beside["heave_acceleration"],
            self._sigma.get("heave", math.nan),
            self._sigma.get("heave_rate", math.nan),
        )
