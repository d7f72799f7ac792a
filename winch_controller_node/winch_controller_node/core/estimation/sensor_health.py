"""How each sensor is seen, in words: the gates themselves are in C++ (`heave_core`, sensor_gate.cpp)."""

from __future__ import annotations

import math
from typing import Any

from heave_core.sense_table import Level, Reason
from heave_node.interface.alarm import Alarm, Value
from heave_node.interface.codes import MruStatus, SensorLevel

from winch_controller_node.core.estimation.sense_design import WATCHES
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import SensorState
from winch_controller_node.interface.sensors import MEASURED_WORDS
from winch_controller_node.parameters.laws import HealthParameters

CONTRADICTS = "contradicts all others"
"""State of a sensor that is excluded and has no other fault, in words."""

STALE, ABSENT = "stale", "absent"
"""Reasons for which a sensor is lost: no data any more, and none since the start."""

REJECTED_WORDS = {
    "nan": "it is not a number",
    "out of range": "it exceeds what is possible",
    "wrong stamp": "its time stamp is missing or ahead of the clock",
    "late": "it is out of order",
    "spike": "it is far from the estimate",
    "jump": "heave has jumped",
    "status settling": "the sensor reports settling",
    "status invalid": "the sensor reports invalid",
}
"""Why a reading was rejected, in the words of its alarm."""


REASONS = {
    Reason.GOOD: "",
    Reason.NOT_A_NUMBER: "nan",
    Reason.WRONG_STAMP: "wrong stamp",
    Reason.OUT_OF_ORDER: "late",
    Reason.FROZEN: "frozen",
    Reason.SPIKE: "spike",
    Reason.JUMP: "jump",
    Reason.STALE: STALE,
    Reason.DELAYED: "delayed",
    Reason.OUT_OF_RANGE: "out of range",
    Reason.STATUS + MruStatus.SETTLING: "status settling",
    Reason.STATUS + MruStatus.INVALID: "status invalid",
}
"""Reasons in words, by the number that the core has for them."""


def reason_words(reason: int) -> str:
    """Return a `reason` of the core in words."""
    return REASONS.get(reason, f"status {reason - Reason.STATUS}")


def lost_alarm(sensor: str, reason: str, *, age: float, limit: float, since: float = math.nan) -> Alarm:
    """Return the alarm of a `sensor` that is lost.

    Parameters
    ----------
    sensor : name
    reason : for which its readings are rejected
    age, limit : age of the newest accepted reading, and the largest that is allowed [s]; of a stale or delayed sensor
    since : time from which on its readings are too old when they come [s]; of a delayed sensor
    """
    if (sensor, reason) == ("encoder", "frozen"):
        return ALARMS.alarm("DRUM_OR_ENCODER: still")
    name = f"SENSOR_LOST, {sensor.upper()}"
    row = ALARMS.get(f"{name}: {reason}") or ALARMS[f"{name}: status"]
    values: dict[str, Value] = {"age": age, "limit": limit, "since": since, "status": reason}
    return row.alarm(**{one: values[one] for one in row.names})


def doubtful_alarm(sensor: str, reason: str, /, **values: Value) -> Alarm:
    """Return the alarm, with its `values`, of a `sensor` that is used although something is wrong, for a `reason`."""
    return ALARMS.alarm(f"SENSOR_DOUBTFUL, {sensor.upper()}: {reason}", **values)


LOST = int(Level.SENSOR_LOST)
"""Level of a sensor that is not to be relied on, as a number: what is asked in every tick."""


class SensorGate:
    """How a sensor is seen: a view of its gate in the core.

    Parameters
    ----------
    sensor : name
    record : its SensorGate in the core
    assumed : its Sensor there
    health : tolerances
    """

    def __init__(self, sensor: str, record: Any, assumed: Any, health: HealthParameters) -> None:
        self.sensor = sensor
        self._record, self._assumed, self._health = record, assumed, health

    @property
    def level(self) -> SensorLevel:
        """How it is seen."""
        return SensorLevel(int(self._record["level"]))

    @property
    def is_lost(self) -> bool:
        """Tell whether the sensor is not to be relied on."""
        return int(self._record["level"]) == LOST

    @property
    def reason(self) -> str:
        """Why its last readings were rejected, or it is lost; empty: they were not."""
        return reason_words(int(self._record["reason"]))

    @property
    def largest_age(self) -> float:
        """Age above which the newest accepted reading is stale [s]."""
        interval = self._record["interval"]["value"]
        return float(self._assumed["latency"] + self._health.stale_samples * interval)

    @property
    def alarm(self) -> Alarm:
        """Fault of the sensor, where its level is `suspect` or `lost`."""
        record, reason = self._record, self.reason
        if not self.is_lost:
            return doubtful_alarm(self.sensor, "one reading", reason=REJECTED_WORDS.get(reason, reason))
        if reason == STALE and math.isnan(record["newest_accepted"]):
            reason = ABSENT
        since, age = float(record["delayed_since"]), float(record["silence"])
        return lost_alarm(self.sensor, reason, age=age, limit=self.largest_age, since=since)

    @property
    def slow_alarm(self) -> Alarm:
        """That the sensor delivers more slowly than nominal."""
        rate, nominal = 1.0 / float(self._record["interval"]["seen"]), 1.0 / float(self._assumed["period"])
        return doubtful_alarm(self.sensor, "slow", rate=rate, nominal=nominal, limit=self.largest_age)

    def state(self, now: float) -> SensorState:
        """Return how the sensor is seen at `now` [s]."""
        record, newest = self._record, float(self._record["newest_accepted"])
        age = math.inf if math.isnan(newest) else now - newest
        level, accepted, refused = self.level, int(record["accepted"]), int(record["refused"])
        alarm = None if level is SensorLevel.OK else self.alarm
        return SensorState(self.sensor, level, self.reason, age, accepted, refused, alarm)


def inconsistency_words(name: str, mean: float) -> str:
    """Return why readings are not consistent yet: the measurement `name` has the largest `mean` squared innovation."""
    largest, memory = WATCHES["inconsistent"], WATCHES["memory"]
    if mean <= largest:  # what is remembered of them was restarted within the tick
        return "sensors are compared anew from this tick on"
    wait = memory * math.log((mean - 1.0) / (largest - 1.0))
    return (
        f"innovations of {MEASURED_WORDS[name]} are {math.sqrt(mean):.1f} times their expected size, limit "
        f"{math.sqrt(largest):.1f}: about {wait:.0f} s more to settle; the sensors are compared meanwhile"
    )
