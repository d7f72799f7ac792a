"""The crane's own lift of the boom tip, as the winch makes up for it: payout that is ordered for it, and that follows.

The winch is ordered the rate of the lift, l'. The drum follows that as it follows every order, after the delay and with
the lag: m' = (l'(t - delay) - m') / T. So m of the payout that is read is the lift's, and l - m, some centimetres while
the boom accelerates, is motion of the boom tip that is left.
"""

from __future__ import annotations

import math
from collections import deque

from winch_controller_node.parameters.model import WinchModelParameters

LEAK_TIME = 30.0
"""Time in which what the winch has not made up for, as after a stop, is taken for payout [s]."""


class LiftOrders:
    """What the winch has been ordered for the lift, by ticks.

    Parameters
    ----------
    winch : its delay and lag
    tick_period : [s]

    Attributes
    ----------
    ordered : payout ordered for the lift [m]
    made, rate : payout of the drum for it by the nominal winch, and its rate [m], [m/s]
    """

    def __init__(self, winch: WinchModelParameters, tick_period: float) -> None:
        self._dt = tick_period
        is_servo = winch.law == "speed_servo"
        self._share = -math.expm1(-tick_period / winch.time_constant) if is_servo else 1.0
        delay = round(winch.command_delay / tick_period)
        self._under_way = deque([0.0] * delay, maxlen=delay) if delay else None
        self.ordered = self.made = self.rate = 0.0

    def step(self, lift: float, rate: float, *, follows: bool) -> float:
        """Go on by a tick, and return the rate to be ordered for it [m/s].

        Parameters
        ----------
        lift, rate : of the boom tip at the start of the tick [m], [m/s]
        follows : the winch follows the rate; else it is to come to rest, and the unit goes with the boom
        """
        if not follows:
            self.ordered = self.made = lift + rate * self._dt
            self.rate = rate
            if self._under_way is not None:
                self._under_way.extend([0.0] * len(self._under_way))
            return 0.0
        arrived = rate
        if self._under_way is not None:
            arrived = self._under_way[0]
            self._under_way.append(rate)
        before = self.rate
        self.rate += self._share * (arrived - self.rate)
        leak = (lift - self.made) * self._dt / LEAK_TIME
        self.made += 0.5 * self._dt * (before + self.rate) + leak
        self.ordered += rate * self._dt + leak
        return rate
