"""The modes of the controller, and the one table that says how it gets from one to another.

off: law off, the brake stays on. standby: the brake is on, the estimator runs. compensating: authority rises to the
share asked for. fade_out: authority falls to zero. constant_tension: tension is held. manual: the operator's speed
alone. stopping: the winch comes to rest at a bounded deceleration, then standby or stopped, with the brake on.
emergency_stop: brake at once, and it stays until another mode is requested.

`TABLE` has a row for each (mode, event, guard). Requests are events that come from an operator; all others are looked
for each tick, in the order of `TICK_EVENTS`. The first row whose guard holds is taken. A request without such a row is
refused with the words of the guards that did not hold. `mode_picture` draws the table.

Arguments: `view` is what events, guards and actions may look at. An action returns the new memory of the machine.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from heave_node.interface.codes import REQUESTED, WinchFault, fault_words
from heave_node.winch.fault_latch import is_automatic

from winch_controller_node.core.estimation.sense_design import BACK_TIME
from winch_controller_node.parameters.laws import ModeParameters


class Mode(str, Enum):
    """Modes by the names of heave_msgs/ControllerState."""

    OFF = "off"
    STANDBY = "standby"
    COMPENSATING = "compensating"
    CONSTANT_TENSION = "constant_tension"
    MANUAL = "manual"
    FADE_OUT = "fade_out"
    STOPPING = "stopping"
    STOPPED = "stopped"
    EMERGENCY_STOP = "emergency_stop"


BRAKED = (Mode.OFF, Mode.STANDBY, Mode.STOPPED, Mode.EMERGENCY_STOP)
"""Modes in which the brake is on."""

MOVING = (Mode.COMPENSATING, Mode.CONSTANT_TENSION, Mode.MANUAL, Mode.FADE_OUT, Mode.STOPPING)
"""Modes in which the winch may move."""

RELEASE_TIME = 0.5
"""Time that the brake stays on before a braked winch is moved [s]: it acknowledges a latched fault."""

RELEASED_TIME = 2.0
"""Time after release of the brake for which a latched fault may still be reported [s]: commands take time."""

SETTLING_LIMIT = 30.0
"""Longest time that a unit may take to settle after a fade-out [s]."""

STOPPING_LIMIT = 20.0
"""Longest time that the winch may take to come to rest [s]; then the brake goes on, and the winch stops by itself."""

MOST_LOSSES, LOSS_GROWTH, FORGIVEN = 3, 4.0, 600.0
"""Compensation resumes automatically after so many losses of a sensor, each time after so many times the wait of the
time before; they count no more once it has gone on for so long [s]."""

COAST_RECOVERY = 0.2
"""Share of the time in which a sensor is good that makes up for as much in which it was lost: one that comes and goes
is lost."""

STANDSTILL = 1e-3
"""Speed below which the winch is at rest [m/s]."""


class ModeError(ValueError):
    """A mode that cannot be taken now; the message says why."""


class Event(str, Enum):
    """What can happen, in words."""

    ASK_STANDBY = f"standby {REQUESTED}"
    ASK_COMPENSATING = f"compensation {REQUESTED}"
    ASK_CONSTANT_TENSION = f"constant tension {REQUESTED}"
    ASK_MANUAL = f"manual {REQUESTED}"
    ASK_STOPPED = f"stop {REQUESTED}"
    ASK_EMERGENCY_STOP = f"emergency stop {REQUESTED}"
    TOUCHDOWN = "touchdown"
    LIFTED_OFF = "unit suspended"
    ENVELOPE = "envelope took over"
    WINCH_EMERGENCY_STOP = "emergency stop of the winch"
    WINCH_FAULT = "winch fault"
    WINCH_SILENT = "no data from the winch"
    SENSOR_LOST = "sensor lost"
    HARM = "compensation makes it worse"
    SENSORS_BACK = "sensors available again"
    SETTLED = "estimate settled"
    FADED = "faded out"
    AT_REST = "winch at rest"


REQUESTS = {
    Mode.STANDBY: Event.ASK_STANDBY,
    Mode.COMPENSATING: Event.ASK_COMPENSATING,
    Mode.CONSTANT_TENSION: Event.ASK_CONSTANT_TENSION,
    Mode.MANUAL: Event.ASK_MANUAL,
    Mode.STOPPED: Event.ASK_STOPPED,
    Mode.EMERGENCY_STOP: Event.ASK_EMERGENCY_STOP,
}
"""Modes that may be requested, and the event that the request is."""


def open_always() -> str:
    """Return that nothing keeps a mode from beginning."""
    return ""


class Situation(NamedTuple):
    """Inputs of the mode machine at each tick.

    Attributes
    ----------
    lost : sensors that the present mode requires and that are lost, with the reason ("mru frozen"), empty when none
    has_estimate : the estimator has had the readings it needs
    winch_fault : number of the winch's own fault, see WinchFault
    harm : the guard's reason to fade out, empty when there is none
    prospect : when compensation is tried again after harm, in words
    speed : speed of the winch as commanded [m/s], absolute; infinite while the envelope brings it to rest
    authority_limit : largest authority that the winch can follow under this law
    is_settled : the unit moves as it would with the winch locked, or cannot be damped: the winch may stop
    is_damped_blind : the unit is damped by the depth sensor, and how it would move with the winch locked is not known
    gates : says why compensation may not begin now, with figures; empty when it may
    tension : says why constant tension may not begin now; empty when it may
    fault_cause : why the winch has its fault, in words; empty where that is not known
    awaits_operator : after this harm compensation is tried again only once an operator asks for it
    resumes_after_fault : the winch has stopped for want of commands, and compensation is asked for again once they come
    envelope : why the envelope has taken over, until an operator acknowledges; empty: it has not
    shown_authority : that unit and drum show, as they move
    """

    lost: str
    has_estimate: bool
    winch_fault: int
    harm: str
    speed: float
    authority_limit: float = 1.0
    is_settled: bool = True
    is_damped_blind: bool = False
    gates: Callable[[], str] = open_always
    tension: Callable[[], str] = open_always
    fault_cause: str = ""
    prospect: str = ""
    awaits_operator: bool = False
    resumes_after_fault: bool = False
    envelope: str = ""
    shown_authority: float = 0.0


NOTHING_KNOWN = Situation(lost="", has_estimate=False, winch_fault=WinchFault.NONE, harm="", speed=0.0)
"""Inputs before the first tick."""


class Memory(NamedTuple):
    """What the mode machine remembers beside its mode.

    Attributes
    ----------
    wants_compensation : compensation is to begin, or to go on, by itself
    may_resume : also after the winch was stopped for a lost sensor
    rest : mode in which a fade-out or a stop ends, standby or stopped
    authority : authority of compensation, 0 to 1
    losses : times that a lost sensor has ended compensation of late
    """

    wants_compensation: bool
    may_resume: bool = True
    rest: Mode = Mode.STANDBY
    authority: float = 0.0
    losses: int = 0

    @property
    def patience(self) -> float:
        """Times the usual wait for which sensors must be good before compensation resumes."""
        return LOSS_GROWTH ** max(self.losses - 1, 0)


class View(NamedTuple):
    """All that guards and events may look at.

    Attributes
    ----------
    situation : of this tick, or of the last one for a request
    memory : of the machine
    parameters : times and rates
    factor : largest authority
    known_fault : fault of the winch that was there at the start, or when an operator last asked for a mode
    time : in the present mode [s]
    well_time, lost_time : for which all required sensors have been well, or one was lost [s]
    coasted : time in which one was lost of late, with what it was good meanwhile taken off [s]
    """

    situation: Situation
    memory: Memory
    parameters: ModeParameters
    factor: float
    known_fault: int
    time: float
    well_time: float
    lost_time: float
    coasted: float = 0.0


# events of a tick


def goes_on_blind(view: View) -> bool:
    """Tell whether a fade-out goes on for as long as the boom tip is not known: no operator has asked for rest."""
    return view.situation.is_damped_blind and view.memory.wants_compensation


def _has_faded(view: View) -> bool:
    situation, longest = view.situation, view.parameters.fade_out_time + SETTLING_LIMIT
    is_over = situation.is_settled or view.time > longest
    return view.memory.authority == 0.0 and is_over and not goes_on_blind(view)


def _has_new_fault(view: View) -> bool:
    fault, known = view.situation.winch_fault, view.known_fault
    return fault != WinchFault.NONE and (fault != known or view.time > RELEASED_TIME)


TICK_EVENTS: dict[Event, Callable[[View], bool]] = {
    Event.WINCH_EMERGENCY_STOP: lambda view: (
        view.situation.winch_fault == WinchFault.EMERGENCY_STOP and _has_new_fault(view)
    ),
    Event.WINCH_FAULT: _has_new_fault,
    Event.ENVELOPE: lambda view: bool(view.situation.envelope),
    Event.WINCH_SILENT: lambda view: "encoder stale" in view.situation.lost,  # it comes with the state of the winch
    Event.SENSOR_LOST: lambda view: max(view.lost_time, view.coasted) > view.parameters.coast_time,
    Event.HARM: lambda view: bool(view.situation.harm),
    Event.SENSORS_BACK: lambda view: view.well_time > BACK_TIME * view.memory.patience,
    Event.SETTLED: lambda view: view.well_time >= max(view.parameters.settling_time, RELEASE_TIME),
    Event.FADED: _has_faded,
    Event.AT_REST: lambda view: (
        view.situation.speed < STANDSTILL or (view.time > STOPPING_LIMIT and math.isfinite(view.situation.speed))
    ),
}
"""Conditions checked each tick, in this order."""


# guards


@dataclass(frozen=True, slots=True)
class Guard:
    """A condition on a row.

    Attributes
    ----------
    name : what must hold, in words
    holds : returns whether it does
    why_not : says why it does not, with figures; None: the name says enough
    """

    name: str
    holds: Callable[[View], bool]
    why_not: Callable[[View], str] | None = None

    def refusal(self, view: View) -> str:
        """Return why the guard does not hold, in words."""
        detail = "" if self.why_not is None else self.why_not(view)
        return f"{self.name} ({detail})" if detail else self.name


WANTED = Guard("compensation intended", lambda view: view.memory.wants_compensation)
NO_HARM = Guard("compensation does no harm", lambda view: not view.situation.harm, lambda view: view.situation.harm)
NO_FAULT = Guard(
    "no winch fault",
    lambda view: view.situation.winch_fault == WinchFault.NONE,
    lambda view: fault_words(view.situation.winch_fault),
)
NEW_FAULT = Guard("the fault is new", lambda view: view.situation.winch_fault != view.known_fault)
NOT_FOR_WANT_OF_COMMANDS = Guard(
    "the fault is not a command timeout", lambda view: not is_automatic(view.situation.winch_fault)
)
SENSORS_WELL = Guard("sensors good", lambda view: view.lost_time == 0.0, lambda view: view.situation.lost)
GATES_OPEN = Guard("start conditions met", lambda view: not view.situation.gates(), lambda view: view.situation.gates())
MAY_HOLD_TENSION = Guard(
    "load landed or held, winch able to follow",
    lambda view: not view.situation.tension(),
    lambda view: view.situation.tension(),
)
BRAKE_HELD = Guard(f"brake on for {RELEASE_TIME:g} s", lambda view: view.time >= RELEASE_TIME)
HAS_ENCODER = Guard("encoder good", lambda view: "encoder" not in view.situation.lost)
SETTLED_ESTIMATE = Guard("estimate settled", TICK_EVENTS[Event.SETTLED])
RESTS_IN_STANDBY = Guard("ends in standby", lambda view: view.memory.rest is Mode.STANDBY)
RESTS_STOPPED = Guard("ends in stopped", lambda view: view.memory.rest is Mode.STOPPED)
MAY_RESUME = Guard(
    "automatic restart allowed, and all sensors good for modes.resume_time (longer after each loss)",
    lambda view: (
        view.parameters.resume
        and view.memory.may_resume
        and view.well_time > view.parameters.resume_time * view.memory.patience
    ),
)

# actions


Action = Callable[[View], Memory]


def want_compensation(view: View) -> Memory:
    """Compensate as soon as that is possible."""
    return view.memory._replace(wants_compensation=True, may_resume=True, losses=0)


def want_rest(view: View) -> Memory:
    """Do not compensate until an operator asks for it."""
    return view.memory._replace(wants_compensation=False, may_resume=True, losses=0)


def end_in_standby(view: View) -> Memory:
    """Let the stop end in standby."""
    return view.memory._replace(rest=Mode.STANDBY)


def end_stopped(view: View) -> Memory:
    """Let the stop end in stopped."""
    return view.memory._replace(rest=Mode.STOPPED)


def compensate_nothing(view: View) -> Memory:
    """Begin with none of the sea."""
    return view.memory._replace(authority=0.0)


def compensate_all(view: View) -> Memory:
    """Begin with all of the sea: the winch follows it already."""
    return view.memory._replace(authority=view.factor)


def compensate_as_shown(view: View) -> Memory:
    """Begin with the share of the sea that unit and drum show: neither has to go elsewhere first."""
    most = view.factor * view.situation.authority_limit
    return view.memory._replace(authority=min(view.situation.shown_authority, most))


def wait_for_operator(view: View) -> Memory:
    """Do nothing until an operator asks for it."""
    return view.memory._replace(wants_compensation=False, may_resume=False)


def count_loss(view: View) -> Memory:
    """Count a lost sensor; after too many of them wait for an operator."""
    losses = view.memory.losses + 1
    is_over = losses > MOST_LOSSES
    memory = wait_for_operator(view) if is_over else view.memory
    return memory._replace(losses=losses)


# the table


@dataclass(frozen=True, slots=True)
class Transition:
    """A row of the table.

    Attributes
    ----------
    sources : modes that it leaves
    event : on which
    target : mode that it enters; the same as the source: the mode stays, and only the actions are done
    guards : that must all hold
    actions : that are done, in order
    """

    sources: tuple[Mode, ...]
    event: Event
    target: Mode
    guards: tuple[Guard, ...] = ()
    actions: tuple[Action, ...] = ()


def _staying(modes: tuple[Mode, ...], event: Event, *actions: Action) -> tuple[Transition, ...]:
    """Return rows in which an event only does `actions`."""
    return tuple(Transition((mode,), event, mode, (), actions) for mode in modes)


_OFF, _STANDBY, _STOPPED, _EMERGENCY = BRAKED
_COMPENSATING, _TENSION, _MANUAL, _FADE_OUT, _STOPPING = MOVING

TABLE: tuple[Transition, ...] = (
    # what an operator asks for
    Transition((*BRAKED[1:], *MOVING), Event.ASK_EMERGENCY_STOP, _EMERGENCY, (), (wait_for_operator,)),
    *_staying((_OFF,), Event.ASK_EMERGENCY_STOP),
    Transition((_COMPENSATING,), Event.ASK_STOPPED, _FADE_OUT, (), (want_rest, end_stopped)),
    Transition((_TENSION,), Event.ASK_STOPPED, _FADE_OUT, (), (want_rest, end_stopped, compensate_all)),
    Transition((_MANUAL,), Event.ASK_STOPPED, _STOPPING, (), (want_rest, end_stopped)),
    Transition((_STANDBY,), Event.ASK_STOPPED, _STOPPED, (), (want_rest,)),
    *_staying((_FADE_OUT, _STOPPING), Event.ASK_STOPPED, want_rest, end_stopped),
    *_staying((_STOPPED, _EMERGENCY), Event.ASK_STOPPED, wait_for_operator),
    *_staying((_OFF,), Event.ASK_STOPPED),
    Transition((_COMPENSATING,), Event.ASK_STANDBY, _FADE_OUT, (), (want_rest, end_in_standby)),
    Transition((_TENSION,), Event.ASK_STANDBY, _FADE_OUT, (), (want_rest, end_in_standby, compensate_all)),
    Transition((_MANUAL,), Event.ASK_STANDBY, _STOPPING, (), (want_rest, end_in_standby)),
    Transition((_STOPPED, _EMERGENCY), Event.ASK_STANDBY, _STANDBY, (), (want_rest,)),
    *_staying((_STANDBY,), Event.ASK_STANDBY, want_rest),
    *_staying((_FADE_OUT, _STOPPING), Event.ASK_STANDBY, want_rest, end_in_standby),
    Transition((_STOPPED, _EMERGENCY), Event.ASK_COMPENSATING, _STANDBY, (), (want_compensation,)),
    Transition(
        (_TENSION,), Event.ASK_COMPENSATING, _COMPENSATING, (SENSORS_WELL, NO_HARM), (want_compensation, compensate_all)
    ),
    Transition(
        (_FADE_OUT,),
        Event.ASK_COMPENSATING,
        _COMPENSATING,
        (SENSORS_WELL, NO_HARM),
        (want_compensation, compensate_as_shown),
    ),
    Transition((_MANUAL,), Event.ASK_COMPENSATING, _STOPPING, (), (want_compensation, end_in_standby)),
    *_staying((_STANDBY, _COMPENSATING), Event.ASK_COMPENSATING, want_compensation),
    *_staying((_FADE_OUT, _STOPPING), Event.ASK_COMPENSATING, want_compensation, end_in_standby),
    Transition(
        (_STANDBY, _STOPPED),
        Event.ASK_CONSTANT_TENSION,
        _TENSION,
        (HAS_ENCODER, BRAKE_HELD, MAY_HOLD_TENSION),
        (want_rest, compensate_nothing),
    ),
    Transition(
        (_COMPENSATING, _TENSION, _FADE_OUT),
        Event.ASK_CONSTANT_TENSION,
        _TENSION,
        (HAS_ENCODER, MAY_HOLD_TENSION),
        (want_rest, compensate_nothing),
    ),
    Transition((_STANDBY, _STOPPED), Event.ASK_MANUAL, _MANUAL, (HAS_ENCODER, BRAKE_HELD), (want_rest,)),
    *_staying((_MANUAL,), Event.ASK_MANUAL),
    # what happens to the unit
    Transition((_COMPENSATING,), Event.TOUCHDOWN, _TENSION, (), (want_rest, compensate_nothing)),
    Transition((_TENSION,), Event.LIFTED_OFF, _COMPENSATING, (), (want_compensation, compensate_all)),
    # what happens to the winch
    Transition(MOVING, Event.WINCH_EMERGENCY_STOP, _EMERGENCY, (), (want_rest,)),
    Transition(MOVING, Event.WINCH_FAULT, _STOPPED, (), (want_rest,)),
    Transition((_STANDBY,), Event.WINCH_FAULT, _STOPPED, (NEW_FAULT,), (want_rest,)),
    Transition((_STOPPED,), Event.WINCH_EMERGENCY_STOP, _EMERGENCY, (NEW_FAULT,), (want_rest,)),
    Transition((_STOPPED,), Event.WINCH_FAULT, _STOPPED, (NEW_FAULT, NOT_FOR_WANT_OF_COMMANDS), (want_rest,)),
    # what happens in front of the winch
    Transition(
        (_COMPENSATING, _TENSION, _MANUAL, _FADE_OUT), Event.ENVELOPE, _STOPPING, (), (wait_for_operator, end_stopped)
    ),
    Transition((_STANDBY,), Event.ENVELOPE, _STOPPED, (), (wait_for_operator,)),
    # what happens to the sensors
    Transition((_FADE_OUT,), Event.WINCH_SILENT, _STOPPING, (RESTS_STOPPED,)),
    Transition((_COMPENSATING,), Event.SENSOR_LOST, _FADE_OUT, (), (end_stopped, count_loss)),
    Transition((_TENSION, _MANUAL), Event.SENSOR_LOST, _STOPPING, (), (end_stopped,)),
    Transition((_COMPENSATING,), Event.HARM, _FADE_OUT, (), (end_in_standby,)),
    Transition(
        (_FADE_OUT,), Event.SENSORS_BACK, _COMPENSATING, (WANTED, RESTS_STOPPED, NO_HARM), (compensate_as_shown,)
    ),
    Transition(
        (_STANDBY,),
        Event.SETTLED,
        _COMPENSATING,
        (WANTED, NO_HARM, BRAKE_HELD, GATES_OPEN),
        (compensate_nothing,),
    ),
    Transition((_STOPPED,), Event.SENSORS_BACK, _STANDBY, (WANTED, NO_FAULT, MAY_RESUME)),
    # the end of a stop
    Transition((_FADE_OUT,), Event.FADED, _STOPPING),
    Transition((_STOPPING,), Event.AT_REST, _STANDBY, (RESTS_IN_STANDBY,)),
    Transition((_STOPPING,), Event.AT_REST, _STOPPED, (RESTS_STOPPED,)),
)
"""Every way from one mode to another. Where several rows fit, the first one counts."""


class ModeOutput(NamedTuple):
    """What the mode asks for in a tick.

    Attributes
    ----------
    mode : the active one; reason : why, empty when there is nothing to say
    authority : authority of compensation, 0 to 1
    brake : is to be on
    before : mode of the tick before; None: the same
    """

    mode: Mode
    reason: str
    authority: float
    brake: bool
    before: Mode | None = None


LOOP_WORDS: dict[Mode, str] = {
    Mode.OFF: "AHC is off",
    Mode.STANDBY: "No compensation: winch in standby, brake on",
    Mode.COMPENSATING: "Compensation continues",
    Mode.CONSTANT_TENSION: "Constant tension continues",
    Mode.MANUAL: "Manual operation continues",
    Mode.FADE_OUT: "Compensation is fading out, then the winch stops",
    Mode.STOPPING: "Winch is stopping",
    Mode.STOPPED: "No compensation: winch stopped, brake on",
    Mode.EMERGENCY_STOP: "No compensation: emergency stop",
}
"""What follows for the load, by mode."""
DAMPED = "Compensation is fading out; the depth sensor damps the load"
COASTING = "coasting on prediction"
"""Begins the reason of mode compensating while a sensor that it requires is lost."""


def loop_words(mode: Mode, *, is_damped_blind: bool = False, coasts: float = 0.0) -> str:
    """Return what the loop does in a `mode`.

    `is_damped_blind`: the load is damped by the depth sensor alone. `coasts`: longest time for which compensation goes
    on without a sensor that it requires [s]; 0: none is lost.
    """
    if mode is Mode.COMPENSATING and coasts:
        return f"{LOOP_WORDS[mode]} on prediction for at most {coasts:g} s"
    return DAMPED if mode is Mode.FADE_OUT and is_damped_blind else LOOP_WORDS[mode]
