"""The motion reference unit (MRU) at the boom tip: what it says of heave, and when it says nothing or worse.

The reading is the true heave plus the lever-arm error (pitch and roll let in), times 1 + scale error, through a
second-order high-pass s^2 / (s^2 + 2 zeta omega_c s + omega_c^2), with white noise, noise that wanders, and in whole
steps where the unit has a resolution. The high-pass is kept as what it
takes away: reading = truth - e with e'' + 2 zeta omega_c e' + omega_c^2 e = 2 zeta omega_c x' + omega_c^2 x - d, solved
exactly for x a cubic between ticks; d is an error of the vertical acceleration, a bias after a restart.
"""

from __future__ import annotations

import math
from itertools import accumulate

import numpy as np
import scipy
from heave_node.interface.codes import MruStatus
from heave_node.interface.fault_kinds import LARGEST_DELAY
from heave_node.interface.faults import FaultSchedule, FaultyValues
from heave_node.interface.sensors import MruReading
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from heave_node.sensing.view import quantised
from numpy.typing import NDArray

from wave_vessel_node.parameters import MruParameters
from wave_vessel_node.vessel.motion import PITCH, ROLL, VesselMotions

_TICK_ROUNDING = 1e-6
"""A delay so little above whole ticks is one of whole ticks [ticks]."""
_IN_HEAVE = np.array([1.0, 0.0, 0.0, 0.0, 0.0])
"""A spike or jump is an error of heave, not of rate, acceleration, roll or pitch."""
_OF_HEAVE = np.array([1.0, 1.0, 1.0, 0.0, 0.0])
"""A scale is one of heave, its rate and acceleration, not of roll or pitch."""


def high_pass_response(omega: Array, cut_off: float, damping: float) -> NDArray[np.complex128]:
    """Return -omega^2 / (cut_off^2 - omega^2 + 2 i damping cut_off omega), the formula the unit obeys."""
    omega = np.asarray(omega, dtype=float)
    return np.asarray(-(omega**2) / (cut_off**2 - omega**2 + 2j * damping * cut_off * omega))


class DrivenOscillator:
    """y'' + 2 zeta omega y' + omega^2 y = value_gain u + rate_gain u' + f, with u a cubic and f constant within a step.

    Parameters
    ----------
    frequency : omega [rad/s]; damping : zeta
    value_gain, rate_gain : of the motion u and of its rate
    period : length of a step [s]
    """

    def __init__(self, frequency: float, damping: float, *, value_gain: float, rate_gain: float, period: float) -> None:
        self._stiffness, self._damping = frequency**2, 2.0 * damping * frequency
        self._gains = (value_gain, rate_gain)
        self._period = period
        self._state = np.zeros(2)
        self._last = (0.0, 0.0)
        # y, y', and the polynomial u, u', u'', u''' as a chain of integrators, and f
        generator = np.zeros((7, 7))
        generator[0, 1] = 1.0
        generator[1, :4] = -self._stiffness, -self._damping, value_gain, rate_gain
        generator[1, 6] = 1.0
        generator[2, 3] = generator[3, 4] = generator[4, 5] = 1.0
        self._transition = scipy.linalg.expm(generator * period)[:2]

    def start(self, value: float, rate: float, state: tuple[float, float] = (0.0, 0.0)) -> None:
        """Begin at u = `value`, u' = `rate`, with (y, y') = `state`."""
        self._state, self._last = np.array(state), (value, rate)

    def run(self, values: Array, rates: Array, forces: Array) -> Array:
        """Advance by n periods to u = `values`, u' = `rates`, with f = `forces` held; all of shape (n,).

        Returns y, y', y'', u and u' at their ends, shape (n, 5): a row is all that `start` needs to go on from there.
        """
        h = self._period
        u, u1 = np.append(self._last[0], values[:-1]), np.append(self._last[1], rates[:-1])
        slope = (values - u) / h
        u2 = (6.0 * slope - 4.0 * u1 - 2.0 * rates) / h
        u3 = (6.0 * u1 + 6.0 * rates - 12.0 * slope) / h**2
        inputs = np.column_stack((u, u, u, u1, u2, u3, forces))
        out = np.column_stack((u, u, u, values, rates))
        for before, after in zip(inputs, out, strict=True):
            before[:2] = self._state
            self._state = after[:2] = self._transition @ before
        self._last = (float(values[-1]), float(rates[-1]))
        drive = self._gains[0] * values + self._gains[1] * rates + forces
        out[:, 2] = drive - self._stiffness * out[:, 0] - self._damping * out[:, 1]
        return out


class MotionReferenceUnit:
    """The unit: `look` takes the true motion of a block of ticks, `step` gives the reading of each of them, in order.

    Parameters
    ----------
    parameters : see MruParameters
    seed : seed of the run
    tick_period : [s]

    Attributes
    ----------
    faults : faults may be injected during the run
    """

    def __init__(self, parameters: MruParameters, *, seed: int, tick_period: float) -> None:
        self._parameters = parameters
        self._period = tick_period
        self._generator = random_stream(seed, "wave_vessel/mru")
        cut_off = 2.0 * math.pi / parameters.high_pass_period if parameters.high_pass_period > 0.0 else 0.0
        damping = parameters.high_pass_damping
        self._taken = DrivenOscillator(
            cut_off, damping, value_gain=cut_off**2, rate_gain=2.0 * damping * cut_off, period=tick_period
        )
        usual = {"restart": parameters.restart_duration}
        self.faults = FaultSchedule(parameters.faults, name="mru", device="mru", usual_duration=usual, seed=seed)
        self._faulty_values = FaultyValues(self.faults, _IN_HEAVE, _OF_HEAVE)
        # what a stamp does not account for is late by a whole tick, as all that arrives is
        unaccounted = math.ceil(max(parameters.stamp_error, 0.0) / tick_period - _TICK_ROUNDING)
        self._late_ticks = unaccounted + round(parameters.latency / tick_period)
        self._steps = (parameters.resolution, parameters.rate_resolution, 0.0, 0.0, 0.0)
        self._random_wander = random_stream(seed, "wave_vessel/mru/wander")
        self._wandered = np.array([parameters.wander * float(self._random_wander.standard_normal())])
        self._kept = 1 + self._late_ticks + math.ceil(LARGEST_DELAY["mru"] / tick_period)
        self._seen = np.zeros((0, 5))
        self._last = 0
        self._last_delivered = -math.inf
        self._sequence = 0
        self._settled = np.zeros(1)
        self._restarted_at = -math.inf

    @property
    def reading_period(self) -> float:
        """Time between two readings [s]: the nearest whole number of ticks to 1 / rate."""
        return self._ticks_at(self._parameters.rate) * self._period

    def look(self, motions: VesselMotions, heave: Array) -> None:
        """Take the truth at the next n ticks, the first of which is 1.

        Parameters
        ----------
        motions : of the vessel
        heave : boom-tip heave about its mean, rate, acceleration, shape (n, 3)
        """
        p, count, six = self._parameters, len(heave), motions.six
        x, y, _ = p.lever_arm_error
        self._truth = (1.0 + p.scale_error) * (heave - x * six[:, :, PITCH] + y * six[:, :, ROLL])
        if not self._last:
            # nothing is taken away of a motion about zero that has been at rest
            self._taken.start(*self._truth[0, :2].tolist())
        self._motions, self._last = motions, self._last + count
        # in every tick, whatever becomes of it: a fault changes no other reading
        self._noise = np.zeros((count, 5))
        self._noise[:, :3] = self._generator.standard_normal((count, 3)) * (p.noise, p.rate_noise, p.rate_noise)
        self._wandered = self._wander(count)
        self._seen = np.vstack((self._seen[-self._kept :], np.empty((count, 5))))
        self._settled = np.full(count, self._settled[-1])
        self._pass(0)

    def series(self, heave: Array) -> Array:
        """Return heave and heave rate as delivered at each tick of a run, shape (n, 2); NaN where nothing is.

        They are those of `step` without scheduled faults, for a boom tip with this `heave` about its mean, rate and
        acceleration at the ticks from the first one on, shape (n, 3).
        """
        p, ticks = self._parameters, np.arange(1, len(heave) + 1)
        self.look(VesselMotions.still(range(1, len(heave) + 1), self._period), heave)
        rows = np.flatnonzero((ticks % self._ticks_at(p.rate) == 0) & (ticks > self._late_ticks))
        seen = self._seen[len(self._seen) - len(heave) :]
        said = np.full((len(heave), 2), np.nan)
        said[rows] = (seen[rows - self._late_ticks] + self._noise[rows])[:, :2]
        for column, step in enumerate(self._steps[:2]):
            said[:, column] = step * np.rint(said[:, column] / step) if step > 0.0 else said[:, column]
        return said if p.measures_rate else said * [1.0, np.nan]

    def _wander(self, count: int) -> Array:
        """Return the error of the next `count` ticks [m]: a first-order Gauss-Markov process, stationary, exact."""
        sigma, decay = self._parameters.wander, math.exp(-self._period / self._parameters.wander_time)
        if sigma == 0.0:
            return np.zeros(count)
        fresh = sigma * math.sqrt(1.0 - decay**2)
        drawn = (fresh * self._random_wander.standard_normal(count)).tolist()
        errors = accumulate(drawn, lambda value, new: decay * value + new, initial=self._wandered.item(-1))
        return np.array(list(errors)[1:])

    def _pass(self, row: int) -> None:
        """Set what the unit sees from a `row` of the block on: the truth less what its high-pass takes away."""
        truth, motions = self._truth[row:], self._motions
        passed = truth
        if self._parameters.high_pass_period > 0.0:
            passed = truth - self._taken.run(truth[:, 0], truth[:, 1], -self._acceleration_errors(row))[:, :3]
        attitude = motions.six[row:, 0, ROLL : PITCH + 1]
        seen = np.hstack((passed, attitude)) + self._wandered[row:, None] * _IN_HEAVE
        self._seen[len(self._seen) - len(seen) :] = seen

    def _acceleration_errors(self, row: int) -> Array:
        """Return the errors of vertical acceleration from a `row` of the block on [m/s^2]: the bias of a restart."""
        p, times = self._parameters, self._motions.time[row:]
        if self._restarted_at < 0.0:
            return np.zeros(len(times))
        since = ((times - self._restarted_at) / p.high_pass_period).tolist()
        return np.array([p.restart_bias * math.exp(-age) for age in since])

    def step(self, tick: int) -> MruReading | None:
        """Return the reading delivered at `tick`, or None if there is none."""
        now, faults = tick * self._period, self.faults
        row = tick - self._last - 1  # of the block, from its end
        restart = faults.take_begun("restart", now)
        if restart is not None:
            self._restart(len(self._truth) + row, now, restart.end)
        faulty_rate = faults.newest("rate", now)
        if tick % self._ticks_at(self._parameters.rate if faulty_rate is None else faulty_rate):
            return None
        self._sequence += 1
        if faults.is_active("restart", now) or faults.is_active("gap", now):
            return None
        return self._reading(tick, row, now)

    def _restart(self, row: int, now: float, end: float) -> None:
        """Begin again at a `row` of the block, `now`, silent until an `end` [s]: the unit knows nothing, reads zero."""
        p, (value, rate) = self._parameters, self._truth[row, :2].tolist()
        self._restarted_at, self._settled[row:] = now, end + p.settling_periods * p.high_pass_period
        self._taken.start(value, rate, state=(value, rate))
        self._pass(row)

    def _ticks_at(self, rate: float) -> int:
        """Return the ticks between two readings at `rate` [Hz]; 0: there is one in every tick."""
        return max(1, round(1.0 / max(rate * self._period, 1e-9))) if rate else 1

    def _reading(self, tick: int, row: int, now: float) -> MruReading | None:
        p = self._parameters
        late = self._late_ticks + round(self.faults.lateness(now) / self._period)
        measured_at = (tick - late) * self._period
        if late >= min(tick, self._kept) or measured_at <= self._last_delivered:
            return None
        self._last_delivered = measured_at
        said = self._faulty_values.apply(now, self._seen[row - late] + self._noise[row])
        heave, heave_rate, heave_acceleration, roll, pitch = map(quantised, said.tolist(), self._steps)
        if not p.measures_rate:
            heave_rate = heave_acceleration = math.nan
        return MruReading(
            time=measured_at + p.stamp_error,
            heave=heave,
            heave_rate=heave_rate,
            roll=roll,
            pitch=pitch,
            status=MruStatus.SETTLING if now < self._settled.item(row) else MruStatus.OK,
            sequence=self._sequence,
            heave_acceleration=heave_acceleration,
            heave_sigma=p.noise,
            heave_rate_sigma=p.rate_noise if p.measures_rate else math.nan,
        )
