"""The motion reference unit (MRU) at the boom tip: what it says of heave, and when it says nothing or worse.

The reading is the true heave plus the lever-arm error (pitch and roll let in), times 1 + scale error, through a
second-order high-pass s^2 / (s^2 + 2 zeta omega_c s + omega_c^2), with white noise, noise that wanders, and in whole
steps where the unit has a resolution. The high-pass is kept as what it
takes away: reading = truth - e with e'' + 2 zeta omega_c e' + omega_c^2 e = 2 zeta omega_c x' + omega_c^2 x - d, solved
exactly for x a cubic between ticks; d is an error of the vertical acceleration (a tilt of the vertical in a turn, a
bias after a restart).
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from heave_node.interface.codes import MruStatus
from heave_node.interface.fault_kinds import LARGEST_DELAY
from heave_node.interface.faults import FaultSchedule, FaultyValues
from heave_node.interface.sensors import MruReading
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from heave_node.sensing.quantisation import quantised
from numpy.typing import NDArray

from wave_vessel_node.mru.oscillator import DrivenOscillator
from wave_vessel_node.parameters import MruParameters
from wave_vessel_node.vessel.motion import PITCH, ROLL, VesselMotion

_TICK_ROUNDING = 1e-6
"""A delay so little above whole ticks is one of whole ticks [ticks]."""
_TURNING = 1e-4  # rad/s: above this rate of turn the unit is disturbed
_IN_HEAVE = np.array([1.0, 0.0, 0.0, 0.0, 0.0])
"""A spike or jump is an error of heave, not of rate, acceleration, roll or pitch."""
_OF_HEAVE = np.array([1.0, 1.0, 1.0, 0.0, 0.0])
"""A scale is one of heave, its rate and acceleration, not of roll or pitch."""


class HighPass:
    """y = s^2 / (s^2 + 2 zeta omega s + omega^2) x, exact for x a cubic between steps and d held; see the module.

    Parameters
    ----------
    cut_off : omega [rad/s]; 0 lets everything pass
    damping : zeta
    period : length of a step [s]
    """

    def __init__(self, cut_off: float, damping: float, period: float) -> None:
        self._cut_off, self._damping = cut_off, damping
        self._taken = DrivenOscillator(
            cut_off, damping, value_gain=cut_off**2, rate_gain=2.0 * damping * cut_off, period=period
        )

    def reset(self, value: float, rate: float) -> None:
        """Start again at the true motion `value`, `rate`: the unit knows nothing and reads zero."""
        self._taken.start(value, rate, state=(value, rate))

    def settle(self, value: float, rate: float) -> None:
        """Begin with nothing taken away: right for a motion `value`, `rate` about zero that has been at rest."""
        self._taken.start(value, rate)

    def step(self, value: float, rate: float, acceleration_error: float = 0.0) -> tuple[float, float, float]:
        """Advance one period to the motion `value`, `rate`, with d = `acceleration_error` held.

        Returns what to subtract from value, rate and acceleration.
        """
        if self._cut_off == 0.0:
            return 0.0, 0.0, 0.0
        return self._taken.step(value, rate, -acceleration_error)


class Wander:
    """A first-order Gauss-Markov process, stationary from the start, sampled exactly.

    Parameters
    ----------
    sigma, time : its standard deviation [m] and time constant [s]
    seed, tick_period : of the run; tick_period in [s]
    """

    def __init__(self, sigma: float, time: float, *, seed: int, tick_period: float) -> None:
        self._sigma, self._decay = sigma, math.exp(-tick_period / time)
        self._random = random_stream(seed, "wave_vessel/mru/wander")
        self._value = sigma * float(self._random.standard_normal())

    def step(self) -> float:
        """Return the error of the next tick [m]."""
        if self._sigma == 0.0:
            return 0.0
        fresh = self._sigma * math.sqrt(1.0 - self._decay**2)
        self._value = self._decay * self._value + fresh * float(self._random.standard_normal())
        return self._value


def high_pass_response(omega: Array, cut_off: float, damping: float) -> NDArray[np.complex128]:
    """Return -omega^2 / (cut_off^2 - omega^2 + 2 i damping cut_off omega), the formula the unit obeys."""
    omega = np.asarray(omega, dtype=float)
    return np.asarray(-(omega**2) / (cut_off**2 - omega**2 + 2j * damping * cut_off * omega))


class MotionReferenceUnit:
    """The unit; `step` is called at every tick with the true motion of that tick, in order.

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
        self._filter = HighPass(cut_off, parameters.high_pass_damping, tick_period)
        self._ticks_between = 1 if parameters.rate == 0.0 else self._ticks_at(parameters.rate)
        self.faults = FaultSchedule(
            parameters.faults,
            name="mru",
            device="mru",
            usual_duration={"restart": parameters.restart_duration},
        )
        self._faulty_values = FaultyValues(self.faults, _IN_HEAVE, _OF_HEAVE)
        self._noise_sigma = np.array([parameters.noise, parameters.rate_noise, parameters.rate_noise, 0.0, 0.0])
        # what a stamp does not account for is late by a whole tick, as all that arrives is
        unaccounted = math.ceil(max(parameters.stamp_error, 0.0) / tick_period - _TICK_ROUNDING)
        self._late_ticks = unaccounted + round(parameters.latency / tick_period)
        self._steps = np.array([parameters.resolution, parameters.rate_resolution, 0.0, 0.0, 0.0])
        self._wander = Wander(parameters.wander, parameters.wander_time, seed=seed, tick_period=tick_period)
        self._history: deque[tuple[float, Array]] = deque(
            maxlen=1 + self._late_ticks + math.ceil(LARGEST_DELAY["mru"] / tick_period)
        )
        self._last_delivered = -math.inf
        self._sequence = 0
        self._settled_at = 0.0
        self._restarted_at = -math.inf
        self._started = False

    @property
    def reading_period(self) -> float:
        """Time between two readings [s]: the nearest whole number of ticks to 1 / rate."""
        return self._ticks_between * self._period

    def step(self, tick: int, heave: Array, motion: VesselMotion) -> MruReading | None:
        """Return the reading delivered at `tick`, or None if there is none.

        Parameters
        ----------
        tick : number of the tick; ticks come in order
        heave : true boom-tip heave about its mean, rate, acceleration at the tick, shape (3,)
        motion : true motion of the vessel at the tick
        """
        now = tick * self._period
        value, rate, acceleration = self._with_instrument_errors(heave, motion)
        if not self._started:
            self._filter.settle(value, rate)
            self._started = True
        self._restart_when_due(now, value, rate)
        of_value, of_rate, of_acceleration = self._filter.step(value, rate, self._acceleration_error(now, motion))
        attitude = (motion.displacement[ROLL], motion.displacement[PITCH])
        passed = (value - of_value, rate - of_rate, acceleration - of_acceleration)
        self._history.append((now, np.array([*passed, *attitude]) + self._wander.step() * _IN_HEAVE))
        # in every tick, whatever becomes of it: a fault changes no other reading
        noise = np.array([*self._generator.standard_normal(3).tolist(), 0.0, 0.0])
        faulty_rate = self.faults.newest("rate", now)
        if tick % (self._ticks_between if faulty_rate is None else self._ticks_at(faulty_rate)):
            return None
        self._sequence += 1
        if self.faults.is_active("restart", now) or self.faults.is_active("gap", now):
            return None
        return self._reading(now, noise)

    def _ticks_at(self, rate: float) -> int:
        """Return the ticks between two readings at `rate` [Hz]."""
        return max(1, round(1.0 / max(rate * self._period, 1e-9)))

    def _reading(self, now: float, noise: Array) -> MruReading | None:
        late = self._late_ticks + round(self.faults.total("delay", now) / self._period)
        if late >= len(self._history):
            return None
        measured_at, seen = self._history[-1 - late]
        if measured_at <= self._last_delivered:
            return None
        self._last_delivered = measured_at
        said = self._faulty_values.apply(now, seen + noise * self._noise_sigma)
        heave, heave_rate, heave_acceleration, roll, pitch = quantised(said, self._steps).tolist()
        if not self._parameters.measures_rate:
            heave_rate = heave_acceleration = math.nan
        return MruReading(
            time=measured_at + self._parameters.stamp_error,
            heave=heave,
            heave_rate=heave_rate,
            roll=roll,
            pitch=pitch,
            status=MruStatus.SETTLING if now < self._settled_at else MruStatus.OK,
            sequence=self._sequence,
            heave_acceleration=heave_acceleration,
            heave_sigma=self._parameters.noise,
            heave_rate_sigma=self._parameters.rate_noise if self._parameters.measures_rate else math.nan,
        )

    def _with_instrument_errors(self, heave: Array, motion: VesselMotion) -> list[float]:
        x, y, _ = self._parameters.lever_arm_error
        scale = 1.0 + self._parameters.scale_error
        six = (motion.displacement.tolist(), motion.velocity.tolist(), motion.acceleration.tolist())
        return [
            scale * (value - x * turned[PITCH] + y * turned[ROLL])
            for value, turned in zip(heave.tolist(), six, strict=True)
        ]

    def _acceleration_error(self, now: float, motion: VesselMotion) -> float:
        period = self._parameters.high_pass_period
        if period == 0.0:
            return 0.0
        if abs(motion.turn_rate) > _TURNING:
            self._settled_at = max(self._settled_at, now + self._parameters.settling_periods * period)
        error = self._parameters.turn_sensitivity * motion.speed * motion.turn_rate
        if self._restarted_at >= 0.0:
            error += self._parameters.restart_bias * math.exp(-(now - self._restarted_at) / period)
        return error

    def _restart_when_due(self, now: float, value: float, rate: float) -> None:
        restart = self.faults.take_begun("restart", now)
        if restart is None:
            return
        self._restarted_at = now
        self._settled_at = restart.end + self._parameters.settling_periods * self._parameters.high_pass_period
        if self._parameters.high_pass_period > 0.0:
            self._filter.reset(value, rate)
