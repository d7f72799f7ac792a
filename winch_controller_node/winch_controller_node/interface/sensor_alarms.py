"""Alarms of sensors and of what is identified: part of the controller's table of alarms."""

from __future__ import annotations

from typing import NamedTuple

from heave_node.interface.alarm import AlarmRow, Severity

EVENT, LOW, MEDIUM, HIGH = Severity.EVENT, Severity.LOW, Severity.MEDIUM, Severity.HIGH


class Loss(NamedTuple):
    """What follows from the loss of a sensor: severity and consequence."""

    severity: Severity
    consequence: str


LOSSES = {
    "mru": Loss(
        HIGH,
        "Compensation fades out until readings are good again. Meanwhile the depth sensor damps the unit; without one, "
        "or on a short stiff cable, the winch stops",
    ),
    "encoder": Loss(HIGH, "Compensation fades out and the winch stops, until readings are good again"),
    "depth": Loss(MEDIUM, "Compensation continues without it; touchdown is recognised later"),
    "load_cell": Loss(
        MEDIUM, "Compensation continues. Tension alarms are off; constant tension ends and cannot be requested"
    ),
    "velocity": Loss(LOW, "Compensation continues without it"),
    "imu": Loss(LOW, "Compensation continues without it"),
}
"""The loss of each sensor, by name."""

EXCLUSIONS = {
    "mru": "Compensation fades out until they agree again. Meanwhile the depth sensor damps the unit; without one, or "
    "on a short stiff cable, the winch stops",
    "encoder": "Compensation continues by the commanded payout while the sensors are compared, and ends if that takes "
    "longer than 20 s",
}
"""Consequence of a sensor that contradicts all others. Compensation continues without any that is not listed."""

SLOW_ACTIONS = {"encoder": "Set the drive to report once per tick (all.tick_period), or check the link"}
"""What to do about a sensor that is slower than nominal and has no rate of its own to enter."""

JUMPING, STATED_NOISE = ("mru", "encoder", "depth"), ("mru", "depth", "velocity", "imu")
"""Sensors whose readings are checked for jumps, and whose noise is compared with the nominal one."""


def _losses_of(sensor: str) -> list[AlarmRow]:
    """Return the alarms of a `sensor` that is lost, one for each reason."""
    prefix, (severity, consequence) = sensor.upper(), LOSSES[sensor]

    def lost(state: str, words: str, action: str, follows: str = consequence) -> AlarmRow:
        return AlarmRow(f"{prefix}_{state}", severity, sensor, words, follows, action)

    found = [
        lost("STALE", "no data for {age:.2f} s, limit {limit:.2f} s", "Check power, cable, driver, clock"),
        lost(
            "LATE",
            "readings come, but {age:.2f} s late since t = {since:.1f} s, limit {limit:.2f} s",
            "Set the clock that stamps them. A delay that stays: latency in the device's map, or --external "
            "NODE=CLOCK:SECONDS",
        ),
        lost("NOT_A_NUMBER", "readings are not numbers", "Restart the sensor or its driver"),
        lost("BAD_STAMP", "time stamps are missing or ahead of the controller's clock", "Set the clock of the sensor"),
        lost("OUT_OF_ORDER", "readings come out of order, or twice", "Check the driver and the network"),
    ]
    if sensor != "encoder":
        found.append(lost("FROZEN", "readings do not change", "Restart the sensor or its driver"))
        found.append(
            lost(
                "SPIKES",
                "readings are far from the estimate",
                "Check connector, cable and supply; if they last, sign and unit of measurement",
            )
        )
    if sensor in JUMPING:
        jumps = "heave steps away from the integral of its own rate" if sensor == "mru" else "readings jump repeatedly"
        again = ". A request for any mode accepts the present heave as the new zero" if sensor == "mru" else ""
        found.append(lost("JUMPS", jumps, f"Check mounting, scale, sign and driver{again}"))
    if sensor == "mru":
        found += _reported_by_mru(severity, consequence)
    return found


def _reported_by_mru(severity: Severity, consequence: str) -> list[AlarmRow]:
    """Return what the MRU reports of itself: no other sensor has a status."""
    return [
        AlarmRow(
            "MRU_SETTLING",
            MEDIUM,
            "mru",
            "the MRU reports that it is settling",
            "Compensation fades out, or does not begin, until it has settled; it then resumes automatically",
            "Wait: an MRU settles for minutes after power-on, and some after a turn. If it lasts, check its aiding "
            "(position, heading)",
        ),
        AlarmRow(
            "MRU_FAULT", severity, "mru", "the MRU reports {status}", consequence, "Read its display, then restart it"
        ),
    ]


def _others_of(sensor: str) -> list[AlarmRow]:
    """Return the alarms of a `sensor` that is not lost."""
    prefix, severity = sensor.upper(), LOSSES[sensor].severity
    found = [
        AlarmRow(
            f"{prefix}_READING_REJECTED",
            LOW,
            sensor,
            "one reading rejected: {reason}",
            "Compensation continues. The sensor counts as lost after three such readings in a row",
            "A single rejection needs no action; check the sensor if it repeats",
        ),
        AlarmRow(
            f"{prefix}_EXCLUDED",
            HIGH if severity is HIGH else MEDIUM,
            sensor,
            "readings contradict all other sensors",
            EXCLUSIONS.get(sensor, "Compensation continues without it"),
            "Check sign, scale and mounting",
        ),
        AlarmRow(f"{prefix}_RECOVERED", EVENT, sensor, "the sensor agrees with all others", "It is used again"),
        AlarmRow(
            f"{prefix}_SLOW",
            LOW,
            sensor,
            "{rate:.3g} readings per second, nominal {nominal:.3g}",
            "Each reading is used; the sensor is stale after {limit:.2f} s without one",
            SLOW_ACTIONS.get(sensor, f"Enter its rate (winch_controller.sensors.{sensor}.rate), or check the link"),
        ),
    ]
    return found + _noise_of(sensor) if sensor in STATED_NOISE else found


def _noise_of(sensor: str) -> list[AlarmRow]:
    """Return the alarms of a `sensor` whose noise differs from the nominal one."""
    prefix, name = sensor.upper(), f"winch_controller.sensors.{sensor}.noise"
    if sensor == "mru":
        name += ", of heave rate winch_controller.sensors.mru.rate_noise"
    return [
        AlarmRow(
            f"{prefix}_NOISE_HIGH",
            LOW,
            sensor,
            "noise of {measurement} is {sigma:.3g} {unit}, {factor:.1f} times nominal",
            "The controller gives it less weight",
            f"Check the sensor, or enter its noise ({name})",
        ),
        AlarmRow(
            f"{prefix}_NOISE_LOW",
            EVENT,
            sensor,
            "noise of {measurement} is below nominal: readings are {ratio:.2f} times as far from the estimate as "
            "expected (noise {sigma:.2g} {unit} nominal, {seen} measured)",
            "Compensation continues, with less benefit from this sensor than possible",
        ),
    ]


SENSORS = tuple(row for sensor in LOSSES for row in (*_losses_of(sensor), *_others_of(sensor)))

READINGS = (
    AlarmRow(
        "ENCODER_JUMP",
        LOW,
        "encoder",
        "the reading jumped by {jump:+.3f} m",
        "The jump is subtracted, compensation continues; a payout set-point follows the new count",
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
        "DRUM_OR_ENCODER_STILL",
        HIGH,
        "drum",
        "the count does not change while the winch is commanded to turn: the drum stands, or its encoder is frozen",
        "Compensation fades out and the winch stops. It resumes automatically once the count changes; while the drum "
        "rests, it may stay the same",
        "Look at the drum. Where it stands, check brake, pressure and dead zone of the drive; where it turns, restart "
        "the encoder or its driver. Then request compensation",
    ),
    AlarmRow(
        "DRUM_OR_ENCODER_REVERSED",
        HIGH,
        "drum",
        "the count goes opposite to the commands: the drum, or its encoder, is reversed",
        EXCLUSIONS["encoder"],
        "Check the sign of encoder and drive",
    ),
    AlarmRow(
        "DRUM_OR_ENCODER_SCALE",
        HIGH,
        "drum",
        "the count goes far more or less than commanded: the drum, or its encoder, does not do as it did",
        EXCLUSIONS["encoder"],
        "Check the scale of the encoder, and the drive",
    ),
    AlarmRow(
        "ENCODER_AT_FAULT",
        HIGH,
        "encoder",
        "the drum does what it was commanded, by {witness}; the count does not say so",
        "The count is not used. Compensation fades out where it stands; otherwise it continues by the commanded "
        "payout, and ends if that takes longer than 20 s",
        "Check the encoder, its scale, sign and driver",
    ),
    AlarmRow(
        "DRIVE_AT_FAULT",
        HIGH,
        "winch",
        "the drum does what the count says and not what it was commanded, by {witness}",
        "Compensation ends; it does not resume automatically",
        "Check the drive: brake, pressure, sign and scale of its set-point; then request compensation",
    ),
    AlarmRow(
        "LOAD_CELL_NEGATIVE",
        MEDIUM,
        "load_cell",
        "reads {tension:.1f} kN, but a cable cannot push",
        "Tension alarms cannot be relied on",
        "Check its sign and zero",
    ),
    AlarmRow(
        "SENSORS_DISAGREE",
        MEDIUM,
        "sensors",
        "readings of {measurement} have been {ratio:.1f} times as far from the estimate as expected for {time:.0f} s; "
        "cause unknown",
        "Compensation continues, and nothing is corrected",
        "Check all sensors, and what hangs on the cable; request standby if the unit moves more than expected",
    ),
)

CORRECTED = "Readings are corrected; compensation continues"

IDENTIFIED = (
    AlarmRow("WINCH_MODEL_UPDATED", EVENT, "winch", "{changes}", "The design uses the new values"),
    AlarmRow("SEA_MODEL_UPDATED", EVENT, "sea", "{changes}", "The design uses the new values"),
    AlarmRow(
        "MRU_SCALE_ERROR",
        MEDIUM,
        "mru",
        "reads {value:.2f} times the motion",
        CORRECTED,
        "Check scale and sign of the MRU, and the drum radius",
    ),
    AlarmRow(
        "MRU_OFFSET",
        LOW,
        "mru",
        "heave has a mean of {value:+.2f} m",
        CORRECTED,
        "Check the reference point of the MRU, and the trim",
    ),
    AlarmRow(
        "MRU_DELAYED",
        MEDIUM,
        "mru",
        "each time stamp is {value:+.2f} s later than its measurement",
        CORRECTED,
        "Check the clock and the latency of the MRU",
    ),
    AlarmRow(
        "MRU_HIGH_PASS",
        LOW,
        "mru",
        "heave is high-passed with a period of {value:.0f} s (nominal {nominal:.0f} s, 0 is none)",
        CORRECTED,
        "Enter it as winch_controller.sensors.mru.high_pass_period",
    ),
    AlarmRow(
        "MRU_DRIFT",
        LOW,
        "mru",
        "heave drifts, as in a turn",
        "The drift is removed from the readings; compensation continues",
        "Check the aiding of the MRU; wait for the end of the turn",
    ),
    AlarmRow(
        "DEPTH_SCALE_ERROR",
        MEDIUM,
        "depth",
        "reads {value:.2f} times the motion",
        CORRECTED,
        "Check scale and unit of measurement",
    ),
    AlarmRow(
        "ENCODER_SCALE_ERROR",
        MEDIUM,
        "encoder",
        "reads {value:.2f} times the payout",
        CORRECTED,
        "Check scale and sign of the encoder, and the drum radius",
    ),
    AlarmRow(
        "CABLE_INERTIA",
        MEDIUM,
        "cable",
        "mass of the unit over stiffness of the cable is {value:.2f} times nominal",
        "The controller uses this value; compensation continues",
        "Check the mass of the unit, and length and stiffness of the cable",
    ),
    AlarmRow(
        "CABLE_DAMPING",
        LOW,
        "cable",
        "damping of the unit by the water is {value:.2g} times nominal",
        "The controller uses this value; compensation continues",
        "Check the drag of the unit",
    ),
    *(
        AlarmRow(
            f"{part.upper()}_NOT_DESIGNABLE",
            MEDIUM,
            part,
            "identified values differ from nominal; no controller can be designed with them",
            "They are not used: the present design stays active",
            "Check the parameters of that part in the scenario",
        )
        for part in ("winch", "sea", "mru", "depth", "encoder", "cable")
    ),
    *(
        AlarmRow(
            f"{part.upper()}_NOMINAL", EVENT, part, "identified values are nominal again", "No correction is applied"
        )
        for part in ("mru", "depth", "encoder", "cable")
    ),
    AlarmRow(
        "ADVISER_LATE",
        LOW,
        "adviser",
        "an answer came more than {latency:g} s after its observations and was rejected",
        "The controller keeps its last values ({which})",
        "Check the load of the machine that runs winch_adviser",
    ),
    AlarmRow(
        "ADVISER_SILENT",
        MEDIUM,
        "adviser",
        "no answer for {time:.1f} s",
        "The controller keeps its last values ({which})",
        "Check that winch_adviser runs; see logs/winch_adviser.log",
    ),
    AlarmRow(
        "ADVISER_REJECTED",
        MEDIUM,
        "adviser",
        "an answer was rejected ({fault})",
        "The controller keeps its last values ({which})",
        "Install the winch_adviser of the controller's version",
    ),
    AlarmRow(
        "ADVISER_CONTRADICTED",
        HIGH,
        "adviser",
        "what it identified is wrong: {fault}",
        "The nominal values are active again. Its answers are not used for {time:.0f} s",
        "Check winch_adviser and its version, then the sensor or part that it names",
    ),
    AlarmRow(
        "ADVISER_EXCLUDED",
        HIGH,
        "adviser",
        "what it identified is wrong {count} times: {fault}",
        "The nominal values stay active: its answers are not used any more",
        "Check winch_adviser and its version, and the parameters of the scenario; restate the sea or restart "
        "winch_controller to use it again",
    ),
    AlarmRow("ADVISER_RESTORED", EVENT, "adviser", "answers again"),
    AlarmRow(
        "ADVISER_ENDED",
        HIGH,
        "adviser",
        "no more answers: {fault}",
        "The controller keeps the values identified until now",
        "See logs/winch_adviser.log, then restart winch_adviser",
    ),
    AlarmRow(
        "SOLVER_FAILED",
        LOW,
        "loop",
        "the solver of mpc found no new plan: {status}",
        "The plan of the tick before is used",
        "Reduce mpc.horizon, or use law lqg, if it repeats",
    ),
)
