"""The table of `look`: three simulated units, the motions that follow from an estimate, and the guard's statistics."""

from __future__ import annotations

from enum import IntFlag

from heave_core.filter_table import DRAG, STATES
from heave_core.rows import COUNTER, Row, Size, structure

KNOTS = Size("KNOTS", 2401)
"""Energies of a sea seen for the first time that are kept, over its `first_look`."""


class Harm(IntFlag):
    """What the guard's checks have found in a tick."""

    DRUM_OFF = 1
    SWING_HIGH = 2
    DEPTH_HIGH = 4
    DISAGREE = 8
    LITTLE_GAIN = 16


HANGING_CABLE = structure(
    "HangingCable",
    "A sampled cable and unit below a top end whose motion is known; the state is the first mode.",
    Row("A", "", "of the mode's heave [m] and rate [m/s] on themselves", shape=(2, 2)),
    Row("B", "", "of the outlet's heave [m] and rate [m/s] on them", shape=(2, 2)),
    Row("drag", "", "quadratic, beyond the linear damping that A has", DRAG),
    Row("tick_period", "s", "time of a tick"),
    Row("participation", "", "of the mode in a motion of the outlet"),
    Row("natural_inertia", "s^2", "a by which the unit swings"),
    Row("largest_push", "m", "stretch downwards at which the cable is slack: weight over stiffness"),
    Row("cable_share", "", "part of the mode that is cable, which a slack one takes away"),
)

HANGING_UNIT = structure(
    "HangingUnit",
    "A simulated unit.",
    Row("heave", "m", "of the mode"),
    Row("rate", "m/s", "of the mode"),
    Row("outlet", "m", "heave of the outlet at the end of the tick"),
    Row("outlet_rate", "m/s", "its rate"),
    Row("is_slack", "", "1: the cable is slack"),
)

LOOK_DESIGN = structure(
    "LookDesign",
    "Indices and rows of the motions in the loop model, and the cables.",
    Row("order", "", "states of the model", COUNTER),
    Row("unit", "", "index of the unit's heave", COUNTER),
    Row("unit_rate", "", "index of the unit's heave rate", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("tip", "", "row of the boom tip's heave", shape=(STATES,)),
    Row("tip_rate", "", "row of its heave rate", shape=(STATES,)),
    Row("payout", "", "row of the drum's payout", shape=(STATES,)),
    Row("payout_rate", "", "row of its rate", shape=(STATES,)),
    Row("through", "", "what the active command adds to the payout rate: a first-order winch without delay"),
    Row("tick_period", "s", "time of a tick"),
    Row("tip_memory", "s", "over which the power of the boom tip is averaged"),
    Row("noise_swing", "", "motion of the boom tip that may be noise, over the error of its estimate"),
    Row("taut_time", "s", "in which a unit that had a taut cable goes over to one that had not"),
    Row("cable", "", "active cable", HANGING_CABLE),
    Row("taut_cable", "", "the same, which is never slack", HANGING_CABLE),
)

LOOK_STATE = structure(
    "LookState",
    "The simulated units, and statistics of the boom tip.",
    Row("shadow", "", "unit with the winch locked", HANGING_UNIT),
    Row("taut_shadow", "", "the same, had the cable been taut for the last seconds", HANGING_UNIT),
    Row("hanging", "", "unit below the drum as it turns, whatever is read of it", HANGING_UNIT),
    Row("tip_power", "m^2", "mean square of the boom tip's heave"),
    Row("wave_share", "", "share of the estimated motion of the boom tip that is not noise"),
    Row("hanging_heave", "m", "of the hanging unit, the mean payout's own motion included"),
)

LOOK_INPUTS = structure(
    "LookInputs",
    "Inputs for the motions at a tick.",
    Row("compensating", "", "share of the active command that compensates"),
    Row("mean", "", "share of it that moves the mean payout"),
    Row("knows_tip", "", "1: the boom tip is measured"),
    Row("takes_unit", "", "1: the simulated units go on from the estimated one: the boom tip was not known until now"),
)

MOTIONS = structure(
    "Motions",
    "All motions at a tick: heaves positive up, payouts positive down.",
    Row("tip", "m", "of the boom tip"),
    Row("tip_rate", "m/s", "of the boom tip"),
    Row("payout", "m", "of the drum, without the mean payout's"),
    Row("payout_rate", "m/s", "of the drum, without the mean payout's"),
    Row("total_payout_rate", "m/s", "of the drum"),
    Row("mean_payout", "m", "of the drum, by the mean payout alone"),
    Row("mean_heave", "m", "of the unit about the mean payout that this itself brings about"),
    Row("mean_rate", "m/s", "its rate"),
    Row("unit", "m", "of the unit about where the mean payout would have it at rest: what compensation has left"),
    Row("unit_rate", "m/s", "its rate"),
    Row("free", "m", "of the unit with the winch locked"),
    Row("free_rate", "m/s", "its rate"),
    Row("taut", "m", "the same since compensation began, had the cable been taut for the last seconds"),
    Row("taut_rate", "m/s", "its rate"),
    Row("released", "m", "that the unit is let go to: of `free`, as far as waves make it"),
    Row("released_rate", "m/s", "its rate"),
    Row("offset", "m", "of the unit about `released`, payout that is out taken off; about rest without a boom tip"),
    Row("offset_rate", "m/s", "its rate"),
    Row("hanging_heave", "m", "of a unit that only hangs on its cable"),
    Row("hanging_stretch", "m", "by which that cable would be longer than at rest"),
    Row("wave_share", "", "share of the boom tip's estimated motion that is not noise"),
)

SIGMA = structure(
    "RunningSigma",
    "Exponentially weighted variance about a slow mean.",
    Row("count", "", "values so far"),
    Row("mean", "", "slow one"),
    Row("variance", "", "about it"),
)

LIMIT = structure(
    "AmplitudeLimit",
    "Limit on an amplitude.",
    Row("time", "s", "memory of the amplitude"),
    Row("ratio", "", "largest amplitude over that of the reference"),
    Row("floor", "", "amplitude that is never too large"),
)

AMPLITUDE = structure(
    "AmplitudeCheck",
    "Mean squares of a motion and of its reference.",
    Row("count", "", "ticks so far"),
    Row("square", "", "of the motion, over the time of the limit"),
    Row("now", "", "of the reference, over that time"),
    Row("waves", "", "of the reference, over the window"),
    Row("left_over", "", "amplitude allowed beside the reference"),
    Row("noise", "", "of the sensor, which is no amplitude"),
)

DETRENDED = structure(
    "DetrendedHeave",
    "Heave from a depth sensor: mean, spikes and jumps removed.",
    Row("value", "m", "heave"),
    Row("last", "m", "reading; NaN: none yet"),
    Row("ticks", "", "since it"),
)

GUARD_DESIGN = structure(
    "GuardDesign",
    "The guarded loop, and the limits beyond which it does harm.",
    Row("tick_period", "s", "time of a tick"),
    Row("window", "s", "memory of the waves: `guard.window`"),
    Row("seen_ticks", "", "ticks of waves after which an amplitude is judged"),
    Row("seen_time", "s", "time after which waves are compared"),
    Row("slow_mean", "", "the mean about which motion is judged is followed so many times more slowly"),
    Row("speed", "m/s", "largest of the winch"),
    Row("usual_speed", "m/s", "largest under the static tension"),
    Row("acceleration", "m/s^2", "largest of the winch"),
    Row("effort_speed", "", "of the law over that of the boom tip"),
    Row("effort_acceleration", "", "of the law over that of the boom tip"),
    Row("rate_error", "", "of the drum's speed over the boom tip's rate"),
    Row("inertia", "s^2", "a of the two-state cable; 0: unknown"),
    Row("fade_time", "s", "shortest time in which authority goes from 0 to 1 or back"),
    Row("feeds_back", "", "1: the law feeds the unit's motion back, so that the loop can become unstable"),
    Row("drum", "", "speed of the drum that is not intended, against that of the boom tip [m/s]", LIMIT),
    Row("swing", "", "swing of the unit against the uncompensated one [m]", LIMIT),
    Row("depth", "", "heave that the depth sensor reads against the uncompensated one [m]", LIMIT),
    Row("mismatch", "", "depth sensor less estimate, against the uncompensated heave [m]", LIMIT),
    Row("catch_up_time", "s", "for which the drum is not checked after a sensor is back"),
    Row("left_over_time", "s", "in which compensation has to take out a swing that it has found"),
    Row("largest_left_over", "", "largest swing that it may find, over the uncompensated one"),
    Row("restart", "", "rest of the last allowance at which a swing that waves have left is allowed again"),
    Row("beyond", "", "share of the largest speed that is missing in a sea beyond the winch's limits"),
    Row("out_of_reach", "", "allowed error of the drum's speed at its limits, over that of one that follows"),
    Row("swing_work", "", "speed of the drum that stops a swinging unit, over the speed of the unit"),
    Row("least_authority", "", "share of the boom tip's speed against which the drum is checked at least"),
    Row("detrend_time", "s", "in which the mean of the depth sensor is followed"),
    Row("largest_step", "m", "between two depths"),
    Row("step_sigmas", "", "the same over the noise of the sensor"),
    Row("step_speed", "m/s", "more of it with the time between the two"),
    Row("full_share", "", "share of the wanted authority from which on waves are compared"),
    Row("harm_ratio", "", "residual over uncompensated motion that is harm: `guard.harm_ratio`"),
    Row("floor", "m", "residual that is never harm: `guard.floor`"),
    Row("peak", "", "amplitude over standard deviation of a sea, over some minutes"),
    Row("significant", "", "amplitude over standard deviation of a sea"),
    Row("highest_time", "s", "memory of the highest crest"),
    Row("group_time", "s", "memory that sees a group of high waves come"),
    Row("group_peak", "", "amplitude over standard deviation within a group"),
    Row("growing", "", "energy of the later half of a growing sea over that of the earlier one"),
    Row("growing_peak", "", "amplitude over standard deviation of its last waves"),
    Row("first_look", "", "ticks for which a sea may be seen to grow"),
    Row("knot_ticks", "", "ticks between two energies that are kept"),
    Row("limit_use", "", "share of the winch's limits that peaks may use: `guard.limit_use`"),
    Row("largest_demand", "", "demand of the sea's share that a law is given which keeps the limits by itself"),
    Row("keeps_limits", "", "1: the law keeps the winch's limits by itself"),
    Row(
        "unshown",
        "",
        "variance left of compensated motion, over that motion's, that a unit may have which has shown nothing",
    ),
    Row("worth", "", "least residual that is worth less authority, over the motion with the winch locked"),
)

DEMAND = structure(
    "WinchDemand",
    "What the sea demands of the winch: speed and acceleration of the boom tip.",
    Row("rate", "m/s", "over the waves", SIGMA),
    Row("acceleration", "m/s^2", "over the waves", SIGMA),
    Row("group_rate", "m/s", "within the group", SIGMA),
    Row("group_acceleration", "m/s^2", "within the group", SIGMA),
    Row("highest_rate", "m/s", "highest crest of late"),
    Row("highest_acceleration", "m/s^2", "highest crest of late"),
    Row("last_rate", "m/s", "of the tick before; NaN: none yet"),
    Row("ticks", "", "seen so far"),
    Row("energy", "m^2/s^2", "sum of the squared rates, while the sea may be seen to grow"),
    Row("energies", "m^2/s^2", "that sum each `knot_ticks`", shape=(KNOTS,)),
)

GUARD_STATE = structure(
    "GuardState",
    "State of the guard.",
    Row("drum", "", "speed of the drum", AMPLITUDE),
    Row("swing", "", "swing of the unit", AMPLITUDE),
    Row("depth", "", "heave by the depth sensor", AMPLITUDE),
    Row("mismatch", "", "depth sensor less estimate", AMPLITUDE),
    Row("measured", "", "heave by the depth sensor", DETRENDED),
    Row("error", "", "depth sensor less estimate", DETRENDED),
    Row("unit", "m", "of the unit over the waves, compensated", SIGMA),
    Row("free_unit", "m", "of the unit over the waves, with the winch locked", SIGMA),
    Row("waves_time", "s", "compared so far"),
    Row("tip", "m", "heave of the boom tip over the waves", SIGMA),
    Row("authority", "", "of the tick before"),
    Row("exchanged_swing", "m^2", "swing that is taken out while authority moves; it fades after"),
    Row("reachable", "m/s", "speed of a drum that follows the intended one within its limits"),
    Row("gain_speed", "m/s", "of the drum that lets the unit gain speed with the mean payout"),
    Row("is_out_of_reach", "", "1: the sea asks for more speed than the winch can give now"),
    Row("left_over_swing", "m", "swing that compensation has found"),
    Row("is_corrected", "", "1: the swing of the next tick is not held against the loop"),
    Row("catch_up", "s", "left, for which the drum is not checked"),
    Row("allowance", "s", "left, for which waves are not compared"),
    Row("demand", "", "of the sea on the winch", DEMAND),
    Row("drum_share", "", "largest error of the drum of late, over the motion with the winch locked"),
    Row("locked", "", "heave with the winch locked, as the reference", AMPLITUDE),
    Row(
        "shown_left",
        "",
        "variance that the unit has shown of late to be left of compensated motion, over that motion's",
    ),
)

SEEN = structure(
    "Seen",
    "Motions that the guard compares at a tick, all about the mean depth.",
    Row("unit", "m", "estimated heave of the unit, compensated"),
    Row("unit_rate", "m/s", "its rate"),
    Row("free", "m", "the same with the winch locked"),
    Row("free_rate", "m/s", "its rate"),
    Row("tip", "m", "estimated heave of the boom tip"),
    Row("tip_rate", "m/s", "its rate"),
    Row("payout_rate", "m/s", "estimated speed of the drum, without that of the mean payout"),
    Row("measured", "m", "heave of the unit as the depth sensor reads it; NaN: no reading came"),
    Row("noise", "m", "standard deviation of that sensor's noise"),
    Row("mean_acceleration", "m/s^2", "of the mean payout"),
    Row("drum_error", "m", "drum less what was predicted of it a second ago"),
    Row("unknown", "", "variance that what is not known leaves of compensated motion, over that motion's"),
    Row("payout", "m", "estimated payout of the drum, without the mean one"),
    Row("authority", "", "of compensation now"),
    Row("target", "", "that it goes to"),
    Row("inhibits", "", "1: compensation is to be off already"),
)

VERDICT = structure(
    "Verdict",
    "Result of the guard at a tick.",
    Row("bits", "", "Harm"),
    Row("drum", "m/s", "amplitude of the drum's error"),
    Row("swing", "m", "amplitude of the unit's swing"),
    Row("depth", "m", "amplitude of the heave by the depth sensor"),
    Row("mismatch", "m", "amplitude of depth sensor less estimate"),
    Row("unit_sigma", "m", "standard deviation of the compensated unit over the waves"),
    Row("free_sigma", "m", "standard deviation of the uncompensated unit over the waves"),
    Row("least_gain", "", "share of the motion that was to be gained"),
    Row("waves_time", "s", "for which waves have been compared"),
    Row("tip_sigma", "m", "standard deviation of the boom tip over the waves"),
    Row("demand", "", "significant amplitude of the sea over the winch's limits"),
    Row("coming", "", "the same of a sea that is seen first and grows: it is as high as its last waves"),
    Row("authority", "", "largest for a law that keeps the winch's limits by itself"),
    Row("usual_authority", "", "largest for one that does not"),
    Row("allowed", "", "largest authority by the winch's limits"),
    Row("best_authority", "", "that leaves the least motion, by what is predicted"),
    Row("residual", "", "motion that it leaves, over that with the winch locked"),
    Row("by_drum", "", "variance that the drum's errors leave of compensated motion, over that motion's"),
    Row("measured", "", "variance that the waves show to be left of it; below 0: they are not compared"),
    Row("shown", "", "authority that unit and drum show"),
)
