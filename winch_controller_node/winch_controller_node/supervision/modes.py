"""The mode machine: what the controller does, why, and how it gets from one mode to another without a step.

off: law off, the brake stays on. standby: the brake is on, the estimator runs. compensating: authority rises to the
share asked for. fade_out: authority falls to zero, then standby or stopping. constant_tension: tension is held.
stopping: the winch comes to rest at a bounded deceleration, then stopped, with the brake on. emergency_stop: brake at
once, and it stays until another mode is requested.
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
"""Modes that may be requested."""

BRAKED = (Mode.OFF, Mode.STANDBY, Mode.STOPPED, Mode.EMERGENCY_STOP)
"""Modes in which the brake is on."""

RELEASE_TIME = 0.5
"""Time that the brake stays on before a braked winch is moved [s]: it acknowledges a latched fault."""

RELEASED_TIME = 2.0
"""A fault that was latched may still be told for so long after the brake was released [s]: commands take time."""

BACK_TIME = 1.0
"""A lost sensor that has been back for so long [s] ends the fade-out that its loss has caused."""

SETTLING_LIMIT = 30.0
"""Longest time that a unit may take to settle after a fade-out [s]."""


class ModeError(ValueError):
    """A mode that cannot be taken now; the message says why."""


@dataclass(frozen=True, slots=True)
class Situation:
    """What the mode machine is told each tick.

    Attributes
    ----------
    lost : required sensors that are lost, with the reason ("mru frozen"), empty when none
    has_estimate : the estimator has had the readings it needs
    winch_fault : number of the winch's own fault, see WinchFault
    harm : the guard's reason to fade out, empty when there is none
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


@dataclass(frozen=True, slots=True)
class ModeOutput:
    """What the mode asks for in a tick.

    Attributes
    ----------
    mode : that is in force; reason : why, empty when there is nothing to say
    authority : share of the sea that is compensated, 0 to 1
    brake : is to be on
    before : mode of the tick before; None: the same
    """

    mode: Mode
    reason: str
    authority: float
    brake: bool
    before: Mode | None = None


class ModeMachine:
    """Decides the mode each tick.

    Parameters
    ----------
    parameters : times and rates
    moves_winch : False: the law never moves the winch, and mode off is never left
    factor : largest authority
    tick_period : [s]

    Attributes
    ----------
    mode, reason, authority : after the last step or request
    target : authority that compensation goes to
    """

    def __init__(self, parameters: ModeParameters, *, moves_winch: bool, factor: float, tick_period: float) -> None:
        self._parameters = parameters
        self._dt = tick_period
        self._factor = factor
        self.mode = Mode.STANDBY if moves_winch else Mode.OFF
        self.reason = "estimate settling" if moves_winch else "law off"
        self._mode_before = self.mode
        self.authority = 0.0
        self.target = factor
        self._time = 0.0
        self._well_time = 0.0
        self._lost_time = 0.0
        self._wants_compensation = parameters.start == "compensating"
        self._after_fade = Mode.STANDBY
        self._may_resume = True
        self._known_fault = int(WinchFault.NONE)

    @property
    def brake(self) -> bool:
        """Tell whether the brake is to be on."""
        return self.mode in BRAKED

    def request(self, name: str) -> None:
        """Request a mode by name.

        Raises ModeError, saying why, where it cannot be taken.
        """
        known = [mode.value for mode in REQUESTS]
        if name not in known:
            raise ModeError(f"mode {name!r} cannot be requested; known: {', '.join(known)}")
        mode = Mode(name)
        if mode is Mode.EMERGENCY_STOP:
            self._enter(Mode.EMERGENCY_STOP, "requested")
            return
        if self.mode is Mode.OFF:
            raise ModeError("law off: the controller does not move the winch")
        if mode is Mode.STOPPED:
            self._wants_compensation = False
            if not self.brake:
                self._enter(Mode.STOPPING, "requested")
            return
        self._request_motion(mode)

    def _request_motion(self, mode: Mode) -> None:
        self._may_resume = True
        if mode is Mode.CONSTANT_TENSION:
            if self._lost_time > 0.0:
                raise ModeError("constant tension needs MRU, load cell and encoder: one of them is lost")
            self._wants_compensation = False
            self._enter(Mode.CONSTANT_TENSION, "requested")
            return
        self._wants_compensation = mode is Mode.COMPENSATING
        if mode is Mode.STANDBY:
            if self.mode in (Mode.COMPENSATING, Mode.CONSTANT_TENSION):
                self._fade(Mode.STANDBY, "standby requested")
            elif self.mode in (Mode.STOPPED, Mode.EMERGENCY_STOP):
                self._enter(Mode.STANDBY, "requested")
            return
        if self.mode in (Mode.STOPPED, Mode.EMERGENCY_STOP):
            self._enter(Mode.STANDBY, "compensation requested")
        elif self.mode is Mode.CONSTANT_TENSION:
            self._enter(Mode.COMPENSATING, "requested")
            self.authority = self._factor

    def touch_down(self) -> None:
        """Go over to constant tension: the unit has landed, even if a sensor is lost for a moment."""
        self._wants_compensation = False
        self._enter(Mode.CONSTANT_TENSION, "touchdown")

    def step(self, situation: Situation) -> ModeOutput:
        """Advance one tick in a `situation` and return what is to be done."""
        self._time += self._dt
        self._lost_time = self._lost_time + self._dt if situation.lost else 0.0
        self._well_time = 0.0 if situation.lost or not situation.has_estimate else self._well_time + self._dt
        if situation.winch_fault and self.mode not in (Mode.OFF, Mode.EMERGENCY_STOP):
            if situation.winch_fault != self._known_fault or self._time > RELEASED_TIME:
                self._trip(situation)
        else:
            self._known_fault = WinchFault.NONE
        {
            Mode.STANDBY: self._standby,
            Mode.COMPENSATING: self._compensating,
            Mode.CONSTANT_TENSION: self._constant_tension,
            Mode.FADE_OUT: self._fade_out,
            Mode.STOPPING: self._stopping,
            Mode.STOPPED: self._stopped,
        }.get(self.mode, self._stay)(situation)
        before, self._mode_before = self._mode_before, self.mode
        return ModeOutput(self.mode, self.reason, self.authority, self.brake, None if before is self.mode else before)

    def acknowledge(self) -> None:
        """Count a change of mode since the last step as seen: the next step does not tell of it."""
        self._mode_before = self.mode

    def _trip(self, situation: Situation) -> None:
        """The winch has stopped by itself: brake on until an operator requests another mode."""
        self._known_fault = situation.winch_fault
        if self.mode in (Mode.STANDBY, Mode.STOPPED):
            return
        is_stop = situation.winch_fault == WinchFault.EMERGENCY_STOP
        self._wants_compensation = False
        words = f"winch fault: {fault_words(situation.winch_fault)}"
        self._enter(Mode.EMERGENCY_STOP if is_stop else Mode.STOPPED, words)

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
            self._enter(Mode.COMPENSATING, "sensors available again")
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
            self._enter(Mode.STANDBY, "sensors available again")

    def _stay(self, situation: Situation) -> None:
        """Off and emergency stop wait for the operator."""

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
