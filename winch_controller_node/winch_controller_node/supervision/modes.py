"""The mode machine: what the controller does, why, and how it gets from one mode to another without a step.

off: law off, the brake stays on. standby: the brake is on, the estimator runs. compensating: authority rises to the
share asked for. fade_out: authority falls to zero, then standby or stopping. constant_tension: tension is held.
stopping: the winch comes to rest at a bounded deceleration, then stopped, with the brake on. emergency_stop: brake at
once, and it stays until another mode is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from heave_node.codes import WinchFault, fault_words

from winch_controller_node.parameters.laws import ModeParameters


class Mode(str, Enum):
    """Modes by the names of heave_msgs/ControllerState."""

    OFF = "off"
    STANDBY = "standby"
    COMPENSATING = "compensating"
    CONSTANT_TENSION = "constant_tension"
    FADE_OUT = "fade_out"
    STOPPING = "stopping"
    STOPPED = "stopped"
    EMERGENCY_STOP = "emergency_stop"


REQUESTS = (Mode.STANDBY, Mode.COMPENSATING, Mode.CONSTANT_TENSION, Mode.STOPPED, Mode.EMERGENCY_STOP)
"""Modes that may be asked for."""

BRAKED = (Mode.OFF, Mode.STANDBY, Mode.STOPPED, Mode.EMERGENCY_STOP)
"""Modes in which the brake is on."""

RELEASE_TIME = 0.5
"""Time the brake request stands before a braked winch is asked to move [s]: a latched fault is acknowledged so."""

BACK_TIME = 1.0
"""A sensor that is back for so long [s] ends the fade-out it was the reason of."""


SETTLING_LIMIT = 30.0
"""Longest time that a unit may take to settle after a fade-out [s]."""


class ModeError(ValueError):
    """A mode that cannot be taken now; the message says why."""


@dataclass(frozen=True)
class Situation:
    """What the mode machine is told each tick.

    Attributes
    ----------
    lost : vital sensors that are lost, with the reason ("mru frozen"), empty when none
    has_estimate : the estimator has had the readings it needs
    winch_fault : number of the winch's own fault, see WinchFault
    harm : the guard's reason to fade out, empty when all is well
    speed : speed of the winch as commanded [m/s], absolute
    authority_limit : share of the sea that the winch can follow under this law
    is_settled : the unit moves as it would with the winch locked: the winch may stop
    """

    lost: str
    has_estimate: bool
    winch_fault: int
    harm: str
    speed: float
    authority_limit: float = 1.0
    is_settled: bool = True


@dataclass(frozen=True)
class ModeOutput:
    """What the mode asks for: the mode, why, authority (0 to 1), and the brake."""

    mode: Mode
    reason: str
    authority: float
    brake: bool


class ModeMachine:
    """Decides the mode each tick.

    Parameters
    ----------
    parameters : times and rates
    law : law of the controller; off never leaves mode off
    factor : largest authority
    tick_period : [s]
    """

    def __init__(self, parameters: ModeParameters, *, law: str, factor: float, tick_period: float) -> None:
        self._parameters = parameters
        self._dt = tick_period
        self._factor = factor
        self.mode = Mode.OFF if law == "off" else Mode.STANDBY
        self.reason = "law off" if law == "off" else "estimate settling"
        self.authority = 0.0
        self.target = factor
        self._time = 0.0
        self._well_time = 0.0
        self._lost_time = 0.0
        self._wants_compensation = parameters.start == "compensating"
        self._after_fade = Mode.STANDBY
        self._may_resume = True

    @property
    def brake(self) -> bool:
        """Tell whether the brake is to be on."""
        return self.mode in BRAKED

    def request(self, name: str) -> None:
        """Ask for a mode by name.

        Raises ModeError, saying why, where it cannot be taken.
        """
        known = [mode.value for mode in REQUESTS]
        if name not in known:
            raise ModeError(f"mode {name!r} cannot be asked for; known: {', '.join(known)}")
        mode = Mode(name)
        if mode is Mode.EMERGENCY_STOP:
            self._enter(Mode.EMERGENCY_STOP, "asked for")
            return
        if self.mode is Mode.OFF:
            raise ModeError("law off: the controller does not move the winch")
        if mode is Mode.STOPPED:
            self._wants_compensation = False
            if not self.brake:
                self._enter(Mode.STOPPING, "asked for")
            return
        self._request_motion(mode)

    def _request_motion(self, mode: Mode) -> None:
        self._may_resume = True
        if mode is Mode.CONSTANT_TENSION:
            if self._lost_time > 0.0:
                raise ModeError("constant tension needs the MRU, the load cell and the encoder")
            self._wants_compensation = False
            self._enter(Mode.CONSTANT_TENSION, "asked for")
            return
        self._wants_compensation = mode is Mode.COMPENSATING
        if mode is Mode.STANDBY:
            if self.mode in (Mode.COMPENSATING, Mode.CONSTANT_TENSION):
                self._fade(Mode.STANDBY, "standby asked for")
            elif self.mode in (Mode.STOPPED, Mode.EMERGENCY_STOP):
                self._enter(Mode.STANDBY, "asked for")
            return
        if self.mode in (Mode.STOPPED, Mode.EMERGENCY_STOP):
            self._enter(Mode.STANDBY, "compensation asked for")
        elif self.mode is Mode.CONSTANT_TENSION:
            self._enter(Mode.COMPENSATING, "asked for")
            self.authority = self._factor

    def step(self, situation: Situation) -> ModeOutput:
        """Advance one tick and return what is to be done."""
        self._time += self._dt
        self._lost_time = self._lost_time + self._dt if situation.lost else 0.0
        self._well_time = 0.0 if situation.lost or not situation.has_estimate else self._well_time + self._dt
        if situation.winch_fault and self.mode not in (Mode.OFF, Mode.EMERGENCY_STOP):
            self._trip(situation)
        {
            Mode.STANDBY: self._standby,
            Mode.COMPENSATING: self._compensating,
            Mode.CONSTANT_TENSION: self._constant_tension,
            Mode.FADE_OUT: self._fade_out,
            Mode.STOPPING: self._stopping,
            Mode.STOPPED: self._stopped,
        }.get(self.mode, self._stay)(situation)
        return ModeOutput(self.mode, self.reason, self.authority, self.brake)

    def _trip(self, situation: Situation) -> None:
        """The winch has stopped by itself: brake on, and wait for somebody unless it was a missed command."""
        if self.mode in (Mode.STANDBY, Mode.STOPPED):
            return
        is_stop = situation.winch_fault == WinchFault.EMERGENCY_STOP
        self._wants_compensation = False
        self._enter(
            Mode.EMERGENCY_STOP if is_stop else Mode.STOPPED, f"winch fault: {fault_words(situation.winch_fault)}"
        )

    def _standby(self, situation: Situation) -> None:
        if situation.lost:
            self.reason = situation.lost
            return
        if not self._wants_compensation:
            return
        settling = max(self._parameters.settling_time, RELEASE_TIME)
        if self._well_time < settling:
            self.reason = "estimate settling"
        elif situation.harm:
            self.reason = situation.harm
        elif self._time >= RELEASE_TIME:
            self._enter(Mode.COMPENSATING, "estimate settled")

    def _compensating(self, situation: Situation) -> None:
        if self._lost_time > self._parameters.coast_time:
            self._fade(Mode.STOPPING, situation.lost)
        elif situation.harm:
            self._fade(Mode.STANDBY, situation.harm)
        else:
            self.reason = f"coasting on prediction: {situation.lost}" if situation.lost else ""
            self.target = self._factor * situation.authority_limit
            self._move_authority(self.target, self._parameters.fade_in_time)

    def _constant_tension(self, situation: Situation) -> None:
        if self._lost_time > self._parameters.coast_time:
            self._enter(Mode.STOPPING, situation.lost)

    def _fade_out(self, situation: Situation) -> None:
        if self._after_fade is Mode.STOPPING and situation.lost and "encoder" in situation.lost:
            self._enter(Mode.STOPPING, situation.lost)
            return
        if self._after_fade is Mode.STOPPING and self._well_time > BACK_TIME and self._wants_compensation:
            self._enter(Mode.COMPENSATING, "sensors well again")
            return
        self._move_authority(0.0, self._parameters.fade_out_time)
        longest = self._parameters.fade_out_time + SETTLING_LIMIT
        if self.authority == 0.0 and (situation.is_settled or situation.lost or self._time > longest):
            self._enter(Mode.STOPPING, self.reason)

    def _stopping(self, situation: Situation) -> None:
        if situation.speed < 1e-3:
            self._enter(self._after_fade if self._after_fade is Mode.STANDBY else Mode.STOPPED, self.reason)

    def _stopped(self, situation: Situation) -> None:
        may = self._parameters.resume and self._may_resume and self._wants_compensation
        if may and not situation.winch_fault and self._well_time > self._parameters.resume_time:
            self._enter(Mode.STANDBY, "sensors well again")

    def _stay(self, situation: Situation) -> None:
        """Off and emergency stop wait for somebody."""

    def _fade(self, after: Mode, reason: str) -> None:
        self._after_fade = after
        self._enter(Mode.FADE_OUT, reason)

    def _enter(self, mode: Mode, reason: str) -> None:
        if mode is not Mode.FADE_OUT and mode is not Mode.COMPENSATING:
            self.authority = 0.0
        if mode is Mode.EMERGENCY_STOP:
            self._may_resume = False
            self._wants_compensation = False
        if mode in (Mode.COMPENSATING, Mode.CONSTANT_TENSION):
            self._after_fade = Mode.STOPPED
        self.mode, self.reason, self._time = mode, reason, 0.0

    def _move_authority(self, target: float, time: float) -> None:
        step = self._dt / time
        self.authority += min(max(target - self.authority, -step), step)
