"""Gates in front of the estimator: which readings may be used, and how each sensor is seen.

A reading is refused for what it shows alone: not a number, a status of the sensor's own, a stamp that
cannot be, a value that does not change. What only the estimate can show (a spike) comes back from the innovations.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import MruStatus, SensorLevel
from heave_node.interface.sensors import MruReading

from winch_controller_node.estimation.mru_steps import SIGMAS, MruSteps
from winch_controller_node.estimation.sensor_noise import OwnInterval, SensorTiming
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import ScalarReading, SensorState
from winch_controller_node.parameters.laws import HealthParameters

CONTRADICTS = "contradicts all others"
"""State of a sensor that is excluded and has no other fault, in words."""

BAD_IN_A_ROW = 3
"""Number of refused readings in a row that make a sensor lost: alarm within 3 samples."""

FIRST_SAMENESS, SAMENESS_MEMORY = 0.01, 200.0
"""Share of readings that are like the one before, of a sensor that does not read in steps, and readings over which that
of another is found."""

BY_CHANCE = 2e-4
"""Probability of a run of equal readings below which a sensor is frozen: three of one that does not read in steps."""

JUMP_SHOWN = 2.0
"""Time for which a subtracted jump is shown [s]: diagnostics come once a second."""

AT_ONCE, TRAVEL_KNOWN = 1.5, 10.0
"""A reading that comes later than so many ticks after the last one is judged by all that the drum should have turned
meanwhile, as far as that is known, so long [s].
"""

LARGEST_STEP, LARGEST_SPEED = 0.2, 4.0
"""A unit makes no step beyond the first [m], or SIGMAS of the sensor's noise, plus the second [m/s] times the time
since the last reading.
"""

LIKE_SCALE = 0.1
"""A jump of the depth by more than this share of it may be another scale, and one that makes a loop harmful."""

MOVING_SPEED, PLAY = 0.05, 0.03
"""A drum commanded faster than this [m/s] must show in the encoder, once that has taken up play and lag [m]."""

LARGEST_PLAY, BEYOND_PLAY = 0.1, 1.25
"""Play that a gear may be found to have [m], and the way of a drum that has turned round, over the play, which proves
the encoder frozen all the same."""

KNOWN_UNSEEN = 0.2
"""Share of the way that a drum has gone unseen by which it may be elsewhere than it was sent."""

LOST_STATES = {
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


def lost_alarm(sensor: str, reason: str, *, age: float, limit: float) -> Alarm:
    """Return the alarm of a `sensor` that is lost.

    Parameters
    ----------
    sensor : name
    reason : for which its readings are rejected
    age, limit : age of the newest accepted reading, and the largest that is allowed [s]; of a stale sensor
    """
    prefix = sensor.upper()
    if reason == "stale":
        return ALARMS.alarm(f"{prefix}_STALE", age=age, limit=limit)
    if reason in LOST_STATES:
        return ALARMS.alarm(f"{prefix}_{LOST_STATES[reason]}")
    return ALARMS.alarm(f"{prefix}_FAULT", status=reason)


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
        self._same_in_a_row = 1
        self._usual_sameness = FIRST_SAMENESS
        self._last_values: tuple[float, ...] = ()
        self._newest_stamp = -math.inf
        self._newest_accepted: float | None = None
        self._started: float | None = None
        self._silence = 0.0  # age of the newest accepted reading when it was last found stale [s]
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
        return lost_alarm(self.sensor, self.reason, age=self._silence, limit=self._largest_age)

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

    def judge(self, now: float, time: float, values: Sequence[float], status: str = "") -> bool:
        """Take one reading in and tell whether it may be used.

        Parameters
        ----------
        now, time : present time and stamp of the reading [s]
        values : all numbers of the reading; it is frozen where none of them changes
        status : what the sensor itself says is wrong; empty when nothing
        """
        reason = self._fault(now, time, values, status)
        if self._newest_stamp < time < math.inf:
            if self._newest_stamp > -math.inf:
                self.interval.add(time - self._newest_stamp)
            self._newest_stamp = time
        if reason:
            self._refuse(reason)
            return False
        self._accepted += 1
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
            self.level, self.reason, self._silence = SensorLevel.LOST, "stale", age
            self._good_in_a_row = 0

    def _fault(self, now: float, time: float, values: Sequence[float], status: str) -> str:
        if not math.isfinite(sum(values)):
            return "nan"
        if not math.isfinite(time) or time > now + self._parameters.stamp_tolerance:
            return "wrong stamp"
        if time <= self._newest_stamp:
            return "late"
        if status:
            return status
        if self._checks_frozen and self._has_stood_still(tuple(values)):
            return "frozen"
        return ""

    def _has_stood_still(self, values: tuple[float, ...]) -> bool:
        """Tell whether readings have been the same for longer than this sensor's usually are.

        Of one that reads in steps two in a row are often the same: a run of n comes by chance with a probability of
        p^(n - 1), p the share of readings that were like the one before.
        """
        if values != self._last_values:
            run = self._same_in_a_row
            weight = min(1.0, run / SAMENESS_MEMORY)
            self._usual_sameness += weight * ((run - 1) / run - self._usual_sameness)
            self._same_in_a_row, self._last_values = 1, values
            return False
        self._same_in_a_row += 1
        chance = max(self._usual_sameness, FIRST_SAMENESS) ** (self._same_in_a_row - 1)
        return self._same_in_a_row >= self._parameters.frozen_samples and chance < BY_CHANCE

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


def largest_step(noise: float, elapsed: float) -> float:
    """Return how far two depths may be apart [m] with an `elapsed` time between them [s] and `noise` of 1 sigma [m]."""
    return max(LARGEST_STEP, SIGMAS * noise) + LARGEST_SPEED * elapsed


class DepthJumps:
    """Takes jumps off the readings of a depth sensor that no unit can have made.

    A sensor that jumps back, as after a spike, is again where it was at first.

    Attributes
    ----------
    offset : sum of the jumps found so far [m]; a reading less the offset is the depth
    jump : the last one [m]
    is_like_scale : as large as that of a sensor that gets another scale or sign
    is_unproved : the last reading goes on from such a jump
    """

    def __init__(self) -> None:
        self.offset = self.jump = 0.0
        self.is_like_scale = self.is_unproved = False
        self._has_jumped = False
        self._last: tuple[float, float] | None = None

    def take_off(self, time: float, depth: float, noise: float = 0.0) -> float | None:
        """Return the depth without jumps [m], or None where it has just jumped.

        Parameters
        ----------
        time, depth : of the reading [s], [m]
        noise : standard deviation of the sensor's, as far as it is known [m]
        """
        last_time, last = (time, depth) if self._last is None else self._last
        allowed = largest_step(noise, time - last_time)
        for offset in (self.offset, 0.0):
            if abs(depth - offset - last) <= allowed:
                self.is_unproved = self._has_jumped and self.is_like_scale and offset != 0.0
                self._has_jumped, self.offset = False, offset
                self._last = (time, depth - offset)
                return depth - offset
        self.jump = depth - self.offset - last
        self.is_like_scale = abs(self.jump) > LIKE_SCALE * abs(last)
        self._has_jumped, self.is_unproved = True, False
        self.offset = depth - last
        self._last = (time, last)
        return None


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
    passes = gate.judge(now, reading.time, values, status)
    if gate.reason == "frozen":
        steps.restart()  # where the ship has gone meanwhile its rate does not tell
    return passes


class EncoderGate:
    """Gate of the drum encoder: finds jumps against the rate the drum is known to have, and takes them off.

    Parameters
    ----------
    timing, parameters : as for SensorGate
    tick_period : [s]

    Attributes
    ----------
    scale : a reading over this, less the offset, is the payout; 1 until it is known to be another
    offset : sum of the jumps found so far [m]
    jump : the last one [m]
    play : that its gear seems to have [m]
    as_read : payout as the encoder reads it, jumps taken off, whatever its assumed scale [m]
    jumped_at : time of the last jump [s]
    """

    def __init__(self, timing: SensorTiming, parameters: HealthParameters, *, tick_period: float) -> None:
        self.gate = SensorGate("encoder", timing, parameters, checks_frozen=False)
        self.scale = 1.0
        self.offset = 0.0
        self.jump, self.jumped_at = 0.0, -math.inf
        self.as_read, self._last_payout = 0.0, math.nan
        self.play = 0.0
        self._parameters = parameters
        self._dt = tick_period
        self._last: tuple[float, float] | None = None
        self._speed = 0.0
        self._still, self._unseen, self._path, self._is_frozen = 0, 0.0, 0.0, False
        self._turned = 0.0  # the last step of the encoder [m]
        self._travel: deque[tuple[float, float]] = deque(maxlen=max(2, round(TRAVEL_KNOWN / tick_period)))

    def rescale(self, factor: float, payout: float) -> None:
        """Take the encoder to read `factor` times as much as it was taken to until now, and the last to be `payout`."""
        self.scale *= factor
        self._last_payout = payout
        if self._last is not None:
            self._last, self._speed = (self._last[0], self._last[1] / factor), self._speed / factor
            self.offset = self._last[1] - payout

    def payout_at(self, as_read: float) -> float:
        """Return the payout at which it has read `as_read`, as its scale is now [m]."""
        return self._last_payout + (as_read - self.as_read) / self.scale

    def count_at(self, payout: float) -> float:
        """Return what the encoder reads at a `payout` [m], its jumps included: a drive's position loop counts by it."""
        return self.scale * (payout + self.offset)

    def pass_tick(self, now: float, expected_rate: float) -> None:
        """Note how the drum should have turned since the last tick, whether a reading comes or not.

        Parameters
        ----------
        now : present time [s]
        expected_rate : payout rate the drum should have had since the last tick [m/s]
        """
        total = self._travel[-1][1] if self._travel else 0.0
        self._travel.append((now, total + expected_rate * self._dt))

    def judge(
        self, now: float, reading: ScalarReading, expected_rate: float, *, is_driven: bool = True
    ) -> float | None:
        """Return the payout [m] without jumps, or None where the reading may not be used.

        Parameters
        ----------
        now : present time [s]
        reading : the encoder's
        expected_rate : payout rate the drum should have had since the last tick [m/s]
        is_driven : the winch follows its commands; a braked drum stands still and is not frozen
        """
        reading = ScalarReading(reading.time, reading.value / self.scale)
        status = self._status(reading, expected_rate, is_driven)
        if not self.gate.judge(now, reading.time, (reading.value,), status):
            if status == "jump":
                self.jumped_at = now
                self.gate.show_for(round(JUMP_SHOWN / self._dt))
            return None
        payout = reading.value - self.offset
        if math.isfinite(self._last_payout):
            self.as_read += self.scale * (payout - self._last_payout)
        else:
            self.as_read = payout
        self._last_payout = payout
        return payout

    def _status(self, reading: ScalarReading, expected_rate: float, is_driven: bool) -> str:
        """Look for jumps and for a drum that turns unseen."""
        if not math.isfinite(reading.value) or not math.isfinite(reading.time):
            return ""
        last, self._last = self._last, (reading.time, reading.value)
        if last is None:
            return ""
        elapsed = max(reading.time - last[0], self._dt)
        step = reading.value - last[1]
        ticks = elapsed / self._dt
        takes_up_play = self._takes_up_play(step, expected_rate * elapsed)
        is_thawing = self._is_frozen and step != 0.0 and not takes_up_play
        if is_thawing:
            expected = self._unseen + expected_rate * elapsed
            tolerance = self._parameters.encoder_step + KNOWN_UNSEEN * self._path
        elif ticks < AT_ONCE:
            expected, tolerance = expected_rate * elapsed, self._parameters.encoder_step
        else:
            # in a gap the drum may have been off its model in each tick
            expected, tolerance = self._expected_travel(last[0], reading.time), ticks * self._parameters.encoder_step
        is_frozen = self._watch_still(step, expected_rate * elapsed, is_driven)
        error = step - expected
        before, self._speed = self._speed, step / elapsed
        # what goes on as before does not jump: whether the drum does so is known by what the winch was sent
        if abs(error) > tolerance and (is_thawing or abs(step - before * elapsed) > tolerance):
            self.offset += error
            self.jump = error
            return "jump"
        return "frozen" if is_frozen else ""

    def _watch_still(self, step: float, expected: float, is_driven: bool) -> bool:
        """Tell whether the encoder is frozen.

        Parameters
        ----------
        step : since the last reading [m]
        expected : how far the drum should have turned meanwhile [m]
        is_driven : the winch follows its commands
        """
        if step != 0.0 or not (is_driven or self._is_frozen):
            self._turned = step or self._turned
            self._thaw()
            return False
        self._unseen += expected
        self._path += abs(expected)
        self._still += 1 if abs(expected) > MOVING_SPEED * self._dt else 0
        # a drum that turns back, and is slow for a moment, takes no proof away
        has_turned_round = self._unseen * self._turned < 0.0
        allowed = max(PLAY, BEYOND_PLAY * self.play) if has_turned_round else PLAY
        self._is_frozen |= self._still >= self._parameters.frozen_samples and abs(self._unseen) > allowed
        return self._is_frozen

    def _takes_up_play(self, step: float, expected: float) -> bool:
        """Tell whether an encoder that seemed frozen, or would have, has only taken up the play of its gear.

        It stood still since the drum turned round, for no longer than a gear takes, and counts on the way that the drum
        goes now. One that froze just there, and counts on from where it stood, looks the same: so much it may be off.

        Parameters
        ----------
        step : in which it counts on [m]
        expected : how far the drum should have turned meanwhile [m]
        """
        is_like_play = (
            self._unseen * self._turned < 0.0 < self._unseen * step
            and PLAY < abs(self._unseen) <= LARGEST_PLAY
            and abs(step - expected) <= self._parameters.encoder_step
        )
        if is_like_play:
            self.play = max(self.play, abs(self._unseen))
        return is_like_play

    def _thaw(self) -> None:
        self._still, self._unseen, self._path, self._is_frozen = 0, 0.0, 0.0, False

    def trust(self) -> None:
        """Take a frozen encoder for good until the drum turns unseen again: an operator asks for it to be tried."""
        self.offset -= self._unseen  # the drum stands where it got to
        self._thaw()

    def _expected_travel(self, start: float, end: float) -> float:
        """Return by how much the drum should have turned between two readings, from `start` to `end` [s]."""
        if not self._travel:
            return 0.0
        times, totals = np.array(self._travel).T
        before, after = np.interp([start, end], times, totals)
        return float(after - before)
