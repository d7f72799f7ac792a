"""Whether depth sensor and payout meter agree on where the unit hangs: both count from the surface of the water.

The estimator counts depth from where a run begins, and goes on whatever the meter's zero is. Under the brake the unit
heaves about its depth at rest: L + u and its stretch below the boom tip. The mean over a wave or a free swing is that.
The stretch may be as assumed or none: a passive compensator is soft, and its preload takes the weight.
"""

from __future__ import annotations

import math

from heave_node.interface.alarm import Alarm

from winch_controller_node.core.supervision.watch.load_watch import Episode
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.alarms import ALARMS

LEAST_OFF = 3.0
"""Difference that is never too large [m]: of tide, draught and trim."""


class PayoutWatch:
    """Compares the depth sensor with the payout while the winch stands.

    Parameters
    ----------
    design : the active one
    """

    def __init__(self, design: ControllerDesign) -> None:
        self._dt = design.tick_period
        self._off = Episode(self._dt)
        self._alarm: Alarm | None = None
        self.take_design(design)
        self._restart(math.nan)

    def take_design(self, design: ControllerDesign) -> None:
        """Refer to the cable of a `design` from now on."""
        self._parameters, cable = design.parameters, design.cable
        # half of the cable's own weight stretches it as well
        pull = 0.5 * (cable.static_tension + design.unit_weight)
        self._stretch = pull / (cable.stiffness * design.length)

    def update(
        self, depths: tuple[tuple[float, float], ...], payout: float, window: float, *, is_known: bool
    ) -> tuple[Alarm, ...]:
        """Take in a tick; return that the two disagree, where that is new.

        Parameters
        ----------
        depths : readings of the tick: stamp [s] and depth, positive down [m]
        payout : mean [m]
        window : time over which the depth is averaged at least [s]
        is_known : the unit hangs below a braked winch and a boom tip at its height, and both are read
        """
        if not is_known or payout != self._payout:
            self._restart(payout)
        else:
            self._time += self._dt
            for _, depth in depths:
                self._sum += depth
                self._count += 1
            if self._time >= window and self._count:
                self._alarm = self._compared(self._sum / self._count, self._parameters.length + payout)
        return (self._alarm,) if self._off.begins(self._alarm is not None) and self._alarm else ()

    def _restart(self, payout: float) -> None:
        self._payout = payout
        self._time, self._sum, self._count = 0.0, 0.0, 0

    def _compared(self, depth: float, out: float) -> Alarm | None:
        """Return that a mean `depth` [m] is not that of a unit below so much cable that is `out` [m]."""
        parameters = self._parameters
        least, stretch = out - parameters.boom_tip_height, self._stretch * out
        limit = LEAST_OFF + parameters.health.payout_tolerance * out
        if -limit <= depth - least <= stretch + limit or parameters.health.payout_tolerance == 0.0:
            return None
        expected = least + stretch
        return ALARMS.alarm("PAYOUT_DEPTH_DISAGREE", depth=depth, out=out, expected=expected)
