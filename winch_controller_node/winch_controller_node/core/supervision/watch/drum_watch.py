"""Reflexes about the drum: is it off what the last second foresaw, and does its encoder go as the winch was ordered."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from heave_core.servo import DrumPrediction, drum_records, sent_points
from heave_node.numerics.arrays import Array
from heave_node.numerics.newest import Newest

from winch_controller_node.beliefs.drum import drum_of
from winch_controller_node.parameters.model import WinchModelParameters

CHECKED_TIME = 1.0
"""The drum is compared with its prediction over this time [s]."""

ORDERED_TIME = 0.8
"""Orders and encoder are compared over this time [s]."""

LEAST_MOTION = 0.004
"""Least motion of orders and encoder for a comparison, 1 sigma [m]."""

LEAST_SEEN = 0.8
"""Least fraction of the encoder readings that a comparison needs."""

SETTLED = 5.0
"""Time constants after which the initial state of a servo has decayed."""

LONGEST = 12.0
"""Time for which orders and readings are kept [s]."""

STRAIGHT = 0.15
"""Orders and encoder are compared where no more is left of the readings than this share: a weak drum lags behind."""

REVERSED, NOT_REVERSED = -0.2, 0.5
"""Ratio of encoder to orders below which the encoder is reversed, and above which it is no more."""

SUDDEN, NOT_SUDDEN = (0.6, 1.6), (0.75, 1.3)
"""Ratio of encoder to orders outside which its scale has changed suddenly, and within which it has not."""

TRUE = 0.1
"""Largest error of that ratio of an encoder that reads what was ordered: a weaker or slower winch is further off."""


class Ordered(NamedTuple):
    """What the encoder reads of what the winch was ordered.

    Attributes
    ----------
    share : times as much
    left : standard deviation of the rest over that of the readings
    payout : where the drum should be by now, did it start where it was read [m]
    is_limited : the winch says that it has been at a limit meanwhile
    """

    share: float
    left: float
    payout: float
    is_limited: bool = False

    def is_reversed(self, *, was: bool) -> bool:
        """Return whether the encoder is reversed, and if it `was` so, still is."""
        return self.share < NOT_REVERSED if was else self.share < REVERSED and self.left < STRAIGHT

    def is_sudden(self, *, was: bool) -> bool:
        """Tell whether the encoder reads far less or more, no limit having acted, and if it `was` so, still does."""
        least, most = NOT_SUDDEN if was else SUDDEN
        return not least < self.share < most and (was or (self.left < STRAIGHT and not self.is_limited))

    @property
    def is_right_way(self) -> bool:
        """Tell whether the encoder goes the way that was ordered."""
        return self.share > NOT_REVERSED and self.left < STRAIGHT

    @property
    def is_true(self) -> bool:
        """Tell whether the encoder reads what was ordered."""
        return abs(self.share - 1.0) < TRUE and self.left < STRAIGHT


class DrumWatch:
    """Keeps orders and encoder readings of the last seconds.

    Parameters
    ----------
    winch : nominal
    largest : most by which the assumed delay may be longer [s]
    tick_period : [s]
    """

    def __init__(self, winch: WinchModelParameters, largest: float, tick_period: float) -> None:
        self._dt, self._nominal = tick_period, winch
        self._ahead = math.ceil((winch.command_delay + largest) / tick_period) + 3
        kept = round(LONGEST / tick_period) + self._ahead
        self._payouts, self._rates, self._tensions, self._readings, self._limits = (Newest(kept) for _ in range(5))
        self._checked = 2 * round(CHECKED_TIME / tick_period)
        self._prediction = DrumPrediction(self._checked - 1, self._ahead + 1, winch.position_gain, tick_period)
        self.take({})
        self.reset()

    def take(self, assumed: Mapping[str, float]) -> None:
        """Go by the `assumed` winch from now on, by quantity."""
        self._drum = np.array(drum_of(self._nominal, assumed), dtype=float)

    def reset(self, payout: float = 0.0) -> None:
        """Restart with the drum at rest at `payout` [m]."""
        self.restart()
        for _ in range(self._ahead):
            self._payouts.append(payout)
            self._rates.append(0.0)
            self._tensions.append(math.nan)

    def restart(self) -> None:
        """Restart with the drum in motion, after something that no drum does."""
        self._readings.clear()

    def add(
        self,
        payout: float,
        rate: float,
        encoder: float | None,
        *,
        tension: float = math.nan,
        is_limited: bool = False,
    ) -> None:
        """Take a tick in.

        Parameters
        ----------
        payout, rate : set-points [m], [m/s]
        encoder : at its end [m]; None: no reading
        tension : at its end [N]; NaN: unknown
        is_limited : the winch says that a limit acted in it
        """
        self._limits.append(float(is_limited))
        self._payouts.append(payout)
        self._rates.append(rate)
        self._tensions.append(tension)
        self._readings.append(math.nan if encoder is None else encoder)

    def error(self) -> float:
        """Return how far the drum is off what was predicted a second ago [m]; 0 where unknown.

        Payout and rate of then are those that explain the second before it best: at a limit an error of the rate stays.
        """
        readings = self._readings.last(self._checked)
        if len(readings) < self._checked or not np.isfinite(readings).all():
            return 0.0
        needed = self._checked + self._ahead
        sent = (self._payouts.last(needed), self._rates.last(needed), self._tensions.last(needed))
        return float(readings[-1] - self._prediction.of(*sent, readings, self._drum))

    def does_as_nominal(self, scale: float) -> bool:
        """Tell whether the encoder, whose assumed `scale` is left out, reads what a nominal winch was ordered."""
        found = self.ordered(np.array(drum_of(self._nominal, {}), dtype=float))
        return found is not None and found._replace(share=found.share * scale).is_true

    def ordered(self, drum: Array | None = None) -> Ordered | None:
        """Return what the encoder reads of what the winch was ordered, with its assumed scale; None: unknown.

        `drum` : that was ordered; None: the assumed one
        """
        drum = self._drum if drum is None else drum
        count = round(ORDERED_TIME / self._dt)
        readings = self._readings.last(count + 1)
        seen = np.isfinite(readings)
        if len(readings) <= count or not seen[0] or np.count_nonzero(seen) < LEAST_SEEN * count:
            return None
        # a slow servo still goes as it was ordered long before: that is known from there on only
        before = min(math.ceil(SETTLED * drum[0] / self._dt), len(self._readings) - count - 1)
        begin = self._readings.last(count + 1 + before)[0]
        begin = begin if math.isfinite(begin) else readings[0]
        needed = before + count + 1 + self._ahead
        payouts, rates = self._payouts.last(needed), self._rates.last(needed)
        start = np.array([[begin, self._rate_before(before + count)]])
        sent = sent_points(payouts, rates, np.zeros(len(rates)), self._tensions.last(needed))
        path = drum_records(sent, drum[np.newaxis], start, self._nominal.position_gain, before + count, self._dt)[0]
        path, travel = path[before:], path[-1] - (path[before - 1] if before > 0 else begin)
        asked, read = path[seen[1:]], readings[1:][seen[1:]]
        asked, read = asked - asked.mean(), read - read.mean()
        asked_squares, read_squares = float(asked @ asked), float(read @ read)
        if min(asked_squares, read_squares) < LEAST_MOTION**2 * len(read):
            return None
        share = float(asked @ read) / asked_squares
        left = max(read_squares - share**2 * asked_squares, 0.0)
        is_limited = bool(np.any(self._limits.last(count + 1) > 0.0))
        return Ordered(share, math.sqrt(left / read_squares), float(readings[0] + travel), is_limited)

    def _rate_before(self, count: int) -> float:
        """Return the speed that the winch was ordered `count` ticks ago and has reached by now [m/s]."""
        lag = round((self._drum[0] + self._drum[1]) / self._dt)
        return float(self._rates.last(count + 1 + lag)[0])
