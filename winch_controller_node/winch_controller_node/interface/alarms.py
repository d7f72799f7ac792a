"""Every alarm of the controller: code, severity, words. Raised elsewhere by code, `ALARMS.alarm(code, **values)`.

The page of alarms is made of this table. A code, once released, keeps its meaning.
"""

from __future__ import annotations

from heave_node.interface.alarm import AlarmRow, AlarmTable, Severity, alarm_table
from heave_node.interface.codes import COMPENSATION_LOST, MODE_CHANGED

from winch_controller_node.interface.sensor_alarms import IDENTIFIED, READINGS, SENSORS

EVENT, LOW, MEDIUM, HIGH, CRITICAL = Severity

LOAD = (
    AlarmRow(
        "CABLE_SLACK",
        MEDIUM,
        "cable",
        "tension {tension:.1f} kN, {percent:.0f} % of static",
        "A snap load may follow",
        "If the unit is being lowered, lower more slowly; if it hangs, compensate or wait for a lower sea",
    ),
    AlarmRow(
        "TENSION_HIGH",
        HIGH,
        "cable",
        "tension {tension:.1f} kN, {ratio:.2f} times static, limit {limit:g}",
        "Cable and winch carry more than planned",
        "Check that the unit is free; compensate a unit that swings; wait for a lower sea, or raise "
        "alarms.tension_ratio where cable and winch bear more",
    ),
    AlarmRow(
        "ROPE_SAFETY_LOW",
        HIGH,
        "rope",
        "tension {tension:.1f} kN leaves a safety factor of {factor:.2f}, {required:.2f} required (breaking force "
        "{capacity:.0f} kN)",
        "The margin of the lift is used up",
        "Compensate, or wait for a lower sea; check that the unit is free",
    ),
    AlarmRow(
        "ROPE_OVERLOADED",
        CRITICAL,
        "rope",
        "tension {tension:.1f} kN, breaking force {capacity:.0f} kN (safety factor {factor:.2f})",
        "The rope may part",
        "Keep everybody clear. If the unit is held fast, pay out; if it hangs free, do not haul in. End the lift, "
        "inspect the rope",
    ),
    AlarmRow(
        "WINCH_SATURATED",
        LOW,
        "winch",
        "at its limits for {percent:.0f} % of the last {time:g} s",
        "The unit moves more than it would with a stronger winch",
        "Reduce the factor of compensation (`heave operate factor 0.8`), or wait for a lower sea",
    ),
    AlarmRow(
        "TENSION_TRAVEL_HALF",
        MEDIUM,
        "cable",
        "constant tension has travelled {travel:g} m, half of tension.travel",
        "Constant tension continues up to tension.travel; there the winch holds its position",
        "Check whether the load yields or hangs free; request stopped if it does",
    ),
    AlarmRow(
        "TENSION_TRAVEL_END",
        HIGH,
        "cable",
        "constant tension has travelled {travel:g} m, the limit tension.travel",
        "The winch holds its position: the load has yielded or is lost",
        "Check the load, then request a mode",
    ),
    AlarmRow(
        "TENSION_LIMIT_LOW",
        MEDIUM,
        "cable",
        "compensation needs {needed:.2f} times the static tension in this sea, and more in a higher one; the limit is "
        "{limit:.4g} times",
        "Compensation that is active continues and does not keep the limit; otherwise it does not begin",
        "Wait for a lower sea, or raise limits.maximum_tension_ratio where cable and winch bear more",
    ),
    AlarmRow(
        "LOWERING_BLIND",
        HIGH,
        "depth",
        "lowering without depth readings",
        "Touchdown is recognised by the load cell alone, and without it not at all: {now}",
        "Lower slowly, or stop",
    ),
)

RESTS = "The winch comes to rest; compensation does not resume automatically"

COMMANDS = (
    AlarmRow(
        "COMMANDS_LATE",
        MEDIUM,
        "winch",
        "commands take effect {delay:.2f} s later than modelled",
        "Compensation continues while the delay is identified, and ends if the delay is too long",
        "Check the drive, the network and the load of the machine",
    ),
    AlarmRow(
        "COMMANDS_OFTEN_LATE",
        MEDIUM,
        "winch",
        "{percent:.0f} % of the commands of the last {window:g} s took effect late, by up to {largest:.2f} s",
        "Compensation is less exact",
        "Check the network and the load of the machine",
    ),
    AlarmRow(
        "COMMANDS_TOO_LATE",
        HIGH,
        "winch",
        "commands take effect {delay:.2f} s later than modelled, limit {limit:.2f} s",
        "The loop would be unstable: no compensation until commands are in time again",
        "Check the drive, the network and the load of the machine",
    ),
    AlarmRow(
        "TICKS_LEFT_OUT",
        MEDIUM,
        "loop",
        "{count} ticks were left out: this node was {time:.2f} s behind",
        "The winch kept its last order meanwhile; the estimate is predicted, and compensation goes on",
        "Check the load of the machine that runs winch_controller",
    ),
    AlarmRow(
        "COMMANDS_CUT",
        HIGH,
        "winch",
        "no command reached the winch for {time:g} s",
        "The winch stops by its own watchdog; compensation resumes automatically once commands arrive, unless "
        "COMMAND_TIMEOUTS follows",
        "Check the link to the winch",
    ),
    AlarmRow(
        "COMMANDS_RESTORED",
        EVENT,
        "winch",
        "commands reach the winch again after a command timeout",
        "Compensation resumes automatically",
    ),
    AlarmRow(
        "COMMAND_TIMEOUTS",
        HIGH,
        "winch",
        "more than {count} command timeouts of the winch within {period:g} s",
        "The winch stays stopped; compensation does not resume automatically",
        "Check the network and the load of the machine, then request compensation",
    ),
    AlarmRow(
        "WINCH_OR_ENCODER_REVERSED",
        HIGH,
        "winch",
        "the encoder turns opposite to the commands, and which of the two is reversed is not known",
        RESTS,
        "Check the sign of encoder and drive, then request compensation",
    ),
    AlarmRow(
        "WINCH_OR_ENCODER_SCALE",
        HIGH,
        "winch",
        "the encoder reads far more or less than commanded, and which of the two is wrong is not known",
        RESTS,
        "Check the scale of encoder and drive, then request compensation",
    ),
)

BRAKE = (
    AlarmRow(
        "LOAD_FALLS_BRAKED",
        CRITICAL,
        "winch",
        "the load cell has fallen by {fall:.1f} kN in {time:g} s under the brake, as where {way:.2f} m are paid out",
        "The load falls, or has touched something. Compensation does not begin until a mode is requested",
        "Keep everybody clear of load and wire. Look at the drum; have a second brake applied",
    ),
    AlarmRow(
        "DRUM_HELD_BY_DRIVE",
        HIGH,
        "winch",
        "the drum stands again, {moved:+.2f} m from where its brake was to hold it",
        "The drive holds the load, not the brake: it falls with the drive's power",
        "Do not press the emergency stop. Have a second brake applied, or set the load down under mode manual",
    ),
    AlarmRow(
        "DRUM_NOT_HELD",
        CRITICAL,
        "winch",
        "the drum runs at {rate:+.2f} m/s under its brake, {moved:+.2f} m so far: {cause}",
        "Nothing holds the load",
        "Keep everybody clear of load and wire; have a second brake applied. A drive that has power holds the drum "
        "under mode manual: clear its fault and request that",
    ),
)

PROOFS = (
    AlarmRow(
        "MRU_REVERSED",
        HIGH,
        "mru",
        "the {witness} moves {scale:.2f} times as the MRU makes the load move (correlation {correlation:.2f}, "
        "{certainty:.0f} standard errors): one of them is reversed",
        "Compensation does not begin: it would double the motion",
        "Check the sign of heave in the MRU's map and its mounting, then sign and scale of the {witness}; it is proved "
        "again all the time",
    ),
    AlarmRow(
        "MRU_SCALE_UNPROVED",
        HIGH,
        "mru",
        "the {witness} moves {scale:.2f} times as the MRU makes the load move (correlation {correlation:.2f}, "
        "{certainty:.0f} standard errors), proved is 0.6 to 1.4",
        "Compensation does not begin",
        "Check scale and unit of heave in the MRU's map and those of the {witness}, then system.unit.mass, "
        "system.cable.axial_stiffness and system.length. To begin all the same: "
        "`heave operate mode compensating --unproved`",
    ),
    AlarmRow(
        "MRU_UNPROVED",
        HIGH,
        "mru",
        "nothing has proved the MRU: {why}",
        "Compensation does not begin",
        "Fit a load cell or a depth sensor, or wait for a higher sea. To begin all the same, with somebody at the "
        "stop: `heave operate mode compensating --unproved`, or entry.accept_unproved in the scenario",
    ),
    AlarmRow(
        "COUNT_SPEED_DISAGREE",
        MEDIUM,
        "winch",
        "the count is off by {error:+.2f} m from the speed that the drive states, over a way of {way:.2f} m in "
        "{time:g} s",
        "One of them is false; compensation goes by the count, within the envelope",
        "Check registers, units and scales of position and speed in the winch's map (`state: position`, `speed`)",
    ),
)

TRIED_AGAIN = "Compensation fades out; it is tried again automatically, first after guard.hold_time"
CHECK_MODEL = (
    "If the next attempt fails too, request standby; check mass of the unit, length of the cable, lag of the winch, "
    "signs of MRU and encoder"
)

HARM = (
    AlarmRow(
        "UNIT_HEAVE_HIGH",
        HIGH,
        "loop",
        "the depth sensor reads {heave:.3f} m rms of heave, more than without compensation",
        TRIED_AGAIN,
        "Check depth sensor and MRU if the unit does not move that much; if it does, and the next attempt fails too, "
        "request standby",
    ),
    AlarmRow(
        "UNIT_SWING_HIGH",
        HIGH,
        "loop",
        "the unit swings by {swing:.3f} m rms, more than without compensation",
        TRIED_AGAIN,
        CHECK_MODEL,
    ),
    AlarmRow(
        "DRUM_SPEED_OFF",
        HIGH,
        "loop",
        "the drum is {error:.3f} m/s rms off its intended speed, more than the speed of the boom tip",
        TRIED_AGAIN,
        "If the next attempt fails too, request standby, and check the drive (pressure, speed control, brake) and its "
        "parameters",
    ),
    AlarmRow(
        "WORSE_THAN_OFF",
        HIGH,
        "loop",
        "the unit heaves {sigma:.3f} m rms; without compensation it would heave {free:.3f} m",
        TRIED_AGAIN,
        CHECK_MODEL,
    ),
    AlarmRow(
        "LITTLE_GAIN",
        MEDIUM,
        "loop",
        "the unit heaves {sigma:.3f} m rms; without compensation it would heave {free:.3f} m: less than "
        "{percent:.0f} % is removed",
        TRIED_AGAIN,
        CHECK_MODEL,
    ),
)

MODES = (
    AlarmRow(
        "DEPTH_MRU_DISAGREE",
        HIGH,
        "sensors",
        "depth sensor and MRU disagree by {error:.3f} m, and which of them is wrong is not known",
        "No compensation; it is tried again automatically, guard.hold_time after they agree",
        "Check sign and scale of both",
    ),
    AlarmRow(
        "PAYOUT_DEPTH_DISAGREE",
        MEDIUM,
        "sensors",
        "the depth sensor reads {depth:.1f} m, and {out:.1f} m of cable put the unit at {expected:.1f} m",
        "Compensation is not affected; the height above the bottom by payout is false, or that by the depth sensor",
        "Do not lower by either. Check the zero of the payout meter (length at payout 0) and of the depth sensor, "
        "boom_tip_height, water density, current",
    ),
    AlarmRow(
        "DEPTH_MRU_EXPLAINED",
        EVENT,
        "sensors",
        "depth sensor and MRU disagreed because of an error in {part}, which is corrected",
        "Compensation resumes automatically",
    ),
    AlarmRow(MODE_CHANGED, EVENT, "mode", "{mode}: {reason}"),
    AlarmRow(
        COMPENSATION_LOST,
        HIGH,
        "mode",
        "mode {mode}: {reason}",
        "The winch stops following the sea: a suspended unit moves with the ship, a landed one may be lifted",
        "Remove the cause. Request compensation where this line neither says that it resumes automatically nor names a "
        "next attempt",
    ),
    AlarmRow(
        "AUTHORITY_LIMITED_BY_SEA",
        LOW,
        "sea",
        "authority limited to {percent:.0f} %: the boom tip moves otherwise than in the assumed sea",
        "{rest:.0f} % of the motion stays until the sea is identified, or fits again",
        "Wait two minutes; check the MRU if it lasts",
    ),
    AlarmRow(
        "AUTHORITY_LIMITED_BY_WINCH",
        MEDIUM,
        "winch",
        "authority limited to {percent:.0f} %: the winch does not follow its commands as modelled",
        "{rest:.0f} % of the motion stays until the winch is identified, or follows again",
        "Wait two minutes; if it lasts, check the drive (pressure, limits of speed and torque, brake)",
    ),
    AlarmRow("AUTHORITY_RESTORED", EVENT, "loop", "authority is {percent:.0f} % again"),
    AlarmRow(
        "SEA_ABOVE_WINCH",
        LOW,
        "sea",
        "peaks of the boom tip need {percent:.0f} % of the winch's limits, limit {limit:.0f} %",
        "Compensation begins with an authority of {authority:.0f} %{rest}",
        "Wait for a lower sea if the unit must move less",
    ),
    AlarmRow(
        "UNIT_NOT_SUSPENDED",
        HIGH,
        "unit",
        "the cable carries {percent:.0f} % of the unit's weight on average: it is slack, or the unit stands, on the "
        "bottom or on deck",
        "Compensation does not begin",
        "Haul in until the cable carries the unit, then request compensation; to stand rigging up, constant_tension. "
        "If it hangs, check load cell and mass of the unit",
    ),
    AlarmRow("TOUCHDOWN", EVENT, "unit", "the unit has landed", "Constant tension is held"),
    AlarmRow(
        "UNIT_SUSPENDED",
        EVENT,
        "unit",
        "the unit is suspended again",
        "The winch compensates, and raises the unit by tension.lift_height",
    ),
    AlarmRow("PREVIEW_USED", EVENT, "preview", "the preview of the sea is used"),
    AlarmRow(
        "PREVIEW_REJECTED",
        LOW,
        "preview",
        "the preview of the sea is not used: {fault}",
        "Compensation continues without it",
        "Check its source",
    ),
    AlarmRow(
        "MOVE_ENDED",
        LOW,
        "mode",
        "the move to a payout of {target:.1f} m ended early near {payout:.1f} m{cause}",
        "The winch does not continue the move",
        "Request it again once the winch compensates",
    ),
    AlarmRow(
        "MOVE_LOST",
        HIGH,
        "mode",
        "the move to a payout of {target:.1f} m was ended near {payout:.1f} m by a fault{cause}",
        "The unit hangs on the way, and moves with the ship",
        "Remove the cause, then request compensation and the move again",
    ),
    AlarmRow(
        "LOAD_SWINGS",
        HIGH,
        "unit",
        "the stop has left the load in a swing of {swing:.2f} m, period {period:.1f} s, about its motion under a "
        "locked drum, {locked:.2f} m now",
        "Under the brake it takes some {half:.0f} min to halve",
        "Keep clear of the load. {remedy}",
    ),
    AlarmRow(
        "PROGRAMME_WAITS",
        EVENT,
        "mode",
        "step at {time:g} s: the move to a payout of {payout:.1f} m waits until the winch compensates{before} (mode "
        "{mode})",
    ),
    AlarmRow(
        "PROGRAMME_REJECTED",
        MEDIUM,
        "mode",
        "step at {time:g} s: {cause}",
        "The step is dropped",
        "Request it again once its condition holds",
    ),
    AlarmRow(
        "OPERATOR_SPEED_LIMITED",
        LOW,
        "mode",
        "{requested:.2f} m/s requested, limit {limit:.2f} m/s (operator.speed_share of the winch's speed limit)",
        "The winch moves at the limit",
        "Ask for less, or raise operator.speed_share",
    ),
)

CRANE = (
    AlarmRow(
        "CRANE_POSE_USED",
        EVENT,
        "crane",
        "the pose of the crane is used",
        "Compensation follows the boom tip where the crane has it",
    ),
    AlarmRow(
        "CRANE_POSE_STALE",
        HIGH,
        "crane",
        "no usable pose for {age:.1f} s, limit {limit:g} s",
        "Compensation continues with the last pose: any motion of the crane since then moves the unit",
        "Stop the crane; check encoders, network and clock",
    ),
    AlarmRow(
        "CRANE_POSE_INVALID",
        MEDIUM,
        "crane",
        "a pose is rejected: {reason}",
        "The last usable pose is extrapolated by its rates, and held once it is stale",
        "Stop the crane if it lasts; check encoders and clock",
    ),
    AlarmRow(
        "CRANE_POSE_JUMP",
        HIGH,
        "crane",
        "{joint} has jumped by {jump:.3f} {unit}, more than the crane can move",
        "The last pose is held; a pose that continues without a further jump is used after 5 s, approached over 10 s",
        "Stop the crane; check the encoder",
    ),
    AlarmRow(
        "CRANE_RATES_DISAGREE",
        HIGH,
        "crane",
        "{joint} is off by {error:.3f} {unit} from what its stated rate makes: it is frozen, or the rate is wrong",
        "Rates are taken from the poses; a frozen pose is where the crane was: its motion since then moves the unit",
        "Stop the crane; check the encoder, and sign, unit and scale of the rate",
    ),
    AlarmRow("CRANE_POSE_RESTORED", EVENT, "crane", "usable poses of the crane come again"),
    AlarmRow(
        "CRANE_TOO_FAST",
        HIGH,
        "crane",
        "the crane moves the boom tip up or down by {rate:.2f} m/s, limit of the winch for it {limit:.2f} m/s",
        "The unit moves with the boom by the difference, and returns once the winch has caught up; compensation "
        "continues",
        "Slow the crane down",
    ),
    AlarmRow(
        "CRANE_BEYOND_RANGE",
        HIGH,
        "crane",
        "the crane's motion takes the payout to {payout:.1f} m, limit for compensation {limit:.1f} m",
        "From there the unit moves with the boom; compensation continues",
        "Move the boom back, or {raise_or_lower} the unit until the range suffices",
    ),
    AlarmRow(
        "CRANE_LENGTHS_MISSING",
        HIGH,
        "crane",
        "a pose of the crane is received, but crane.boom_length is 0",
        "It is not used: the boom tip is taken to stand still on the ship",
        "State the crane's lengths and its reference pose (system.crane)",
    ),
)

LATCHED = "Brake on; latched until an operator requests a mode"
TAKEN_OVER = "The order is replaced: the boom tip's raw motion is followed and fades out, then brake; latched"
ASK_AGAIN = "then request a mode"

ENVELOPE = (
    AlarmRow(
        "ORDER_TOO_FAST",
        HIGH,
        "envelope",
        "order of {speed:+.2f} m/s about the requested move, limit {limit:.2f} m/s by the boom tip's motion",
        TAKEN_OVER,
        f"Check encoder, MRU and the identified winch, {ASK_AGAIN}",
    ),
    AlarmRow(
        "ORDER_TOO_FAR",
        HIGH,
        "envelope",
        "drum {travel:+.2f} m off the requested move, limit {limit:.2f} m by the boom tip's motion",
        TAKEN_OVER,
        f"Check encoder, MRU and the identified winch, {ASK_AGAIN}",
    ),
    AlarmRow(
        "ORDER_NOT_FINITE",
        HIGH,
        "envelope",
        "the controller's order is not a number",
        TAKEN_OVER,
        f"Keep the bag and report it, {ASK_AGAIN}",
    ),
    AlarmRow(
        "DRUM_OFF_ORDER",
        CRITICAL,
        "winch",
        "count {distance:+.2f} m off what was ordered, limit {limit:.2f} m",
        LATCHED,
        f"Drive or encoder is wrong in scale or sign, or the drum runs: check both, {ASK_AGAIN}",
    ),
    AlarmRow(
        "DRUM_RUNS_BRAKED",
        CRITICAL,
        "winch",
        "count moved by {distance:+.2f} m with the brake on, limit {limit:.2f} m",
        LATCHED,
        f"Keep everybody clear. The brake slips, or the count drifts: check both, {ASK_AGAIN}",
    ),
    AlarmRow(
        "STOP_OVERDUE",
        HIGH,
        "envelope",
        "compensation was to end: {time:.0f} s without an end, limit {limit:g} s",
        f"The winch comes to rest. {LATCHED}",
        f"Check the MRU and what the unit does, {ASK_AGAIN}",
    ),
    AlarmRow(
        "LOAD_SWUNG_HIGHER",
        HIGH,
        "envelope",
        "load cell varies by {ratio:.2f} times its limit, more than with the winch locked",
        f"Compensation fades out. {LATCHED}",
        f"Check the sign of the MRU, mass of the unit and length of the cable, {ASK_AGAIN}",
    ),
)

ALARMS: AlarmTable = alarm_table(
    *(*SENSORS, *READINGS, *IDENTIFIED, *LOAD, *COMMANDS, *BRAKE, *PROOFS, *HARM, *CRANE, *ENVELOPE, *MODES)
)
"""All of them, by code."""

HARMFUL = frozenset(row.code for row in HARM)
"""Codes by which the guard ends compensation that does harm."""
