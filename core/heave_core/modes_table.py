"""The table of mode machine and attempts: rows of transitions, times and rates, what is remembered, and what is told.

The rows themselves, and the words of events and guards, are the controller's; they are handed over as an array.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag

from heave_core.rows import COUNTER, Row, structure

MODE_ROWS = 128
"""Most rows of the table, one for each mode that it leaves."""

ACTIONS = 3
"""Most actions of a row."""


class ModeNumber(IntEnum):
    """Modes, in the order of their names."""

    IN_OFF = 0
    IN_STANDBY = 1
    IN_COMPENSATING = 2
    IN_CONSTANT_TENSION = 3
    IN_MANUAL = 4
    IN_FADE_OUT = 5
    IN_STOPPING = 6
    IN_STOPPED = 7
    IN_EMERGENCY_STOP = 8
    NO_MODE = -1


class ModeEvent(IntEnum):
    """What can happen; those that are looked for in each tick come last, in their order."""

    ON_ASK_STANDBY = 0
    ON_ASK_COMPENSATING = 1
    ON_ASK_CONSTANT_TENSION = 2
    ON_ASK_MANUAL = 3
    ON_ASK_STOPPED = 4
    ON_ASK_EMERGENCY_STOP = 5
    ON_TOUCHDOWN = 6
    ON_LIFTED_OFF = 7
    ON_WINCH_EMERGENCY_STOP = 8
    ON_WINCH_FAULT = 9
    ON_ENVELOPE = 10
    ON_WINCH_SILENT = 11
    ON_SENSOR_LOST = 12
    ON_HARM = 13
    ON_SENSORS_BACK = 14
    ON_SETTLED = 15
    ON_FADED = 16
    ON_AT_REST = 17
    MODE_EVENTS = 18


class ModeGuard(IntFlag):
    """What must hold for a row."""

    IF_WANTED = 1
    IF_NO_HARM = 2
    IF_NO_FAULT = 4
    IF_NEW_FAULT = 8
    IF_NOT_FOR_WANT_OF_COMMANDS = 16
    IF_SENSORS_WELL = 32
    IF_GATES_OPEN = 64
    IF_MAY_HOLD_TENSION = 128
    IF_BRAKE_HELD = 256
    IF_HAS_ENCODER = 512
    IF_SETTLED_ESTIMATE = 1024
    IF_RESTS_IN_STANDBY = 2048
    IF_RESTS_STOPPED = 4096
    IF_MAY_RESUME = 8192


class ModeAction(IntEnum):
    """What a row does, beside going to its target."""

    DO_NOTHING = 0
    DO_WANT_COMPENSATION = 1
    DO_WANT_REST = 2
    DO_END_IN_STANDBY = 3
    DO_END_STOPPED = 4
    DO_COMPENSATE_NOTHING = 5
    DO_COMPENSATE_ALL = 6
    DO_WAIT_FOR_OPERATOR = 7
    DO_COUNT_LOSS = 8


class WhyOff(IntEnum):
    """Why compensation is to be off."""

    NOT_OFF = 0
    HARM_DONE = 1
    HARM_CERTAIN = 2
    HARM_UNEXPLAINED = 3
    HARM_EXPLAINED = 4


MODE_ROW = structure(
    "ModeRow",
    "A way from one mode to another; the same one: it stays, and only the actions are done.",
    Row("mode", "", "that it leaves, of ModeNumber", COUNTER),
    Row("event", "", "on which, of ModeEvent", COUNTER),
    Row("target", "", "that it enters, of ModeNumber", COUNTER),
    Row("guards", "", "that must all hold, bits of ModeGuard", COUNTER),
    Row("actions", "", "that are done, in order, of ModeAction", COUNTER, (ACTIONS,)),
)

MODE_DESIGN = structure(
    "ModeDesign",
    "Times and rates of the mode machine, and its table: where several rows fit, the first one counts.",
    Row("tick_period", "s", "time of a step"),
    Row("settling_time", "s", "for which the sensors are well before compensation begins"),
    Row("fade_in_time", "s", "over which authority goes to 1"),
    Row("fade_out_time", "s", "over which it goes to 0"),
    Row("coast_time", "s", "for which prediction replaces a lost sensor"),
    Row("resume_time", "s", "for which all sensors are good before a winch that has stopped for one resumes"),
    Row("hiccup", "s", "for which a sensor may be lost without restarting a wait"),
    Row("release_time", "s", "for which the brake stays on before a braked winch is moved"),
    Row("released_time", "s", "after release of the brake for which a latched fault may still be reported"),
    Row("settling_limit", "s", "longest time that a unit may take to settle after a fade-out"),
    Row("stopping_limit", "s", "longest time that the winch may take to come to rest"),
    Row("loss_growth", "", "factor of the wait from one loss of a sensor to the next"),
    Row("forgiven", "s", "compensation after which losses count no more"),
    Row("coast_recovery", "", "share of the time with a good sensor that makes up for as much without it"),
    Row("standstill", "m/s", "speed below which the winch is at rest"),
    Row("back_time", "s", "for which a sensor that was lost must deliver again"),
    Row("most_losses", "", "of a sensor after which compensation resumes automatically", COUNTER),
    Row("resumes", "", "1: compensation may resume automatically", COUNTER),
    Row("count", "", "rows", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("rows", "", "of the table", MODE_ROW, (MODE_ROWS,)),
)

MODE_STATE = structure(
    "ModeState",
    "What the mode machine remembers.",
    Row("authority", "", "of compensation, 0 to 1"),
    Row("target", "", "that it goes to"),
    Row("factor", "", "largest authority"),
    Row("time", "s", "in the present mode"),
    Row("well_time", "s", "for which all required sensors have been well"),
    Row("lost_time", "s", "for which one has been lost"),
    Row("coasted", "s", "time in which one was lost of late"),
    Row("mode", "", "of ModeNumber", COUNTER),
    Row("before", "", "mode of the tick before", COUNTER),
    Row("wants", "", "1: compensation is to begin, or to go on, by itself", COUNTER),
    Row("may_resume", "", "1: also after the winch was stopped for a lost sensor", COUNTER),
    Row("rest", "", "mode in which a stop ends", COUNTER),
    Row("losses", "", "times that a lost sensor has ended compensation of late", COUNTER),
    Row("known_fault", "", "of the winch, at the start or at the last request of an operator; -1: none read", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
)

SITUATION = structure(
    "Situation",
    "What the mode machine is told at a tick.",
    Row("lost", "", "1: a sensor that the present mode requires is lost"),
    Row("encoder_lost", "", "1: the encoder is, and the mode requires it"),
    Row("winch_silent", "", "1: for want of any data"),
    Row("has_estimate", "", "1: the estimator has had the readings that it needs"),
    Row("winch_fault", "", "the winch's own; 0: none"),
    Row("is_emergency", "", "1: that is its emergency stop"),
    Row("is_automatic", "", "1: a controller may release it by itself"),
    Row("harm", "", "1: the guard has a reason to fade out"),
    Row("envelope", "", "1: the envelope has taken over, and nobody has acknowledged it"),
    Row("gates_closed", "", "1: compensation may not begin now"),
    Row("tension_closed", "", "1: constant tension may not"),
    Row("is_settled", "", "1: the winch may stop"),
    Row("is_damped_blind", "", "1: the unit is damped by the depth sensor, and the boom tip is not known"),
    Row("speed", "m/s", "of the winch, as commanded; infinite while the envelope brings it to rest"),
    Row("authority_limit", "", "largest authority that the winch can follow under this law"),
)

ATTEMPT_DESIGN = structure(
    "AttemptDesign",
    "When compensation that has failed is tried again.",
    Row("largest_residual", "", "motion that compensation may leave, over that with the winch locked"),
    Row("interruption", "", "motion that a stop for want of commands leaves, over that with the winch locked"),
    Row("learnt", "", "share of a tick in what the waves show"),
)

ATTEMPT_STATE = structure(
    "AttemptState",
    "What the attempts at compensation that failed have shown.",
    Row("doubt", "", "variance that errors of unknown cause leave of compensated motion, over that motion's"),
    Row("doubt_before", "", "the same before the last failure"),
    Row("interruptions", "", "attempts that the winch has ended for want of commands, as far as they still count"),
    Row("inhibits", "", "1: compensation is to be off", COUNTER),
    Row("is_unexplained", "", "1: for a disagreement, until it is known who is wrong", COUNTER),
    Row("is_present", "", "1: its reason lasts in this tick", COUNTER),
    Row("distrusts", "", "1: the depth sensor disagrees with the estimate", COUNTER),
    Row("why", "", "of WhyOff", COUNTER),
    Row("harm", "", "that the attempt has done, bits of Harm", COUNTER),
    Row("begun", "", "counts reasons: where it grows, another one holds from that tick on", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
)

STRUCTURES = (MODE_ROW, MODE_DESIGN, MODE_STATE, SITUATION, ATTEMPT_DESIGN, ATTEMPT_STATE)
"""In the order in which C++ needs them."""

RECORDS = (MODE_DESIGN, MODE_STATE, SITUATION, ATTEMPT_DESIGN, ATTEMPT_STATE)
"""What Python and C++ hold together."""

SIZES = {"MODE_ROWS": MODE_ROWS, "ACTIONS": ACTIONS}
"""Sizes of arrays."""

ENUMERATIONS: tuple[type[IntEnum | IntFlag], ...] = (ModeNumber, ModeEvent, ModeGuard, ModeAction, WhyOff)
"""Names of numbers, and of bits."""
