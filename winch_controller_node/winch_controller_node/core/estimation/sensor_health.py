"""Gates in front of the estimator: which readings may be used, and how each sensor is seen.

A reading is refused for what it shows alone: not a number, a status of the sensor's own, a stamp that
cannot be, a value that does not change. What only the estimate can show (a spike) comes back from the innovations.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import MruStatus, SensorLevel
from heave_node.interface.sensors import MruReading

from winch_controller_node.core.estimation.mru_steps import MruSteps
from winch_controller_node.core.estimation.sensor_noise import OwnInterval, SensorTiming
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import SensorState
from winch_controller_node.parameters.laws import HealthParameters

CONTRADICTS = "contradicts all others"
"""State of a sensor that is excluded and has no other fault, in words."""

BAD_IN_A_ROW = 3
"""Number of refused readings in a row that make a sensor lost: alarm within 3 samples."""

FIRST_SAMENESS, SAMENESS_MEMORY = 0.01, 200.0
"""Share of readings that are like the one before, of a sensor that does not read in steps, and readings over which that
of another is found."""

HEAVE_SAMENESS = 0.5
"""The same share of heave and rate of an MRU alone, at first: they may be read in steps."""

FEWEST_OF_STEPS, LONGER = 24, 2.0
"""Equal readings of a sensor that reads in steps that are none of a crest: so many, and this factor over its longest
run."""

BY_CHANCE = 2e-4
"""Probability of a run of equal readings below which a sensor is frozen: three of one that does not read in steps."""

STALE, ABSENT = "stale", "absent"
"""Reasons for which a sensor is lost: no data any more, and none since the start."""

LOST_STATES = {
    ABSENT: "ABSENT",
    "nan": "NOT_A_NUMBER",
    "wrong stamp": "BAD_STAMP",
    "late": "OUT_OF_ORDER",
    "frozen": "FROZEN",
    "spike": "SPIKES",
    "jump": "JUMPS",
    "status settling": "SETTLING",
}
"""End of the alarm code of a lost sensor, by the reason for which its readings are rejected."""

REJECTED_WORDS = {
    "nan": "it is not a number",
    "wrong stamp": "its time stamp is missing or ahead of the clock",
    "late": "it is out of order",
    "spike": "it is far from the estimate",
    "jump": "it has jumped",
    "status settling": "the sensor reports settling",
    "status invalid": "the sensor reports invalid",
}
"""Why a reading was rejected, in the words of its alarm."""


def lost_alarm(sensor: str, reason: str, *, age: float, limit: float, since: float = math.nan) -> Alarm:
    """Return the alarm of a `sensor` that is lost.

    Parameters
    ----------
    sensor : name
    reason : for which its readings are rejected
    age, limit : age of the newest accepted reading, and the largest that is allowed [s]; of a stale or delayed sensor
    since : time from which on its readings are too old when they come [s]; of a delayed sensor
    """
    prefix = sensor.upper()
    if reason == STALE:
        return ALARMS.alarm(f"{prefix}_STALE", age=age, limit=limit)
    if reason == "delayed":
        return ALARMS.alarm(f"{prefix}_LATE", age=age, limit=limit, since=since)
    if (sensor, reason) == ("encoder", "frozen"):
        return ALARMS.alarm("DRUM_OR_ENCODER_STILL")
    if reason in LOST_STATES:
        return ALARMS.alarm(f"{prefix}_{LOST_STATES[reason]}")
    return ALARMS.alarm(f"{prefix}_FAULT", status=reason)


class Sameness:
    """Reports whether readings have been the same for longer than this sensor's usually are.

    Of one that reads in steps two in a row are often the same: a run of n comes by chance with a probability of
    p^(n - 1), p the share of readings that were like the one before. At a crest of the sea runs are longer than that:
    one must also be longer than those before.

    Parameters
    ----------
    usual : share of readings that are like the one before, at first
    """

    def __init__(self, usual: float) -> None:
        self._least = self._usual = usual
        self._run, self._last = 1, tuple[float, ...]()
        self._longest = 1.0

    def stands(self, values: tuple[float, ...], least: int) -> bool:
        """Take a reading's `values` in; tell whether the run of equal ones, of at least so many, is no chance."""
        if values != self._last:
            weight = min(1.0, self._run / SAMENESS_MEMORY)
            # one run far longer than all before was a sensor that stood, not one that reads in steps
            longest = min(float(self._run), 2.0 * self._longest)
            self._longest = max(longest, self._longest * (1.0 - weight / 10.0))
            self._usual += weight * ((self._run - 1) / self._run - self._usual)
            self._run, self._last = 1, values
            return False
        self._run += 1
        if self._longest >= 2.0:  # it reads in steps
            least = max(least, FEWEST_OF_STEPS, round(LONGER * self._longest))
        return self._run >= least and max(self._usual, self._least) ** (self._run - 1) < BY_CHANCE


class SensorGate:
    """Gate of one sensor.

    Parameters
    ----------
    sensor : name
    timing : period and latency
    parameters : counts and tolerances
    checks_frozen : equal readings mean a frozen sensor (not so for a quantised one at rest)

    Attributes
    ----------
    level, reason : how the sensor is seen now
    interval : at which it delivers
    """

    def __init__(
        self, sensor: str, timing: SensorTiming, parameters: HealthParameters, *, checks_frozen: bool = True
    ) -> None:
        self.sensor = sensor
        self.level = SensorLevel.OK
        self.reason = ""
        self._timing = timing
        self._parameters = parameters
        self._checks_frozen = checks_frozen
        self._accepted = 0
        self._refused = 0
        self._bad_in_a_row = 0
        self._good_in_a_row = 0
        self._good_needed = parameters.recover_samples
        self._sameness, self._sameness_of_part = Sameness(FIRST_SAMENESS), Sameness(HEAVE_SAMENESS)
        self._newest_stamp = -math.inf
        self._newest_accepted: float | None = None
        self._started: float | None = None
        self._silence = 0.0  # age of the newest accepted reading when it was last found stale or delayed [s]
        self._newest_arrival = -math.inf
        self._delayed_since = math.nan
        self.interval = OwnInterval(timing.period)

    @property
    def is_lost(self) -> bool:
        """Tell whether the sensor is not to be relied on."""
        return self.level is SensorLevel.LOST

    @property
    def alarm(self) -> Alarm:
        """Fault of the sensor, where its level is `suspect` or `lost`."""
        if not self.is_lost:
            reason = REJECTED_WORDS.get(self.reason, self.reason)
            return ALARMS.alarm(f"{self.sensor.upper()}_READING_REJECTED", reason=reason)
        age, limit, since = self._silence, self._largest_age, self._delayed_since
        reason = ABSENT if self.reason == STALE and self._newest_accepted is None else self.reason
        return lost_alarm(self.sensor, reason, age=age, limit=limit, since=since)

    @property
    def _largest_age(self) -> float:
        """Age above which the newest accepted reading is stale [s]."""
        return self._timing.latency + self._parameters.stale_samples * self.interval.value

    @property
    def slow_alarm(self) -> Alarm:
        """That the sensor delivers more slowly than nominal."""
        rate, nominal = 1.0 / self.interval.seen, 1.0 / self._timing.period
        return ALARMS.alarm(f"{self.sensor.upper()}_SLOW", rate=rate, nominal=nominal, limit=self._largest_age)

    def state(self, now: float) -> SensorState:
        """Return how the sensor is seen at `now` [s]."""
        age = math.inf if self._newest_accepted is None else now - self._newest_accepted
        alarm = None if self.level is SensorLevel.OK else self.alarm
        return SensorState(self.sensor, self.level, self.reason, age, self._accepted, self._refused, alarm)

    def judge(
        self, now: float, time: float, values: Sequence[float], status: str = "", part: Sequence[float] = ()
    ) -> bool:
        """Take one reading in and tell whether it may be used.

        Parameters
        ----------
        now, time : present time and stamp of the reading [s]
        values : all numbers of the reading; it is frozen where none of them changes
        status : what the sensor itself says is wrong; empty when nothing
        part : those of the `values` that may freeze while the others go on; empty: none
        """
        reason = self._fault(now, time, values, status, part)
        if self._newest_stamp < time < math.inf:
            if self._newest_stamp > -math.inf:
                self.interval.add(time - self._newest_stamp)
            self._newest_stamp = time
        if reason:
            self._refuse(reason)
            return False
        self._accepted += 1
        self._newest_arrival = now
        self._newest_accepted = max(time, self._newest_accepted or time)
        self._accept()
        return True

    def take_back(self, *, is_spike: bool) -> None:
        """Take back the newest reading: it is outside the estimator's gate.

        Parameters
        ----------
        is_spike : such readings were predicted well until now; where they were not, which is reported elsewhere, one
            more says nothing new of the sensor
        """
        before = (self.level, self.reason)
        self._accepted -= 1
        self._refuse("spike")
        if not is_spike:
            self.level, self.reason = before

    def take_back_jump(self) -> None:
        """Take back the newest reading: it has jumped."""
        self._accepted -= 1
        self._refuse("jump")

    def show_for(self, samples: int) -> None:
        """Let what was just refused be seen until `samples` good readings have come."""
        self._good_needed = samples

    def tick(self, now: float) -> None:
        """Notice what did not come by `now` [s]; once per tick, after the readings."""
        if self._started is None:
            self._started = now
        newest = self._started if self._newest_accepted is None else self._newest_accepted
        age = now - newest
        if age > self._largest_age + 1e-6 and self._bad_in_a_row == 0:
            comes = now - self._newest_arrival <= self._parameters.stale_samples * self.interval.value + 1e-6
            reason = "delayed" if comes else "stale"
            self._delayed_since = self._delayed_since if self.reason == reason else now
            self.level, self.reason, self._silence = SensorLevel.LOST, reason, age
            self._good_in_a_row = 0

    def _fault(self, now: float, time: float, values: Sequence[float], status: str, part: Sequence[float]) -> str:
        if not math.isfinite(sum(values)):
            return "nan"
        if not math.isfinite(time) or time > now + self._parameters.stamp_tolerance:
            return "wrong stamp"
        if time <= self._newest_stamp:
            return "late"
        # a heave that stands contradicts its rate as well
        if part and self._sameness_of_part.stands(tuple(part), self._parameters.frozen_samples):
            status = "frozen"
        if status:
            return status
        if self._checks_frozen and self._sameness.stands(tuple(values), self._parameters.frozen_samples):
            return "frozen"
        return ""

    def _refuse(self, reason: str) -> None:
        self._refused += 1
        self._bad_in_a_row += 1
        self._good_in_a_row = 0
        self._good_needed = self._parameters.recover_samples
        self.reason = reason
        is_grave = reason == "frozen" or self._bad_in_a_row >= BAD_IN_A_ROW
        is_lost = is_grave or self.is_lost
        self.level = SensorLevel.LOST if is_lost else SensorLevel.SUSPECT

    def _accept(self) -> None:
        self._bad_in_a_row = 0
        self._good_in_a_row += 1
        if self.level is not SensorLevel.OK and self._good_in_a_row >= self._good_needed:
            self.level, self.reason = SensorLevel.OK, ""


_MRU_WORDS: dict[int, str] = {
    MruStatus.OK: "",
    MruStatus.SETTLING: "status settling",
    MruStatus.INVALID: "status invalid",
}


def judge_mru(gate: SensorGate, now: float, reading: MruReading, steps: MruSteps, noise: float) -> bool:
    """Tell whether a reading of the MRU may be used, its status word included.

    Parameters
    ----------
    gate : of the MRU
    now : present time [s]
    reading : the MRU's
    steps : of the readings before
    noise : standard deviation of its heave [m]
    """
    status = _MRU_WORDS.get(reading.status, f"status {reading.status}")
    # a unit that does not measure the rate says NaN
    rate = 0.0 if math.isnan(reading.heave_rate) else reading.heave_rate
    if status or not math.isfinite(reading.heave + rate + reading.time):
        steps.restart()
    elif steps.is_off(reading, noise):
        status = "jump"
    values = (reading.heave, rate, reading.roll, reading.pitch)
    passes = gate.judge(now, reading.time, values, status, values[:2])
    if gate.reason == "frozen":
        steps.restart()  # where the ship has gone meanwhile its rate does not tell
    return passes
