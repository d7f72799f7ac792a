"""What moves the unit: a speed of the mean payout, and moves to a depth or by one. Tasks, see `tasks`.

Arguments: `link` is the way to the run.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from heave_bags.analyse.events import ALARMS_PART
from heave_node.interface.alarm import alarms_in
from heave_node.interface.codes import OPERATOR_SPEED_LIMITED

from heave_bringup.operate.requests import Answer, refusal
from heave_bringup.operate.tasks import STATE_TIME

if TYPE_CHECKING:
    from heave_bringup.operate.link import DepthMove, RunLink

SPEED_PERIOD = 0.1
"""Simulated time between two requests of a speed [s]."""
SETTLING_TIME = 3.0
"""Simulated time in which the mean payout comes to rest after a speed [s]."""


class Lowering:
    """Asks for a `speed` of the mean payout, positive lowers [m/s], as a joystick does, for a `duration` [s,
    simulated]; done when the payout rests again.
    """

    def __init__(self, link: RunLink, speed: float, duration: float) -> None:
        self._link = link
        self._speed, self._duration = speed, duration
        self._began = self._ended = self._asked_at = self._payout_before = math.nan
        self._is_let_go = False
        self._limit = ""
        self._heard_at = link.wall_time
        self._heard_time = math.nan

    def poll(self) -> Answer | None:
        """See Task."""
        controller = self._link.situation.controller
        silent = self._silence(math.nan if controller is None else controller.time)
        if controller is None or silent > STATE_TIME:
            return refusal(f"the controller has said nothing for {STATE_TIME:g} s") if silent > STATE_TIME else None
        if controller.mode not in ("compensating", "manual"):
            return refusal(f"a speed needs mode compensating or manual; the mode is {controller.mode}")
        now = controller.time
        self._limit = self._limit or self._limit_reported()
        if math.isnan(self._began):
            self._began, self._payout_before = now, controller.mean_payout
        if math.isnan(self._ended) and (self._is_let_go or now - self._began >= self._duration):
            self._ended = now
        if not math.isnan(self._ended) and now - self._ended > SETTLING_TIME:
            moved, took = controller.mean_payout - self._payout_before, self._ended - self._began
            limit = f"; {self._limit}" if self._limit else ""
            done = f"speed {self._speed:+g} m/s for {took:.1f} s: the mean payout moved by {moved:+.2f} m"
            return Answer(done + limit)
        if not now - self._asked_at < SPEED_PERIOD - 1e-6:  # tick times are rounded sums
            self._asked_at = now
            self._link.ask_speed(self._speed if math.isnan(self._ended) else 0.0)
        return None

    def _limit_reported(self) -> str:
        """Return what the controller reports about a limit of this speed; empty: nothing, or nothing yet."""
        reported = self._link.situation.troubles.get(ALARMS_PART)
        found = [] if reported is None else alarms_in(reported.message)
        return next((one.text for one in found if one.code == OPERATOR_SPEED_LIMITED), "")

    def _silence(self, heard: float) -> float:
        """Return for how long nothing new was `heard` of the controller, by wall time [s]."""
        if heard != self._heard_time and not math.isnan(heard):
            self._heard_time, self._heard_at = heard, self._link.wall_time
        return self._link.wall_time - self._heard_at

    def cancel(self) -> None:
        """Ask for no speed any more."""
        self._link.ask_speed(0.0)
        self._is_let_go = True


class Followed:
    """A `move` that was requested and is followed: `show` is called with mean depth [m], rate [m/s] and time to go [s].

    It `waits` for the end of the move, or only until it is under way.
    """

    def __init__(self, move: DepthMove | MoveBy, show: Callable[[float, float, float], None], *, waits: bool) -> None:
        self._move, self._show, self._waits = move, show, waits

    def poll(self) -> Answer | None:
        """See Task."""
        answer, progress = self._move.poll(), self._move.progress
        if answer is not None:
            return answer
        if progress is not None:
            self._show(*progress)
            if not self._waits:
                depth, _, time_to_go = progress
                return Answer(f"under way from {depth:.2f} m, {time_to_go:.0f} s to go")
        return None

    def cancel(self) -> None:
        """End the move smoothly."""
        self._move.cancel()


class MoveBy:
    """Moves the unit by a `distance` from where it hangs, positive lowers [m], at most at a mean `speed` [m/s]; 0: the
    controller's own.
    """

    def __init__(self, link: RunLink, distance: float, speed: float) -> None:
        self._link = link
        self._distance, self._speed = distance, speed
        self._move: DepthMove | None = None
        self._began = link.wall_time

    @property
    def is_under_way(self) -> bool:
        """Whether the controller has begun the move."""
        return self._move is not None and self._move.is_under_way

    @property
    def progress(self) -> tuple[float, float, float] | None:
        """Mean depth [m], rate [m/s] and time to go [s]."""
        return None if self._move is None else self._move.progress

    def poll(self) -> Answer | None:
        """See Task."""
        if self._move is None:
            depth = self._link.situation.depth
            if not math.isfinite(depth):
                late = self._link.wall_time - self._began > STATE_TIME
                return refusal("the controller does not report the depth of the unit: use depth D") if late else None
            self._move = self._link.start_move(depth + self._distance, self._speed)
        return self._move.poll()

    def cancel(self) -> None:
        """End the move smoothly."""
        if self._move is not None:
            self._move.cancel()
