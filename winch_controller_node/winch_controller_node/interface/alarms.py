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
        "When lowering, lower more slowly. When hanging, compensate, or wait for calmer seas",
    ),
    AlarmRow(
        "TENSION_HIGH",
        HIGH,
        "cable",
        "tension {tension:.1f} kN, {ratio:.2f} times static, limit {limit:g}",
        "Rope and winch carry more than planned",
        "Check for snagging. Compensate a swinging load. Wait for calmer seas; alarms.tension_ratio is the limit",
    ),
    AlarmRow(
        "ROPE_SAFETY_LOW",
        HIGH,
        "rope",
        "tension {tension:.1f} kN leaves a safety factor of {factor:.2f}, {required:.2f} required (breaking force "
        "{capacity:.0f} kN)",
        "The safety margin of the lift is used up",
        "Check for snagging. Compensate, or wait for calmer seas",
    ),
    AlarmRow(
        "ROPE_OVERLOADED",
        CRITICAL,
        "rope",
        "tension {tension:.1f} kN, breaking force {capacity:.0f} kN (safety factor {factor:.2f})",
        "The rope may part",
        "Keep everybody clear. If the load is snagged, pay out; if it hangs free, do not haul in. End the lift and "
        "inspect the rope",
    ),
    AlarmRow(
        "WINCH_SATURATED",
        LOW,
        "winch",
        "at its limits for {percent:.0f} % of the last {time:g} s",
        "The load moves more than it would with a stronger winch",
        "Reduce the gain (`heave operate factor 0.8`), or wait for calmer seas",
    ),
    AlarmRow(
        "TENSION_TRAVEL_HALF",
        MEDIUM,
        "cable",
        "rope has travelled {travel:g} m in CT mode, half of tension.travel",
        "{loop}. At tension.travel the winch will hold its position",
        "Check whether the load has moved or hangs free. If so, request stopped",
    ),
    AlarmRow(
        "TENSION_TRAVEL_END",
        HIGH,
        "cable",
        "rope has travelled {travel:g} m in CT mode, the limit tension.travel",
        "The winch holds its position",
        "The load has moved, or the rope has parted: check, then request a mode",
    ),
    AlarmRow(
        "TENSION_LIMIT_LOW",
        MEDIUM,
        "cable",
        "compensation needs {needed:.2f} times the static tension in this sea, limit {limit:.4g} times",
        "{loop}. The limit cannot be kept in this sea",
        "Wait for calmer seas. Raise limits.maximum_tension_ratio only if rope and winch are rated for it",
    ),
    AlarmRow(
        "LOWERING_BLIND",
        HIGH,
        "depth",
        "lowering without a depth sensor",
        "{now}",
        "Lower slowly, or stop",
    ),
)

RESTS = "{loop}. Compensation will not resume automatically"

COMMANDS = (
    AlarmRow(
        "COMMANDS_LATE",
        MEDIUM,
        "winch",
        "commands take effect {delay:.2f} s later than modelled",
        "{loop}. The delay is being identified",
        "Check the drive, the network and the CPU load of the computer",
    ),
    AlarmRow(
        "COMMANDS_OFTEN_LATE",
        MEDIUM,
        "winch",
        "{percent:.0f} % of the commands of the last {window:g} s took effect late, by up to {largest:.2f} s",
        "{loop}. Residual motion is larger",
        "Check the network and the CPU load of the computer",
    ),
    AlarmRow(
        "COMMANDS_TOO_LATE",
        HIGH,
        "winch",
        "commands take effect {delay:.2f} s later than modelled, limit {limit:.2f} s",
        "{loop}. It resumes automatically once commands arrive in time",
        "Check the drive, the network and the CPU load of the computer",
    ),
    AlarmRow(
        "TICKS_LEFT_OUT",
        MEDIUM,
        "loop",
        "controller missed {count} cycles ({time:.2f} s late): computer overloaded",
        "{loop}. The winch kept its last command meanwhile",
        "Check the CPU load of the computer that runs winch_controller",
    ),
    AlarmRow(
        "COMMANDS_CUT",
        HIGH,
        "winch",
        "no command reached the winch for {time:g} s",
        "{loop}. The watchdog of the winch stops it",
        "Check the link to the winch",
    ),
    AlarmRow(
        "COMMANDS_RESTORED",
        EVENT,
        "winch",
        "commands reach the winch again after a command timeout",
        "Compensation will resume automatically",
    ),
    AlarmRow(
        "COMMAND_TIMEOUTS",
        HIGH,
        "winch",
        "more than {count} command timeouts of the winch within {period:g} s",
        RESTS,
        "Check the network and the CPU load of the computer, then request compensation",
    ),
    AlarmRow(
        "WINCH_OR_ENCODER_REVERSED",
        HIGH,
        "winch",
        "encoder and commands run in opposite directions: one of them is reversed",
        RESTS,
        "Check the sign of encoder and drive, then request compensation",
    ),
    AlarmRow(
        "WINCH_OR_ENCODER_SCALE",
        HIGH,
        "winch",
        "the encoder reads far from what was commanded: one of them has a wrong scale",
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
        "Compensation does not begin until a mode is requested",
        "Keep everybody clear of load and wire. The load falls, or has landed: look at the drum, apply a second brake",
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
        "Fit a load cell or a depth sensor, or wait for a higher sea. To begin all the same: "
        "`heave operate mode compensating --unproved`, or entry.accept_unproved in the scenario",
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

TRIED_AGAIN = "{loop}. The next attempt is automatic"
CHECK_MODEL = (
    "If the next attempt fails too, request standby. Check load mass, rope length, winch lag, and the signs of MRU and "
    "encoder"
)

HARM = (
    AlarmRow(
        "UNIT_HEAVE_HIGH",
        HIGH,
        "loop",
        "the depth sensor reads {heave:.3f} m rms heave, more than with the winch locked",
        TRIED_AGAIN,
        "If the load moves less than that, check depth sensor and MRU. If the next attempt fails too, request standby",
    ),
    AlarmRow(
        "UNIT_SWING_HIGH",
        HIGH,
        "loop",
        "the load swings by {swing:.3f} m rms, more than with the winch locked",
        TRIED_AGAIN,
        CHECK_MODEL,
    ),
    AlarmRow(
        "DRUM_SPEED_OFF",
        HIGH,
        "loop",
        "drum speed is {error:.3f} m/s rms off its set-point, more than the boom tip moves",
        TRIED_AGAIN,
        "If the next attempt fails too, request standby and check the drive: pressure, speed control, brake",
    ),
    AlarmRow(
        "WORSE_THAN_OFF",
        HIGH,
        "loop",
        "the load heaves {sigma:.3f} m rms; with the winch locked it would heave {free:.3f} m",
        TRIED_AGAIN,
        CHECK_MODEL,
    ),
    AlarmRow(
        "LITTLE_GAIN",
        MEDIUM,
        "loop",
        "the load heaves {sigma:.3f} m rms; with the winch locked it would heave {free:.3f} m: less than "
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
        "depth sensor and MRU disagree by {error:.3f} m: one of them is wrong",
        "{loop}. The next attempt is automatic, guard.hold_time after they agree",
        "Check sign and scale of both",
    ),
    AlarmRow(
        "PAYOUT_DEPTH_DISAGREE",
        MEDIUM,
        "sensors",
        "the depth sensor reads {depth:.1f} m; {out:.1f} m of rope put the load at {expected:.1f} m",
        "{loop}. The height above the seabed is uncertain",
        "Do not lower by either. Check the zero of payout and depth sensor, boom_tip_height, water density and current",
    ),
    AlarmRow(
        "DEPTH_MRU_EXPLAINED",
        EVENT,
        "sensors",
        "depth sensor and MRU disagreed because of an error in {part}, now corrected",
        "Compensation will resume automatically",
    ),
    AlarmRow(MODE_CHANGED, EVENT, "mode", "{mode}: {reason}"),
    AlarmRow(
        COMPENSATION_LOST,
        HIGH,
        "mode",
        "mode {mode}: {reason}",
        "{loop}. A suspended load moves with the ship",
        "Remove the cause. If this line names no next attempt, request compensation",
    ),
    AlarmRow(
        "AUTHORITY_LIMITED_BY_SEA",
        LOW,
        "sea",
        "gain limited to {percent:.0f} %: the boom tip moves differently from the assumed sea",
        "{rest:.0f} % of the motion remains while the sea is identified",
        "Wait two minutes. If it persists, check the MRU",
    ),
    AlarmRow(
        "AUTHORITY_LIMITED_BY_WINCH",
        MEDIUM,
        "winch",
        "gain limited to {percent:.0f} %: the winch does not follow its commands as modelled",
        "{rest:.0f} % of the motion remains while the winch is identified",
        "Wait two minutes. If it persists, check the drive: pressure, speed and torque limits, brake",
    ),
    AlarmRow("AUTHORITY_RESTORED", EVENT, "loop", "gain is {percent:.0f} % again"),
    AlarmRow(
        "SEA_ABOVE_WINCH",
        LOW,
        "sea",
        "peak boom-tip motion needs {percent:.0f} % of the winch's limits, limit {limit:.0f} %",
        "Compensation begins with a gain of {authority:.0f} %{rest}",
        "If the load must move less, wait for calmer seas",
    ),
    AlarmRow(
        "UNIT_NOT_SUSPENDED",
        HIGH,
        "unit",
        "the rope carries {percent:.0f} % of the load on average: slack rope, or a load on the seabed or on deck",
        "Compensation does not begin",
        "Haul in until the rope carries the load, then request compensation. To stand rigging up, use CT mode. If the "
        "load hangs, check load cell and mass",
    ),
    AlarmRow("TOUCHDOWN", EVENT, "unit", "the load has landed", "The winch changes to constant tension"),
    AlarmRow(
        "UNIT_SUSPENDED",
        EVENT,
        "unit",
        "the load is suspended again",
        "The winch compensates and raises the load by tension.lift_height",
    ),
    AlarmRow("PREVIEW_USED", EVENT, "preview", "the wave preview is used"),
    AlarmRow(
        "PREVIEW_REJECTED",
        LOW,
        "preview",
        "the wave preview is not used: {fault}",
        "{loop}",
        "Check its source",
    ),
    AlarmRow(
        "MOVE_ENDED",
        LOW,
        "mode",
        "the move to a payout of {target:.1f} m ended early near {payout:.1f} m{cause}",
        "The move is not resumed",
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
        "The step is skipped",
        "Request it again once its condition holds",
    ),
    AlarmRow(
        "OPERATOR_SPEED_LIMITED",
        LOW,
        "mode",
        "{requested:.2f} m/s requested, limit {limit:.2f} m/s (operator.speed_share of the winch's speed limit)",
        "The winch moves at the limit",
        "Request a lower speed. operator.speed_share sets the limit",
    ),
)

CRANE = (
    AlarmRow(
        "CRANE_POSE_USED",
        EVENT,
        "crane",
        "crane pose received",
        "Compensation follows the boom tip as the crane moves",
    ),
    AlarmRow(
        "CRANE_POSE_STALE",
        HIGH,
        "crane",
        "no usable pose for {age:.1f} s, limit {limit:g} s",
        "{loop}. The last pose is used: crane motion since then moves the load",
        "Stop the crane. Check its encoders, network and clock",
    ),
    AlarmRow(
        "CRANE_POSE_INVALID",
        MEDIUM,
        "crane",
        "a crane pose was rejected: {reason}",
        "The last valid pose is extrapolated by its rates, then held",
        "If it persists, stop the crane and check its encoders and clock",
    ),
    AlarmRow(
        "CRANE_POSE_JUMP",
        HIGH,
        "crane",
        "{joint} jumped by {jump:.3f} {unit}, more than the crane can move",
        "The last pose is held. The new one is accepted after 5 s without another jump",
        "Stop the crane and check the encoder",
    ),
    AlarmRow(
        "CRANE_RATES_DISAGREE",
        HIGH,
        "crane",
        "{joint} is {error:.3f} {unit} off the integral of its own rate",
        "Rates are derived from the poses. If the pose is frozen, crane motion moves the load",
        "Stop the crane. Check the encoder, and sign, unit and scale of the rate",
    ),
    AlarmRow("CRANE_POSE_RESTORED", EVENT, "crane", "crane poses are valid again"),
    AlarmRow(
        "CRANE_TOO_FAST",
        HIGH,
        "crane",
        "the crane moves the boom tip vertically at {rate:.2f} m/s, the winch can follow {limit:.2f} m/s",
        "{loop}. The load moves with the boom until the winch has caught up",
        "Slow the crane down",
    ),
    AlarmRow(
        "CRANE_BEYOND_RANGE",
        HIGH,
        "crane",
        "the crane's motion takes the payout to {payout:.1f} m, limit for compensation {limit:.1f} m",
        "{loop}. Beyond the limit the load moves with the boom",
        "Move the boom back, or {raise_or_lower} the load",
    ),
    AlarmRow(
        "CRANE_LENGTHS_MISSING",
        HIGH,
        "crane",
        "a crane pose is received, but crane.boom_length is 0",
        "It is not used. The boom tip is assumed fixed to the ship",
        "State lengths and reference pose of the crane (system.crane)",
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
