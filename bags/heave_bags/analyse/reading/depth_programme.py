"""Heave while the unit is lowered or raised: what is left when the programme of depth is taken out of a run's
signals.
"""

from __future__ import annotations

import numpy as np
import scipy

from heave_bags.signals import RunSignals, Signal

MOVED = 0.1
"""A set-point that moves less than this is no programme [m]."""
SPAN = 60.0
"""Length of the running mean [s], applied twice: waves up to 20 s pass to better than 3 %."""


def take_out_programme(signals: RunSignals, set_point: Signal, cable_weight: float = 0.0) -> bool:
    """Take the programme, and the slow change of stretch that goes with it, out of the heave and payout signals.

    `set_point` is the payout that compensation works about [m]. Payout is counted from it; the heave of the
    unit and of the uncompensated unit from their running mean; the static tension goes with the `cable_weight` [N/m]
    in water of what is paid out. Returns whether there was a programme; without one nothing changes.
    """
    if not has_programme(set_point.value):
        return False
    if signals.payout.size:
        signals.payout = Signal(signals.payout.time, signals.payout.value - set_point.at(signals.payout))
    if signals.static_tension.size:
        static = signals.static_tension.value[0] + cable_weight * (set_point.value - set_point.value[0])
        signals.static_tension = Signal(set_point.time, static)
    for name in ("unit_heave", "uncompensated_heave"):
        heave: Signal = getattr(signals, name)
        if heave.size > 1:
            follows = _moved(heave) > 0.5 * np.ptp(set_point.value)
            straight = heave.value + set_point.at(heave) if follows else heave.value
            setattr(signals, name, Signal(heave.time, straight - running_mean(heave.time, straight)))
    return True


def has_programme(set_point: np.ndarray) -> bool:
    """Return whether a `set_point` of payout [m], shape (n,), moves so much that it is taken out."""
    return set_point.size > 1 and bool(np.ptp(set_point) >= MOVED)


def _moved(heave: Signal) -> float:
    """Return by how much a unit has changed its depth, waves left out."""
    return float(np.ptp(running_mean(heave.time, heave.value)))


def running_mean(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the running mean over SPAN, taken twice, of evenly sampled `values`, shape (n,), at `time` [s].

    At the ends the last values go on.
    """
    period = float(np.median(np.diff(time)))
    widest = 100 * values.size  # beyond which every mean is that of the ends
    width = max(1, round(SPAN / period)) if period * widest > SPAN else widest
    once = scipy.ndimage.uniform_filter1d(values, width, mode="nearest")
    return np.asarray(scipy.ndimage.uniform_filter1d(once, width, mode="nearest"))
