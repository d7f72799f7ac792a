"""After a stop the load swings: by how much, for how long, and what damps it.

A drum that is stopped leaves the unit in a free swing about the motion that it has under a locked drum. With
a z'' + max(b, d |z'|) z' + z = 0 and w = 1/sqrt(a) the amplitude falls by

    A' = - b A/(2 a),    or by the drag    A' = - 4/(3 pi) d w^3 A^2,

whichever is more (mean power of the damping over a period; Krylov and Bogoliubov). Nothing else ends it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from heave_node.interface.alarm import Alarm

from winch_controller_node.core.estimation.loop_tick import LoopTick, free_swing
from winch_controller_node.core.supervision.modes import BRAKED, MOVING, Mode
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.model.blocks import CableModel

COME_TO_REST = 2.0
"""Time after the brake was ordered at which the drum stands [s]."""

NOTABLE, NOTABLE_SHARE = 0.1, 0.5
"""Swing that is reported [m], and its share of the swing that the unit has under a locked drum at the same time."""


class Decay(NamedTuple):
    """How a free swing goes on: period and time to half of the amplitude [s]."""

    period: float
    half: float


def decay_of(swing: float, cable: CableModel) -> Decay:
    """Return how a free `swing` [m] on a `cable` goes on."""
    a = cable.natural_a
    w = 1.0 / math.sqrt(a)
    by_drag = 4.0 / (3.0 * math.pi) * cable.drag * w**3 * swing
    linear = 0.5 * cable.b / a
    if by_drag > linear:
        return Decay(2.0 * math.pi / w, 1.0 / by_drag)  # of A = A0/(1 + A0 c t)
    return Decay(2.0 * math.pi / w, math.log(2.0) / linear if linear > 0.0 else math.inf)


class AfterStop:
    """Reports the swing that a stop has left.

    `tick_period` : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._left = -1.0

    def is_due(self, mode: Mode, before: Mode | None = None) -> bool:
        """Take in the `mode` of a tick, and the one `before` where it has changed; tell whether the drum stands now."""
        if mode not in BRAKED or mode is Mode.OFF:
            self._left = -1.0
        elif before in MOVING:
            self._left = COME_TO_REST
        left, self._left = self._left, self._left - self._dt
        return left > 0.0 >= self._left

    def alarms(self, tick: LoopTick, cable: CableModel, *, hangs: bool) -> tuple[Alarm, ...]:
        """Return that the load swings, at a `tick` in which this is due.

        `cable` is the active two-state cable; `hangs` : the unit hangs, as far as is known
        """
        if not (hangs and tick.knows_tip):
            return ()
        swing = free_swing(tick.offset, tick.offset_rate, cable.natural_a)
        locked = free_swing(tick.free, tick.free_rate, cable.natural_a)
        # one that would slacken the cable is no estimate, but one that has lost its encoder
        if not max(NOTABLE, NOTABLE_SHARE * locked) < swing < cable.static_tension / cable.stiffness:
            return ()
        decay = decay_of(swing, cable)
        lost = sorted({"mru", "encoder"} & tick.lost.keys())
        remedy = (
            f"Request compensating once {' and '.join(lost)} can be read again"
            if lost
            else "Request compensating: it removes the swing within half a minute"
        )
        return (
            ALARMS.alarm(
                "LOAD_SWINGS", swing=swing, locked=locked, period=decay.period, half=decay.half, remedy=remedy
            ),
        )
