"""The table of what is sensed: gates, noise, the estimator's terms, consistency, tension, sea, and the tick itself."""

from __future__ import annotations

from enum import IntEnum

from heave_core.filter_table import MEASUREMENTS, STATES
from heave_core.look_table import MOTIONS
from heave_core.rows import COUNTER, Row, Size, structure

SENSORS = Size("SENSORS", 8)
"""Most sensors with a gate."""

NOISE_READINGS = Size("NOISE_READINGS", 100)
"""Readings that the noise is judged by, once there are so many."""

INTERVALS = Size("INTERVALS", 5)
"""Intervals by whose median a sensor's own rate is known."""

READ = Size("READ", 4)
"""Most numbers of a reading that the gate looks at."""

SHARES = Size("SHARES", 64)
"""Ticks for which the mean payout's share is kept, for readings that come late."""

TRAVELS = Size("TRAVELS", 10240)
"""Ticks that fit of the way that the drum should have turned."""


class Reason(IntEnum):
    """Why a reading was rejected, or a sensor is lost; from STATUS on it is what the sensor itself reports."""

    GOOD = 0
    NOT_A_NUMBER = 1
    WRONG_STAMP = 2
    OUT_OF_ORDER = 3
    FROZEN = 4
    SPIKE = 5
    JUMP = 6
    STALE = 7
    DELAYED = 8
    OUT_OF_RANGE = 9
    STATUS = 16


class Level(IntEnum):
    """How a sensor is seen."""

    SENSOR_OK = 0
    SENSOR_SUSPECT = 1
    SENSOR_LOST = 2


class ZeroKind(IntEnum):
    """What a reading counts from."""

    OWN_ZERO = 0
    FIRST_READING = 1
    STATIC_TENSION = 2


class News(IntEnum):
    """What a tick has that Python is to say in words."""

    SENSOR_WORSE = 1
    SENSOR_SLOW = 2
    NOISE_HIGH = 4
    NOISE_LOW = 8
    UNEXPLAINED = 16
    SEA_CHANGED = 32
    ACCURACY_REFUSED = 64


HEALTH = structure(
    "Health",
    "Tolerances of the gates.",
    Row("stamp_tolerance", "s", "by which a stamp may be ahead: `health.stamp_tolerance`"),
    Row("frozen_samples", "", "equal readings in a row: `health.frozen_samples`"),
    Row("stale_samples", "", "missing readings: `health.stale_samples`"),
    Row("recover_samples", "", "good readings: `health.recover_samples`"),
    Row("encoder_step", "m", "off the way sent that is a jump: `health.encoder_step`"),
    Row("bad_in_a_row", "", "refused readings that make a sensor lost"),
    Row("rounding", "s", "by which an age may be beyond its limit"),
    Row("sameness_memory", "", "readings over which the share of equal ones is found"),
    Row("in_steps", "", "longest run, which is forgotten slowly, from which on a sensor reads in steps"),
    Row("fewest_of_steps", "", "equal readings of a sensor that reads in steps that are frozen"),
    Row("longer", "", "the same over its longest run"),
    Row("crest", "", "the same over its newest run: at a crest the last step takes longer than the one before"),
    Row("standing_time", "s", "for which one may stand before its first step: a multiple of `modes.settling_time`"),
    Row("few_steps", "", "height of a sea in steps up to which a sensor may read in steps without two alike in a row"),
    Row("longest_wave", "s", "period of the longest wave: its crest stands for as long as it is within a step"),
    Row("by_chance", "", "probability of a run of equal readings below which a sensor is frozen"),
    Row("fewest_noise", "", "readings from which on noise is judged"),
    Row("noise_updated", "", "readings from one judgement of it to the next"),
    Row("noise_unknown", "", "noise until then over the nominal one"),
    Row("noise_worse", "", "ratio to the nominal noise, or to that last reported, that is reported"),
    Row("noise_median", "", "median magnitude of a third difference of white noise over its standard deviation"),
    Row("least_noise", "", "nominal noise up to which a sensor is never reported as quieter, in its unit"),
    Row("late", "", "nominal intervals from which on a reading is late"),
)

SENSOR = structure(
    "Sensor",
    "Assumed properties of a sensor.",
    Row("is_watched", "", "1: it has a gate", COUNTER),
    Row("is_used", "", "1: the estimator takes it", COUNTER),
    Row("checks_frozen", "", "1: equal readings mean a frozen sensor", COUNTER),
    Row("sees_tip", "", "1: it measures the boom tip, of which the mean payout has no share", COUNTER),
    Row("zero", "", "what it counts from: ZeroKind", COUNTER),
    Row("measured", "", "index of its first measurement", COUNTER),
    Row("sign", "", "of the value in the model over that of the reading"),
    Row("period", "s", "nominal interval of its readings"),
    Row("latency", "s", "usual age of a reading when it arrives"),
    Row("longest_period", "s", "longest interval that is believed of it"),
    Row("first_sameness", "", "share of equal readings at first"),
    Row("part_sameness", "", "the same of heave and rate of a motion reference unit"),
    Row("largest", "", "largest magnitude that each number of a reading can have, in its unit", shape=(READ,)),
    Row("scale", "", "assumed reading over truth"),
    Row("offset", "", "assumed offset of its first measurement"),
    Row("delay", "s", "assumed delay of its stamps"),
)

MEASURED = structure(
    "Measured",
    "A measurement, and its place in the filter.",
    Row("sensor", "", "index of the sensor; -1: none has it", COUNTER),
    Row("which", "", "index in the filter; -1: a cross-check alone", COUNTER),
    Row("has_noise", "", "1: the noise of the sensor is followed", COUNTER),
    Row(
        "is_judged",
        "",
        "1: and seen in the readings, between which the sea is smooth",
        COUNTER,
    ),
    Row("stretches", "", "1: it is the unit's heave, in which the cable's stretch by more payout has a share", COUNTER),
    Row("is_compared", "", "1: its innovations say whether model and sensor agree", COUNTER),
    Row("nominal", "", "standard deviation of the noise, as assumed, in the sensor's unit"),
    Row("sigma", "", "the same in the filter"),
    Row("largest_stated", "", "largest that the sensor may state; what is beyond counts as not stated"),
    Row("row", "", "on the state of a tick", shape=(STATES,)),
    Row("change", "", "its first difference over ticks", shape=(STATES,)),
    Row("bend", "", "its second difference over ticks", shape=(STATES,)),
)

STEP_LIMITS = structure(
    "StepLimits",
    "Largest steps of MRU, depth sensor and encoder that are not jumps.",
    Row("mru_step", "m", "of the heave beyond its rate"),
    Row("sigmas", "", "the same over the noise, also of a depth"),
    Row("scatter", "s", "by which a reading without a time may be late"),
    Row("longest_gap", "s", "after which heaves are not compared"),
    Row("mean_time", "s", "over which the mean of the heave is taken"),
    Row("largest_heave", "m", "that a ship reaches"),
    Row("near_mean", "", "distance of the mean from that of before, over the spread, that has come back"),
    Row("least_near", "m", "and at least"),
    Row("depth_step", "m", "of a unit between two depths"),
    Row("depth_speed", "m/s", "of a unit"),
    Row("like_scale", "", "share of the depth by which a jump may be another scale"),
    Row("shown_ticks", "", "good readings until a jump of the encoder is shown no more"),
    Row("at_once", "", "ticks from which on a reading of the encoder is judged by all travel"),
    Row("travel_ticks", "", "ticks over which that is known"),
    Row("moving_speed", "m/s", "of a drum that must show in the encoder"),
    Row("play", "m", "that a gear has"),
    Row("largest_play", "m", "that it may be found to have"),
    Row("beyond_play", "", "way of a drum that has turned round, over the play found, that proves it frozen"),
    Row("known_unseen", "", "share of an unseen way by which the drum may be elsewhere"),
    Row("release_time", "s", "for which a winch that is ordered to move may hold its drum"),
)

WATCHES = structure(
    "Watches",
    "Limits for the checks of consistency, tension, boom tip and sea.",
    Row("memory", "s", "of the mean of the normalised innovations squared"),
    Row("largest_nis", "", "what one counts at most"),
    Row("inconsistent", "", "mean above which readings are inconsistent"),
    Row("quiet", "", "mean below which a sensor is quieter than nominal"),
    Row("quiet_time", "s", "until that is reported"),
    Row("unexplained_time", "s", "until inconsistent readings are reported"),
    Row("tension_share", "", "of a new tension in its low-pass"),
    Row("tension_memory", "s", "of its mean"),
    Row("moved", "m", "of the mean payout from which on the tension is that of another place"),
    Row("coast_time", "s", "for which a lost boom tip is predicted: `modes.coast_time`"),
    Row("back_time", "s", "for which it must be there again"),
)

SEA_DESIGN = structure(
    "SeaDesign",
    "The design sea, and how the actual sea is observed.",
    Row("variance", "m^2", "of the boom tip's heave in the sea of the design"),
    Row("memory", "s", "of the variances"),
    Row("group_memory", "s", "of the variance that sees a sea grow"),
    Row("group_share", "", "of the group's height that a few waves may have"),
    Row("patience", "s", "before the sea may be lower than at first"),
    Row("step", "", "change of the height that changes the noise"),
    Row("smallest", "", "height over that of the design"),
    Row("largest", "", "height over that of the design"),
    Row("innovation_memory", "s", "of the normalised innovations of the heave rate"),
    Row("largest_nis", "", "what one counts at most"),
    Row("least_error", "m/s", "of the predicted heave rate that is small in any sea"),
    Row("least_heave", "m", "standard deviation below which no waves are counted"),
)

SENSE_DESIGN = structure(
    "SenseDesign",
    "Assumed sensors and measurements, tolerances, and what determines the mean payout's share of a command.",
    Row("mru", "", "index of the motion reference unit", COUNTER),
    Row("depth", "", "index of the depth sensor", COUNTER),
    Row("encoder", "", "index of the encoder of the drum", COUNTER),
    Row("load_cell", "", "index of the load cell", COUNTER),
    Row("excludes_jumped", "", "1: a sensor that may have another scale since a jump is a cross-check only", COUNTER),
    Row("is_first_order", "", "1: u' = K (u_0 - u) by the payout set-point; 0: speed servo", COUNTER),
    Row("levers", "", "indices of the lever arm's states, x and y; -1: not estimated", COUNTER, (2,)),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("tick_period", "s", "time of a tick"),
    Row("on_tick", "", "share of a tick by which a stamp on it may be off"),
    Row("static_tension", "N", "from which a load cell counts"),
    Row("stretch_per_payout", "", "by which a unit at rest goes further down than is paid out"),
    Row("lag", "s", "time constant of the speed servo"),
    Row("position_rate", "1/s", "K of a first-order winch"),
    Row("position_gain", "1/s", "k_p of the servo's position loop"),
    Row("first_waves", "", "after which the sea is known"),
    Row("refuted", "", "mean of the normalised innovations squared of the heave rate of another sea"),
    Row("health", "", "tolerances of the gates", HEALTH),
    Row("steps", "", "what is no jump", STEP_LIMITS),
    Row("watches", "", "of what was read", WATCHES),
    Row("sea", "", "of the design", SEA_DESIGN),
    Row("sensors", "", "by index", SENSOR, (SENSORS,)),
    Row("measured", "", "measurements by index", MEASURED, (MEASUREMENTS,)),
)

SAMENESS = structure(
    "Sameness",
    "How long readings have stayed the same.",
    Row("run", "", "of equal readings"),
    Row("longest", "", "run before"),
    Row("newest", "", "run before"),
    Row("usual", "", "share of equal readings"),
    Row("least", "", "share at first"),
    Row("step", "", "smallest change of the first number"),
    Row("top", "", "highest of it of late"),
    Row("bottom", "", "lowest of it of late"),
    Row("values", "", "of the last reading", shape=(4,)),
)

INTERVAL = structure(
    "OwnInterval",
    "Interval between readings of a sensor: the nominal one, or the observed one if that is longer.",
    Row("count", "", "of intervals so far"),
    Row("last", "s", "ring of the last ones", shape=(INTERVALS,)),
    Row("reported", "s", "from which on it is slow"),
    Row("seen", "s", "median of the last ones"),
    Row("value", "s", "now"),
)

GATE = structure(
    "SensorGate",
    "Observed state of a sensor.",
    Row("level", "", "Level"),
    Row("reason", "", "Reason"),
    Row("accepted", "", "readings so far"),
    Row("refused", "", "readings so far"),
    Row("bad_in_a_row", "", "refused readings"),
    Row("good_in_a_row", "", "accepted readings"),
    Row("good_needed", "", "of those until it is good again"),
    Row("newest_stamp", "s", "of all readings"),
    Row("newest_accepted", "s", "stamp; NaN: none"),
    Row("newest_arrival", "s", "of those accepted"),
    Row("started", "s", "first tick; NaN: none"),
    Row("silence", "s", "age of the newest accepted reading when it was last stale"),
    Row("delayed_since", "s", "it is stale, or delayed; NaN: never"),
    Row("zero", "", "its reading that counts as 0; NaN: none yet"),
    Row("reported", "", "Level at the end of the tick before"),
    Row("causes", "", "2^Reason of each for which it is lost and that was reported"),
    Row("news", "", "News"),
    Row("same", "", "all numbers of a reading", SAMENESS),
    Row("same_part", "", "those that may freeze while the others go on", SAMENESS),
    Row("interval", "", "at which it delivers", INTERVAL),
)

NOISE = structure(
    "SensorNoise",
    "Noise of a measurement: nominal, or as stated by the sensor or observed, whichever is larger.",
    Row("count", "", "readings so far"),
    Row("last", "", "three readings before, oldest first", shape=(3,)),
    Row("differences", "", "ring of the magnitudes of third differences", shape=(NOISE_READINGS,)),
    Row("seen", "", "standard deviation; NaN: not known"),
    Row("reported", "", "standard deviation"),
    Row("worse", "", "readings for which it has been larger"),
    Row("sigma", "", "now"),
    Row("factor", "", "over the nominal one, where it has just become larger; else 0"),
    Row("mean", "", "of the normalised innovations squared"),
    Row("quiet_time", "s", "for which that has been low"),
    Row("is_quiet", "", "1: that has been reported"),
    Row("refused", "", "first standard deviation that was stated and cannot be; NaN: none"),
    Row("is_refused", "", "1: that has been reported"),
    Row("news", "", "News"),
)

MRU_STEPS = structure(
    "MruSteps",
    "Checks the MRU's heave against the integral of its rate.",
    Row("time", "s", "of the last reading; NaN: none"),
    Row("heave", "m", "of it"),
    Row("heave_rate", "m/s", "of it"),
    Row("foreseen", "m", "heave"),
    Row("rate", "m/s", "by heave alone; NaN: not known"),
    Row("mean", "m", "heave"),
    Row("known", "s", "over which that is taken"),
    Row("new_mean", "m", "heave since a step"),
    Row("new_square", "m^2", "its square"),
    Row("new_time", "s", "since it"),
    Row("is_unproved", "", "1: it has come back by its mean alone"),
    Row("attitude_time", "s", "of the attitude before; NaN: none"),
    Row("roll", "rad", "then"),
    Row("pitch", "rad", "then"),
)

DEPTH_JUMPS = structure(
    "DepthJumps",
    "Jumps of a depth sensor that no unit can make.",
    Row("offset", "m", "sum of the jumps found"),
    Row("jump", "m", "the last one"),
    Row("is_like_scale", "", "1: as large as that of a sensor that gets another scale or sign"),
    Row("is_unproved", "", "1: the last reading goes on from such a jump"),
    Row("has_jumped", "", "1: in the last reading"),
    Row("time", "s", "of the last reading; NaN: none"),
    Row("depth", "m", "of it, jumps taken off"),
)

ENCODER = structure(
    "EncoderGate",
    "Drum encoder compared with the commanded travel.",
    Row("scale", "", "reading over payout, the offset apart"),
    Row("offset", "m", "sum of the jumps found"),
    Row("jump", "m", "the last one"),
    Row("jumped_at", "s", "time of it"),
    Row("as_read", "m", "payout as it is read, jumps taken off, whatever the scale"),
    Row("last_payout", "m", "payout then; NaN: none"),
    Row("play", "m", "that its gear seems to have"),
    Row("time", "s", "of the last reading; NaN: none"),
    Row("value", "m", "of it, by the scale"),
    Row("speed", "m/s", "of the last two"),
    Row("still", "", "ticks for which it has not counted while the drum should turn"),
    Row("unseen", "m", "way of the drum meanwhile"),
    Row("path", "m", "magnitude of that"),
    Row("is_frozen", "", "1: it is"),
    Row("turned", "m", "the last step"),
    Row("held", "s", "for which the winch has held the drum although it is ordered to move"),
    Row("count", "", "ticks so far"),
    Row("times", "s", "ring of ticks", shape=(TRAVELS,)),
    Row("totals", "m", "ring of the way that the drum should have turned until then", shape=(TRAVELS,)),
)

SEA_STATE = structure(
    "SeaSeen",
    "The observed sea.",
    Row("seen", "s", "time so far"),
    Row("since_judged", "s", "time"),
    Row("variance", "m^2", "of the boom tip's heave"),
    Row("rate_variance", "m^2/s^2", "of its rate"),
    Row("fourth_moment", "m^4", "of its heave"),
    Row("group_variance", "m^2", "of the last waves"),
    Row("applied", "", "height over that of the design, in the noise"),
    Row("mean_nis", "", "of the heave rate"),
)

TENSION_MEAN = structure(
    "MeanTension",
    "Mean tension while unit and mean payout stay where they are.",
    Row("count", "", "ticks of it"),
    Row("value", "N", "mean; NaN: none"),
    Row("variance", "N^2", "about it"),
    Row("place", "m", "mean payout; NaN: none yet"),
    Row("stands", "", "1: the unit stands"),
    Row("filtered", "N", "low-passed tension; NaN: none yet"),
)

SENSE_STATE = structure(
    "SenseState",
    "State of the sensing half of a tick, apart from the filter.",
    Row("excluded", "", "index of the sensor in use that is a cross-check only; -1: none", COUNTER),
    Row("shares", "", "of the mean payout that are kept", COUNTER),
    Row("newest_share", "", "place of the newest", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("share_ticks", "", "ring of ticks", shape=(SHARES,)),
    Row("share_states", "", "ring of the states that the mean payout alone brought about", shape=(SHARES, STATES)),
    Row("first_heave", "m", "of the unit when its depth was first read"),
    Row("tension", "N", "newest accepted; NaN: none yet"),
    Row("mru_rate", "m/s", "newest accepted; NaN: not measured"),
    Row("unit_heave", "m", "newest, by the depth sensor"),
    Row("disagree_time", "s", "for which readings have been inconsistent"),
    Row("is_unexplained", "", "1: that has been reported"),
    Row("tip_lost", "s", "time for which the boom tip has been lost"),
    Row("tip_back", "s", "time for which it has been there again"),
    Row("knows_tip", "", "1: it is measured, or can be predicted still"),
    Row("gates", "", "by sensor", GATE, (SENSORS,)),
    Row("noises", "", "by measurement", NOISE, (MEASUREMENTS,)),
    Row("mru", "", "its steps", MRU_STEPS),
    Row("jumps", "", "of the depth sensor", DEPTH_JUMPS),
    Row("encoder", "", "of the drum", ENCODER),
    Row("mean_tension", "", "and what is low-passed", TENSION_MEAN),
    Row("sea", "", "that is seen", SEA_STATE),
)

DELIVERED = structure(
    "Delivered",
    "A reading as delivered; a scalar one uses the first three fields.",
    Row("sensor", "", "index"),
    Row("time", "s", "stamp"),
    Row("value", "", "in its unit; heave"),
    Row("rate", "m/s", "heave rate; NaN: not measured"),
    Row("roll", "rad", "of the vessel"),
    Row("pitch", "rad", "of the vessel"),
    Row("status", "", "that the unit reports of itself"),
    Row("sequence", "", "number of the sample, as the unit counts"),
    Row("acceleration", "m/s^2", "heave acceleration; NaN: not measured"),
    Row("sigma", "", "of the heave as the unit states it; NaN: it does not"),
    Row("rate_sigma", "", "of the rate likewise"),
)

OBSERVED = structure(
    "Observed",
    "A gated reading, as sent to the adviser and used by the filter.",
    Row("delivered", "", "tick at which it was delivered"),
    Row("tick", "", "to which it belongs"),
    Row("row", "", "index of the measurement"),
    Row("value", "", "as read about its zero, in the sign of the model"),
    Row("share", "", "of it that the mean payout brings about"),
    Row("offset", "", "how much later than its tick it was measured, in ticks"),
    Row("sigma", "", "standard deviation of its noise; NaN: that of the filter"),
    Row("is_used", "", "1: the estimator takes it"),
    Row("nis", "", "normalised innovation squared; NaN: not compared"),
    Row("lever_x", "", "weight of the lever arm's x"),
    Row("lever_y", "", "weight of its y"),
    Row("gated", "", "value by the encoder's assumed scale"),
)

TICK = structure(
    "Tick",
    "State of the loop at a tick.",
    Row("number", "", "of the tick"),
    Row("compensating", "", "share of the active command that compensates, in the terms of the model"),
    Row("mean", "", "share of it that moves the mean payout"),
    Row("mean_command", "", "share of the next command that moves the mean payout"),
    Row("left_over", "m", "payout from before a stop, on its way to the mean"),
    Row("encoder_payout", "m", "encoder reading, jumps taken off; NaN: none came"),
    Row("mru_rate", "m/s", "newest heave rate of the motion reference unit; NaN: it measures none"),
    Row("tension", "N", "newest at the top; NaN: none yet"),
    Row("filtered_tension", "N", "the same low-passed"),
    Row("tension_mean", "N", "over the waves since unit and mean payout are where they are; NaN: none"),
    Row("tension_sigma", "N", "standard deviation about it"),
    Row("tension_time", "s", "for which the situation has been the same"),
    Row("depth_heave", "m", "newest depth as heave about the mean payout's share; NaN: none came"),
    Row("depth_noise", "m", "standard deviation of the depth sensor's noise"),
    Row("depth_innovation", "", "its innovation over the standard deviation of that; NaN: none"),
    Row("has_depth", "", "1: there is a depth sensor, and it is not lost"),
    Row("sees_landing", "", "1: and it does not contradict all others"),
    Row("has_encoder", "", "1: a reading of the encoder has been accepted since the start"),
    Row("knows_sea", "", "1: some waves have been seen"),
    Row("is_sea_refuted", "", "1: the sea of the design predicts badly what the motion reference unit reads"),
    Row("disagree_time", "s", "for which readings have been inconsistent"),
    Row("knows_tip", "", "1: the boom tip is measured; what is known of it otherwise is not to be acted upon"),
    Row("missing_push", "m", "by how much more the linear model would push the unit down than a slack cable does"),
    Row("counted", "m", "payout as the encoder counts it, used or not; NaN: none came"),
    Row("count_tick", "", "to which that belongs"),
    Row("count_offset", "", "how much later it was measured, in ticks"),
    Row("lost_sensors", "", "bits of those that are lost, by index"),
    Row("news", "", "News"),
    Row("depth_count", "", "depths accepted"),
    Row("observed_count", "", "readings observed"),
    Row("motions", "", "of boom tip, drum and units", MOTIONS),
)

SECOND = structure(
    "Second",
    "A second filter in parallel with the active one, with another model of the same readings.",
    Row("goes_by_count", "", "1: by the count of the drum, and readings as corrected; 0: by readings as read", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("levers", "", "indices of its lever arm's states, x and y; -1: not estimated", COUNTER, (2,)),
    Row("which", "", "index of each measurement in it; -1: none", COUNTER, (MEASUREMENTS,)),
    Row("sigma", "", "standard deviation of the noise of each in it", shape=(MEASUREMENTS,)),
    Row("is_compared", "", "1: says who is right", COUNTER, (MEASUREMENTS,)),
    Row("active", "", "sum of the squared innovations of the active filter over the noise", shape=(MEASUREMENTS,)),
    Row("second", "", "the same of this one", shape=(MEASUREMENTS,)),
    Row("count", "", "readings in these sums", shape=(MEASUREMENTS,)),
)
