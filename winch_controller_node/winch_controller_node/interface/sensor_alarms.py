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
        "{loop}",
    ),
    "encoder": Loss(HIGH, "{loop}"),
    "depth": Loss(MEDIUM, "{loop}. Touchdown will be detected later"),
    "load_cell": Loss(MEDIUM, "{loop}. Tension alarms are off and constant tension is not available"),
    "velocity": Loss(LOW, "{loop}"),
    "imu": Loss(LOW, "{loop}"),
}
"""The loss of each sensor, by name."""

SLOW_ACTIONS = {"encoder": "Set the drive to report once per cycle (all.tick_period); check the link"}
"""What to do about a sensor that is slower than nominal and has no rate of its own to enter."""

JUMPING, STATED_NOISE = ("mru", "encoder", "depth"), ("mru", "depth", "velocity", "imu")
"""Sensors whose readings are checked for jumps, and whose noise is compared with the nominal one."""


def _losses_of(sensor: str) -> list[AlarmRow]:
    """Return the alarms of a `sensor` that is lost, one for each reason."""
    prefix, (severity, consequence) = sensor.upper(), LOSSES[sensor]

    def lost(state: str, words: str, action: str, follows: str = consequence) -> AlarmRow:
        return AlarmRow(f"{prefix}_{state}", severity, sensor, words, follows, action)

    found = [
        lost("STALE", "no data for {age:.2f} s, limit {limit:.2f} s", "Check its power, cable, driver and clock"),
        lost(
            "LATE",
            "readings arrive {age:.2f} s late since t = {since:.1f} s, limit {limit:.2f} s",
            "Set the clock that stamps them. For a constant delay: latency in the device's map, or --replace "
            "NODE=external:CLOCK:SECONDS",
        ),
        lost(
            "ABSENT",
            "no data since the start",
            "If it is not fitted, remove it from sensors.use. Else check its power, cable and driver",
        ),
        lost("NOT_A_NUMBER", "readings are not numbers", "Restart the sensor and its driver"),
        lost("BAD_STAMP", "time stamps are missing, or ahead of the controller", "Set the clock of the sensor"),
        lost("OUT_OF_ORDER", "readings arrive out of sequence, or twice", "Check the driver and the network"),
    ]
    if sensor != "encoder":
        found.append(lost("FROZEN", "readings do not change", "Restart the sensor and its driver"))
        found.append(
            lost(
                "SPIKES",
                "readings are far from the estimate",
                "Check connector, cable and supply. If it continues, check sign and unit",
            )
        )
    if sensor in JUMPING:
        jumps = "heave does not match the integral of heave rate" if sensor == "mru" else "readings jump repeatedly"
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
            "{loop}",
            "Wait: an MRU needs minutes to settle after power-on, and some do after a turn. If it persists, check its "
            "position and heading input",
        ),
        AlarmRow(
            "MRU_FAULT",
            severity,
            "mru",
            "the MRU reports {status}",
            consequence,
            "Read its display, then restart it",
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
            "{loop}. Three in a row count as loss of the sensor",
            "One rejection needs no action. If it recurs, check the sensor",
        ),
        AlarmRow(
            f"{prefix}_EXCLUDED",
            HIGH if severity is HIGH else MEDIUM,
            sensor,
            "readings contradict all other sensors",
            "{loop}",
            "Check sign, scale and mounting",
        ),
        AlarmRow(f"{prefix}_RECOVERED", EVENT, sensor, "agrees with the other sensors again", "Back in use"),
        AlarmRow(
            f"{prefix}_SLOW",
            LOW,
            sensor,
            "{rate:.3g} readings per second, {nominal:.3g} expected",
            "All readings are used. It counts as lost after {limit:.2f} s without one",
            SLOW_ACTIONS.get(sensor, f"Check the link. Its normal rate is winch_controller.sensors.{sensor}.rate"),
        ),
    ]
    return found + _noise_of(sensor) if sensor in STATED_NOISE else found


def _noise_of(sensor: str) -> list[AlarmRow]:
    """Return the alarms of a `sensor` whose noise differs from the nominal one."""
    prefix, name = sensor.upper(), f"winch_controller.sensors.{sensor}.noise"
    if sensor == "mru":
        name += " and .rate_noise"
    return [
        AlarmRow(
            f"{prefix}_NOISE_HIGH",
            LOW,
            sensor,
            "noise of {measurement} is {sigma:.3g} {unit}, {factor:.1f} times the stated value",
            "The controller gives it less weight",
            f"Check the sensor. If this is its normal noise, enter it as {name}",
        ),
        AlarmRow(
            f"{prefix}_NOISE_LOW",
            EVENT,
            sensor,
            "noise of {measurement} is below the stated {sigma:.2g} {unit}: {seen} measured ({ratio:.2f} of the "
            "expected scatter)",
            "{loop}. This sensor could be given more weight",
        ),
    ]


SENSORS = tuple(row for sensor in LOSSES for row in (*_losses_of(sensor), *_others_of(sensor)))

READINGS = (
    AlarmRow(
        "ENCODER_JUMP",
        LOW,
        "encoder",
        "the reading jumped by {jump:+.3f} m",
        "{loop}. The jump is subtracted; payout set-points follow the new count",
        "If it recurs, check the encoder",
    ),
    AlarmRow(
        "DEPTH_JUMP",
        LOW,
        "depth",
        "the reading jumped by {jump:+.3f} m",
        "{loop}. The jump is subtracted",
        "If it recurs, check the sensor",
    ),
    AlarmRow(
        "DEPTH_SCALE_JUMP",
        MEDIUM,
        "depth",
        "the reading jumped by {jump:+.3f} m: scale or sign has changed",
        "{loop}. The sensor is not used until it agrees with the others. A mode request accepts it at once",
        "Check its scale and sign",
    ),
    AlarmRow(
        "DRUM_OR_ENCODER_STILL",
        HIGH,
        "drum",
        "the count does not change although the winch is commanded to turn: the drum stands, or its encoder is frozen",
        "{loop}. It resumes automatically once the count changes",
        "Look at the drum. If it stands, check brake, pressure and dead zone of the drive; else restart the encoder. "
        "Then request compensation",
    ),
    AlarmRow(
        "DRUM_OR_ENCODER_REVERSED",
        HIGH,
        "drum",
        "count and commands run in opposite directions: drum or encoder is reversed",
        "{loop}",
        "Check the sign of encoder and drive",
    ),
    AlarmRow(
        "DRUM_OR_ENCODER_SCALE",
        HIGH,
        "drum",
        "the count is far from what was commanded: drum or encoder has changed its scale",
        "{loop}",
        "Check the scale of the encoder, and the drive",
    ),
    AlarmRow(
        "ENCODER_AT_FAULT",
        HIGH,
        "encoder",
        "the drum follows its commands (cross-check: {witness}), but the count does not",
        "{loop}. The count is not used",
        "Check the encoder, its scale, sign and driver",
    ),
    AlarmRow(
        "DRIVE_AT_FAULT",
        HIGH,
        "winch",
        "the drum does not follow its commands; the count is confirmed by {witness}",
        "{loop}. Compensation will not resume automatically",
        "Check the drive: brake, pressure, sign and scale of its set-point; then request compensation",
    ),
    AlarmRow(
        "LOAD_CELL_NEGATIVE",
        MEDIUM,
        "load_cell",
        "reads {tension:.1f} kN: a rope cannot push",
        "Tension alarms are unreliable",
        "Check its sign and zero",
    ),
    AlarmRow(
        "SENSORS_DISAGREE",
        MEDIUM,
        "sensors",
        "{measurement} has been {ratio:.1f} times as far from the estimate as expected for {time:.0f} s; cause unknown",
        "{loop}. Nothing is corrected",
        "Check all sensors and the load. If the load moves more than expected, request standby",
    ),
)

CORRECTED = "{loop}. Readings are corrected"

IDENTIFIED = (
    AlarmRow("WINCH_MODEL_UPDATED", EVENT, "winch", "{changes}", "The controller uses the new values"),
    AlarmRow("SEA_MODEL_UPDATED", EVENT, "sea", "{changes}", "The controller uses the new values"),
    AlarmRow(
        "MRU_SCALE_ERROR",
        MEDIUM,
        "mru",
        "reads {value:.2f} times the motion",
        CORRECTED,
        "Check scale and sign of the MRU. A wrong drum radius looks the same",
    ),
    AlarmRow(
        "MRU_OFFSET",
        LOW,
        "mru",
        "heave has a mean of {value:+.2f} m",
        CORRECTED,
        "Check the reference point of the MRU and the trim of the ship",
    ),
    AlarmRow(
        "MRU_DELAYED",
        MEDIUM,
        "mru",
        "time stamps are {value:+.2f} s late",
        CORRECTED,
        "Check the clock and the latency of the MRU",
    ),
    AlarmRow(
        "MRU_HIGH_PASS",
        LOW,
        "mru",
        "heave is high-pass filtered at a period of {value:.0f} s ({nominal:.0f} s stated, 0 is none)",
        CORRECTED,
        "Enter it as winch_controller.sensors.mru.high_pass_period",
    ),
    AlarmRow(
        "MRU_DRIFT",
        LOW,
        "mru",
        "heave drifts, as it does in a turn",
        "{loop}. The drift is removed from the readings",
        "Wait for the end of the turn. Check the position and heading input of the MRU",
    ),
    AlarmRow(
        "DEPTH_SCALE_ERROR",
        MEDIUM,
        "depth",
        "reads {value:.2f} times the motion",
        CORRECTED,
        "Check its scale and unit",
    ),
    AlarmRow(
        "ENCODER_SCALE_ERROR",
        MEDIUM,
        "encoder",
        "reads {value:.2f} times the payout",
        CORRECTED,
        "Check scale and sign of the encoder and the drum radius",
    ),
    AlarmRow(
        "CABLE_INERTIA",
        MEDIUM,
        "cable",
        "load mass over rope stiffness is {value:.2f} times the stated value",
        "{loop}. The controller uses the identified value",
        "Check load mass, rope length and rope stiffness",
    ),
    AlarmRow(
        "CABLE_DAMPING",
        LOW,
        "cable",
        "drag of the load is {value:.2g} times the stated value",
        "{loop}. The controller uses the identified value",
        "Check the drag area of the load",
    ),
    *(
        AlarmRow(
            f"{part.upper()}_NOT_DESIGNABLE",
            MEDIUM,
            part,
            "no stable controller exists for the identified values",
            "They are not used. The present controller stays active",
            "Check the parameters of this part in the scenario",
        )
        for part in ("winch", "sea", "mru", "depth", "encoder", "cable")
    ),
    *(
        AlarmRow(
            f"{part.upper()}_NOMINAL",
            EVENT,
            part,
            "identified values match the stated ones again",
            "No correction is applied",
        )
        for part in ("mru", "depth", "encoder", "cable")
    ),
    AlarmRow(
        "ADVISER_LATE",
        LOW,
        "adviser",
        "identification result arrived more than {latency:g} s late and was ignored",
        "The controller keeps its last values ({which})",
        "Check the CPU load of the computer that runs winch_adviser",
    ),
    AlarmRow(
        "ADVISER_SILENT",
        MEDIUM,
        "adviser",
        "no identification result for {time:.1f} s",
        "The controller keeps its last values ({which})",
        "Check that winch_adviser is running, and its log",
    ),
    AlarmRow(
        "ADVISER_REJECTED",
        MEDIUM,
        "adviser",
        "identification result rejected: {fault}",
        "The controller keeps its last values ({which})",
        "Install the winch_adviser of the controller's version",
    ),
    AlarmRow(
        "ADVISER_CONTRADICTED",
        HIGH,
        "adviser",
        "its identification is wrong: {fault}",
        "The stated values are active again. Its results are ignored for {time:.0f} s",
        "Check winch_adviser, its version and the part that it names",
    ),
    AlarmRow(
        "ADVISER_EXCLUDED",
        HIGH,
        "adviser",
        "its identification was wrong {count} times: {fault}",
        "The stated values stay active. Its results are no longer used",
        "Check winch_adviser, its version and the scenario. To use it again, restart winch_controller",
    ),
    AlarmRow("ADVISER_RESTORED", EVENT, "adviser", "identification results arrive again"),
    AlarmRow(
        "ADVISER_ENDED",
        HIGH,
        "adviser",
        "stopped: {fault}",
        "The controller keeps the values identified so far",
        "Check its log, then restart winch_adviser",
    ),
    AlarmRow(
        "SOLVER_FAILED",
        LOW,
        "loop",
        "the MPC solver found no solution: {status}",
        "The previous plan is used",
        "If it recurs, reduce mpc.horizon",
    ),
)
