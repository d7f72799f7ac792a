"""Every alarm of the controller: code, severity, words. Raised elsewhere by code, `ALARMS.alarm(code, **values)`.

The page of alarms is made of this table. A code, once released, keeps its meaning.
"""

from __future__ import annotations

from typing import NamedTuple

from heave_node.interface.alarm import AlarmRow, AlarmTable, Severity, alarm_table
from heave_node.interface.codes import COMPENSATION_LOST, MODE_CHANGED

EVENT, LOW, MEDIUM, HIGH, CRITICAL = Severity


class Loss(NamedTuple):
    """What follows from the loss of a sensor: severity and consequence."""

    severity: Severity
    consequence: str


LOSSES = {
    "mru": Loss(HIGH, "Compensation fades out"),
    "encoder": Loss(HIGH, "Compensation fades out, and the winch stops"),
    "depth": Loss(MEDIUM, "Compensation continues without it; touchdown is recognised later"),
    "load_cell": Loss(MEDIUM, "No tension alarms and no constant tension"),
    "velocity": Loss(LOW, "Compensation continues without it"),
    "imu": Loss(LOW, "Compensation continues without it"),
}
"""The loss of each sensor, by name."""


def _rows_of(sensor: str) -> list[AlarmRow]:
    """Return the alarms of a `sensor`: why it is lost, and what else may be wrong with it."""
    prefix, (severity, consequence) = sensor.upper(), LOSSES[sensor]

    def lost(state: str, words: str, action: str) -> AlarmRow:
        return AlarmRow(f"{prefix}_{state}", severity, sensor, words, consequence, action)

    frozen = ("readings do not change", "Restart the sensor or its driver")
    jumps = "heave jumps away from what its heave rate says" if sensor == "mru" else "readings jump repeatedly"
    if sensor == "encoder":
        frozen = (
            "readings do not change while the winch is commanded to turn",
            "Check that the drum turns (brake, dead zone of the drive), then restart the encoder or its driver",
        )
    return [
        lost("STALE", "no data for {age:.2f} s, limit {limit:.2f} s", "Check power, cable, driver, clock"),
        lost("NOT_A_NUMBER", "readings are not numbers", "Restart the sensor or its driver"),
        lost("BAD_STAMP", "time stamps are missing or ahead of the clock of the run", "Set the clock of the sensor"),
        lost("OUT_OF_ORDER", "readings come out of order, or twice", "Check the driver and the network"),
        lost("FROZEN", *frozen),
        lost("SPIKES", "readings are far from the estimate", "Check mounting, sign and unit"),
        lost("JUMPS", jumps, "Check mounting, scale and sign, and the driver"),
        lost("SETTLING", "the sensor reports that it is settling", "Wait"),
        lost("FAULT", "the sensor reports {status}", "Read its display, then restart it"),
        AlarmRow(
            f"{prefix}_READING_REJECTED",
            LOW,
            sensor,
            "one reading rejected ({reason})",
            "Compensation continues",
            "Check the sensor if it repeats",
        ),
        AlarmRow(
            f"{prefix}_NOISE_HIGH",
            LOW,
            sensor,
            "noise of {measurement} is {sigma:.3g}, {factor:.1f} times nominal",
            "The estimate relies less on it",
            "Check the sensor, or state its noise",
        ),
        AlarmRow(
            f"{prefix}_NOISE_LOW",
            EVENT,
            sensor,
            "innovations of {measurement} are {ratio:.2f} times their assumed size (noise {sigma:.2g} assumed, {seen} "
            "seen)",
            "Compensation continues, with less benefit from this sensor than possible",
            "State its noise, or check its scale",
        ),
        AlarmRow(
            f"{prefix}_EXCLUDED",
            HIGH if severity is HIGH else MEDIUM,
            sensor,
            "readings contradict all other sensors",
            "The sensor is not used",
            "Check sign, scale and mounting",
        ),
        AlarmRow(f"{prefix}_RECOVERED", EVENT, sensor, "the sensor agrees with all others and is used again"),
    ]


SENSORS = tuple(row for sensor in LOSSES for row in _rows_of(sensor))

READINGS = (
    AlarmRow(
        "ENCODER_JUMP",
        LOW,
        "encoder",
        "the reading jumped by {jump:+.3f} m",
        "The jump is subtracted, compensation continues",
        "Check the encoder if it repeats",
    ),
    AlarmRow(
        "DEPTH_JUMP",
        LOW,
        "depth",
        "the reading jumped by {jump:+.3f} m",
        "The jump is subtracted, compensation continues",
        "Check the sensor if it repeats",
    ),
    AlarmRow(
        "DEPTH_SCALE_JUMP",
        MEDIUM,
        "depth",
        "the reading jumped by {jump:+.3f} m, as after a change of scale or sign",
        "The sensor is not used until it agrees with all others, or a mode is requested",
        "Check its scale and sign",
    ),
    AlarmRow(
        "ENCODER_REVERSED",
        HIGH,
        "encoder",
        "the encoder turns opposite to the commands",
        "The encoder is not used while the sensors are compared",
        "Check the sign of encoder and drive",
    ),
    AlarmRow(
        "ENCODER_SCALE_STEP",
        HIGH,
        "encoder",
        "the encoder reads far more or less than commanded",
        "The encoder is not used while the sensors are compared",
        "Check the scale of the encoder, and the drive",
    ),
    AlarmRow(
        "LOAD_CELL_NEGATIVE",
        MEDIUM,
        "load_cell",
        "reading {tension:.1f} kN, and no cable pushes",
        "Tension alarms cannot be relied on",
        "Check its sign and zero",
    ),
    AlarmRow(
        "SENSORS_DISAGREE",
        MEDIUM,
        "sensors",
        "cause unknown: innovations of {measurement} {ratio:.1f} times their expected size for {time:.0f} s, and no "
        "known fault explains it",
        "Compensation continues on the present assumptions",
        "Check all sensors, cable and unit; request standby if the unit moves more than expected",
    ),
)

IDENTIFIED = (
    AlarmRow("WINCH_MODEL_UPDATED", EVENT, "winch", "{changes}", "The design uses the new values"),
    AlarmRow("SEA_MODEL_UPDATED", EVENT, "sea", "{changes}", "The design uses the new values"),
    AlarmRow(
        "MRU_SCALE_ERROR",
        MEDIUM,
        "mru",
        "reads {value:.2f} times the motion",
        "Corrected",
        "Check scale and sign of the MRU, and the drum radius",
    ),
    AlarmRow(
        "MRU_OFFSET",
        LOW,
        "mru",
        "heave has a mean of {value:+.2f} m",
        "Corrected",
        "Check the reference point of the MRU, and the trim",
    ),
    AlarmRow(
        "MRU_DELAYED",
        MEDIUM,
        "mru",
        "time stamps are {value:+.2f} s late",
        "Corrected",
        "Check the clock and the latency of the MRU",
    ),
    AlarmRow(
        "MRU_HIGH_PASS",
        LOW,
        "mru",
        "heave has a high-pass of {value:.0f} s (nominal {nominal:.0f} s, 0 is none)",
        "Corrected",
        "State sensors.mru.high_pass_period",
    ),
    AlarmRow(
        "MRU_DRIFT",
        LOW,
        "mru",
        "heave drifts, as in a turn",
        "Tracked",
        "Check the aiding of the MRU; wait for the turn",
    ),
    AlarmRow(
        "DEPTH_SCALE_ERROR", MEDIUM, "depth", "reads {value:.2f} times the motion", "Corrected", "Check scale and unit"
    ),
    AlarmRow(
        "ENCODER_SCALE_ERROR",
        MEDIUM,
        "encoder",
        "reads {value:.2f} times the payout",
        "Corrected",
        "Check scale and sign of the encoder, and the drum radius",
    ),
    AlarmRow(
        "CABLE_INERTIA",
        MEDIUM,
        "cable",
        "inertia is {value:.2f} times nominal",
        "Corrected",
        "Check the mass of the unit, and length and stiffness of the cable",
    ),
    AlarmRow(
        "CABLE_DAMPING", LOW, "cable", "damping is {value:.2g} times nominal", "Corrected", "Check the drag of the unit"
    ),
    *(
        AlarmRow(
            f"{part.upper()}_NOT_DESIGNABLE",
            MEDIUM,
            part,
            "the identified values differ from nominal, and no controller can be designed for them",
            "The values are not used",
            "Check the stated parameters",
        )
        for part in ("winch", "sea", "mru", "depth", "encoder", "cable")
    ),
    *(
        AlarmRow(f"{part.upper()}_NOMINAL", EVENT, part, "confirmed nominal")
        for part in ("mru", "depth", "encoder", "cable")
    ),
    AlarmRow(
        "ADVISER_LATE",
        LOW,
        "adviser",
        "an answer came more than {latency:g} s after its observations and was rejected",
        "The controller keeps {active}",
        "Check the load of the machine that runs winch_adviser",
    ),
    AlarmRow(
        "ADVISER_SILENT",
        MEDIUM,
        "adviser",
        "no answer for {time:.1f} s",
        "The controller keeps {active}",
        "Check that winch_adviser runs",
    ),
    AlarmRow(
        "ADVISER_REJECTED",
        MEDIUM,
        "adviser",
        "an answer was rejected ({fault})",
        "The controller keeps {active}",
        "Install the winch_adviser of the controller's version",
    ),
    AlarmRow("ADVISER_RESTORED", EVENT, "adviser", "answers again"),
    AlarmRow(
        "ADVISER_ENDED",
        HIGH,
        "adviser",
        "no more answers: {fault}",
        "The controller keeps what was identified so far",
        "Restart winch_adviser",
    ),
    AlarmRow(
        "SOLVER_FAILED",
        LOW,
        "loop",
        "{status}",
        "The plan of the tick before is used",
        "Reduce mpc.horizon, or use law lqg, if it repeats",
    ),
)

LOAD = (
    AlarmRow(
        "CABLE_SLACK",
        MEDIUM,
        "cable",
        "tension {tension:.1f} kN, {percent:.0f} % of static",
        "A snap load may follow",
        "Lower more slowly, or wait for a lower sea",
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
        "Keep everybody clear, pay out to unload, end the lift; inspect the rope before the next one",
    ),
    AlarmRow(
        "WINCH_SATURATED",
        LOW,
        "winch",
        "at its limits for {percent:.0f} % of the last {time:g} s",
        "The unit moves more than it would with a stronger winch",
        "Reduce the factor, or wait for a lower sea",
    ),
    AlarmRow(
        "TENSION_TRAVEL_HALF",
        MEDIUM,
        "cable",
        "constant tension has travelled {travel:g} m, half of tension.travel",
        "",
        "Check whether the load yields or is suspended; request stopped if it is",
    ),
    AlarmRow(
        "TENSION_TRAVEL_END",
        HIGH,
        "cable",
        "constant tension has travelled {travel:g} m, the limit tension.travel",
        "The winch holds there: the load has yielded or is lost",
        "Check the load",
    ),
    AlarmRow(
        "TENSION_LIMIT_LOW",
        MEDIUM,
        "cable",
        "compensation needs {needed:.2f} times the static tension in this sea, and more in a higher one; the limit is "
        "{limit:.4g} times",
        "Compensation does not keep the limit",
        "Raise limits.maximum_tension_ratio, or wait for a lower sea",
    ),
    AlarmRow(
        "LOWERING_BLIND",
        HIGH,
        "depth",
        "lowering without depth readings",
        "Touchdown is recognised {how}",
        "Lower slowly, or stop",
    ),
)

COMMANDS = (
    AlarmRow(
        "COMMANDS_LATE",
        MEDIUM,
        "winch",
        "commands take effect {delay:.2f} s later than modelled",
        "The delay is identified; compensation ends where it is too long",
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
        "The loop would be unstable: no compensation",
        "Check the drive, the network and the load of the machine",
    ),
    AlarmRow(
        "COMMANDS_CUT",
        HIGH,
        "winch",
        "no command reached the winch for {time:g} s",
        "No compensation; the winch stops by its watchdog",
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
        "The winch waits for an operator",
        "Check the network and the load of the machine, then request compensation",
    ),
    AlarmRow(
        "WINCH_OR_ENCODER_REVERSED",
        HIGH,
        "winch",
        "the encoder turns opposite to the commands, and which of the two is reversed is not known",
        "No compensation",
        "Check the sign of encoder and drive, then request compensation",
    ),
    AlarmRow(
        "WINCH_OR_ENCODER_SCALE",
        HIGH,
        "winch",
        "the encoder reads far more or less than commanded, and which of the two is wrong is not known",
        "No compensation",
        "Check the scale of encoder and drive, then request compensation",
    ),
)

HARM = (
    AlarmRow(
        "UNIT_HEAVE_HIGH",
        HIGH,
        "loop",
        "the depth sensor reads {heave:.3f} m of heave, more than without compensation",
        "Compensation fades out",
        "If the unit does not move so, check depth sensor and MRU",
    ),
    AlarmRow(
        "UNIT_SWING_HIGH",
        HIGH,
        "loop",
        "the unit swings by {swing:.3f} m, more than without compensation",
        "Compensation fades out, and is tried again automatically",
        "Check winch, cable and sensor parameters if it repeats",
    ),
    AlarmRow(
        "DRUM_SPEED_OFF",
        HIGH,
        "loop",
        "the drum is {error:.3f} m/s off its intended speed, more than the speed of the boom tip",
        "Compensation fades out, and is tried again automatically",
        "Check the drive and its parameters if it repeats",
    ),
    AlarmRow(
        "WORSE_THAN_OFF",
        HIGH,
        "loop",
        "heave of the unit {sigma:.3f} m, {free:.3f} m without compensation (standard deviations)",
        "Compensation fades out, and is tried again automatically",
        "Check winch, cable and sensor parameters if it repeats",
    ),
    AlarmRow(
        "LITTLE_GAIN",
        MEDIUM,
        "loop",
        "heave of the unit {sigma:.3f} m, {free:.3f} m without compensation (standard deviations): less than "
        "{percent:.0f} % gained",
        "Compensation fades out, and is tried again automatically",
        "Check winch, cable and sensor parameters if it repeats",
    ),
)

MODES = (
    AlarmRow(
        "DEPTH_MRU_DISAGREE",
        HIGH,
        "sensors",
        "depth sensor and MRU disagree by {error:.3f} m, and which of them is wrong is not known",
        "No compensation until they agree",
        "Check sign and scale of both",
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
        "The unit is no longer held still",
        "Remove the cause; request compensation where it does not resume automatically",
    ),
    AlarmRow(
        "AUTHORITY_LIMITED_BY_SEA",
        LOW,
        "sea",
        "authority limited to {percent:.0f} %: the boom tip moves otherwise than in the assumed sea",
        "The rest of the motion stays until the sea is identified",
        "Wait; check the MRU if it lasts",
    ),
    AlarmRow(
        "AUTHORITY_LIMITED_BY_WINCH",
        MEDIUM,
        "winch",
        "authority limited to {percent:.0f} %: the winch does not follow its commands as modelled",
        "The rest of the motion stays until the winch is identified",
        "Wait; check the drive if it lasts",
    ),
    AlarmRow("AUTHORITY_RESTORED", EVENT, "loop", "authority is {percent:.0f} % again"),
    AlarmRow(
        "SEA_ABOVE_WINCH",
        LOW,
        "sea",
        "peaks of the boom tip need {percent:.0f} % of the winch's limits, limit {limit:.0f} %",
        "Compensation begins with an authority of {authority:.0f} %{rest}",
        "Wait for a lower sea where the unit must move less",
    ),
    AlarmRow("TOUCHDOWN", EVENT, "unit", "the unit has landed", "Constant tension is held"),
    AlarmRow("UNIT_SUSPENDED", EVENT, "unit", "the unit is suspended again", "Compensation continues"),
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
        "the move to a payout of {target:.1f} m ends near {payout:.1f} m",
        "",
        "Request it again once the winch compensates",
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
    ),
)

ALARMS: AlarmTable = alarm_table(*SENSORS, *READINGS, *IDENTIFIED, *LOAD, *COMMANDS, *HARM, *MODES)
"""All of them, by code."""

HARMFUL = frozenset(row.code for row in HARM)
"""Codes by which the guard ends compensation that does harm."""
