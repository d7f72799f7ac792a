"""The industrial baseline: the outlet follows the boom tip, by feed-forward and a position loop, tuned by rule.

What makers of winches do: a filter makes position, speed and acceleration of the boom tip of the motion reference unit;
they are predicted over the command's delay; the winch's lag is inverted; a position loop takes care of what is left.
Nothing is known of cable and unit, and nothing is tuned but by the winch's stated lag T and delay tau:

    v_set = v_d + T a_d,   v_d = v + k (x - p),   a_d = a + k (v - p'),   k by `rule_gain` of the law of that name

x, v, a of the boom tip (and of the operator's target) and the payout p, all at t + tau. p is predicted by a model of
the winch driven by the commands that are still on their way (Smith predictor). tau holds half a sample time, for which
a command is held on average.

The filter is a steady Kalman filter whose heave acceleration is a damped oscillator at the expected peak period. While
the motion reference unit says nothing, or the same thing again and again, the filter coasts; after a second of it the
winch stands still. A landing is seen by the load cell: lowering ends there.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from heave_node.numerics.arrays import Array
from scipy.linalg import expm, solve_discrete_are
from winch_controller_node.laws.industrial import rule_gain

from heave_bringup.benchmark.interface import MRU_INVALID, WINCH_OK, Command, Facts, Measurement, MruReading

DAMPING = 0.3
"""Damping ratio of the oscillator that the heave acceleration is taken for: a broad sea."""
QUIETEST = 1e-3
"""Smallest noise assumed for a sensor [m], [m/s], [m/s^2]."""
SPIKE = 0.5
"""Error of a predicted heave above which a reading is rejected as a spike [m]."""
INSISTENCE = 10
"""Rejected readings in a row after which the next one is taken."""
COASTING = 1.0
"""The filter coasts this long without a reading before the winch stops [s]."""
REPEATED = 3
"""Number of equal readings in a row that count as none."""
LANDED = 0.8
"""Share of the first tension at which a unit that is lowered has landed."""
TENSION_TIME = 4.0
"""Time constant over which tension is averaged [s]."""
ACKNOWLEDGING = 20
"""Samples for which the brake is requested, and then not, to clear a fault of the winch."""


class Industrial:
    """The baseline.

    Parameters
    ----------
    facts : of the case
    """

    def __init__(self, facts: Facts) -> None:
        winch = facts.winch
        self._dt = facts.sample_time
        self._winch = winch
        self._delay = winch.command_delay + 0.5 * self._dt
        self._gain = rule_gain(self._delay, winch.time_constant)
        self._tip = BoomTip(facts)
        self._model = WinchModel(facts)
        self._landing = Landing(facts.sample_time)
        self._faulty = 0

    def step(self, measurement: Measurement) -> Command:
        """See `Controller.step`."""
        self._tip.step(measurement.time, measurement.mru)
        target = self._landing.bounded(measurement)
        self._faulty = self._faulty + 1 if measurement.winch.fault != WINCH_OK else 0
        brake = self._faulty % (2 * ACKNOWLEDGING) in range(1, ACKNOWLEDGING + 1)
        x, v, a = self._tip.ahead(self._delay)
        payout, rate = self._model.ahead(measurement.winch.payout)
        if measurement.winch.brake:
            rate = 0.0
        payout += 0.5 * self._dt * rate
        wanted_rate = v + target[1]
        wanted = wanted_rate + self._gain * (x + target[0] - payout)
        slope = a + self._gain * (wanted_rate - rate)
        limit = self._winch.set_point_limit
        order = min(max(wanted + self._winch.time_constant * slope, -limit), limit)
        self._model.step(0.0 if brake else order)
        return Command(order, target[0], brake)


class BoomTip:
    """Position, speed and acceleration of the boom tip, filtered and predicted.

    States: heave, its rate, acceleration a, and a'; a'' + 2 zeta w a' + w^2 a is white noise, of the strength at which
    a has the standard deviation 2 (H_s/4) w^2: twice that of a sine at the peak, for a sea has a tail. The gain is the
    steady one for a reading at each sample time.

    Parameters
    ----------
    facts : expected sea, noise of the readings, sample time
    """

    def __init__(self, facts: Facts) -> None:
        w, dt = 2.0 * math.pi / facts.sea.peak_period, facts.sample_time
        self._a = np.zeros((4, 4))
        self._a[[0, 1, 2], [1, 2, 3]] = 1.0
        self._a[3, 2:] = -w * w, -2.0 * DAMPING * w
        sigma = 0.5 * facts.sea.significant_wave_height * w * w
        density = 4.0 * DAMPING * w**3 * sigma**2
        self._f, noise = _sampled(self._a, density, dt)
        sensors = facts.sensors
        sigmas = [sensors.mru_noise, sensors.mru_rate_noise, sensors.mru_acceleration_noise]
        self._gains = {n: _steady_gain(self._f, noise, np.maximum(sigmas[:n], QUIETEST)) for n in (2, 3)}
        self._transitions: dict[float, Array] = {}
        self._x: Array = np.zeros(4)
        self._heard = -math.inf
        self._time = 0.0
        self._last: tuple[float, float] | None = None
        self._repeated = self._refused = 0

    def step(self, time: float, readings: tuple[MruReading, ...]) -> None:
        """Go to `time` [s] with the `readings` delivered there."""
        self._time = time
        self._x = self._f @ self._x
        for reading in readings:
            self._take(reading)

    def ahead(self, horizon: float) -> tuple[float, float, float]:
        """Return heave, rate and acceleration `horizon` [s] from now; at rest where nothing has been heard of late."""
        if self._time - self._heard > COASTING:
            return float(self._x[0]), 0.0, 0.0
        x = self._transition(horizon) @ self._x
        return float(x[0]), float(x[1]), float(x[2])

    def _take(self, reading: MruReading) -> None:
        said = (reading.heave, reading.heave_rate)
        self._repeated = self._repeated + 1 if said == self._last else 0
        self._last = said
        good = reading.status != MRU_INVALID and self._repeated < REPEATED and all(map(math.isfinite, said))
        if not good:
            return
        age = max(self._time - reading.time, 0.0)
        then = self._transition(-age) @ self._x
        if abs(said[0] - then[0]) > SPIKE and self._refused < INSISTENCE and math.isfinite(self._heard):
            self._refused += 1
            return
        if self._refused >= INSISTENCE or not math.isfinite(self._heard):
            then = np.array([*said, 0.0, 0.0])
        self._refused, self._heard = 0, reading.time
        values = [*said, reading.heave_acceleration] if math.isfinite(reading.heave_acceleration) else [*said]
        n = len(values)
        then = then + self._gains[n] @ (np.array(values) - then[:n])
        self._x = self._transition(age) @ then

    def _transition(self, duration: float) -> Array:
        """Return the transition matrix over `duration` [s], rounded to the microsecond, before or after now."""
        key = round(duration, 6)
        if key not in self._transitions:
            self._transitions[key] = expm(self._a * key)
        return self._transitions[key]


class WinchModel:
    """The winch by its stated lag, delay and limits: where it will be when a command of now takes effect.

    Parameters
    ----------
    facts : the winch
    """

    def __init__(self, facts: Facts) -> None:
        winch, self._dt = facts.winch, facts.sample_time
        self._winch = winch
        self._decay = math.exp(-self._dt / winch.time_constant)
        late = round(winch.command_delay / self._dt)
        self._payout = self._rate = 0.0
        self._past: deque[float] = deque([0.0] * (late + 1), maxlen=late + 1)

    def ahead(self, payout: float) -> tuple[float, float]:
        """Return payout and rate when a command of now takes effect, from the payout measured now [m]."""
        return payout + self._payout - self._past[0], self._rate

    def step(self, order: float) -> None:
        """Take `order`, the speed set-point of now [m/s]."""
        winch, before = self._winch, self._rate
        change = (min(max(order, -winch.speed_limit), winch.speed_limit) - before) * (1.0 - self._decay)
        if winch.set_point_limit > winch.speed_limit:
            change = (order - before) * (1.0 - self._decay)
        largest = winch.acceleration_limit * self._dt
        wanted = before + min(max(change, -largest), largest)
        self._rate = min(max(wanted, -winch.speed_limit), winch.speed_limit)
        self._payout += 0.5 * (before + self._rate) * self._dt
        self._past.append(self._payout)


class Landing:
    """Ends a lowering where the load cell says that the unit stands; raising goes on as asked.

    Parameters
    ----------
    sample_time : [s]
    """

    def __init__(self, sample_time: float) -> None:
        self._share = sample_time / TENSION_TIME
        self._first = self._mean = math.nan
        self._held = math.inf

    def bounded(self, measurement: Measurement) -> tuple[float, float]:
        """Return payout [m] and rate [m/s] of the target of `measurement`, no lower than where the unit landed."""
        target = measurement.target
        for reading in measurement.load_cell:
            if math.isfinite(reading.value):
                self._note(reading.value)
        if target.payout_rate > 0.0 and self._mean < LANDED * self._first and math.isinf(self._held):
            self._held = target.payout
        if target.payout_rate < 0.0 and target.payout < self._held:
            self._held = math.inf
        return (self._held, 0.0) if target.payout > self._held else (target.payout, target.payout_rate)

    def _note(self, tension: float) -> None:
        if math.isnan(self._first):
            self._first = self._mean = tension
        self._mean += self._share * (tension - self._mean)


def _sampled(a: Array, density: float, dt: float) -> tuple[Array, Array]:
    """Return transition matrix and noise covariance over `dt` of x' = a x + white noise on its last row (Van Loan)."""
    n = len(a)
    noise = np.zeros((n, n))
    noise[-1, -1] = density
    block = expm(np.block([[-a, noise], [np.zeros((n, n)), a.T]]) * dt)
    f = block[n:, n:].T
    return f, f @ block[:n, n:]


def _steady_gain(f: Array, noise: Array, sigma: Array) -> Array:
    """Return the gain of the steady filter that measures the first states with the standard deviations `sigma`."""
    n = len(sigma)
    h = np.eye(n, len(f))
    r = np.diag(sigma**2)
    p = solve_discrete_are(f.T, h.T, noise, r)
    return np.asarray(p @ h.T @ np.linalg.inv(h @ p @ h.T + r))
