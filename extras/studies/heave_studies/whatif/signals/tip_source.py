"""The boom tip of a record under any scale, delay and lever arm of its MRU."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from winch_controller_node.beliefs.corrections import Correction

from heave_studies.whatif.signals.record import SensorRecord, at_ticks
from heave_studies.whatif.signals.tip import HighPass, Tip, smoothed_tip

STEADY = 0.5
"""Time over which an attitude is averaged: no vessel rolls so fast [s]."""

TURNS = 1e-3
"""Standard deviation of a pitch from which on a lever arm matters [rad]."""


@dataclass(frozen=True)
class TipSource:
    """What the MRU has read of the boom tip, smoothed."""

    time: Array  # of each tick (n,) [s]
    plain: Tip  # boom tip under what is assumed of the MRU
    assumed: Correction  # of the MRU
    high_pass: HighPass  # that the MRU has
    pitch: Array  # of the vessel at each tick, about its mean (n,) [rad]
    pitch_rate: Array  # of the vessel at each tick (n,) [rad/s]

    @property
    def turns(self) -> bool:
        """Whether the vessel pitches so much that a wrong lever arm shows."""
        return float(np.std(self.pitch)) > TURNS

    def under(self, scale: float = 1.0, delay: float = 0.0, lever_arm: float = 0.0) -> Tip:
        """Return the boom tip under what is other than assumed.

        Parameters
        ----------
        scale : reading over truth [-]
        delay : of the readings [s]
        lever_arm : error of it, forward [m]
        """
        heave = self.plain.heave / scale + lever_arm * self.pitch
        rate = self.plain.rate / scale + lever_arm * self.pitch_rate
        if delay != 0.0:
            heave, rate = (np.interp(self.time + delay, self.time, one) for one in (heave, rate))
        return Tip(heave, rate, self.plain.sigma)


def tip_source(record: SensorRecord, assumed: Correction, high_pass: HighPass) -> TipSource:
    """Return what the MRU of a `record` says of the boom tip, with what is `assumed` of it and its `high_pass`."""
    time, _, pitch = record.attitude.T
    read = at_ticks(record, time - assumed.delay, pitch) if len(time) else np.zeros(record.ticks)
    half = max(1, round(0.5 * STEADY / record.tick_period))
    about = np.ones(2 * half + 1)
    mean = np.convolve(read - read.mean(), about, "same") / np.convolve(np.ones_like(read), about, "same")
    return TipSource(
        record.time,
        smoothed_tip(record, assumed, high_pass),
        assumed,
        high_pass,
        mean,
        np.gradient(mean, record.tick_period),
    )
