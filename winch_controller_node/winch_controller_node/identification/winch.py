"""Time constant and delay of the winch, identified from what it was sent and what its encoder read in a running loop.

Servo and delay look alike at the frequencies of a sea, but not where the winch is at its limits: there the servo's lag
vanishes and the delay stays. Both are found, by Gauss-Newton over the last seconds on the drum with its limits; noise
in the commands and the winch's limits tell them apart. The design is made anew with what was found.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from heave_node.arrays import Array

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.identification.drum_kernel import Drum, drum_record
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import LagParameters
from winch_controller_node.parameters.model import WinchModelParameters

SHORTEST_RECORD = 4.0
"""Record [s] from which on the lags are estimated."""

PRIOR_SIGMAS = (0.05, 0.1)
"""Prior standard deviations of time constant and delay [s]: how far they may well be from the nominal ones."""

ITERATIONS = 6
"""Largest number of Gauss-Newton steps; each record begins where the last one ended."""

CONVERGED = 1e-4
"""Iteration ends with a step of time constant and delay below this [s]."""

DIFFERENCE = 1e-4
"""Step of the sensitivities [s], [m/s]."""

SIGNIFICANT = 4.0
"""A change is taken when it is so many standard deviations off."""

CORRELATED = 4.0
"""Residuals in a row that count as one: they are not white."""

RESOLUTION = 3e-4
"""Least standard deviation of what is left [m]: an encoder of 1 mm."""

LATE_TICKS = 2
"""Ticks in a row with a command overdue that raise the alarm."""

LATE_WINDOW = 2.0
"""Commands of so many seconds are judged together: one hiccup of a machine is no slow transport."""

SMALLEST_LAG = 0.005
"""Least time constant of a servo [s]."""


@dataclass(frozen=True)
class WinchLags:
    """What was found.

    Attributes
    ----------
    time_constant, delay : of servo and command [s]
    covariance : of both, shape (2, 2) [s^2]
    residual : standard deviation of the encoder about the drum's model [m]
    """

    time_constant: float
    delay: float
    covariance: Array
    residual: float

    def is_far_from(self, winch: WinchModelParameters, step: float) -> bool:
        """Tell whether the model `winch` differs by more than `step` [s], and significantly."""
        off = np.array([self.time_constant - winch.time_constant, self.delay - winch.command_delay])
        return bool(np.max(np.abs(off)) > step and off @ np.linalg.solve(self.covariance, off) > SIGNIFICANT**2)


class WinchIdentifier:
    """Finds time constant and delay of a speed servo.

    Parameters
    ----------
    parameters : length of the record, smallest and largest change
    design : with the nominal winch
    """

    def __init__(self, parameters: LagParameters, design: ControllerDesign) -> None:
        self._parameters = parameters
        self._dt = design.tick_period
        self._nominal = design.parameters.winch
        self._found = (self._nominal.time_constant, self._nominal.command_delay)
        self._ahead = math.ceil((self._nominal.command_delay + parameters.largest) / self._dt) + 2
        window = max(2, round(parameters.window / self._dt))
        self._payouts: deque[float] = deque(maxlen=window + self._ahead)
        self._rates: deque[float] = deque(maxlen=window + self._ahead)
        self._readings: deque[float] = deque(maxlen=window)
        self.reset()
        # compiled here, not in a tick of a run in real time
        self._record(np.zeros(self._ahead + 1), np.zeros(self._ahead + 1), 1, np.array([*self._found, 0.0, 0.0]))

    def reset(self, payout: float = 0.0) -> None:
        """Begin a new record with the drum at rest at `payout` [m]."""
        self._payouts.clear()
        self._rates.clear()
        self.restart()
        self._payouts.extend([payout] * self._ahead)
        self._rates.extend([0.0] * self._ahead)

    def restart(self) -> None:
        """Begin a new record with the drum in motion, after something that the model does not know."""
        self._readings.clear()

    def add(self, payout_set_point: float, rate_set_point: float, encoder: float | None) -> None:
        """Take in a tick.

        Parameters
        ----------
        payout_set_point, rate_set_point : of the tick that ends [m], [m/s]
        encoder : reading at its end [m]; None: no reading
        """
        self._payouts.append(payout_set_point)
        self._rates.append(rate_set_point)
        self._readings.append(math.nan if encoder is None else encoder)

    @property
    def is_full(self) -> bool:
        """Tell whether the record has its full length."""
        return len(self._readings) == self._readings.maxlen

    def find(self) -> WinchLags | None:
        """Return the lags that fit the record best, or None where it does not tell."""
        count = len(self._readings)
        readings = np.array(self._readings)
        seen = np.isfinite(readings)
        if count * self._dt < SHORTEST_RECORD or np.count_nonzero(seen) < count // 2:
            return None
        payouts, rates = np.array(self._payouts), np.array(self._rates)
        nominal = np.array([self._nominal.time_constant, self._nominal.command_delay])
        guess = np.array([*self._found, readings[seen][0], 0.0])
        variance = RESOLUTION**2
        for _ in range(ITERATIONS):
            record, slopes = self._linearise(payouts, rates, count, guess)
            residual, slopes = (readings - record)[seen], slopes[seen]
            variance = max(float(np.mean(residual**2)), RESOLUTION**2)
            information = slopes.T @ slopes / (CORRELATED * variance)
            pull = slopes.T @ residual / (CORRELATED * variance)
            information[[0, 1], [0, 1]] += 1.0 / np.square(PRIOR_SIGMAS)
            pull[:2] += (nominal - guess[:2]) / np.square(PRIOR_SIGMAS)
            size = np.sqrt(np.diag(information))
            covariance = np.linalg.inv(information / np.outer(size, size)) / np.outer(size, size)
            before, guess = guess, self._bounded(guess + covariance @ pull)
            if np.max(np.abs(guess - before)[:2]) < CONVERGED:
                break
        if not np.all(np.isfinite(guess)):
            return None
        self._found = (float(guess[0]), float(guess[1]))
        return WinchLags(*self._found, covariance[:2, :2], math.sqrt(variance))

    def improved_parameters(self, parameters: WinchControllerParameters) -> WinchControllerParameters | None:
        """Return parameters with the lags that were found, or None where the present ones do."""
        found, winch = self.find(), parameters.winch
        if found is None or not found.is_far_from(winch, self._parameters.step):
            return None
        return replace(parameters, winch=replace(winch, time_constant=found.time_constant, command_delay=found.delay))

    def _linearise(self, payouts: Array, rates: Array, count: int, guess: Array) -> tuple[Array, Array]:
        """Return the record and how it goes with time constant, delay, payout and rate at its start, (count, 4)."""
        slopes = np.ones((count, 4))
        record = self._record(payouts, rates, count, guess)
        for column in (0, 1, 3):
            other = guess.copy()
            other[column] += DIFFERENCE
            slopes[:, column] = (self._record(payouts, rates, count, other) - record) / DIFFERENCE
        return record, slopes

    def _record(self, payouts: Array, rates: Array, count: int, guess: Array) -> Array:
        winch = self._nominal
        lag, delay, payout, rate = (float(value) for value in guess)
        drum = Drum(lag, delay, winch.position_gain, winch.speed_limit, winch.acceleration_limit)
        return drum_record(payouts, rates, count, drum, payout, rate, self._dt)

    def _bounded(self, guess: Array) -> Array:
        """Keep the lags within what is allowed."""
        largest, nominal = self._parameters.largest, self._nominal
        guess[0] = min(max(guess[0], SMALLEST_LAG), nominal.time_constant + largest)
        guess[1] = min(max(guess[1], nominal.command_delay - largest, 0.0), nominal.command_delay + largest)
        return guess


class LateCommands:
    """Notices that the winch takes commands later than modelled, by the sequence numbers that it acknowledges.

    A transport that becomes slower is seen so within three ticks, long before the record of the drum tells; that it
    stays so is judged by the median over some seconds.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._late = 0
        self._overdue: deque[float] = deque(maxlen=max(1, round(LATE_WINDOW / tick_period)))

    @property
    def overdue(self) -> float:
        """Time by which more than half of the commands of the last seconds were later than modelled, at least [s]."""
        window = self._overdue.maxlen or 1
        later = sorted(self._overdue, reverse=True)
        return later[window // 2] if len(later) > window // 2 else 0.0

    def update(self, given: int, taken: int, delay: float) -> str:
        """Return what is wrong in words, once each time; empty when nothing is.

        Parameters
        ----------
        given, taken : number of the last command, and of the newest one in effect at the end of its tick
        delay : of the model [s]
        """
        due = math.ceil(delay / self._dt - 1e-6) - 1
        late_ticks = given - taken - due - 1
        is_late = taken > 0 and late_ticks > 0
        self._late = self._late + 1 if is_late else 0
        self._overdue.append(late_ticks * self._dt if is_late else 0.0)
        if self._late != LATE_TICKS:
            return ""
        return f"winch commands take effect at least {late_ticks * self._dt:.2f} s later than modelled"
