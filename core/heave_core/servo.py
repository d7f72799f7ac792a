"""The drum under the set-points it was sent, see `src/servo.cpp`: what its encoder should have read."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from heave_core.library import library, new
from heave_core.watch_table import SERVO_RUN

Array = NDArray[np.float64]

POSITION_STEP = 0.005
"""Step of the position loop [s]; without one each piece of a tick is exact."""

START_STEPS = 3
"""Gauss-Newton steps to payout and rate at the start of a record."""

RATE_STEP = 1e-3
"""Step of the sensitivity to the rate at the start [m/s]."""

EDGE = 1e-9
"""Part of a tick that counts as none."""

NO_POWER_LIMIT = 1e9
"""Power that no winch has [W]."""

WEAK_SLOPE = 1e-6
"""Effect of the rate at the start on the payout that counts as none, as at the limit of the speed [s]."""


class Drum(NamedTuple):
    """A speed servo behind a transport delay, by the rows of SERVO in `watch_table`, with their units and meanings."""

    lag: float
    delay: float
    gain: float = 1.0
    deadband: float = 0.0
    speed_out: float = math.inf
    speed_in: float = math.inf
    acceleration_out: float = 1e9
    acceleration_in: float = 1e9
    backlash: float = 0.0
    reach: float = 1.0
    hauling: float = 1.0
    creep: float = 0.0
    power: float = NO_POWER_LIMIT


def run_of(position_gain: float, dt: float, sent: int = 0, ticks: int = 0) -> NDArray[Any]:
    """Return an array of one ServoRun.

    Parameters
    ----------
    position_gain : of the servo's position loop [1/s]; 0: none
    dt : tick period [s]
    sent, ticks : set-points of the record, and ticks at its end for which readings are made
    """
    run: NDArray[Any] = new(SERVO_RUN)
    of_it = (POSITION_STEP, EDGE, NO_POWER_LIMIT, RATE_STEP, WEAK_SLOPE)
    run[0] = (sent, ticks, 0, START_STEPS, dt, position_gain, *of_it)
    return run


def sent_points(payouts: Array, rates: Array, late: Array, tensions: Array) -> Array:
    """Return what was sent as a table, (4, n), by ticks, oldest first.

    Parameters
    ----------
    payouts, rates : set-points [m], [m/s]
    late : by how much later than the delay each of them took effect [ticks]
    tensions : at the top at the end of each tick [N]; NaN where unknown: there the power limits nothing
    """
    return np.array([payouts, rates, late, tensions], dtype=float)


def drum_records(sent: Array, drums: Array, starts: Array, position_gain: float, count: int, dt: float) -> Array:
    """Return the encoder's reading of each drum at the end of each of the last `count` ticks, shape (m, count) [m].

    Parameters
    ----------
    sent : see `sent_points`, of at least count + delay/dt + 1 ticks
    drums : fields of `Drum`, shape (m, 13)
    starts : payout and rate at the start of the `count` ticks, shape (m, 2) [m], [m/s]
    position_gain : of the servo's position loop [1/s]; 0: none
    count : ticks
    dt : tick period [s]

    Raises ValueError for arrays of another shape, and for fewer set-points than ticks.
    """
    if sent.shape[0] != 4 or sent.shape[1] < count or drums.shape[1] != len(Drum._fields) or starts.shape[1] != 2:
        raise ValueError(f"drum: set-points {sent.shape} for {count} ticks, drums {drums.shape}, starts {starts.shape}")
    out, run = np.empty((len(drums), count)), run_of(position_gain, dt, sent.shape[1], count)
    # held here until the call is over
    arrays = (run, sent, np.ascontiguousarray(drums), np.ascontiguousarray(starts))
    library().heave_core_servo(*(one.ctypes.data for one in arrays), len(drums), out.ctypes.data)
    return out
