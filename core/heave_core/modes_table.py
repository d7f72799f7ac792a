"""The table of supervision: mode machine, attempts, gates, and what is decided in a tick.

The rows themselves, and the words of events and guards, are the controller's; they are handed over as an array.
"""

from __future__ import annotations

from enum import IntEnum

from heave_core.look_table import SIGMA
from heave_core.rows import COUNTER, Row, Size, structure

MODE_ROWS = Size("MODE_ROWS", 128)
"""Most rows of the table, one for each mode that it leaves."""

ACTIONS = Size("ACTIONS", 3)
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


class ModeGuard(IntEnum):
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
    DO_COMPENSATE_AS_SHOWN = 9


class WhyOff(IntEnum):
    """Why compensation is to be off."""

    NOT_OFF = 0
    HARM_DONE = 1
    HARM_CERTAIN = 2
    HARM_UNEXPLAINED = 3
    HARM_EXPLAINED = 4


class Gate(IntEnum):
    """What keeps compensation, or constant tension, from beginning."""

    LOAD_STANDS = 1
    LOAD_UNWEIGHED = 2
    SEA_UNSEEN = 4
    READINGS_DISAGREE = 8
    TENSION_LOW = 16
    RANGE_SHORT = 32
    RESIDUAL_HIGH = 64
    MRU_UNPROVED = 128
    LOAD_CELL_LOST = 256
    LOAD_HANGS = 512
    TENSION_UNSEEN = 1024
    PEAKS_HIGH = 2048


class Happened(IntEnum):
    """What Python is to say of a tick in words."""

    LOAD_NOT_HANGING = 1
    DEPTH_NOT_PAYOUT = 2
    INHIBITED = 4
    LINK_BACK = 8
    LINK_LOST_OFTEN = 16
    TENSION_NOT_KEPT = 32
    AUTHORITY_HELD = 64
    AUTHORITY_FREE = 128
    LOWERS_BLIND = 256
    UNIT_EVENT = 512
    SEA_ABOVE_WINCH = 1024


EPISODES = Size("EPISODES", 3)
"""Causes that are reported once for as long as they come and go."""

UNIT_PAST = Size("UNIT_PAST", 8192)
"""Ticks for which the unit's heave is kept, for a depth reading that comes late."""

MODES = Size("MODES", 9)
"""Number of modes."""

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
    "Inputs of the mode machine at a tick.",
    Row("lost", "", "1: a sensor that the present mode requires is lost"),
    Row("encoder_lost", "", "1: the encoder is, and the mode requires it"),
    Row("encoder_frozen", "", "1: since its reading stays the same, as it does at rest"),
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
    Row("shown_authority", "", "that unit and drum show, as they move"),
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

SUPERVISION_DESIGN = structure(
    "SupervisionDesign",
    "What a tick is supervised by, beside guard, landing and modes.",
    Row("tick_period", "s", "time of a tick"),
    Row("past", "", "ticks for which the unit's heave is kept", COUNTER),
    Row("required", "", "bits of the sensors that each mode requires, by index", COUNTER, (MODES,)),
    Row("command_timeout", "", "fault of a winch that got no command in time", COUNTER),
    Row("emergency_stop", "", "fault of a winch whose emergency stop acts", COUNTER),
    Row("restart", "", "fault of a winch that has begun anew", COUNTER),
    Row("automatic", "", "bits of the faults, by number, that a controller may release by itself", COUNTER),
    Row("cautious", "", "authority that is best in a sea that is not the assumed one"),
    Row("quiet_time", "s", "for which a cause must be away before it is reported again"),
    Row("least_rate", "m/s", "above which the winch lowers"),
    Row("least_authority", "", "above which the mean payout lowers the unit"),
    Row("tension_memory", "s", "over which the tension is averaged"),
    Row("least_averaged", "", "share of it from which on a mean is one"),
    Row("mean_error", "", "error of the mean tension, over the standard deviation of the tension"),
    Row("cable_weight", "N/m", "of the cable in water"),
    Row("more", "m", "cable at payout 0 beyond that of the static tension"),
    Row("hangs_least", "", "share of its weight from which on the cable carries the unit"),
    Row("hangs_most", "", "share up to which it does"),
    Row("hanging", "", "1: the tension of a hanging unit may be held: `tension.hanging`"),
    Row("length", "m", "of cable at payout 0: `length`"),
    Row("tip_height", "m", "of the boom tip over the water: `boom_tip_height`"),
    Row("payout_tolerance", "", "of the payout meter; 0: it is not compared: `health.payout_tolerance`"),
    Row("stretch", "", "of the cable under the load, relative"),
    Row("least_off", "m", "difference of depth and payout that is never too large"),
    Row("longest_wait", "s", "from the start, for which compensation waits for waves"),
    Row("peak", "", "amplitude over standard deviation of a sea, over some minutes"),
    Row("peak_ratio", "", "that amplitude over the significant one"),
    Row("peak_use", "", "of the winch's limits that peaks may use: `entry.peak_use`"),
    Row("payout_minimum", "m", "least payout of the winch"),
    Row("payout_maximum", "m", "largest payout of the winch"),
    Row("highest_ratio", "", "highest tension over the static one; infinite: none"),
    Row("tension_per_metre", "1/m", "of stretch, over the static one"),
    Row("stretch_weight", "", "of a tick in the statistics of the stretch"),
    Row("slow_mean", "", "their mean is followed so many times more slowly"),
    Row("tension_peak", "", "amplitude over standard deviation of some minutes of waves"),
    Row("tension_left", "", "share of a locked winch's tension that is left where the winch follows the whole sea"),
    Row("tension_hold", "s", "for which a highest tension that was too low must be enough before it is kept again"),
    Row("inertia", "s^2", "a of the two-state cable"),
    Row("settled_at_rest", "m", "swing of the unit at which a fade-out may end in calm water"),
    Row("blind_limit", "s", "longest time for which the unit is damped by the depth sensor alone"),
    Row("held_time", "s", "after which limited authority is reported, and its end"),
    Row("reported_again", "s", "after which it is reported again"),
    Row("grown", "", "factor by which peaks that were reported grow before they are again"),
    Row("duties", "", "Duty of each mode", shape=(MODES,)),
    Row("link_wait", "s", "for which winch, link and sensors are well before compensation is tried again"),
)

SUPERVISION_STATE = structure(
    "SupervisionState",
    "What supervision remembers, beside guard, landing and modes.",
    Row("count", "", "heaves of the unit that are kept", COUNTER),
    Row("next", "", "place of the next one", COUNTER),
    Row("fault_before", "", "of the winch, at the tick before", COUNTER),
    Row("reasons", "", "of compensation being off, that have been reported so far", COUNTER),
    Row("is_pending", "", "1: compensation is asked for again once commands reach the winch", COUNTER),
    Row("is_tried", "", "1: it has been, and the winch has kept its fault", COUNTER),
    Row("fades_compensation", "", "1: this fade-out is that of compensation", COUNTER),
    Row("is_reported", "", "1: limited authority has been reported", COUNTER),
    Row("is_off", "", "1: depth sensor and payout disagree", COUNTER),
    Row("is_kept", "", "1: the highest tension is one that compensation can keep", COUNTER),
    Row("is_low", "", "1: it is too low for this sea", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("link_well", "s", "time for which winch, link and sensors have been well"),
    Row("held", "s", "time for which authority has been limited; below 0: it was reported"),
    Row("free", "s", "time since it is not limited any more"),
    Row("blind", "s", "time for which the unit has been damped by the depth sensor alone"),
    Row("unweighed", "s", "time for which the load cell has been lost"),
    Row("wait", "s", "for which the tension must be averaged still; 0: it is not too low"),
    Row("watched", "m", "payout at which the depth is averaged"),
    Row("watched_time", "s", "for which it is"),
    Row("depths", "m", "sum of the depths read"),
    Row("depth_count", "", "of them"),
    Row("mean_depth", "m", "that was compared last"),
    Row("stretch", "m", "of the cable under a locked winch", SIGMA),
    Row("least_ratio", "", "least highest tension over the static one"),
    Row("enough", "s", "time for which the highest tension has been enough"),
    Row("peak_reported", "", "peaks over the winch's limits that were reported last; 0: none"),
    Row(
        "quiet",
        "s",
        "time for which each cause has been away: load, depth and payout, lowering blind",
        shape=(EPISODES,),
    ),
    Row("past", "m", "heave of the unit about the mean payout's, by ticks", shape=(UNIT_PAST,)),
)

SUPERVISION_SEEN = structure(
    "SupervisionSeen",
    "What a tick is supervised by, beside what was sensed.",
    Row("fault", "", "of the winch; 0: none"),
    Row("speed", "m/s", "of the winch, as commanded; infinite while the envelope brings it to rest"),
    Row("mean_payout", "m", "that the winch goes to"),
    Row("mean_acceleration", "m/s^2", "with which it goes there"),
    Row("settled_swing", "m", "of the unit at which a fade-out may end; infinite: it is not asked for"),
    Row("share", "", "authority that is best with the winch as it is known, above 0"),
    Row("drum_error", "m", "drum less what was predicted of it a second ago"),
    Row("is_certain", "", "1: compensation must be off"),
    Row("is_reversed", "", "1: drum or encoder are reversed: the winch is brought to rest"),
    Row("envelope", "", "1: the envelope has taken over"),
    Row("is_proved", "", "1: the proofs let compensation begin"),
    Row("cell_jumped", "", "1: the load cell is off by a jump that no operator knows of"),
)

SUPERVISED = structure(
    "Supervised",
    "What is to be done in a tick.",
    Row("mode", "", "of ModeNumber"),
    Row("before", "", "mode of the tick before"),
    Row("event", "", "of ModeEvent, that was taken; -1: none"),
    Row("authority", "", "of compensation, 0 to 1"),
    Row("is_braked", "", "1: the brake is on"),
    Row("is_inhibited", "", "1: the guard keeps compensation off"),
    Row("is_damped", "", "1: the unit is damped while compensation fades out"),
    Row("trusts_estimate", "", "1: the depth sensor agrees with the estimate"),
    Row("fades_by_law", "", "1: the law itself lets the unit go"),
    Row("unit_stands", "", "1: on the bottom"),
    Row("bounds_tension", "", "1: the highest tension is one that compensation can keep"),
    Row("happened", "", "bits of Happened"),
    Row("gates", "", "bits of Gate: for compensation"),
    Row("tension_gates", "", "bits of Gate: for constant tension"),
)
