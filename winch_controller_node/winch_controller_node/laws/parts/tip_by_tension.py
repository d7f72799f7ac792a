"""The boom tip as tension and drum tell it, above a unit that stands on the bottom.

A wire that stands answers its upper end with the tension k (s t/2) coth(s t/2), k its stiffness and t the time of a
wave down and back: resonances at n/t, hardly damped, where a winch that follows the tension as it is read rings. The
mean of the tension over t has zeros there, and is k (1 + exp(-s t))/2 times the length that is pulled. So

    mean tension over t / k + (payout now + payout t ago)/2 = (boom tip now + boom tip t ago)/2 + a constant,

the boom tip t/2 ago, whatever the winch does. A Kalman filter with the assumed sea predicts it from there.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from heave_core.law import put
from heave_core.law_table import ALONE_STATES, TENSION_ALONE, TENSION_RECORD, TENSION_TICKS
from heave_core.library import new
from heave_node.numerics.arrays import Array, ComplexArray
from heave_node.numerics.linear_model import LinearModel, output_sigma
from scipy.linalg import solve_discrete_are

from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.model.regulator import is_sea_state
from winch_controller_node.parameters.model import WinchModelParameters

GAIN_MARGIN = 2.0
"""Least gain margin of the loop, at every mode of the wire and for slow changes of tension."""

WAVE_KEPT = 0.98
"""Share of an axial wave that comes back from a unit on hard ground, at least damping: 0.3 % of critical in mode 1."""

WAVE_TIME_SHARES = (0.95, 1.0, 1.05)
"""Time of a wave over the assumed one: a stiffness 10 % off changes it so. Windows are tried at the same shares."""

RESONANCE = np.linspace(-8.0, 8.0, 49)
"""Frequencies about a resonance at which its circle in the Nyquist diagram is followed, over its half-width."""

SLOWEST = 0.02
"""Frequency below which the loop is the correction's integral alone [rad/s]."""

NOISE_SHARES = tuple(0.1 * 2.0**step for step in range(9))
"""Noise of a reading over the boom tip's standard deviation, from the least that is assumed."""

OFFSET_DRIFT = 0.02
"""Random walk of the constant in a reading [m/sqrt(s)]."""


def mean_weights(ticks: float) -> Array:
    """Return the weights of the newest readings and those before in a mean over so many `ticks`, at least 1."""
    weights = np.clip(ticks - np.arange(math.ceil(ticks)), 0.0, 1.0)
    return np.asarray(weights / weights.sum())


class TensionRecord:
    """Tension and payout of the last ticks, in the core.

    Parameters
    ----------
    longest : time that is kept [s]
    tick_period : [s]
    record : array of one `TensionRecord` of the core that it is; None: it has its own

    Raises DesignError where that does not fit.
    """

    def __init__(self, longest: float, *, tick_period: float, record: Any = None) -> None:
        ticks = math.ceil(longest / tick_period) + 1
        if ticks > TENSION_TICKS:
            raise DesignError(
                f"a wave takes {longest:g} s down the wire and back, {ticks} ticks, and {TENSION_TICKS} fit: make the "
                "tick longer"
            )
        self.record = new(TENSION_RECORD) if record is None else record
        put(self.record, {"count": 0, "kept": ticks})


def standing_wire(s: ComplexArray, wave_time: float) -> ComplexArray:
    """Return tension over stiffness and pulled length of a wire that stands, at `s` [1/s].

    Its waves need `wave_time` [s] down and back.
    """
    x = 0.5 * (wave_time * s - math.log(WAVE_KEPT))
    return np.asarray(x / np.tanh(x))


class WireLoop(NamedTuple):
    """What is between a rate command and the tension of a wire that stands."""

    stiffness: float  # of the wire [N/m]
    round_trip: float  # time of a wave down the wire and back [s]
    delay: float  # of the winch, half a tick of holding each command included [s]
    lag: float  # of the winch [s]
    tick_period: float  # [s]

    @property
    def lateness(self) -> float:
        """Time from the motion that a mean tension measures to what the winch does about it [s]."""
        return 0.5 * self.round_trip + self.delay + self.lag

    def frequencies(self, wave_time: float) -> ComplexArray:
        """Return s that show a loop in ticks over a wire whose waves take `wave_time` [s]: every resonance, and all."""
        modes = np.arange(1, max(int(0.5 * wave_time / self.tick_period), 1) + 1)
        near = (2.0 * math.pi * modes[:, np.newaxis] - math.log(WAVE_KEPT) * RESONANCE) / wave_time
        return np.asarray(1j * np.sort(np.append(near, np.geomspace(SLOWEST, math.pi / self.tick_period, 200))))

    def through_winch(self, s: ComplexArray) -> ComplexArray:
        """Return rate over rate command at `s` [1/s]."""
        return np.asarray(np.exp(-s * self.delay) / (1.0 + s * self.lag))


def wire_loop(cable: CableModel, winch: WinchModelParameters, round_trip: float, tick_period: float) -> WireLoop:
    """Return the loop over a `cable` and `winch`; `round_trip` of a wave and `tick_period` in s."""
    delay = winch.command_delay + 0.5 * tick_period
    return WireLoop(cable.stiffness, round_trip, delay, winch.time_constant, tick_period)


def standing_time_constant(loop: WireLoop) -> float:
    """Return the least time constant T of a correction by the mean tension alone, above a unit that stands [s].

    Slow changes see exp(-s d)/(s T), d the lateness of the `loop`, which is real and negative first at pi/(2 d):
    T >= 2 d m/pi for a gain margin of m.
    """
    return 2.0 * loop.lateness * GAIN_MARGIN / math.pi


def hanging_time_constant(loop: WireLoop, cable: CableModel) -> float:
    """Return the least time constant T of a correction by the mean tension alone, above a unit that hangs [s].

    The `loop` with the `cable` is a s exp(-s d)/((a s^2 + b s + 1) T): a/(b T) at the unit's resonance. Where the
    lateness d is less than a quarter of its period, that is a damping, and the loop is real and negative above it, at
    pi/(2 d).
    """
    quarter = math.pi / (2.0 * loop.lateness)
    stiff = cable.a * quarter**2
    largest = cable.a / max(cable.b, 1e-6)
    if stiff > 1.0:
        largest = min(largest, cable.a * quarter / (stiff - 1.0))
    return GAIN_MARGIN * largest


class TipByTension:
    """Foretells the boom tip's rate from tension and payout.

    The assumed noise of a reading is the least with which the loop keeps its gain margin over the wave
    equation, also where stiffness and wave's time are not quite as assumed: its Nyquist diagram cuts the real axis
    nowhere left of -1/GAIN_MARGIN. Each mode adds to it a circle through 0, the larger the less it is damped and the
    less exactly the mean is over its own period. Delay and lag of the winch turn it.

    Parameters
    ----------
    model : sampled augmented model of the design, whose waves and vessel it assumes
    loop : wire and winch
    correction : rate that is asked besides for a metre of tension over stiffness, at most [1/s]

    Attributes
    ----------
    window : over which the tension is averaged [s]
    time_constant : of the correction: one over it, or longer where the wire needs that [s]
    leftmost : where the loop's Nyquist diagram cuts the real axis furthest to the left
    """

    def __init__(self, model: LinearModel, loop: WireLoop, correction: float) -> None:
        self._loop = loop
        self._sea = np.array([model.state(name) for name in model.state_names if is_sea_state(name)])
        sea = model.select_states([model.state_names[index] for index in self._sea])
        self._tip = sea.row("boom_tip_heave")
        self._A = _with_constant(sea.A, 1.0)
        self._row = np.append(self._tip, 1.0)
        ahead = np.linalg.matrix_power(self._A, round(loop.lateness / loop.tick_period))
        self._rate: Array = np.append(sea.row("boom_tip_heave_rate"), 0.0) @ ahead
        self._design(sea, correction)

    def _design(self, sea: LinearModel, correction: float) -> None:
        """Choose the window, a `correction` [1/s] that is slow enough, and the gain."""
        trip, least = self._loop.round_trip, self._loop.tick_period
        nothing = np.zeros_like(self._row)
        windows = [max(share * trip, least) for share in WAVE_TIME_SHARES]
        self.leftmost, self.window = max((self._leftmost(nothing, correction, window), window) for window in windows)
        # the loop of the correction alone is in proportion to it, and may take half of the margin
        slower = max(1.0, -2.0 * GAIN_MARGIN * self.leftmost)
        self.time_constant, self.leftmost = slower / correction, self.leftmost / slower
        noise = _with_constant(sea.noise_covariance, OFFSET_DRIFT**2 * self._loop.tick_period)
        sigma = output_sigma(sea)["boom_tip_heave"]
        self._gain = nothing
        for share in NOISE_SHARES:
            gain = self._kalman_gain(noise, share * sigma)
            leftmost = self._leftmost(gain, correction / slower, self.window)
            if leftmost >= -1.0 / GAIN_MARGIN:
                self._gain, self.leftmost = gain, leftmost
                return

    def _kalman_gain(self, noise: Array, sigma: float) -> Array:
        """Return the stationary gain for a process `noise` and readings of `sigma` [m], shape (n + 1,)."""
        row = self._row
        P = solve_discrete_are(self._A.T, row[:, np.newaxis], noise, [[sigma**2]])
        return np.asarray(P @ row / (row @ P @ row + sigma**2))

    def _leftmost(self, gain: Array, correction: float, window: float) -> float:
        """Return where the loop cuts the real axis furthest to the left, whatever the wave's time."""
        return min(self._cut(gain, correction, window, share) for share in WAVE_TIME_SHARES)

    def _cut(self, gain: Array, correction: float, window: float, wave_share: float) -> float:
        """Return the same for a wave's time that is `wave_share` of the assumed one.

        What the drum's own motion adds to the reading is known; only the wire's further response to it comes back.
        """
        loop, trip = self._loop, self._loop.round_trip
        s = loop.frequencies(wave_share * trip)
        late = np.exp(-s * loop.tick_period)
        mean = np.polynomial.polynomial.polyval(late, mean_weights(window / loop.tick_period))
        # a stiffer wire has quicker waves
        pulled = mean * standing_wire(s, wave_share * trip) / wave_share**2
        foreseen = 0.5 * (1.0 + late ** round(trip / loop.tick_period))
        asked = self._asked(gain, s) * (pulled - foreseen) + correction * pulled
        L = asked * loop.through_winch(s) / s
        cuts = np.flatnonzero(L.imag[:-1] * L.imag[1:] <= 0.0)
        return float(min(0.0, *L.real[cuts], *L.real[cuts + 1]))

    def _asked(self, gain: Array, s: ComplexArray) -> ComplexArray:
        """Return rate over reading at `s` [1/s]: x(k) = (I - g c) A x(k-1) + g y(k)."""
        kept = (np.eye(len(gain)) - np.outer(gain, self._row)) @ self._A
        poles, vectors = np.linalg.eig(kept)
        residues = (self._rate @ vectors) * np.linalg.solve(vectors, gain.astype(complex))
        late = np.exp(-s * self._loop.tick_period)
        return np.asarray((residues / (1.0 - np.outer(late, poles))).sum(axis=1))

    def tell(self, core: Any) -> None:
        """Tell `core`, an array of one `TensionAlone`, all of it."""
        loop, weights = self._loop, mean_weights(self.window / self._loop.tick_period)
        count = len(self._row)
        if count > ALONE_STATES:
            raise DesignError(f"the sea has {count - 1} states, and {ALONE_STATES - 1} fit: lower sea.filter_states")
        values = {
            "states": count,
            "window": len(weights),
            "trip": round(loop.round_trip / loop.tick_period),
            "sea": self._sea,
            "weights": weights,
            "A": self._A.ravel(),
            "row": self._row,
            "rate": self._rate,
            "gain": self._gain,
            "x": np.zeros(count),
            "stiffness": loop.stiffness,
        }
        put(core, values)


def _with_constant(matrix: Array, value: float) -> Array:
    """Return a matrix, shape (n, n), with one more state of which `value` is its own entry, shape (n + 1, n + 1)."""
    larger = np.zeros((len(matrix) + 1, len(matrix) + 1))
    larger[:-1, :-1], larger[-1, -1] = matrix, value
    return larger


class TensionAlone:
    """Follows the boom tip as tension and drum tell it, and corrects by the mean tension.

    Above a unit that hangs they do not tell it, and the correction is left.

    Parameters
    ----------
    model : sampled augmented model of the design
    cable : stiffness, and what a hanging unit does; winch : delay, lag and speed
    round_trip : time of a wave down the cable and back [s]
    time_constant : of the correction; the least, which delay and wire may lengthen [s]
    """

    def __init__(
        self,
        model: LinearModel,
        cable: CableModel,
        winch: WinchModelParameters,
        round_trip: float,
        time_constant: float,
    ) -> None:
        assert model.dt is not None
        loop = wire_loop(cable, winch, round_trip, model.dt)
        self.largest = winch.speed_limit  # speed of the correction [m/s]
        # the boom tip as tension and drum tell it
        self.tip = TipByTension(model, loop, 1.0 / max(time_constant, standing_time_constant(loop)))
        self.standing = self.tip.time_constant  # time constant of the correction above a unit that stands [s]
        # time constant of the correction above a unit that hangs [s]
        self.hanging = max(time_constant, hanging_time_constant(loop, cable))
        self.core = new(TENSION_ALONE)  # array of one `TensionAlone` of the core
        self.tip.tell(self.core)
        put(self.core, {"standing": self.standing, "hanging": self.hanging})
