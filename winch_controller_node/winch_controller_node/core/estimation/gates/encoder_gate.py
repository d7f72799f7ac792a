"""The gate of the drum encoder: what it reads is held against the way that the drum was sent."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from winch_controller_node.core.estimation.sensor_health import SensorGate
from winch_controller_node.core.estimation.sensor_noise import SensorTiming
from winch_controller_node.interface.readings import ScalarReading
from winch_controller_node.parameters.laws import HealthParameters

JUMP_SHOWN = 2.0
"""Time for which a subtracted jump is shown [s]: diagnostics come once a second."""

AT_ONCE, TRAVEL_KNOWN = 1.5, 10.0
"""A reading that comes later than so many ticks after the last one is judged by all that the drum should have turned
meanwhile, as far as that is known, so long [s].
"""

MOVING_SPEED, PLAY = 0.05, 0.03
"""A drum commanded faster than this [m/s] must show in the encoder, once that has taken up play and lag [m]."""

LARGEST_PLAY, BEYOND_PLAY = 0.1, 1.25
"""Play that a gear may be found to have [m], and the way of a drum that has turned round, over the play, which proves
the encoder frozen all the same."""

KNOWN_UNSEEN = 0.2
"""Share of the way that a drum has gone unseen by which it may be elsewhere than it was sent."""


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

    def counted(self, reading: float) -> float:
        """Return the payout that a `reading` says, jumps taken off [m]."""
        return reading / self.scale - self.offset

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
