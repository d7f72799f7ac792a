"""The envelope's table: what its parameters fill, what a tick changes, what comes in and what goes out."""

from __future__ import annotations

from enum import IntEnum, IntFlag

from heave_core.rows import COUNTER, Row, Size, structure

KEPT = Size("KEPT", 512)
"""Orders that are kept for the delay of the winch, in ticks."""

BINS = Size("BINS", 60)
"""Bins of the window over which the ship's motion is watched."""

STROKES = Size("STROKES", 64)
"""Samples of the drum's way that are kept, to compare it with what was sent of late."""


class Duty(IntEnum):
    """What the controller is there for."""

    FOLLOW = 0
    OPERATE = 1
    TENSION = 2
    FADE = 3
    STOP = 4
    DAMP = 5


class Phase(IntEnum):
    """Who makes the order: the controller, or the envelope: raw motion, ramp to rest, brake, drive at rest."""

    FREE = 0
    TAKEN = 1
    RAMP = 2
    HELD = 3
    CAUGHT = 4


class Cause(IntEnum):
    """Why the envelope took over."""

    NOTHING = 0
    RATE = 1
    TRAVEL = 2
    NOT_FINITE = 3
    DRUM = 4
    BRAKE_SLIPS = 5
    FADE_LONG = 6
    UNSEEN = 7
    HARM = 8
    DRIFT = 9


class MoveKind(IntEnum):
    """Kind of a request for a move."""

    NONE = 0
    GO = 1
    STOP_MOVE = 2
    HALT = 3
    DRIVE = 4
    STAND = 5


class DriveState(IntEnum):
    """What the drive reports: nothing, a limit of its own, its brake, a fault."""

    DRIVE_FREE = 0
    DRIVE_LIMITED = 1
    DRIVE_RESTS = 2
    DRIVE_FAILED = 3


class Bit(IntFlag):
    """What acted in a tick."""

    AT_RATE = 1
    AT_TRAVEL = 2
    AT_STOP = 4
    MRU_LOST = 8
    COUNT_LOST = 16
    COUNT_JUMPED = 32
    LOAD_JUMPED = 64
    LOAD_IS_OFF = 128


WINCH = structure(
    "Winch",
    "The nominal winch, as the parameters state it.",
    Row("is_first_order", "", "1: u' = K (u_0 - u) by the payout set-point; 0: speed servo", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("lag", "s", "time constant T of the speed servo; 1/K of a first-order winch"),
    Row("delay", "s", "time from the start of a command's tick to its effect"),
    Row("position_gain", "1/s", "k_p of the servo's position loop"),
    Row("gain", "", "speed over set-point while it pays out"),
    Row("hauling_gain", "", "speed over set-point while it hauls in"),
    Row("creep", "m/s", "speed at a set-point of 0"),
    Row("reach", "m/s", "largest set-point that has an effect"),
    Row("speed", "m/s", "largest speed"),
    Row("acceleration", "m/s^2", "largest acceleration"),
    Row("power", "W", "largest product of tension and speed; 0: no limit"),
)

CABLE = structure(
    "Cable",
    "The nominal two-state cable a z'' + b z' + z = x_0 - payout, tension k (x_0 - payout - z).",
    Row("inertia", "s^2", "a of the first mode, in which the unit swings, at `length`"),
    Row("participation", "", "of that mode in a motion of the boom tip"),
    Row("damping", "s", "b"),
    Row("drag", "s^2/m", "quadratic drag: the damping is drag |z'| where that is more than b"),
    Row("stiffness", "N/m", "k at `length`"),
    Row("length", "m", "unstretched cable at payout 0"),
    Row("static_tension", "N", "tension at the top at rest; 0: not known"),
)

BOUNDS = structure(
    "Bounds",
    "Margins and times of the envelope: the fields of `EnvelopeParameters` of the same names.",
    Row("window", "s", "time over which the ship's motion is watched"),
    Row("rate_factor", "", "speed about the asked move over the largest rate of the boom tip"),
    Row("rate_margin", "m/s", "speed beyond that"),
    Row("travel_factor", "", "travel about the asked move over the largest heave of the boom tip"),
    Row("travel_margin", "m", "travel beyond that"),
    Row("travel_time", "s", "time in which travel is forgotten"),
    Row("early_factor", "", "factor on both while the window is empty"),
    Row("lost_factor", "", "factor on both while the count or the motion reference unit is lost"),
    Row("largest_heave", "m", "heave beyond which a reading is implausible"),
    Row("largest_rate", "m/s", "rate beyond which a reading is implausible"),
    Row("largest_acceleration", "m/s^2", "change of the rate beyond which two readings do not belong together"),
    Row("heave_step", "m", "step of the heave beyond its rate that is a jump"),
    Row("mru_time", "s", "time without a good reading after which the motion reference unit is lost"),
    Row("frozen_readings", "", "equal readings in a row that are a frozen motion reference unit"),
    Row("count_time", "s", "time without a good reading after which the count is lost"),
    Row("count_step", "m", "step of the count beyond the winch's largest speed that is a jump"),
    Row("frozen_travel", "m", "travel sent without a step of the count after which it is frozen"),
    Row("frozen_time", "s", "time that this takes at least"),
    Row("drum_margin", "m", "distance of the count from the nominal drum that is allowed"),
    Row("drum_share", "", "and the share of the travel of the last `drum_time`"),
    Row("drum_time", "s", "time in which that distance is forgotten"),
    Row("stroke_factor", "", "speed and acceleration of the count over the largest sent of late"),
    Row("stroke_margin", "m", "way beyond that at which the drum runs; twice the step of the count is added"),
    Row("stroke_gain", "", "weight of a way that is gained by acceleration beside one by speed: drives overshoot"),
    Row("stroke_late", "s", "time by which a drum may follow later than stated"),
    Row("stroke_soon", "s", "the same of a drive that has kept to it for a `window`"),
    Row("stroke_span", "s", "time over which ways are formed, one beside the one before, for the acceleration"),
    Row("brake_margin", "m", "motion of the count under the brake that is allowed; a step of half of it may be a jump"),
    Row("rest_speed", "m/s", "speed below which a braked drum stands"),
    Row("used_share", "", "of the bounds on speed and travel, up to which the controller goes"),
    Row("bound_time", "s", "time at a bound after which the envelope takes over"),
    Row("bound_window", "s", "within which that time counts"),
    Row("takeover_time", "s", "time in which the envelope's own order fades"),
    Row("damping_time", "s", "time for which it goes on to damp the load by the load cell"),
    Row("damping_rate", "1/s", "speed over the stretch that the load cell shows beyond its mean"),
    Row("fade_out_time", "s", "longest fade-out with the motion reference unit"),
    Row("blind_time", "s", "longest fade-out without it"),
    Row("unseen_time", "s", "longest compensation without the motion reference unit"),
    Row("stop_deceleration", "m/s^2", "deceleration of a stop: `modes.stop_deceleration`"),
    Row("stop_margin", "m/s", "speed about the ramp of a stop that is allowed"),
    Row("stop_time", "s", "time at the end of the ramp after which the brake goes on"),
    Row("move_tolerance", "m", "distance of an asked move beyond that by count or depth sensor"),
    Row("harm_ratio", "", "spread of the load cell over that of the nominal cable with the winch locked"),
    Row("harm_margin", "", "spread beyond that, over the static tension"),
    Row("harm_time", "s", "time over which spreads are formed, and for which harm must last"),
    Row("harm_felt", "", "largest ratio of those that is taken for the cable's own, seen under the locked winch"),
    Row("load_step", "", "step of the load cell over the static tension, beyond the ship's motion, that is a jump"),
    Row("load_taut", "", "tension over the static one below which the cable may be slack further down, and snap"),
    Row("tension_travel", "m", "travel of constant tension: `tension.travel`"),
    Row("largest_load", "N", "reading of the load cell beyond which it is implausible; 0: it is not used"),
    Row("highest_tension", "N", "tension above which the winch gives way; 0: none"),
    Row("jerk_time", "s", "time in which the acceleration of a move builds up: `move.jerk_time`"),
)

DESIGN = structure(
    "Design",
    "Values from parameters and operator only; nothing identified or estimated.",
    Row("tick_period", "s", "time of a tick"),
    Row("winch", "", "nominal winch", WINCH),
    Row("cable", "", "nominal cable", CABLE),
    Row("envelope", "", "margins and times of the envelope", BOUNDS),
)

SENT = structure(
    "Sent",
    "A command that was sent, and the move requested at that time.",
    Row("payout", "m", "payout set-point"),
    Row("rate", "m/s", "payout-rate set-point"),
    Row("brake", "", "1: on"),
    Row("move", "m/s", "rate of the asked move"),
)

DRUM = structure(
    "Drum",
    "A nominal drum.",
    Row("payout", "m", "cable paid out"),
    Row("rate", "m/s", "speed, positive pays out"),
)

MOVE = structure(
    "Move",
    "The move that the operator has requested, as the envelope generates it.",
    Row("request", "", "number of the newest request taken"),
    Row("kind", "", "what goes on: MoveKind"),
    Row("distance", "m", "to go to the target"),
    Row("rate", "m/s", "of the mean payout"),
    Row("slope", "m/s^2", "its acceleration"),
    Row("speed", "m/s", "largest, or that is asked for"),
    Row("acceleration", "m/s^2", "largest"),
)

STROKE = structure(
    "Stroke",
    "Position of the drum, without jumps of count and set-point.",
    Row("sent", "m", "by the nominal drum without delay"),
    Row("nominal", "m", "by the nominal drum"),
    Row("off", "m", "way of the count beyond that without delay"),
)

BEYOND = structure(
    "Beyond",
    "Way of the drum at a speed beyond any that was sent of late.",
    Row("out", "m", "paid out"),
    Row("in", "m", "hauled in"),
)

HELD_DRUM = structure(
    "HeldDrum",
    "A braked drum, by its count.",
    Row("time", "s", "for which the brake has acted; 0: it does not"),
    Row("count", "m", "last reading"),
    Row("slowest", "m/s", "least speed so far"),
    Row("rests", "", "1: it has come to rest, or runs on without"),
    Row("step", "m", "large step that may have been a jump"),
    Row("runs", "", "1: the last large step was motion"),
    Row("moved", "m", "since it came to rest"),
)

DRIFT = structure(
    "Drift",
    "The count beside what was sent while the winch follows the sea, and what the depth sensor says of it.",
    Row("time", "s", "for which it has followed"),
    Row("off", "m", "count less nominal drum, forgotten as travel is"),
    Row("way", "m", "of the count, forgotten likewise"),
    Row("heave", "m", "of the nominal unit, whose payout is the count"),
    Row("heave_rate", "m/s", "of the nominal unit"),
    Row("level", "m", "depth and that heave together, as it began; NaN: none yet"),
    Row("shown", "m", "the same now, smoothed"),
    Row("seen", "m", "`off` at the last reading of the depth sensor, smoothed likewise"),
    Row("against", "m^2", "mean drift times what the depth went against it beyond half; below 0: creep"),
    Row("age", "s", "since that reading"),
)

BIN = structure(
    "Bin",
    "Boom-tip motion within one part of the window.",
    Row("rate", "m/s", "largest rate"),
    Row("highest", "m", "largest heave"),
    Row("lowest", "m", "least heave"),
    Row("sum", "m", "of all heaves"),
    Row("readings", "", "number of them"),
    Row("time", "s", "seen"),
)

SPREAD = structure(
    "Spread",
    "Exponentially weighted mean and variance of a signal.",
    Row("mean", "N", "of the signal"),
    Row("variance", "N^2", "of the signal"),
)

STATE = structure(
    "State",
    "State of the envelope.",
    Row("tick", "", "ticks so far", COUNTER),
    Row("bin", "", "bin that is being filled", COUNTER),
    Row("equal", "", "equal readings of the motion reference unit in a row", COUNTER),
    Row("sample", "", "newest sample of the drum's way", COUNTER),
    Row("phase", "", "Phase: who makes the order"),
    Row("cause", "", "Cause: why the envelope took over; latched until acknowledged"),
    Row("phase_time", "s", "time in the phase"),
    Row("duty", "", "Duty of the tick before"),
    Row("limited", "", "1: the drive reports a limit of its own; forgotten as travel is"),
    Row("value", "", "figure that the cause exceeded, in its unit"),
    Row("limit", "", "limit of that figure"),
    Row("ramp", "m/s", "largest speed of a stop that is under way; NaN: none is"),
    Row("rest_time", "s", "time at the end of the ramp"),
    Row("fade_time", "s", "time of the fade-out with the motion reference unit"),
    Row("blind_time", "s", "time of fade-out or compensation without it"),
    Row("bound", "s", "time at a bound of late"),
    Row("mru_age", "s", "since the last good reading"),
    Row("seen_time", "s", "for which the motion reference unit has been good without a loss"),
    Row("heave", "m", "of the boom tip, jumps taken off"),
    Row("rate", "m/s", "of the boom tip"),
    Row("read_heave", "m", "of the last reading; NaN: none yet"),
    Row("read_rate", "m/s", "of the last reading"),
    Row("read_age", "s", "since the last reading"),
    Row("jump", "m", "taken off the heave"),
    Row("count_age", "s", "since the last good reading"),
    Row("count", "m", "last reading; NaN: none yet"),
    Row("position", "m", "count, jumps taken off"),
    Row("step", "m", "of the last reading from the one before"),
    Row("unproved", "m", "way that a count which has jumped is to go along with the drum"),
    Row("strayed", "m", "from the drum on that way"),
    Row("still_travel", "m", "sent without a step of the count"),
    Row("still_time", "s", "for which that goes on"),
    Row("since_count", "m", "travel of the nominal drum since the last reading of the count"),
    Row("time_since_count", "s", "since the last reading of the count"),
    Row("asked_since_count", "m", "travel of the asked move since then"),
    Row("travel_sent", "m", "travel of the nominal drum about the asked move"),
    Row("travel_count", "m", "travel by count about the asked move"),
    Row("allowance", "m", "further travel that is allowed: constant tension"),
    Row("lead", "m", "further travel that is allowed: for a move that the load is to follow, or a swing to stop"),
    Row("held_tension", "N", "tension that was last asked for"),
    Row("residual", "m", "count less nominal drum of late"),
    Row("drum_travel", "m", "travel of the nominal drum of late"),
    Row("drift", "", "of the count from what was sent", DRIFT),
    Row("last_speed", "m/s", "speed of the last order sent"),
    Row("load", "N", "last reading of the load cell, jumps taken off; NaN: none yet"),
    Row("load_jump", "N", "taken off the load"),
    Row("load_known", "N", "of that, what an operator knows of"),
    Row("taut_time", "s", "for which the cable has been taut"),
    Row("load_age", "s", "since that reading"),
    Row("mean_load", "N", "of the load cell, forgotten as orders at a bound are"),
    Row("unit_heave", "m", "of the nominal cable with the winch locked"),
    Row("unit_rate", "m/s", "of the nominal cable with the winch locked"),
    Row("harm_time", "s", "for which the load cell has shown harm"),
    Row("left", "N^2", "variance of the load beyond the nominal one as following began; it fades"),
    Row("felt", "", "spread of the load cell over that of the nominal cable, under a locked winch"),
    Row("follow_time", "s", "for which the winch has followed the sea and nothing else"),
    Row("measured", "", "spread of the load cell", SPREAD),
    Row("locked", "", "spread of the nominal cable's tension with the winch locked", SPREAD),
    Row("drum", "", "nominal drum driven by what was sent", DRUM),
    Row("prompt", "", "nominal drum without delay", DRUM),
    Row("stroke", "", "where the drum is", STROKE),
    Row("unjudged", "", "samples since the last reading of the count"),
    Row("strokes", "", "where it was, by sample", STROKE, (STROKES,)),
    Row("beyond", "", "of a drum that may be late", BEYOND),
    Row("beyond_soon", "", "of one that has been punctual", BEYOND),
    Row("punctual_time", "s", "for which a drum that turns has been so"),
    Row("resolution", "m", "smallest step of the count, in a minute; 0: none yet"),
    Row("runaway", "m", "way of the count beyond any that was sent; positive pays out"),
    Row("off_step", "m", "large step of the count beyond what was sent that may have been a jump"),
    Row("off_runs", "", "1: the last such step was motion"),
    Row("held", "", "drum under its brake", HELD_DRUM),
    Row("move", "", "asked move", MOVE),
    Row("bins", "", "what the boom tip did", BIN, (BINS,)),
    Row("sent", "", "orders of late, by tick", SENT, (KEPT,)),
)

READINGS = structure(
    "Readings",
    "Inputs of the envelope at a tick.",
    Row("mru_heave", "m", "raw heave of the boom tip, positive up; NaN: no good reading came"),
    Row("mru_rate", "m/s", "raw heave rate; NaN: none came"),
    Row("count", "m", "raw count of the drum; NaN: none came"),
    Row("count_age", "s", "time by which that count is older than the tick"),
    Row("drive", "", "DriveState: what the winch reports of itself"),
    Row("load", "N", "raw load cell; NaN: none came"),
    Row("depth", "m", "raw depth sensor, positive down; NaN: none came"),
    Row("lift_rate", "m/s", "rate with which a crane lifts the boom tip, by geometry"),
    Row("duty", "", "Duty: what the controller is there for"),
    Row("held_tension", "N", "tension that was asked for; NaN: none"),
    Row("request", "", "number of the operator's request"),
    Row("kind", "", "MoveKind"),
    Row("distance", "m", "to go, as the controller has it"),
    Row("target", "m", "payout to go to; NaN: none was stated"),
    Row("reference", "m", "to go, by the raw depth sensor; NaN: none"),
    Row("speed", "m/s", "largest, or that is asked for"),
    Row("acceleration", "m/s^2", "largest"),
    Row("acknowledged", "", "1: an operator acknowledges"),
    Row("payout", "m", "set-point that the controller orders"),
    Row("rate", "m/s", "set-point that the controller orders"),
    Row("brake", "", "1: the controller orders the brake"),
)

ORDER = structure(
    "Order",
    "The command that leaves the envelope, and the reason for any change.",
    Row("payout", "m", "set-point sent"),
    Row("rate", "m/s", "set-point sent"),
    Row("brake", "", "1: on"),
    Row("bits", "", "Bit: what acted in this tick"),
    Row("phase", "", "Phase"),
    Row("cause", "", "Cause"),
    Row("value", "", "figure that the cause, or the bound, is about"),
    Row("limit", "", "its limit"),
    Row("rate_bound", "m/s", "largest speed about the asked move"),
    Row("travel_bound", "m", "largest travel about the asked move"),
    Row("move_rate", "m/s", "of the asked move"),
    Row("travel_sent", "m", "by the nominal drum"),
    Row("travel_count", "m", "by count"),
    Row("residual", "m", "count less nominal drum of late"),
    Row("residual_limit", "m", "its limit"),
    Row("harm", "", "spread of the load cell over its limit; NaN: not judged"),
    Row("speed", "m/s", "speed that was sent"),
    Row("load_step", "N", "step of the load cell that no load makes; 0: none"),
    Row("lowest", "m/s", "set-point down to which the controller may go next: a rate, or payout beyond the drum's [m]"),
    Row("highest", "m/s", "set-point up to which it may go next; infinite where no bound acts"),
)
