"""The mode machine in words: requests, and why a mode is what it is. `heave_core` (modes.cpp) runs the table."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from heave_core.library import fill, library, new
from heave_core.modes_table import MODE_DESIGN, MODE_STATE, SITUATION, ModeGuard, ModeNumber
from heave_node.interface.codes import WinchFault, fault_words

from winch_controller_node.core.estimation.sense_design import BACK_TIME
from winch_controller_node.core.supervision.modes import (
    BRAKED,
    COASTING,
    EVENTS,
    MODES,
    MOST_LOSSES,
    RELEASE_TIME,
    REQUESTS,
    SETTLED_ESTIMATE,
    TABLE,
    WAIT,
    Event,
    Mode,
    ModeError,
    ModeOutput,
    Situation,
    event_number,
    mode_design,
)
from winch_controller_node.parameters.laws import ModeParameters

FROZEN_ENCODER = "encoder frozen"
"""How it is called among the sensors that are lost; with the drum at rest it cannot show that it is good again."""

TRIES = (Mode.COMPENSATING.value, Mode.CONSTANT_TENSION.value, Mode.MANUAL.value)
"""Modes that move the winch: who requests one wants a frozen or reversed encoder to be tried again."""

AUTHORITY, TARGET, FACTOR, TIME, WELL_TIME = range(5)
"""Places among the numbers of the core's ModeState."""

WORDED = (
    *(Event.WINCH_FAULT, Event.WINCH_EMERGENCY_STOP, Event.SENSOR_LOST, Event.WINCH_SILENT, Event.HARM, Event.ENVELOPE),
)
"""Events whose words say more than their name."""

GUARDS = {guard.number: guard for row in TABLE for guard in row.guards}
"""Guards by their number in the core."""


class ModeMachine:
    """The mode, on the core's memory.

    Parameters
    ----------
    parameters : times and rates
    look : returns what the last tick is, in words
    moves_winch : False: the law never moves the winch, and mode off is never left
    factor : largest authority; may be set to another one, to which authority goes over the fade-in time
    tick_period : [s]

    Attributes
    ----------
    design, state, situation : arrays of one of the core's structures
    mode : after the last step or request
    """

    def __init__(
        self,
        parameters: ModeParameters,
        look: Callable[[], Situation] = Situation,
        *,
        moves_winch: bool,
        factor: float,
        tick_period: float,
    ) -> None:
        self._parameters = parameters
        self.design, self.state, self.situation = new(MODE_DESIGN), new(MODE_STATE), new(SITUATION)
        fill(self.design[0], mode_design(parameters, tick_period))
        self.mode = Mode.STANDBY if moves_winch else Mode.OFF
        self._entered = SETTLED_ESTIMATE.name if moves_winch else "law off"
        self._has_entered = True
        self._look = look
        number = MODES.index(self.mode)
        times = dict.fromkeys(("time", "well_time", "lost_time", "coasted", "authority", "losses"), 0.0)
        memory = {"wants": parameters.start == "compensating", "may_resume": True, "rest": ModeNumber.IN_STANDBY}
        modes = {"mode": number, "before": number, "known_fault": -1}
        fill(self.state[0], {**times, **memory, **modes, "target": factor, "factor": factor})
        self._row, self._numbers = self.state[0], self.state.view(np.uint8)[: 5 * 8].view(np.float64)
        self._at = [one.ctypes.data for one in (self.design, self.situation, self.state)]
        core = library()
        self._request, self._event = core.heave_core_modes_request, core.heave_core_modes_event
        self._missing = core.heave_core_modes_missing

    @property
    def authority(self) -> float:
        """Authority of compensation, 0 to 1."""
        return self._numbers.item(AUTHORITY)  # type: ignore[no-any-return]

    @property
    def target(self) -> float:
        """Authority that compensation goes to."""
        return self._numbers.item(TARGET)  # type: ignore[no-any-return]

    @property
    def factor(self) -> float:
        """Largest authority."""
        return self._numbers.item(FACTOR)  # type: ignore[no-any-return]

    @property
    def wants_compensation(self) -> bool:
        """Tell whether compensation is to begin, or to go on, by itself."""
        return bool(self._row["wants"])

    @property
    def obstacle(self) -> str:
        """What keeps compensation from beginning now, in words; empty where nothing does."""
        now = _tried(self._look())
        if now.lost:
            return f"{now.lost}; request it again once the sensor is good"
        harm = "" if now.awaits_operator else now.harm  # who asks has looked at the cause
        return harm or now.gates

    @property
    def fault(self) -> str:
        """The fault that the winch reports, in words; empty where there is none."""
        fault = int(self.situation["winch_fault"][0])
        return "" if fault == WinchFault.NONE else fault_words(fault)

    @property
    def brake(self) -> bool:
        """Tell whether the brake is to be on."""
        return self.mode in BRAKED

    @property
    def is_damped_blind(self) -> bool:
        """Tell whether a fade-out damps the unit by the depth sensor alone."""
        return self.mode is Mode.FADE_OUT and bool(self.situation["is_damped_blind"][0])

    @property
    def coasts(self) -> bool:
        """Tell whether compensation goes on without a sensor that it requires."""
        is_lost = bool(self.situation["lost"][0])
        return self.mode is Mode.COMPENSATING and is_lost and not self._has_entered

    @property
    def reason(self) -> str:
        """Why the mode is what it is; empty while compensation just goes on."""
        if self._has_entered:
            return self._entered
        if self.mode is Mode.COMPENSATING:
            return f"{COASTING}: {self._look().lost}" if self.coasts else ""
        now = self._look()
        if self.mode is Mode.FADE_OUT and self.wants_compensation and now.harm:
            return _harm(now)  # the cause may have become known
        if self.mode is Mode.STANDBY:
            return now.lost or (self._why_waiting(now) if self.wants_compensation else "") or self._entered
        return self._entered

    def set_factor(self, factor: float) -> None:
        """Set the largest authority to `factor`; while compensating, authority goes there over the fade-in time."""
        self._numbers[FACTOR] = factor

    def request(self, name: str) -> None:
        """Request a mode by name.

        Raises ModeError, saying why, where it cannot be taken.
        """
        events = {mode.value: event for mode, event in REQUESTS.items()}
        if name not in events:
            raise ModeError(f"mode {name!r} cannot be requested; known: {', '.join(events)}")
        number = event_number(events[name])
        missing = self._missing(*self._at[:2], number, self._at[2])
        refusal = self._refusal(name, missing) if missing else ""
        if not self._request(*self._at[:2], number, self._at[2]):
            raise ModeError(refusal)
        self._enter(events[name])

    def resume(self) -> None:
        """Note that the core has asked for compensation again."""
        self._enter(Event.ASK_COMPENSATING)

    def touch_down(self) -> None:
        """Go over to constant tension: the unit has landed, even if a sensor is lost for a moment."""
        if self._event(*self._at[:2], event_number(Event.TOUCHDOWN), self._at[2]):
            self._enter(Event.TOUCHDOWN)

    def lift_off(self) -> None:
        """Compensate where the unit hangs; the next step does not tell of the change."""
        if self._event(*self._at[:2], event_number(Event.LIFTED_OFF), self._at[2]):
            self._enter(Event.LIFTED_OFF)
        self._row["before"] = self._row["mode"]

    @property
    def output(self) -> ModeOutput:
        """What is to be done in a tick that has not changed the mode."""
        return ModeOutput(self.mode, "", self.authority, self.brake)

    def go_on(self) -> None:
        """Take that the core has made a step without an event."""
        self._has_entered = False

    def follow(self, event: int, before: int) -> ModeOutput:
        """Take that the core has made a step; return what is to be done.

        Parameters
        ----------
        event : number of that which it has taken; -1: none
        before : number of the mode of the step before
        """
        if event >= 0:
            self._enter(EVENTS[event])
        else:
            self.go_on()
        last = MODES[before]
        return self.output if last is self.mode else self.output._replace(reason=self.reason, before=last)

    def _enter(self, event: Event) -> None:
        """Take the mode of the core, which an `event` may have changed, with its reason."""
        mode = MODES[int(self._row["mode"])]
        if mode is self.mode:
            return
        # a stop that comes to its end goes on for the reason for which it began
        self._entered = self.reason if event in (Event.FADED, Event.AT_REST) else self._words(event)
        self.mode, self._has_entered = mode, True

    def _words(self, event: Event) -> str:
        """Return why an event changes the mode."""
        if event not in WORDED:
            return str(event.value)
        now = self._look()
        if event in (Event.WINCH_FAULT, Event.WINCH_EMERGENCY_STOP):
            cause = f": {now.fault_cause}" if now.fault_cause else ""
            return f"winch fault: {self.fault}{cause}; {_after_fault(now)}"
        if event in (Event.SENSOR_LOST, Event.WINCH_SILENT):
            return f"{now.lost}; {self._after_loss(now)}"
        if event is Event.HARM:
            return _harm(now)
        return f"{now.envelope}; check the cause, then request a mode"

    def _after_loss(self, now: Situation) -> str:
        """Return what becomes of a mode that a lost sensor has ended, once that is good again."""
        losses = int(self._row["losses"])
        if losses > MOST_LOSSES:
            return f"a sensor was lost {losses} times: request a mode once it is good and stays so"
        if not (self.wants_compensation and self._row["may_resume"]):
            return "request a mode once the sensor is good"
        if not self._parameters.resume:
            return "compensation resumes automatically only while authority falls; after that request it"
        if FROZEN_ENCODER in now.lost:
            return "compensation resumes automatically once the count changes, or on request"
        if losses > 1:
            growth = float(self.design["loss_growth"][0]) ** (losses - 1)
            wait, stopped = (f"{time * growth:.0f} s" for time in (BACK_TIME, self._parameters.resume_time))
            good = f"good for {wait}, {stopped} once the winch has stopped"
            return f"compensation resumes automatically once the sensor has been {good}: it comes and goes"
        until = "; until then the depth sensor damps the load" if now.is_damped_blind else ""
        return f"compensation resumes automatically once the sensor is good{until}"

    def _refusal(self, name: str, missing: int) -> str:
        """Return why no row of a request can be taken: bits of guards that are `missing`; below 0: there is no row."""
        if self.mode is Mode.OFF:
            return "law off: the controller does not move the winch"
        if missing < 0:
            return f"mode {name} cannot be entered from mode {self.mode.value}: request standby first"
        now = _tried(self._look()) if name in TRIES else self._look()
        reasons = [GUARDS[guard].refusal(now) for guard in ModeGuard if guard & missing]
        return f"mode {name} needs: {'; '.join(reasons)}"

    def _why_waiting(self, now: Situation) -> str:
        """Return what compensation waits for."""
        wait = max(self._parameters.settling_time, RELEASE_TIME) - self._numbers.item(WELL_TIME)
        if wait > 0.0:
            return f"estimate settling, {wait:.0f} s more"
        return _harm(now) or now.gates


def _tried(now: Situation) -> Situation:
    """Return a situation in which an operator wants the winch to move: a frozen encoder is tried again."""
    return now._replace(lost=", ".join(one for one in now.lost.split(", ") if one != FROZEN_ENCODER))


def _harm(now: Situation) -> str:
    """Return what harm compensation does, and when it is tried again; empty where it does none."""
    return "; ".join(part for part in (now.harm, now.prospect) if part)


def _after_fault(now: Situation) -> str:
    """Return what becomes of a mode that a fault of the winch has ended, once that is cleared."""
    if now.resumes_after_fault:
        return f"compensation resumes automatically {WAIT:g} s after commands reach the winch again"
    return "request a mode once it is cleared"
