"""What an operator can do to a run: each thing a task that is looked at until it has a definite answer.

A task never blocks, so that one screen can have several under way, and the emergency stop waits for none of them.

Arguments: `link` is the way to the run.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from heave_bringup.operate.requests import (
    Answer,
    Task,
    refusal,
    request_fault,
    request_mode,
    request_pause,
    request_step,
)
from heave_bringup.operate.situation import PAUSED, RUNNING

if TYPE_CHECKING:
    from heave_bringup.operate.link import RunLink

STATE_TIME = 5.0
"""Wall time in which a run must show what it was asked for [s]."""
STOP_TIME = 120.0
"""Simulated time in which a stop must have ended: fade-out, settling and coming to rest have bounds too [s]."""
BRAKE_TIME = 10.0
"""Simulated time in which the brake must be on and the drum at rest after an emergency stop [s]."""
PRESS_TIME = 1.0
"""Wall time after which an emergency stop that the controller has not answered goes to the winch itself [s]."""
AT_REST = 0.01
"""Speed of a drum at rest, as its encoder reads it [m/s]."""


class AnyOf:
    """Several `tasks`, begun and answered together: done where any was; the answers of the others are left out then."""

    def __init__(self, tasks: Sequence[Task]) -> None:
        self._tasks = tasks
        self._answers: list[Answer | None] = [None] * len(tasks)

    def poll(self) -> Answer | None:
        """See Task."""
        self._answers = [done or task.poll() for done, task in zip(self._answers, self._tasks, strict=True)]
        given = [answer for answer in self._answers if answer is not None]
        if len(given) < len(self._tasks):
            return None
        done = [answer for answer in given if not answer.is_refused]
        return Answer("; ".join(dict.fromkeys(answer.text for answer in done or given)), is_refused=not done)

    def cancel(self) -> None:
        """See Task."""
        for task in self._tasks:
            task.cancel()


class ClockTask:
    """Pauses a run where `is_paused`, or lets it go on; done when the run shows it.

    A run that is paused may go on for some `ticks`; None: until further notice.
    """

    def __init__(self, link: RunLink, *, ticks: int | None = None, is_paused: bool = False) -> None:
        self._link = link
        run = link.situation.run
        self._goal = ticks + run.tick if ticks is not None and run is not None else None
        self._wanted = PAUSED if is_paused or ticks is not None else RUNNING
        self._seen_tick = run.tick if run is not None else 0
        self._asked: Task | None = link.start(
            request_pause(is_paused=is_paused) if ticks is None else request_step(ticks)
        )
        self._moved_at = link.wall_time

    def poll(self) -> Answer | None:
        """See Task."""
        if self._asked is not None:
            answer = self._asked.poll()
            if answer is None or answer.is_refused:
                return answer
            self._asked, self._moved_at = None, self._link.wall_time
        run = self._link.situation.run
        if run is not None and self._has_come(run.state, run.tick):
            verb = "paused" if self._wanted == PAUSED else "running"
            return Answer(f"{verb} at t = {run.time:.2f} s (tick {run.tick})")
        if self._link.situation.is_over:
            return refusal("the run has ended")
        if run is not None and run.tick != self._seen_tick:
            self._seen_tick, self._moved_at = run.tick, self._link.wall_time
        if self._link.wall_time - self._moved_at > STATE_TIME:
            return refusal(f"taken, but the run does not show it after {STATE_TIME:g} s: see status")
        return None

    def _has_come(self, state: int, tick: int) -> bool:
        return state == self._wanted and (self._goal is None or tick >= self._goal)

    def cancel(self) -> None:
        """See Task."""


class Stop:
    """Fades compensation out, brings the winch to rest and brakes; done when the brake is on."""

    def __init__(self, link: RunLink) -> None:
        self._link = link
        self._asked: Task | None = link.start(request_mode("stopped"))
        self._since = math.nan

    def poll(self) -> Answer | None:
        """See Task."""
        situation = self._link.situation
        if self._asked is not None:
            answer = self._asked.poll()
            if answer is None or answer.is_refused:
                return answer
            self._asked, self._since = None, situation.time
        return self._reported_by_controller() or self._reported_by_run()

    def _reported_by_controller(self) -> Answer | None:
        controller = self._link.situation.controller
        # what was said before the answer came does not count
        if controller is not None and controller.time > self._since:
            if controller.mode in ("stopped", "off", "emergency_stop"):
                return Answer(f"{controller.mode} at t = {controller.time:.2f} s, the brake is on")
            if controller.mode not in ("fade_out", "stopping"):
                return refusal(f"mode {controller.mode}: somebody else has taken over: {controller.reason}")
        return None

    def _reported_by_run(self) -> Answer | None:
        situation = self._link.situation
        if situation.is_paused:
            return Answer("stop requested: it begins with the next tick, the run is paused")
        if situation.is_over:
            return refusal("the run ended before the winch had stopped")
        if situation.time - self._since > STOP_TIME:
            return refusal(f"the winch has not stopped within {STOP_TIME:g} s: emergency-stop brakes it at once")
        return None

    def cancel(self) -> None:
        """See Task."""


class EmergencyStop:
    """Brakes at once: the controller is asked and, where it does not answer, the winch itself.

    Done when the winch says that its brake is on and its drum at rest.
    """

    def __init__(self, link: RunLink) -> None:
        self._link = link
        self._pressed_at = link.wall_time
        self._since = link.situation.time
        self._by: list[str] = []
        self._controller: Task | None = link.start(request_mode("emergency_stop"))
        self._drive: Task | None = None
        self._is_drive_asked = False
        self._refusals: list[str] = []

    def poll(self) -> Answer | None:
        """See Task."""
        self._press()
        situation, winch = self._link.situation, self._link.situation.winch
        took = situation.time - self._since
        is_fresh = winch is not None and winch.time > self._since
        if self._is_taken and winch is not None and is_fresh and winch.brake and abs(winch.rate) < AT_REST:
            return self._taken(f"the brake is on and the drum at rest, {took:.2f} s later")
        if self._is_taken and situation.is_paused:
            return self._taken("active from the next tick, the run is paused")
        if self._is_given_up(took):
            why = "; ".join(self._refusals) or f"the drum is not known to be at rest after {took:.1f} s"
            return refusal(f"NOT STOPPED: {why}: press the emergency stop of the winch itself")
        return None

    @property
    def _is_taken(self) -> bool:
        return bool(self._by)

    def _taken(self, what: str) -> Answer:
        release = "" if not self._is_drive_asked else "; the winch keeps its own until fault clear winch"
        return Answer(f"emergency stop by {' and '.join(self._by)}: {what}{release}")

    def _press(self) -> None:
        """Take the controller's answer, and go to the winch itself where that does not do."""
        if self._controller is not None and (answer := self._controller.poll()) is not None:
            self._controller = None
            self._note("the controller", answer)
        is_late = self._link.wall_time - self._pressed_at > PRESS_TIME
        if not self._is_taken and not self._is_drive_asked and (self._controller is None or is_late):
            self._is_drive_asked = True
            self._drive = self._link.start(request_fault("winch", "emergency_stop"))
        if self._drive is not None and (answer := self._drive.poll()) is not None:
            self._drive = None
            self._note("the winch itself", answer)

    def _note(self, who: str, answer: Answer) -> None:
        if answer.is_refused:
            self._refusals.append(answer.text)
        else:
            self._by.append(who)

    def _is_given_up(self, took: float) -> bool:
        both_refused = self._controller is None and len(self._refusals) > 1
        waited = self._link.wall_time - self._pressed_at
        is_silent = took <= 0.0 and waited > 2.0 * STATE_TIME
        return (not self._is_taken and both_refused) or took > BRAKE_TIME or is_silent

    def cancel(self) -> None:
        """See Task."""
