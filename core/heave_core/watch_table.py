"""The table of what is watched: landing, figures of merit, drum and link, nominal load; load, rope and winch."""

from __future__ import annotations

from enum import IntEnum

from heave_core.look_table import HANGING_CABLE, HANGING_UNIT
from heave_core.rows import COUNTER, Row, Size, structure

REMEMBERED = Size("REMEMBERED", 4096)
"""Readings of a trend that are kept."""

WINDOWS = Size("WINDOWS", 3)
"""Windows that are looked at, longer ones for noisier sensors."""


class Landed(IntEnum):
    """What has just happened to the unit."""

    NOT = 0
    TOUCHDOWN = 1
    LIFTED_OFF = 2


class LoadNews(IntEnum):
    """What has just begun with load, rope and winch."""

    SLACK = 1
    TENSION_HIGH = 2
    SATURATED = 4
    ROPE_SHORT = 8
    ROPE_OVERLOADED = 16
    TRAVEL_HALF = 32
    TRAVEL_END = 64


CAUSES = Size("CAUSES", len(LoadNews))
"""Causes that are watched."""


class ReflexNews(IntEnum):
    """What the reflex about the encoder has found before a tick."""

    ENCODER_FOUND = 1
    COUNT_STEPPED = 2
    COUNT_AGREES = 4
    COUNT_JUDGED = 8
    COUNT_DISPUTED = 16
    BELIEFS_REFUTED = 32
    ENCODER_REFUTED = 64
    ENCODER_TRUSTED = 128


class LinkNews(IntEnum):
    """What has just become wrong with the commands."""

    COMMANDS_SLOW = 1
    COMMANDS_RAGGED = 2


SERVO = structure(
    "Servo",
    "A speed servo behind a transport delay.",
    Row("lag", "s", "time constant"),
    Row("delay", "s", "from the start of a tick to the effect of its set-points"),
    Row("gain", "", "speed that it settles at over its set-point, paying out"),
    Row("deadband", "m/s", "of the set-point only what is beyond it counts"),
    Row("speed_out", "m/s", "limit of paying out"),
    Row("speed_in", "m/s", "limit of hauling in"),
    Row("acceleration_out", "m/s^2", "limit towards paying out"),
    Row("acceleration_in", "m/s^2", "limit towards hauling in"),
    Row("backlash", "m", "play of the encoder's gear"),
    Row("reach", "", "largest set-point that has an effect, over the limit of the speed"),
    Row("hauling", "", "gain of hauling in, over that of paying out"),
    Row("creep", "m/s", "speed at a set-point of 0"),
    Row("power", "W", "it turns no faster than this over the tension"),
)

SERVO_RUN = structure(
    "ServoRun",
    "A record of set-points, and how it is processed.",
    Row("sent", "", "set-points: more than ticks by the delay", COUNTER),
    Row("ticks", "", "at the end of the record, for which readings are made", COUNTER),
    Row("fitted", "", "readings that state payout and rate at the start", COUNTER),
    Row("start_steps", "", "Gauss-Newton steps to these", COUNTER),
    Row("tick_period", "s", "time of a tick"),
    Row("position_gain", "1/s", "of the servo's position loop; 0: none"),
    Row("position_step", "s", "step of the position loop; without one each piece of a tick is exact"),
    Row("edge", "", "part of a tick that counts as none"),
    Row("no_power_limit", "W", "power that no winch has"),
    Row("rate_step", "m/s", "step of the sensitivity to the rate at the start"),
    Row("weak_slope", "s", "effect of that rate on the payout that counts as none, as at the limit of the speed"),
)

SERVO_START = structure(
    "ServoStart",
    "A servo at the start of a record.",
    Row("payout", "m", "cable paid out"),
    Row("rate", "m/s", "speed, positive pays out"),
)

TREND = structure(
    "Trend",
    "The newest readings, in order of time.",
    Row("count", "", "readings that are kept", COUNTER),
    Row("next", "", "place of the next one", COUNTER),
    Row("changed", "s", "time of the last one that was another than the one before"),
    Row("times", "s", "of the readings", shape=(REMEMBERED,)),
    Row("values", "", "read", shape=(REMEMBERED,)),
)

LANDING_DESIGN = structure(
    "LandingDesign",
    "Load and cable, and the criteria for a landing.",
    Row("static_tension", "N", "at the top while the unit hangs under water"),
    Row("weight", "N", "of the unit in water"),
    Row("stiffness", "N/m", "of the cable"),
    Row("following_time", "s", "that a hanging unit needs to follow the winch"),
    Row("swing_time", "s", "of a free swing or a wave, whichever is longer"),
    Row("touchdown_ratio", "", "share of the weight below which the unit has landed: `tension.touchdown_ratio`"),
    Row("lowered", "m", "distance that the winch lowers within a window"),
    Row("shortest", "s", "least length of a window"),
    Row("longest", "s", "largest length of a window"),
    Row("windows", "", "that are looked at, over that", shape=(WINDOWS,)),
    Row("least_readings", "", "that a slope needs"),
    Row("filled", "", "share of a window that the readings must span"),
    Row("least_rate", "m/s", "above which the winch lowers"),
    Row("steady_share", "", "of the speed now that a steady one has had over a window at least"),
    Row("standing_share", "", "of the speed of lowering at which a unit that stands moves at most"),
    Row("relief_share", "", "of what the stiffness makes of the lowering that a relieved cable loses at least"),
    Row("certain", "", "standard errors by which a trend must be more than nothing"),
    Row("innovation_above", "", "standard deviations by which a landed unit is read above a hanging one"),
    Row("unconfirmed_time", "", "longest time of an unconfirmed touchdown, in windows"),
    Row("pause", "", "time after one until the next such, over that time"),
)

LANDING_STATE = structure(
    "LandingState",
    "State of the landing detector: where the unit is, and what was read.",
    Row("unit_stands", "", "1: on the seabed"),
    Row("may_stand", "", "1: it may just have landed"),
    Row("is_weighed", "", "1: a load cell tells whether it has; else it may until a swing is over"),
    Row("is_unloaded", "", "1: the winch is braked over a cable that does not carry the unit, on average"),
    Row("is_lifting", "", "1: a standing unit is to be lifted off"),
    Row("share", "", "of the weight that the cable has carried under the brake"),
    Row("lowering_rate", "m/s", "at which the winch lowers; 0 before that is known"),
    Row("may_stand_since", "s", "time of the last unconfirmed touchdown"),
    Row("event", "", "Landed: in this tick"),
    Row("depth", "m", "read, positive down", TREND),
    Row("hanging", "m", "depth of a unit that only hangs on its cable", TREND),
    Row("tension", "N", "at the top", TREND),
    Row("payout", "m", "mean one of the drum", TREND),
    Row("innovation", "", "of the depth sensor, over its standard deviation", TREND),
    Row("hanging_share", "", "of the weight that the cable of a hanging unit carries", TREND),
)

KPI_DESIGN = structure(
    "KpiDesign",
    "Length of the window, and when the winch counts as at its limits.",
    Row("tick_period", "s", "time of a tick"),
    Row("rows", "", "ticks that the window holds; whoever calls has the place for them"),
    Row("speed", "m/s", "from which on the winch is at its limit"),
    Row("acceleration", "m/s^2", "from which on the winch is at its limit"),
)

KPI_STATE = structure(
    "KpiState",
    "State of the KPI window, apart from its rows.",
    Row("count", "", "ticks so far"),
    Row("last_rate", "m/s", "of the winch at the last tick"),
)

KPI_ROW = structure(
    "KpiRow",
    "One tick of the window; NaN: not known.",
    Row("unit", "m", "heave of the unit"),
    Row("uncompensated", "m", "heave of the uncompensated one"),
    Row("tip", "m", "heave of the boom tip"),
    Row("payout", "m", "of the winch, about its mean"),
    Row("rate", "m/s", "of the winch"),
    Row("acceleration", "m/s^2", "of the winch"),
    Row("tension", "N", "at the top"),
    Row("at_limit", "", "1: the winch is at its limit"),
)

KPI_WINDOW = structure(
    "KpiWindow",
    "Statistics over the ticks whose heaves are known so far; NaN: none.",
    Row("rows", "", "ticks that count"),
    Row("unit", "m", "standard deviation of the unit"),
    Row("uncompensated", "m", "standard deviation of the uncompensated one"),
    Row("tip", "m", "standard deviation of the boom tip"),
    Row("outlet", "m", "standard deviation of boom tip less payout"),
    Row("largest", "m", "distance of the unit from its mean"),
    Row("speed", "m/s", "largest of the winch"),
    Row("acceleration", "m/s^2", "largest of the winch"),
    Row("power", "W", "largest of tension times speed"),
    Row("mean_power", "W", "mean of its absolute value"),
    Row("least_tension", "N", "at the top"),
    Row("largest_tension", "N", "at the top"),
    Row("at_limit", "", "share of the ticks at which the winch is at its limit"),
)

DRUM_WATCH_DESIGN = structure(
    "DrumWatchDesign",
    "How the commands and encoder readings of the last seconds are compared.",
    Row("kept", "", "ticks that are kept; whoever calls has the place for them", COUNTER),
    Row("ahead", "", "ticks before a record whose orders still act in it", COUNTER),
    Row("checked", "", "readings by which the drum is predicted", COUNTER),
    Row("ordered", "", "ticks over which orders and encoder are compared", COUNTER),
    Row("least_seen", "", "least share of readings that a comparison needs"),
    Row("settled", "", "time constants after which the initial state of a servo has decayed"),
    Row("least_motion", "m", "least motion of orders and encoder for a comparison, 1 sigma"),
    Row("run", "", "how a record is gone through", SERVO_RUN),
    Row("assumed", "", "drum that is assumed", SERVO),
    Row("nominal", "", "drum of the parameters", SERVO),
)

DRUM_WATCH_STATE = structure(
    "DrumWatchState",
    "Indices into the rows of the drum watch.",
    Row("next", "", "place of the next row", COUNTER),
    Row("count", "", "rows that there are", COUNTER),
    Row("readings", "", "rows since the comparison began", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
)

DRUM_ROW = structure(
    "DrumRow",
    "Command of a tick, and encoder reading at its end.",
    Row("payout", "m", "set-point"),
    Row("rate", "m/s", "set-point"),
    Row("tension", "N", "at the top; NaN: unknown"),
    Row("reading", "m", "of the encoder; NaN: none"),
    Row("is_limited", "", "1: the winch reports that a limit acted"),
)

REFLEX_DESIGN = structure(
    "ReflexDesign",
    "When the encoder is set aside; what it reads is a share of what the winch was ordered.",
    Row("look_ticks", "", "from one look to the next", COUNTER),
    Row("looks", "", "running that are wrong, of an encoder that has gone the right way", COUNTER),
    Row("lost_ticks", "", "after which a lost encoder is lost indeed", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("tick_period", "s", "time of a tick"),
    Row("another_count", "s", "from a jump of the count to the first effect of an order in the new one"),
    Row("longest_aside", "s", "in which it must be known what an encoder reads that is set aside"),
    Row("beginning", "s", "since the winch began to move, in which it may be the winch that is reversed"),
    Row("separated", "", "evidence of a third sensor at which drive or encoder is named [nats]"),
    Row("learnt", "", "share of a look in that of looks in which the encoder reads what was ordered"),
    Row("known", "", "that share from which on the winch is known: the encoder then errs"),
    Row("straight", "", "rest over the readings up to which orders and encoder are compared"),
    Row("reversed", "", "share below which the encoder is reversed"),
    Row("not_reversed", "", "share above which it is no more"),
    Row("less", "", "share below which its scale has changed suddenly"),
    Row("more", "", "share above which it has"),
    Row("not_less", "", "share from which on it has not any more"),
    Row("not_more", "", "share up to which it has not any more"),
    Row("error", "", "largest of the share of an encoder that reads what was ordered"),
)

REFLEX_STATE = structure(
    "ReflexState",
    "What the reflex remembers of the encoder.",
    Row("last", "", "tick in which the winch moved; -1: none", COUNTER),
    Row("lost_ticks", "", "for which it has been lost", COUNTER),
    Row("looks", "", "running in which it was wrong", COUNTER),
    Row("was_right", "", "1: it has gone the right way", COUNTER),
    Row("is_unresolved", "", "1: winch or encoder are wrong, and which is not known: nothing can be done", COUNTER),
    Row("is_reversed", "", "1: it was set aside for its direction; 0: for its scale", COUNTER),
    Row("is_named", "", "1: drive or encoder has been named", COUNTER),
    Row("compares", "", "1: a filter goes by the count, beside the active one", COUNTER),
    Row("moving_time", "s", "for which the winch has moved"),
    Row("aside_time", "s", "for which the encoder has been set aside"),
    Row("true_share", "", "of looks in which it reads what was ordered"),
    Row("nats", "", "evidence for the filter that goes by the count"),
    Row("payout", "m", "at which the drum is where the encoder was set aside"),
)

LINK_DESIGN = structure(
    "LinkDesign",
    "When commands count as late.",
    Row(
        "minute",
        "",
        "commands of which the share is judged; the caller has place for them and a window",
        COUNTER,
    ),
    Row("window", "", "commands that are judged together: one hiccup is no slow transport", COUNTER),
    Row("late_ticks", "", "commands in a row that are late after which the delay is another one", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("tick_period", "s", "time of a tick"),
    Row("largest_share", "", "of the commands that may be late; half of it ends the alarm"),
    Row("cut_time", "s", "without a new command taken after which the link counts as cut"),
    Row("memory", "s", "for which a silence of the winch is a cause"),
    Row("rounding", "", "part of a tick that counts as none"),
)

LINK_STATE = structure(
    "LinkState",
    "Lateness of the commands, and silence on the link.",
    Row("in_a_row", "", "late commands", COUNTER),
    Row("without_new", "", "ticks since a command was taken, where that is late", COUNTER),
    Row("newest", "", "number of the command that was taken last", COUNTER),
    Row("next", "", "place of the next command in the minute", COUNTER),
    Row("count", "", "commands in it", COUNTER),
    Row("late_in_minute", "", "of them late", COUNTER),
    Row("known", "", "commands of which it is known how late they were, since the start", COUNTER),
    Row("late", "", "of them late", COUNTER),
    Row("is_slow", "", "1: half of the commands of the last seconds were late", COUNTER),
    Row("is_ragged", "", "1: too many of the last minute were", COUNTER),
    Row("has_begun", "", "1: with the last one they have just become late", COUNTER),
    Row("is_cut", "", "1: no new command has been taken for long", COUNTER),
    Row("news", "", "LinkNews: what has just become wrong", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("largest", "s", "time by which one was later than modelled"),
    Row("overdue", "s", "time by which more than half of those of the last seconds were, at least"),
    Row("since_state", "s", "since the winch reported"),
    Row("silence", "s", "longest time without a report of late"),
    Row("since_silence", "s", "since then"),
    Row("untaken", "s", "for which commands should have been in effect and were not"),
)

WINCH_WATCH_DESIGN = structure(
    "WinchWatchDesign",
    "Limits for the checks of the winch.",
    Row("drum", "", "orders and encoder", DRUM_WATCH_DESIGN),
    Row("link", "", "commands", LINK_DESIGN),
    Row("delay", "s", "of the active winch"),
    Row("modelled", "s", "beyond which a command is late: the active delay, or the stated one"),
)

WINCH_WATCH_STATE = structure(
    "WinchWatchState",
    "State of the winch watch.",
    Row("drum", "", "orders and encoder", DRUM_WATCH_STATE),
    Row("link", "", "commands", LINK_STATE),
    Row("error", "m", "payout of the drum less what was predicted of it a second ago; 0 where unknown"),
)

NOMINAL_LOAD_DESIGN = structure(
    "NominalLoadDesign",
    "The nominal unit below a locked drum, and how the MRU moves it.",
    Row("tick_period", "s", "time of a tick"),
    Row("blend", "s", "time constant with which heave corrects the integral of its rate"),
    Row("unread", "s", "age of a reading from which on the motion is not known"),
    Row("cable", "", "that it hangs on", HANGING_CABLE),
)

NOMINAL_LOAD_STATE = structure(
    "NominalLoadState",
    "Positions of boom tip and unit.",
    Row("time", "s", "of the newest reading"),
    Row("heave", "m", "of the boom tip"),
    Row("unit", "m", "heave of the unit"),
    Row("read_time", "s", "for which the motion has been known"),
    Row("rate", "m/s", "of the boom tip"),
    Row("base_time", "s", "of the heave from which it goes on"),
    Row("base_heave", "m", "that heave; NaN: none was read"),
    Row("hanging", "", "the unit", HANGING_UNIT),
)

LOAD_WATCH_DESIGN = structure(
    "LoadWatchDesign",
    "Alarm limits for tension, rope and winch.",
    Row("tick_period", "s", "time of a tick"),
    Row("quiet_time", "s", "for which a cause must be away before it is reported again: groups of a swell are one"),
    Row("slack_ratio", "", "share of the static tension below which the cable goes slack"),
    Row("tension_ratio", "", "share of it above which the tension is high; 0: none is"),
    Row("saturation_time", "s", "over which the share of the time at a limit is averaged"),
    Row("saturation_share", "", "of the time at a limit above which the winch is saturated"),
    Row("capacity", "N", "that the rope can bear; NaN: not stated"),
    Row("required", "", "its safety factor"),
    Row("least", "", "safety factor below which it carries more than it can"),
)

LOAD_WATCH_STATE = structure(
    "LoadWatchState",
    "State of the alarms of load and winch.",
    Row("at_limit", "", "share of the time at a limit, averaged"),
    Row("quiet", "s", "time for which each cause has been away, by the bits of LoadNews", shape=(CAUSES,)),
)
