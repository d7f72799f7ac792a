"""The table of laws, governor and command: what a design fills, what a tick changes, what goes in and out."""

from __future__ import annotations

from enum import IntEnum

from heave_core.envelope_table import MOVE
from heave_core.filter_table import STATES
from heave_core.rows import COUNTER, Row, Size, structure

PLAN_ROWS = Size("PLAN_ROWS", 2048)
"""Rows of a plan that fit: limits at ticks of its horizon."""

PLAN_NUMBERS = Size("PLAN_NUMBERS", 131072)
"""Numbers of those rows that fit: rows times states."""

FOLLOWED = Size("FOLLOWED", 20)
"""Ticks for which the corrections of a plan are kept: the most between two solutions, `mpc.solve_ticks`."""

TENSION_TICKS = Size("TENSION_TICKS", 1024)
"""Ticks of tension and payout that fit: of a wave down the wire and back."""

ALONE_STATES = Size("ALONE_STATES", 40)
"""States of the sea, and one, that fit where tension and drum lead alone."""

HALVINGS = Size("HALVINGS", 20)
"""Halvings of a tick that find when a limited servo has reached its linear speed: to 5e-8 of the tick."""


class LawKind(IntEnum):
    """How a law makes its command."""

    ANOTHER_LAW = 0
    NO_LAW = 1
    LINEAR_LAW = 2
    FEEDBACK_LAW = 3
    CONSTRAINED_LAW = 4


class RowKind(IntEnum):
    """What the rows of a plan bound, in their order."""

    PLANNED_SPEED = 0
    PLANNED_ACCELERATION = 1
    PLANNED_SET_POINT = 2
    PLANNED_PAYOUT = 3
    PLANNED_TENSION = 4
    PLAN_KINDS = 5


class Way(IntEnum):
    """By what the command of a tick is made."""

    BY_LAW = 0
    BY_FADE = 1
    BY_SETTLING = 2
    BY_PLACE = 3
    BY_TENSION = 4
    BY_NOTHING = 5
    BY_BRAKE = 6
    BY_SLOWING = 7


class Asks(IntEnum):
    """What Python is asked for before the command can be made."""

    NEEDS_PLAN = 1
    NEEDS_LAW = 2
    NEEDS_TENSION = 4


class Shaped(IntEnum):
    """What has shaped a command."""

    BY_SPEED = 1
    BY_POWER = 2
    BY_RANGE = 4
    BY_ACCELERATION = 8
    BY_FADING = 16
    BY_HIGHEST_TENSION = 32
    BY_ENVELOPE = 64
    BY_BOUNDS = 128


class Moved(IntEnum):
    """Which payout has moved in a tick."""

    MEAN_MOVED = 1
    LEFT_OVER_MOVED = 2
    CARRIED_MOVED = 4
    HALT_ENDED = 8


MEAN_PAYOUT = structure(
    "MeanPayout",
    "The mean payout and its motion.",
    Row("tick_period", "s", "time of a tick"),
    Row("jerk_time", "s", "time in which the acceleration of a move builds up"),
    Row("payout", "m", "now"),
    Row("move", "", "that goes on", MOVE),
)

MEAN_MOTION = structure(
    "MeanMotion",
    "Intended motion of the winch, and the loop's response to it.",
    Row("mean", "", "payout about which the winch compensates", MEAN_PAYOUT),
    Row("left_over", "", "payout from before a stop, on its way to the mean", MEAN_PAYOUT),
    Row("carried", "", "payout by which the mean is carried along where the place moves", MEAN_PAYOUT),
    Row("state", "", "that the mean payout alone brings about", shape=(STATES,)),
    Row("lead", "", "state that the drum's lead of it alone brings about", shape=(STATES,)),
)

ACTIVE_WINCH = structure(
    "ActiveWinch",
    "Active winch model and its limits, the only place from which a tick takes them.",
    Row("is_first_order", "", "1: u' = K (u_0 - u) by the payout set-point; 0: speed servo", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("tick_period", "s", "time of a tick"),
    Row("lag", "s", "time constant T of the speed servo"),
    Row("position_rate", "1/s", "K of a first-order winch"),
    Row("position_gain", "1/s", "k_p of the servo's position loop"),
    Row("gain", "", "speed over set-point while it pays out"),
    Row("hauling_gain", "", "factor on it while it hauls in"),
    Row("creep", "m/s", "speed at a set-point of 0"),
    Row("reach", "", "largest set-point over the largest speed"),
    Row("tick_share", "", "1 - exp(-dt/T): of a step that the servo makes in a tick"),
    Row("linear_step", "m/s", "largest distance of a set-point from the speed, in the linear model"),
    Row("speed", "m/s", "largest speed"),
    Row("acceleration", "m/s^2", "largest acceleration"),
    Row("power", "W", "largest product of tension and speed; infinite without a limit"),
    Row("lowest", "m", "least payout that is used"),
    Row("highest", "m", "largest payout that is used"),
    Row("least_tension", "N", "least tension at the top that a plan may have; 0: any"),
    Row("most_tension", "N", "highest one; above it the winch gives way; infinite: any"),
    Row("static_tension", "N", "while all hangs at rest"),
)

LAW = structure(
    "Law",
    "A control law: u = m v - G x with the unit's share bounded, or a plan within the limits of the winch.",
    Row("kind", "", "LawKind: how it makes its command", COUNTER),
    Row("states", "", "number of states", COUNTER),
    Row("unit", "", "states of the unit: heave and its rate", COUNTER, (2,)),
    Row("plans", "", "1: near the limits the constrained law takes over", COUNTER),
    Row("solve_ticks", "", "ticks between solutions of the plan", COUNTER),
    Row("ends", "", "row of the plan at which each RowKind ends", COUNTER, (RowKind.PLAN_KINDS,)),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("gain", "", "G, of all states", shape=(STATES,)),
    Row("reading_share", "", "m, of the heave rate that the motion reference unit reads"),
    Row("unit_share", "", "of the largest speed that the unit's own error may ask for"),
    Row("near_speed", "m/s", "row of the boom tip's rate", shape=(STATES,)),
    Row("near_acceleration", "m/s^2", "row of its acceleration", shape=(STATES,)),
    Row("near_kept", "", "of a wave, or a swing of the unit, after a tick"),
    Row("near_begins", "", "share of a limit from which on it is near"),
    Row("near_ends", "", "share of a limit below which it is no longer"),
    Row("constrained", "", "gain with which plans at the limits are made", shape=(STATES,)),
    Row("free_less_constrained", "", "gain away from the limits less that", shape=(STATES,)),
    Row("kept", "", "of the step between the two after a solution without a limit"),
    Row("standing", "m/s", "row of the command under which the drum does not accelerate", shape=(STATES,)),
    Row("spared", "", "share of the acceleration that a command leaves unused where no limit shapes it"),
    Row("times", "s", "from now, of the rows that bound the payout", shape=(PLAN_ROWS,)),
    Row("rows", "", "of the plan, by state: one state's share of all rows after the other's", shape=(PLAN_NUMBERS,)),
)

LAW_STATE = structure(
    "LawState",
    "State and results of a law.",
    Row("asks", "", "Asks: 0, or NEEDS_PLAN", COUNTER),
    Row("since_solution", "", "ticks since the plan was last solved", COUNTER),
    Row("plan_age", "", "ticks since the plan that is followed was made", COUNTER),
    Row("has_plan", "", "1: a correction is followed; 0: no limit shapes the command", COUNTER),
    Row("is_near", "", "1: the limits are near, or were shortly before", COUNTER),
    Row("by_plan", "", "1: the command of the tick is that of the constrained law", COUNTER),
    Row("command", "m/s", "that is asked for"),
    Row("near_share", "", "of a limit, the largest of late"),
    Row("freedom", "", "share of the gain that is that away from the limits"),
    Row("correction", "m/s", "of the plan, by ticks since its solution", shape=(FOLLOWED,)),
    Row("seen_now", "m/s", "what a preview adds to the command, with the constrained gain"),
    Row("seen_free", "m/s", "what it adds beyond that with the free one"),
    Row("seen", "", "what it adds to the rows of the plan", shape=(PLAN_ROWS,)),
    Row("planned", "", "rows of the plan without a correction", shape=(PLAN_ROWS,)),
    Row("lower", "", "their lower bounds", shape=(PLAN_ROWS,)),
    Row("upper", "", "their upper bounds", shape=(PLAN_ROWS,)),
)

PROBLEM = structure(
    "Problem",
    "Inputs of a law at a tick.",
    Row("payout", "m", "of the winch as it follows the mean payout, when the next command takes effect"),
    Row("rate", "m/s", "its rate"),
    Row("command", "m/s", "share of the command that belongs to it"),
    Row("static_tension", "N", "about which the model's tension counts"),
    Row("measured_tension", "N", "low-passed reading of the load cell"),
    Row("mru_rate", "m/s", "heave rate as it was read, times the authority"),
    Row("bounds_tension", "", "1: the highest tension is to be kept"),
    Row("speed", "m/s", "largest about the mean payout that the envelope lets pass; infinite where none is known"),
    Row("x", "", "state of the compensation problem", shape=(STATES,)),
)

GOVERNED = structure(
    "Governed",
    "Command after the governor.",
    Row("value", "m/s", "in the terms of the linear model: the estimator's input"),
    Row("sent", "m/s", "the same for the winch, whose limiter acts within the tick, and which has a gain of its own"),
    Row("shaped", "", "Shaped: by what"),
)

TENSION_RECORD = structure(
    "TensionRecord",
    "Tension and payout of the last ticks.",
    Row("newest", "", "place of the newest", COUNTER),
    Row("count", "", "of ticks there are", COUNTER),
    Row("kept", "", "of ticks at most", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("tensions", "N", "at the top", shape=(TENSION_TICKS,)),
    Row("payouts", "m", "of the drum", shape=(TENSION_TICKS,)),
)

TENSION_ALONE = structure(
    "TensionAlone",
    "Boom-tip motion from tension alone: a filter with the assumed sea, and a constant as its last state.",
    Row("states", "", "of the sea, and one", COUNTER),
    Row("window", "", "ticks over which the tension is averaged", COUNTER),
    Row("trip", "", "ticks that a wave takes down the wire and back", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("sea", "", "states of the model that are of the sea", COUNTER, (ALONE_STATES,)),
    Row("weights", "", "of the newest tension and those before in the mean", shape=(TENSION_TICKS,)),
    Row("A", "", "transition of a tick, row by row", shape=(ALONE_STATES * ALONE_STATES,)),
    Row("row", "", "c, of the reading", shape=(ALONE_STATES,)),
    Row("rate", "", "row of the boom tip's rate when the next command acts", shape=(ALONE_STATES,)),
    Row("gain", "", "g, of the reading, stationary", shape=(ALONE_STATES,)),
    Row("x", "", "state", shape=(ALONE_STATES,)),
    Row("stiffness", "N/m", "of the wire"),
    Row("standing", "s", "time constant of the correction above a unit that stands"),
    Row("hanging", "s", "the same above one that hangs"),
)

TENSION_LAW = structure(
    "TensionLaw",
    "Constant tension, boom tip known.",
    Row("tip_rate", "m/s", "row of the boom tip's rate when the command acts", shape=(STATES,)),
    Row("standing", "m/s", "row of the command under which the drum would stand", shape=(STATES,)),
    Row("outlet", "m", "row of the cable that is out beyond the boom tip", shape=(STATES,)),
    Row("time_constant", "s", "of the correction"),
    Row("speed", "m/s", "largest correction"),
    Row("blend_step", "", "share of the boom tip that is given up, or taken up again, in a tick"),
    Row("travel_share", "", "of a tick in the average of the travel"),
)

TENSION_STATE = structure(
    "TensionState",
    "State of constant tension.",
    Row("has_alone", "", "1: what leads alone is there", COUNTER),
    Row("begins", "", "1: it begins in the next tick", COUNTER),
    Row("value", "N", "that is held now; NaN before the first"),
    Row("target", "N", "that it goes to"),
    Row("slope", "N/s", "with which it goes there"),
    Row("origin", "m", "cable out beyond the boom tip where the travel begins; NaN: in the next tick"),
    Row("travel", "m", "from there, averaged"),
    Row("bound", "m", "of it, either way"),
    Row("required", "m", "travel that the change of tension needs beyond the bound"),
    Row("tip_share", "", "share of the command that goes by the boom tip as it is estimated"),
    Row("record", "", "tension and payout of late", TENSION_RECORD),
    Row("alone", "", "what leads by them alone", TENSION_ALONE),
)

COMMAND_DESIGN = structure(
    "CommandDesign",
    "What else determines the command, apart from winch and law.",
    Row("states", "", "number of states", COUNTER),
    Row("payout", "", "state of the payout", COUNTER),
    Row("unit", "", "states of the unit: heave and its rate", COUNTER, (2,)),
    Row("sea_states", "", "number of states of the sea", COUNTER),
    Row("sea", "", "states of vessel and waves", COUNTER, (STATES,)),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("payout_row", "m", "row of the payout", shape=(STATES,)),
    Row("payout_ahead", "m", "row of the payout when the command takes effect", shape=(STATES,)),
    Row("rate_ahead", "m/s", "row of its rate then", shape=(STATES,)),
    Row("fade", "m/s", "row of the command that follows the boom tip slowly", shape=(STATES,)),
    Row("settling", "m/s", "row of the one that damps the unit as well", shape=(STATES,)),
    Row("inertia", "s^2", "a of the two-state cable"),
    Row("damping", "s", "b of it"),
    Row("stiffness", "N/m", "of the cable"),
    Row("giving_time", "s", "in which the winch gives way to a tension above the highest one"),
    Row("largest_unseen", "m", "swing that compensation corrects of a unit that no depth sensor sees"),
    Row("unseen_error", "m", "swing beyond which it corrects all: up to there it may be error"),
    Row("stop_step", "m/s", "by which a stop is slower each tick"),
    Row("longest_fade", "s", "longest fade-out"),
    Row("minute", "s", "over which speeds and travel are remembered"),
    Row("more_travel", "", "travel of a fade-out over the largest of the last minute"),
    Row("more_room", "m", "travel beyond that"),
    Row("quicker", "", "step over the largest of the last minute that is allowed then"),
    Row("more_acceleration", "m/s^2", "acceleration beyond that"),
    Row("tension", "", "constant tension", TENSION_LAW),
)

COMMAND_STATE = structure(
    "CommandState",
    "The last command, and statistics of the last minute of commands.",
    Row("value", "m/s", "of the last command, in the terms of the linear model"),
    Row("sent", "m/s", "set-point for it"),
    Row("standing", "m/s", "command under which the winch would have stayed where it was"),
    Row("shaped", "", "Shaped: by what"),
    Row("speed", "m/s", "that was ordered"),
    Row("travel", "m", "that the orders make: e' = v - e / minute"),
    Row("largest_speed", "m/s", "of the last minute; it stays while a fade-out is under way"),
    Row("largest_travel", "m", "of the last minute, likewise"),
    Row("last_sent", "m/s", "set-point, for its step"),
    Row("largest_step", "m/s", "of set-points within the last minute"),
    Row("easing", "s", "for which the order makes no larger step yet"),
    Row("fading", "s", "time of the fade-out that is under way; 0: none is"),
    Row("longest", "s", "that it may take"),
    Row("lead", "m", "payout by which the drum was to lead the mean one at the last tick"),
    Row("tension", "", "constant tension", TENSION_STATE),
)

LOOP = structure(
    "Loop",
    "State of the loop at a tick, and what the winch is to do.",
    Row("way", "", "Way: by what the command is made"),
    Row("share", "", "authority of which the law knows: 0 where the boom tip is not known"),
    Row("heave", "m", "of the unit with the winch locked"),
    Row("rate", "m/s", "its rate"),
    Row("swing", "m", "of the unit about the mean payout, which that brings about"),
    Row("swing_rate", "m/s", "its rate"),
    Row("is_unseen", "", "1: no depth sensor sees the unit that is held"),
    Row("left_over", "m", "payout from before a stop, on its way to the mean"),
    Row("mean_command", "m/s", "share of the next command that moves the mean payout"),
    Row("lead_command", "m/s", "share with which the drum leads it, so that the unit moves as it does"),
    Row("mru_rate", "m/s", "heave rate as read, times the authority"),
    Row("tension", "N", "newest reading at the top; NaN: none yet"),
    Row("filtered_tension", "N", "the same low-passed"),
    Row("gives_way", "", "1: the winch gives way to a tension above the highest one"),
    Row("bounds_tension", "", "1: plans keep the highest tension"),
    Row("fades", "", "1: a fade-out is under way"),
    Row("is_held", "", "1: it waits for a sensor"),
    Row("follows_tip", "", "1: the motion of the boom tip is known"),
    Row("unit_stands", "", "1: the unit stands on the bottom"),
    Row("lowest", "m/s", "set-point down to which the envelope lets pass; of a first-order winch about the drum [m]"),
    Row("highest", "m/s", "set-point up to which it does"),
    Row("estimate", "", "state without the mean payout's own motion", shape=(STATES,)),
    Row("mean_state", "", "state that the mean payout alone brings about", shape=(STATES,)),
    Row("lead_state", "", "state that the drum's lead alone brings about", shape=(STATES,)),
)

COMMAND = structure(
    "Command",
    "The command of a tick.",
    Row("asked", "m/s", "by the law, without the mean payout's share"),
    Row("value", "m/s", "that the governor lets through, in the terms of the linear model"),
    Row("sent", "m/s", "set-point for it"),
    Row("standing", "m/s", "under which the winch would stay where it is"),
    Row("compensating", "m/s", "share of the value that compensates"),
    Row("mean", "m/s", "share that moves the mean payout"),
    Row("shaped", "", "Shaped: by what of winch and fade-out"),
    Row("gives_way", "", "1: a tension above the highest one shapes it"),
    Row("at_travel", "", "1: the bound on the travel of constant tension shapes it"),
    Row("half_travelled", "", "1: half of that bound has been used"),
    Row("by_plan", "", "1: it is that of the constrained law"),
    Row("has_plan", "", "1: limits shape its plan"),
    Row("payout", "m", "of the drum when it takes effect"),
    Row("rate", "m/s", "of the drum then"),
)

PLACE = structure(
    "Place",
    "Position set-point that belongs to a speed command, for a drive with its own position loop.",
    Row("leak", "s", "time constant with which the place is drawn to the drum: far slower than the waves"),
    Row("reach", "m", "furthest that it leads the drum"),
    Row("payout", "m", "the place; NaN: the brake has not opened yet"),
)

ACT_SEEN = structure(
    "ActSeen",
    "Inputs of the acting half of a tick: what to do, and what was read.",
    Row("way", "", "Way: by what the command is made"),
    Row("authority", "", "of compensation"),
    Row("compensates", "", "1: the mode is that of compensation"),
    Row("fades", "", "1: it is fade_out"),
    Row("brake", "", "1: the brake is to be on"),
    Row("is_damped", "", "1: the unit is damped in a fade-out"),
    Row("bounds_tension", "", "1: the highest tension is one that compensation can keep"),
    Row("unit_stands", "", "1: the unit stands on the bottom"),
    Row("knows_tip", "", "1: the boom tip is measured"),
    Row("has_depth", "", "1: there is a depth sensor, and it is not lost"),
    Row("sees_landing", "", "1: and it does not contradict all others"),
    Row("follows_tip", "", "1: the motion reference unit is not lost"),
    Row("mru_rate", "m/s", "heave rate that was read; NaN: none"),
    Row("tension", "N", "newest reading at the top; NaN: none yet"),
    Row("filtered_tension", "N", "the same low-passed"),
    Row("static_tension", "N", "under the hanging unit at rest"),
    Row("at_limit", "", "1: a limit of the winch that a sea takes it to acts"),
    Row("stated_payout", "m", "payout that was read before it is known to be the mean one; NaN: it is known"),
    Row("scale", "", "of the encoder"),
    Row("offset", "m", "of its count by jumps"),
)

ACT_DONE = structure(
    "ActDone",
    "Results of the acting half of a tick.",
    Row("payout", "m", "set-point that is sent"),
    Row("rate", "m/s", "set-point that is sent"),
    Row("brake", "", "1: it is ordered"),
    Row("mean_payout", "m", "that the winch works about, in the encoder's count"),
    Row("own_payout", "m", "set-point in the controller's own count, without the place of the rate"),
    Row("own_rate", "m/s", "set-point likewise"),
    Row("set_point", "m", "payout about which the winch works"),
    Row("depth_set_point", "m", "the part of it that takes the unit to another depth"),
    Row("moved", "", "Moved: which payout has moved"),
    Row("load_news", "", "LoadNews: what has just begun"),
    Row("is_replaced", "", "1: the envelope has sent another order"),
)


class Stage(IntEnum):
    """Where a tick goes on; one that comes back before its end waits for Python there."""

    DONE = 0
    SENSE = 1
    DECIDE = 2
    POSE = 3
    ANSWER = 4
    MAKE = 5
    SEND = 6
    BEGIN = 7


class Stop(IntEnum):
    """Where a tick is to wait in any case."""

    AFTER_SENSE = 1
    BEFORE_ACT = 2
    BEFORE_ANSWER = 4


GIVEN = structure(
    "Given",
    "What comes at a tick, beside its readings: the winch's report, as long as no other comes.",
    Row("number", "", "of the tick"),
    Row("readings", "", "number of those delivered"),
    Row("stops", "", "bits of Stop"),
    Row("cause", "", "Cause for which the envelope has taken over; 0: it has not"),
    Row("has_winch", "", "1: the winch has reported in this tick"),
    Row("winch_time", "s", "of its report, by its clock"),
    Row("encoder", "m", "its count"),
    Row("encoder_rate", "m/s", "speed that it states with it"),
    Row("brake", "", "1: it has the brake on"),
    Row("fault", "", "0: none"),
    Row("command", "", "number of the newest command that it has taken"),
    Row("limits_hit", "", "bits of the limits that act"),
)

ACTIVE = structure(
    "Active",
    "What holds from tick to tick, until another design, belief or move is active.",
    Row("payout_limit", "", "bit of the end of the winch's payout, where no model of it holds", COUNTER),
    Row("identifies_winch", "", "1: what the drum is off counts", COUNTER),
    Row("has_begun", "", "1: the count may be used: it is known which payout is the mean one", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("stated_payout", "m", "payout that was read before that is known; NaN: it is known"),
    Row("static_tension", "N", "under the hanging unit at rest"),
    Row("settled_swing", "m", "of the unit at which a fade-out may end; infinite: it is not asked for"),
    Row("share", "", "authority that is best with the winch as it is known, above 0"),
    Row("tolerated_delay", "s", "of commands beyond the modelled one, with which compensation is tried"),
)

NOTED = structure(
    "Noted",
    "What the adviser is told of a tick, by the columns of its observations.",
    Row("command", "", "share of the last command that compensates, in the terms of the model"),
    Row("order_payout", "m", "set-point of the tick before"),
    Row("order_rate", "m/s", "set-point of the tick before"),
    Row("sequence", "", "number of that order"),
    Row("brake", "", "1: ordered then, or on by the report of the winch"),
    Row("encoder", "m", "payout as the encoder reads it, jumps taken off; NaN: none came"),
    Row("taken", "", "number of the newest order in effect; NaN: the winch has not reported"),
    Row("limits_hit", "", "bits of the limits that act"),
    Row("tension", "N", "newest at the top; NaN: none yet"),
    Row("authority", "", "of compensation, 0 to 1"),
    Row("compensates", "", "1: the mode is that of compensation"),
    Row("tip_heave", "m", "estimated, of the boom tip"),
    Row("tip_rate", "m/s", "its rate"),
    Row("unit_rate", "m/s", "rate of the unit, without the mean payout's share"),
    Row("missing_push", "m", "by how much more the linear model would push the unit down than a slack cable does"),
)

CONTROLLED = structure(
    "Controlled",
    "Results of a tick, and the order of it that the next one goes by.",
    Row("sequence", "", "number of the order; 0: none has been given"),
    Row("authority", "", "of compensation, 0 to 1"),
    Row("news", "", "News of the sensors"),
    Row("observed", "", "readings observed"),
    Row("proof_news", "", "ProofNews"),
    Row("asks", "", "Asks: what the law needs first"),
    Row("encoder_news", "", "ReflexNews"),
    Row("noted", "", "what the adviser is told", NOTED),
    Row("acted", "", "what the acting half has made", ACT_DONE),
)
