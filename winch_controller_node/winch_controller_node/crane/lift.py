"""The crane's own lift of the boom tip, as the winch makes up for it: payout that is ordered for it, and that follows.

The winch is ordered the speed v = l' + (l - m) / tau for a lift l, where m is what the nominal drum has paid out for it
by the time at which the order takes effect. The drum follows that as it follows every order, after the delay and with
the lag. So m of the payout that is read is the lift's, and the loop does not see it. What the drum lags behind, l - m,
some centimetres while the boom gains speed, is gone within tau.

The lift has a share of the winch's speed, acceleration and range: of a crane that moves faster or further l - m grows,
and the unit goes with the boom by that. The governor is given m, m' and the order for them beside the loop's own, and
bounds the sum: what its limits take away is taken from the loop's share, and the estimator is given that share.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from heave_node.numerics.linear_sampling import discretise

from winch_controller_node.laws.parts.governor import LiftShare
from winch_controller_node.model.blocks import winch_block
from winch_controller_node.motion.trajectory import approach_speed
from winch_controller_node.parameters.model import WinchModelParameters

CATCH_UP = 2.0
"""Time tau in which the drum makes up for what it lags behind [s]; four of its lags where longer: no overshoot."""

HISTORY = 10.0
"""Time for which the payout is kept [s]: longer than any delay of a winch."""


class LiftBounds(NamedTuple):
    """What the lift may use of the winch; compensation has the rest.

    Attributes
    ----------
    speed, acceleration : largest [m/s], [m/s^2]
    lowest, highest : payout for the lift that leaves compensation its room in the range [m]
    """

    speed: float = math.inf
    acceleration: float = math.inf
    lowest: float = -math.inf
    highest: float = math.inf


UNBOUNDED = LiftBounds()
"""Bounds of a winch without limits."""


class LiftOrders:
    """What the winch has been ordered for the lift, and what the nominal drum has paid out for it.

    Parameters
    ----------
    winch : the nominal one
    tick_period : [s]

    Attributes
    ----------
    bound : what keeps the winch from making up for the lift: "speed" or "range"; empty: nothing
    """

    def __init__(self, winch: WinchModelParameters, tick_period: float) -> None:
        self._dt = tick_period
        self._speed = 0.0
        self.bound = ""
        self._past: deque[tuple[float, float]] = deque([(0.0, 0.0)], maxlen=round(HISTORY / tick_period) + 1)
        self.take_winch(winch)

    def take_winch(self, winch: WinchModelParameters) -> None:
        """Go by another nominal `winch` from now on; what was paid out stays."""
        self._winch = winch
        self._is_first_order = winch.law == "first_order"
        self._lag = 1.0 / winch.position_rate if self._is_first_order else winch.time_constant
        drum = discretise(winch_block(winch), self._dt)
        self._a, self._b = drum.A.tolist(), drum.B[:, 0].tolist()

    @property
    def speed(self) -> float:
        """Speed that is ordered for the lift [m/s]."""
        return self._speed

    def made(self, before: float) -> tuple[float, float]:
        """Return the drum's payout for the lift, and its rate, a time `before` the start of the coming tick [m], [m/s].

        A negative time is one within the tick.
        """
        behind = (before + self._winch.command_delay) / self._dt
        newest = len(self._past) - 1
        at = min(max(newest - behind, 0.0), float(newest))
        first = min(math.floor(at), max(newest - 1, 0))
        (payout, rate), (next_payout, next_rate) = self._past[first], self._past[min(first + 1, newest)]
        part = at - first
        return payout + part * (next_payout - payout), rate + part * (next_rate - rate)

    def step(self, lift: float, rate: float, bounds: LiftBounds = UNBOUNDED) -> LiftShare:
        """Go on by a tick; return what is ordered for the lift.

        Parameters
        ----------
        lift, rate : of the boom tip at the start of the tick [m], [m/s]
        bounds : of what the winch may do for it
        """
        payout, drum_rate = self._past[-1]
        behind = lift + rate * self._winch.command_delay - payout
        speed = self._bounded(rate + behind / max(CATCH_UP, 4.0 * self._lag), payout, bounds)
        if self._is_first_order:  # payout that the drum gains in a tick, by its share b of what it is off
            command = payout + speed * self._dt / self._b[0]
        else:  # what the position loop takes off over the tick is added
            command = speed + self._winch.position_gain * (payout + 0.5 * drum_rate * self._dt)
        self._past.append(self._after(payout, drum_rate, command))
        return LiftShare(command, payout, drum_rate)

    def _bounded(self, wanted: float, payout: float, bounds: LiftBounds) -> float:
        """Return the speed nearest to the `wanted` one within `bounds` [m/s], from a `payout` for the lift [m]."""
        step = bounds.acceleration * self._dt
        speed = min(max(wanted, self._speed - step), self._speed + step)
        within = min(max(speed, -bounds.speed), bounds.speed)
        up, down = (max(room, 0.0) for room in (payout - bounds.lowest, bounds.highest - payout))
        slowest, fastest = (
            approach_speed(room, bounds.acceleration, self._lag) if math.isfinite(room) else math.inf
            for room in (up, down)
        )
        self._speed = min(max(within, -slowest), fastest)
        self.bound = "range" if self._speed != within else "speed" if abs(wanted) > bounds.speed else ""
        return self._speed

    def _after(self, payout: float, rate: float, command: float) -> tuple[float, float]:
        """Return payout and rate of the drum a tick later under a `command`."""
        state = (payout,) if self._is_first_order else (payout, rate)
        after = [
            sum(a * x for a, x in zip(row, state, strict=True)) + b * command
            for row, b in zip(self._a, self._b, strict=True)
        ]
        if self._is_first_order:
            return after[0], (after[0] - payout) / self._dt
        return after[0], after[1]
