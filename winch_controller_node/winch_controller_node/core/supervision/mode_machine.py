"""The mode machine: runs the table of modes, moves authority between its ends, and says why it is where it is."""

from __future__ import annotations

from heave_node.interface.codes import WinchFault, fault_words

from winch_controller_node.core.estimation.sense_design import BACK_TIME
from winch_controller_node.core.supervision.command_timeouts import WAIT
from winch_controller_node.core.supervision.modes import (
    BRAKED,
    COAST_RECOVERY,
    COASTING,
    FORGIVEN,
    MAY_RESUME,
    MOST_LOSSES,
    NOTHING_KNOWN,
    REQUESTS,
    SETTLED_ESTIMATE,
    TABLE,
    TICK_EVENTS,
    Event,
    Memory,
    Mode,
    ModeError,
    ModeOutput,
    Situation,
    Transition,
    View,
    goes_on_blind,
)
from winch_controller_node.parameters.laws import ModeParameters

FROZEN_ENCODER = "encoder frozen"
"""How it is called among the sensors that are lost; with the drum at rest it cannot show that it is good again."""

TRIES = (Mode.COMPENSATING.value, Mode.CONSTANT_TENSION.value, Mode.MANUAL.value)
"""Modes that move the winch: who requests one wants a frozen or reversed encoder to be tried again."""

HICCUP = 0.5
"""Sensors that were lost for no longer than this [s] need not be good for the whole of a wait again."""

ROWS: dict[tuple[Mode, Event], tuple[Transition, ...]] = {
    (mode, event): tuple(row for row in TABLE if mode in row.sources and row.event is event)
    for mode in Mode
    for event in Event
}
"""The rows that each event can take in each mode."""

LOOKED_FOR = {mode: [(event, happens) for event, happens in TICK_EVENTS.items() if ROWS[mode, event]] for mode in Mode}
"""The events of a tick that a mode has rows for, in their order."""


class ModeMachine:
    """Decides the mode each tick.

    Parameters
    ----------
    parameters : times and rates
    moves_winch : False: the law never moves the winch, and mode off is never left
    factor : largest authority; may be set to another one, to which authority goes over the fade-in time
    tick_period : [s]

    Attributes
    ----------
    mode, reason : after the last step or request
    target : authority that compensation goes to
    """

    def __init__(self, parameters: ModeParameters, *, moves_winch: bool, factor: float, tick_period: float) -> None:
        self._parameters = parameters
        self._dt = tick_period
        self.factor = factor
        self.mode = Mode.STANDBY if moves_winch else Mode.OFF
        self.reason = SETTLED_ESTIMATE.name if moves_winch else "law off"
        self.target = factor
        self._mode_before = self.mode
        self._memory = Memory(wants_compensation=parameters.start == "compensating")
        self._situation = NOTHING_KNOWN
        self._known_fault: int | None = None
        self._time = self._well_time = self._lost_time = self._coasted = 0.0

    @property
    def authority(self) -> float:
        """Authority of compensation, 0 to 1."""
        return self._memory.authority

    @property
    def wants_compensation(self) -> bool:
        """Tell whether compensation is to begin, or to go on, by itself."""
        return self._memory.wants_compensation

    @property
    def may_resume(self) -> bool:
        """Return whether compensation that a lost sensor has ended may resume: all are back for long enough."""
        return MAY_RESUME.holds(self._view)

    @property
    def obstacle(self) -> str:
        """What keeps compensation from beginning now, in words; empty where nothing does."""
        lost = self._tried.lost
        if lost:
            return f"{lost}; request it again once the sensor is good"
        harm = "" if self._situation.awaits_operator else self._situation.harm  # who asks has looked at the cause
        return harm or self._situation.gates()

    @property
    def _tried(self) -> Situation:
        """The situation in which an operator wants the winch to move: a frozen encoder is tried again."""
        lost = [one for one in self._situation.lost.split(", ") if one != FROZEN_ENCODER]
        return self._situation._replace(lost=", ".join(lost))

    @property
    def fault(self) -> str:
        """The fault that the winch reports, in words; empty where there is none."""
        fault = self._situation.winch_fault
        return "" if fault == WinchFault.NONE else fault_words(fault)

    @property
    def brake(self) -> bool:
        """Tell whether the brake is to be on."""
        return self.mode in BRAKED

    @property
    def is_damped_blind(self) -> bool:
        """Tell whether a fade-out damps the unit by the depth sensor alone."""
        return self.mode is Mode.FADE_OUT and self._situation.is_damped_blind

    def set_factor(self, factor: float) -> None:
        """Set the largest authority to `factor`; while compensating, authority goes there over the fade-in time."""
        self.factor = factor

    def request(self, name: str) -> None:
        """Request a mode by name.

        Raises ModeError, saying why, where it cannot be taken.
        """
        events = {mode.value: event for mode, event in REQUESTS.items()}
        if name not in events:
            raise ModeError(f"mode {name!r} cannot be requested; known: {', '.join(events)}")
        # an operator who asks for a mode knows of the fault that is there, and the brake acknowledges it
        self._known_fault = self._situation.winch_fault
        before = self._situation
        if name in TRIES:
            self._situation = self._tried
        if not self._take(events[name]):
            refusal, self._situation = self._refusal(name, events[name]), before
            raise ModeError(refusal)

    def touch_down(self) -> None:
        """Go over to constant tension: the unit has landed, even if a sensor is lost for a moment."""
        self._take(Event.TOUCHDOWN)

    def lift_off(self) -> None:
        """Compensate where the unit hangs; the next step does not tell of the change."""
        self._take(Event.LIFTED_OFF)
        self._mode_before = self.mode

    def step(self, situation: Situation) -> ModeOutput:
        """Advance one tick in a `situation` and return what is to be done."""
        self._situation = situation
        if self._known_fault is None or situation.winch_fault == WinchFault.NONE:
            self._known_fault = situation.winch_fault
        self._time += self._dt
        self._lost_time = self._lost_time + self._dt if situation.lost else 0.0
        self._coasted = (
            self._coasted + self._dt if situation.lost else max(self._coasted - COAST_RECOVERY * self._dt, 0.0)
        )
        if not situation.has_estimate or self._lost_time > HICCUP:
            self._well_time = 0.0
        elif not situation.lost:
            self._well_time += self._dt
        if self.mode is Mode.FADE_OUT:
            if goes_on_blind(self._view):
                # the unit is held at rest, and goes on so once its sensor is back
                self._time = min(self._time, self._parameters.fade_out_time)
            else:
                self._approach(0.0, self._parameters.fade_out_time)
        if self._is_quiet or not self._take_event():
            self._go_on()
        before, self._mode_before = self._mode_before, self.mode
        return ModeOutput(self.mode, self.reason, self.authority, self.brake, None if before is self.mode else before)

    @property
    def _is_quiet(self) -> bool:
        """Tell whether compensation goes on: none of the events that it has rows for has happened."""
        situation = self._situation
        has_news = situation.lost or situation.winch_fault or situation.harm or situation.envelope
        return self.mode is Mode.COMPENSATING and not has_news

    def _take_event(self) -> bool:
        """Take the first event of the tick that has a row; return whether there is one."""
        view = self._view
        return any(happens(view) and self._take(event) for event, happens in LOOKED_FOR[self.mode])

    @property
    def _view(self) -> View:
        return View(
            situation=self._situation,
            memory=self._memory,
            parameters=self._parameters,
            factor=self.factor,
            known_fault=self._known_fault or WinchFault.NONE,
            time=self._time,
            well_time=0.0 if self._situation.lost else self._well_time,
            lost_time=self._lost_time,
            coasted=self._coasted,
        )

    def _take(self, event: Event) -> bool:
        """Take the first row of an event whose guards hold; return whether there is one."""
        rows = ROWS[self.mode, event]
        if not rows:
            return False
        view = self._view
        row = next((row for row in rows if all(guard.holds(view) for guard in row.guards)), None)
        if row is None:
            return False
        for action in row.actions:
            self._memory = action(self._view)
        if row.target is not self.mode:
            self._enter(row.target, event)
        return True

    def _enter(self, mode: Mode, event: Event) -> None:
        if mode not in (Mode.COMPENSATING, Mode.FADE_OUT):
            self._memory = self._memory._replace(authority=0.0)
        self.reason = self._words(event)
        self.mode, self._time = mode, 0.0
        self._coasted = 0.0 if mode is Mode.COMPENSATING else self._coasted

    def _words(self, event: Event) -> str:
        """Return why an event changes the mode."""
        situation = self._situation
        if event in (Event.WINCH_FAULT, Event.WINCH_EMERGENCY_STOP):
            cause = f": {situation.fault_cause}" if situation.fault_cause else ""
            return f"winch fault: {self.fault}{cause}; {self._after_fault()}"
        if event in (Event.SENSOR_LOST, Event.WINCH_SILENT):
            return f"{situation.lost}; {self._after_loss()}"
        if event is Event.HARM:
            return self._harm
        if event is Event.ENVELOPE:
            return f"{situation.envelope}; check the cause, then request a mode"
        # a stop that comes to its end goes on for the reason for which it began
        return self.reason if event in (Event.FADED, Event.AT_REST) else event.value

    @property
    def _harm(self) -> str:
        """What harm compensation does, and when it is tried again; empty where it does none."""
        return "; ".join(part for part in (self._situation.harm, self._situation.prospect) if part)

    def _after_loss(self) -> str:
        """Return what becomes of a mode that a lost sensor has ended, once that is good again."""
        if self._memory.losses > MOST_LOSSES:
            return f"a sensor was lost {self._memory.losses} times: request a mode once it is good and stays so"
        if not (self.wants_compensation and self._memory.may_resume):
            return "request a mode once the sensor is good"
        if not self._parameters.resume:
            return "compensation resumes automatically only while authority falls; after that request it"
        if FROZEN_ENCODER in self._situation.lost:
            return "compensation resumes automatically once the count changes, or on request"
        if self._memory.losses > 1:
            wait = BACK_TIME * self._memory.patience
            return (
                f"compensation resumes automatically once the sensor has been good for {wait:.0f} s: it comes and goes"
            )
        until = "; until then the depth sensor damps the load" if self._situation.is_damped_blind else ""
        return f"compensation resumes automatically once the sensor is good{until}"

    def _after_fault(self) -> str:
        """Return what becomes of a mode that a fault of the winch has ended, once that is cleared."""
        if self._situation.resumes_after_fault:
            return f"compensation resumes automatically {WAIT:g} s after commands reach the winch again"
        return "clear it, then request a mode"

    def _refusal(self, name: str, event: Event) -> str:
        """Return why no row of a request can be taken."""
        if self.mode is Mode.OFF:
            return "law off: the controller does not move the winch"
        rows = ROWS[self.mode, event]
        if not rows:
            return f"mode {name} cannot be entered from mode {self.mode.value}: request standby first"
        view = self._view
        missing = [guard.refusal(view) for guard in rows[0].guards if not guard.holds(view)]
        return f"mode {name} needs: {'; '.join(missing)}"

    def _approach(self, target: float, time: float) -> None:
        step = self._dt / time
        change = min(max(target - self.authority, -step), step)
        if change:
            self._memory = self._memory._replace(authority=self.authority + change)

    def _go_on(self) -> None:
        """Move authority to what the winch can follow, and say why the mode stays what it is."""
        situation = self._situation
        if self.mode is Mode.COMPENSATING:
            if self._time > FORGIVEN and self._memory.losses:
                self._memory = self._memory._replace(losses=0)
            self.target = self.factor * situation.authority_limit
            self._approach(self.target, self._parameters.fade_in_time)
            self.reason = f"{COASTING}: {situation.lost}" if situation.lost else ""
        elif self.mode is Mode.FADE_OUT and self.wants_compensation and situation.harm:
            self.reason = self._harm  # the cause may have become known
        elif self.mode is Mode.STANDBY and situation.lost:
            self.reason = situation.lost
        elif self.mode is Mode.STANDBY and self.wants_compensation:
            self.reason = self._why_waiting()

    def _why_waiting(self) -> str:
        """Return what compensation waits for."""
        if not SETTLED_ESTIMATE.holds(self._view):
            return f"estimate settling, {self._parameters.settling_time - self._well_time:.0f} s more"
        situation = self._situation
        return self._harm or situation.gates() or self.reason
