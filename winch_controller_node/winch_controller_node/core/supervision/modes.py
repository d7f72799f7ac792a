"""The modes of the controller, and the one table that says how it gets from one to another.

off: law off, the brake stays on. standby: the brake is on, the estimator runs. compensating: authority rises to the
share asked for. fade_out: authority falls to zero. constant_tension: tension is held. manual: the operator's speed
alone. stopping: the winch comes to rest at a bounded deceleration, then standby or stopped, with the brake on.
emergency_stop: brake at once, and it stays until another mode is requested.

`TABLE` has a row for each (mode, event, guard). Requests are events that come from an operator; all others are looked
for each tick, in the order of `ModeEvent`. The first row whose guard holds is taken. A request without such a row is
refused with the words of the guards that did not hold. `mode_picture` draws the table; the core runs it (`heave_core`,
modes.cpp), where events, guards and actions have their conditions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple

from heave_core.modes_table import ACTIONS, MODE_ROWS, ModeAction, ModeEvent, ModeGuard, ModeNumber
from heave_node.interface.codes import REQUESTED, WinchFault, fault_words

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

MOST_LOSSES = 3
"""Losses of a sensor after which compensation resumes automatically."""

STANDSTILL = 1e-3
"""Speed below which the winch is at rest [m/s]."""


WAIT = 3.0
"""Time for which a winch, its link and all sensors are well after a timeout before compensation is tried again [s]."""


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


class Situation(NamedTuple):
    """What a tick is, in words, for the reason of a mode and for what refuses a request."""

    # sensors that the present mode requires and that are lost, with the reason ("mru frozen"), empty when none
    lost: str = ""
    winch_fault: int = WinchFault.NONE  # number of the winch's own fault, see WinchFault
    harm: str = ""  # the guard's reason to fade out, empty when there is none
    prospect: str = ""  # when compensation is tried again after harm, in words
    # the unit is damped by the depth sensor, and how it would move with the winch locked is not known
    is_damped_blind: bool = False
    gates: str = ""  # why compensation may not begin now, with figures; empty when it may
    tension: str = ""  # why constant tension may not begin now; empty when it may
    fault_cause: str = ""  # why the winch has its fault, in words; empty where that is not known
    awaits_operator: bool = False  # after this harm compensation is tried again only once an operator asks for it
    # the winch has stopped for want of commands, and compensation is asked for again once they come
    resumes_after_fault: bool = False
    envelope: str = ""  # why the envelope has taken over, until an operator acknowledges; empty: it has not


# guards


@dataclass(frozen=True, slots=True)
class Guard:
    """A condition on a row."""

    number: ModeGuard  # in the core, where it is looked at
    name: str  # what must hold, in words
    why_not: Callable[[Situation], str] | None = None  # says why it does not, with figures; None: the name says enough

    def refusal(self, situation: Situation) -> str:
        """Return why the guard does not hold in a `situation`, in words."""
        detail = "" if self.why_not is None else self.why_not(situation)
        return f"{self.name} ({detail})" if detail else self.name


WANTED = Guard(ModeGuard.IF_WANTED, "compensation intended")
NO_HARM = Guard(ModeGuard.IF_NO_HARM, "compensation does no harm", lambda now: now.harm)
NO_FAULT = Guard(ModeGuard.IF_NO_FAULT, "no winch fault", lambda now: fault_words(now.winch_fault))
NEW_FAULT = Guard(ModeGuard.IF_NEW_FAULT, "the fault is new")
NOT_FOR_WANT_OF_COMMANDS = Guard(ModeGuard.IF_NOT_FOR_WANT_OF_COMMANDS, "the fault is not a command timeout")
SENSORS_WELL = Guard(ModeGuard.IF_SENSORS_WELL, "sensors good", lambda now: now.lost)
GATES_OPEN = Guard(ModeGuard.IF_GATES_OPEN, "start conditions met", lambda now: now.gates)
MAY_HOLD_TENSION = Guard(
    ModeGuard.IF_MAY_HOLD_TENSION, "load landed or held, winch able to follow", lambda now: now.tension
)
BRAKE_HELD = Guard(ModeGuard.IF_BRAKE_HELD, f"brake on for {RELEASE_TIME:g} s")
HAS_ENCODER = Guard(ModeGuard.IF_HAS_ENCODER, "encoder good")
SETTLED_ESTIMATE = Guard(ModeGuard.IF_SETTLED_ESTIMATE, "estimate settled")
RESTS_IN_STANDBY = Guard(ModeGuard.IF_RESTS_IN_STANDBY, "ends in standby")
RESTS_STOPPED = Guard(ModeGuard.IF_RESTS_STOPPED, "ends in stopped")
MAY_RESUME = Guard(
    ModeGuard.IF_MAY_RESUME,
    "automatic restart allowed, and all sensors good for modes.resume_time (longer after each loss)",
)

# actions

WANT_COMPENSATION = ModeAction.DO_WANT_COMPENSATION
WANT_REST = ModeAction.DO_WANT_REST
END_IN_STANDBY = ModeAction.DO_END_IN_STANDBY
END_STOPPED = ModeAction.DO_END_STOPPED
COMPENSATE_NOTHING = ModeAction.DO_COMPENSATE_NOTHING
COMPENSATE_ALL = ModeAction.DO_COMPENSATE_ALL
COMPENSATE_AS_SHOWN = ModeAction.DO_COMPENSATE_AS_SHOWN
WAIT_FOR_OPERATOR = ModeAction.DO_WAIT_FOR_OPERATOR
COUNT_LOSS = ModeAction.DO_COUNT_LOSS


# the table


@dataclass(frozen=True, slots=True)
class Transition:
    """A row of the table."""

    sources: tuple[Mode, ...]  # modes that it leaves
    event: Event  # on which
    target: Mode  # mode that it enters; the same as the source: the mode stays, and only the actions are done
    guards: tuple[Guard, ...] = ()  # that must all hold
    actions: tuple[ModeAction, ...] = ()  # that are done, in order


def _staying(modes: tuple[Mode, ...], event: Event, *actions: ModeAction) -> tuple[Transition, ...]:
    """Return rows in which an event only does `actions`."""
    return tuple(Transition((mode,), event, mode, (), actions) for mode in modes)


_OFF, _STANDBY, _STOPPED, _EMERGENCY = BRAKED
_COMPENSATING, _TENSION, _MANUAL, _FADE_OUT, _STOPPING = MOVING

TABLE: tuple[Transition, ...] = (
    # what an operator asks for
    Transition((*BRAKED[1:], *MOVING), Event.ASK_EMERGENCY_STOP, _EMERGENCY, (), (WAIT_FOR_OPERATOR,)),
    *_staying((_OFF,), Event.ASK_EMERGENCY_STOP),
    Transition((_COMPENSATING,), Event.ASK_STOPPED, _FADE_OUT, (), (WANT_REST, END_STOPPED)),
    Transition((_TENSION,), Event.ASK_STOPPED, _FADE_OUT, (), (WANT_REST, END_STOPPED, COMPENSATE_ALL)),
    Transition((_MANUAL,), Event.ASK_STOPPED, _STOPPING, (), (WANT_REST, END_STOPPED)),
    Transition((_STANDBY,), Event.ASK_STOPPED, _STOPPED, (), (WANT_REST,)),
    *_staying((_FADE_OUT, _STOPPING), Event.ASK_STOPPED, WANT_REST, END_STOPPED),
    *_staying((_STOPPED, _EMERGENCY), Event.ASK_STOPPED, WAIT_FOR_OPERATOR),
    *_staying((_OFF,), Event.ASK_STOPPED),
    Transition((_COMPENSATING,), Event.ASK_STANDBY, _FADE_OUT, (), (WANT_REST, END_IN_STANDBY)),
    Transition((_TENSION,), Event.ASK_STANDBY, _FADE_OUT, (), (WANT_REST, END_IN_STANDBY, COMPENSATE_ALL)),
    Transition((_MANUAL,), Event.ASK_STANDBY, _STOPPING, (), (WANT_REST, END_IN_STANDBY)),
    Transition((_STOPPED, _EMERGENCY), Event.ASK_STANDBY, _STANDBY, (), (WANT_REST,)),
    *_staying((_STANDBY,), Event.ASK_STANDBY, WANT_REST),
    *_staying((_FADE_OUT, _STOPPING), Event.ASK_STANDBY, WANT_REST, END_IN_STANDBY),
    Transition((_STOPPED, _EMERGENCY), Event.ASK_COMPENSATING, _STANDBY, (), (WANT_COMPENSATION,)),
    Transition(
        (_TENSION,), Event.ASK_COMPENSATING, _COMPENSATING, (SENSORS_WELL, NO_HARM), (WANT_COMPENSATION, COMPENSATE_ALL)
    ),
    Transition(
        (_FADE_OUT,),
        Event.ASK_COMPENSATING,
        _COMPENSATING,
        (SENSORS_WELL, NO_HARM),
        (WANT_COMPENSATION, COMPENSATE_AS_SHOWN),
    ),
    Transition((_MANUAL,), Event.ASK_COMPENSATING, _STOPPING, (), (WANT_COMPENSATION, END_IN_STANDBY)),
    *_staying((_STANDBY, _COMPENSATING), Event.ASK_COMPENSATING, WANT_COMPENSATION),
    *_staying((_FADE_OUT, _STOPPING), Event.ASK_COMPENSATING, WANT_COMPENSATION, END_IN_STANDBY),
    Transition(
        (_STANDBY, _STOPPED),
        Event.ASK_CONSTANT_TENSION,
        _TENSION,
        (HAS_ENCODER, BRAKE_HELD, MAY_HOLD_TENSION),
        (WANT_REST, COMPENSATE_NOTHING),
    ),
    Transition(
        (_COMPENSATING, _TENSION, _FADE_OUT),
        Event.ASK_CONSTANT_TENSION,
        _TENSION,
        (HAS_ENCODER, MAY_HOLD_TENSION),
        (WANT_REST, COMPENSATE_NOTHING),
    ),
    Transition((_STANDBY, _STOPPED), Event.ASK_MANUAL, _MANUAL, (HAS_ENCODER, BRAKE_HELD), (WANT_REST,)),
    *_staying((_MANUAL,), Event.ASK_MANUAL),
    # what happens to the unit
    Transition((_COMPENSATING,), Event.TOUCHDOWN, _TENSION, (), (WANT_REST, COMPENSATE_NOTHING)),
    Transition((_TENSION,), Event.LIFTED_OFF, _COMPENSATING, (), (WANT_COMPENSATION, COMPENSATE_ALL)),
    # what happens to the winch
    Transition(MOVING, Event.WINCH_EMERGENCY_STOP, _EMERGENCY, (), (WANT_REST,)),
    Transition(MOVING, Event.WINCH_FAULT, _STOPPED, (), (WANT_REST,)),
    Transition((_STANDBY,), Event.WINCH_FAULT, _STOPPED, (NEW_FAULT,), (WANT_REST,)),
    Transition((_STOPPED,), Event.WINCH_EMERGENCY_STOP, _EMERGENCY, (NEW_FAULT,), (WANT_REST,)),
    Transition((_STOPPED,), Event.WINCH_FAULT, _STOPPED, (NEW_FAULT, NOT_FOR_WANT_OF_COMMANDS), (WANT_REST,)),
    # what happens in front of the winch
    Transition(
        (_COMPENSATING, _TENSION, _MANUAL, _FADE_OUT), Event.ENVELOPE, _STOPPING, (), (WAIT_FOR_OPERATOR, END_STOPPED)
    ),
    Transition((_STANDBY,), Event.ENVELOPE, _STOPPED, (), (WAIT_FOR_OPERATOR,)),
    # what happens to the sensors
    Transition((_FADE_OUT,), Event.WINCH_SILENT, _STOPPING, (RESTS_STOPPED,)),
    Transition((_COMPENSATING,), Event.SENSOR_LOST, _FADE_OUT, (), (END_STOPPED, COUNT_LOSS)),
    Transition((_TENSION, _MANUAL), Event.SENSOR_LOST, _STOPPING, (), (END_STOPPED,)),
    Transition((_COMPENSATING,), Event.HARM, _FADE_OUT, (), (END_IN_STANDBY,)),
    Transition(
        (_FADE_OUT,), Event.SENSORS_BACK, _COMPENSATING, (WANTED, RESTS_STOPPED, NO_HARM), (COMPENSATE_AS_SHOWN,)
    ),
    Transition(
        (_STANDBY,),
        Event.SETTLED,
        _COMPENSATING,
        (WANTED, NO_HARM, BRAKE_HELD, GATES_OPEN),
        (COMPENSATE_NOTHING,),
    ),
    Transition((_STOPPED,), Event.SENSORS_BACK, _STANDBY, (WANTED, NO_FAULT, MAY_RESUME)),
    # the end of a stop
    Transition((_FADE_OUT,), Event.FADED, _STOPPING),
    Transition((_STOPPING,), Event.AT_REST, _STANDBY, (RESTS_IN_STANDBY,)),
    Transition((_STOPPING,), Event.AT_REST, _STOPPED, (RESTS_STOPPED,)),
)
"""Every way from one mode to another. Where several rows fit, the first one counts."""


CONSTANTS = {
    "hiccup": 0.5,
    "release_time": RELEASE_TIME,
    "released_time": RELEASED_TIME,
    "settling_limit": SETTLING_LIMIT,
    "stopping_limit": STOPPING_LIMIT,
    "loss_growth": 4.0,
    "forgiven": 600.0,
    "coast_recovery": 0.2,  # a sensor that comes and goes is lost
    "standstill": STANDSTILL,
    "back_time": BACK_TIME,
    "most_losses": MOST_LOSSES,
}
"""Constants of the modes: meanings and units are in the core's table, MODE_DESIGN."""

MODES = tuple(Mode)
"""Modes by their number in the core."""

EVENTS = tuple(Event[event.name.removeprefix("ON_")] for event in ModeEvent if event is not ModeEvent.MODE_EVENTS)
"""Events by their number in the core."""


def event_number(event: Event) -> int:
    """Return the number of an `event` in the core."""
    return int(ModeEvent[f"ON_{event.name}"])


def _rows() -> list[dict[str, Any]]:
    """Return the table as the core has it: a row for each mode that is left."""
    return [
        {
            "mode": ModeNumber[f"IN_{mode.name}"],
            "event": event_number(row.event),
            "target": ModeNumber[f"IN_{row.target.name}"],
            "guards": sum(guard.number for guard in row.guards),
            "actions": (*row.actions, *[ModeAction.DO_NOTHING] * (ACTIONS - len(row.actions))),
        }
        for row in TABLE
        for mode in row.sources
    ]


def mode_design(parameters: ModeParameters, tick_period: float) -> dict[str, Any]:
    """Return the values of the core's ModeDesign, of its `parameters` and a `tick_period` [s]."""
    rows = _rows()
    empty = {"mode": ModeNumber.NO_MODE, "event": 0, "target": 0, "guards": 0, "actions": (0,) * ACTIONS}
    return {
        "tick_period": tick_period,
        "settling_time": parameters.settling_time,
        "fade_in_time": parameters.fade_in_time,
        "fade_out_time": parameters.fade_out_time,
        "coast_time": parameters.coast_time,
        "resume_time": parameters.resume_time,
        **CONSTANTS,
        "resumes": parameters.resume,
        "count": len(rows),
        "rows": [*rows, *[empty] * (MODE_ROWS - len(rows))],
    }


class ModeOutput(NamedTuple):
    """What the mode asks for in a tick."""

    mode: Mode  # the active one
    reason: str  # why it has changed; empty: it has not
    authority: float  # authority of compensation, 0 to 1 [-]
    brake: bool  # is to be on
    before: Mode | None = None  # mode of the tick before; None: the same


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
