"""Set signals of a winch under test: the payout rate that is ordered, as a function of time. Pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from wave_vessel_node.sea.spectra import Bretschneider

STREAM = "accept/sea"
"""Name of the random stream of the phases of an irregular sea."""
COMPONENTS = 200
"""Sine waves of an irregular sea: it repeats itself only after twice its duration."""


@dataclass(frozen=True)
class SetSignal:
    """What a winch is ordered to do."""

    duration: float  # [s]
    rate: Callable[[Array], Array]  # ordered payout rate [m/s] at times from 0 [s], shapes (n,); positive pays out
    words: str  # what it is, for people
    is_braked: bool = False  # the brake is requested all the time


def steps(speeds: Sequence[float], hold: float) -> SetSignal:
    """Return ordered `speeds` one after the other [m/s], each for `hold` [s]."""
    values = np.asarray(speeds, dtype=float)

    def rate(time: Array) -> Array:
        places = np.minimum((time / hold + 1e-9).astype(int), values.size - 1)
        return np.asarray(values[places])

    words = f"steps to {', '.join(f'{speed:g}' for speed in speeds)} m/s, {hold:g} s each"
    return SetSignal(values.size * hold, rate, words)


def ramp(speed: float, acceleration: float, hold: float) -> SetSignal:
    """Return a ramp to a `speed` [m/s] at an `acceleration` [m/s^2], held for `hold` [s], and down; then the way back.

    The drum rests for `hold` between the two ways.
    """
    rise = abs(speed) / acceleration
    corners = np.cumsum([0.0, rise, hold, rise, hold, rise, hold, rise])
    values = np.array([0.0, speed, speed, 0.0, 0.0, -speed, -speed, 0.0])
    words = f"ramps at {acceleration:g} m/s^2 to {speed:g} m/s and back"
    return SetSignal(float(corners[-1]) + hold, lambda time: np.interp(time, corners, values), words)


def sine(amplitude: float, period: float, cycles: float) -> SetSignal:
    """Return a payout of `amplitude` [m] at a `period` [s], over so many `cycles`, faded in over the first one."""
    omega = 2.0 * math.pi / period

    def rate(time: Array) -> Array:
        return np.minimum(time / period, 1.0) * amplitude * omega * np.cos(omega * time)

    return SetSignal(cycles * period, rate, f"sine of {amplitude:g} m at {period:g} s")


def sweep(speed: float, longest: float, shortest: float, duration: float) -> SetSignal:
    """Return a sine of the rate, of amplitude `speed` [m/s], over a `duration` [s].

    Its period falls evenly in its logarithm from the `longest` to the `shortest` [s].
    """
    first, growth = 1.0 / longest, math.log(longest / shortest) / duration
    words = f"sine sweep of {speed:g} m/s from {longest:g} to {shortest:g} s"
    if growth == 0.0:
        return SetSignal(duration, lambda time: speed * np.sin(2.0 * math.pi * first * time), words)
    scale = 2.0 * math.pi * first / growth
    return SetSignal(duration, lambda time: speed * np.sin(scale * np.expm1(growth * time)), words)


def sea(height: float, period: float, duration: float, seed: int = 1) -> SetSignal:
    """Return a payout that follows a boom tip which moves as the surface of a Bretschneider sea does.

    Its significant `height` [m], peak `period` [s] and `duration` [s] are given, and the `seed` of its phases.
    """
    spectrum = Bretschneider(height, period)
    peak = spectrum.peak_frequency
    step = min(math.pi / duration, 4.0 * peak / COMPONENTS)
    omega = np.arange(0.4 * peak, 4.0 * peak, step)
    heights = np.sqrt(2.0 * spectrum.density(omega) * step)
    phases = random_stream(seed, STREAM).uniform(0.0, 2.0 * math.pi, omega.size)

    def rate(time: Array) -> Array:
        fade = np.minimum(time / period, 1.0)
        return np.asarray(fade * -(heights * omega * np.sin(np.outer(time, omega) + phases)).sum(axis=1))

    return SetSignal(duration, rate, f"irregular sea of Hs {height:g} m, Tp {period:g} s")


def hold(duration: float) -> SetSignal:
    """Return a drum that is held at rest by its drive, brake off, for a `duration` [s]."""
    return SetSignal(duration, np.zeros_like, f"held by the drive for {duration:g} s")


def brake(duration: float) -> SetSignal:
    """Return a drum that is held by its brake for a `duration` [s]."""
    return SetSignal(duration, np.zeros_like, f"held by the brake for {duration:g} s", is_braked=True)


@dataclass(frozen=True)
class SignalKind:
    """A kind of set signal."""

    make: Callable[..., SetSignal]  # makes it
    arguments: Mapping[str, str]  # of that, each with its dimension
    defaults: Mapping[str, float]  # of some of them


KINDS: Mapping[str, SignalKind] = {
    "steps": SignalKind(steps, {"speeds": "speed", "hold": "time"}, {}),
    "ramp": SignalKind(ramp, {"speed": "speed", "acceleration": "acceleration", "hold": "time"}, {"hold": 2.0}),
    "sine": SignalKind(sine, {"amplitude": "length", "period": "time", "cycles": "number"}, {"cycles": 5.0}),
    "sweep": SignalKind(
        sweep, {"speed": "speed", "longest": "time", "shortest": "time", "duration": "time"}, {"duration": 60.0}
    ),
    "sea": SignalKind(
        sea,
        {"height": "length", "period": "time", "duration": "time", "seed": "number"},
        {"duration": 120.0, "seed": 1},
    ),
    "hold": SignalKind(hold, {"duration": "time"}, {}),
    "brake": SignalKind(brake, {"duration": "time"}, {}),
}
"""Kinds of set signals by the name that a procedure gives them."""


COMMAND_LOSS, BRAKE = "command_loss", "brake"
"""Events that the test does itself, to a virtual and to a real winch: it sends nothing more, or requests the brake."""


@dataclass(frozen=True)
class WinchTest:
    """A winch by itself: the `signal` that it is ordered to follow, under a `load` [N]."""

    signal: SetSignal
    load: float = 0.0


@dataclass(frozen=True)
class Event:
    """What is done to a part during a step."""

    device: str  # name of it
    fault: str  # kind of fault (`heave_node.interface.faults`), COMMAND_LOSS or BRAKE
    at: float  # [s]
    duration: float = 0.0  # [s]; 0: to the end
    magnitude: float = 0.0  # in the unit of its kind
    ask: str = ""  # what a person does where the part is real; "": the test does it itself

    @property
    def words(self) -> str:
        """What happens, in a line."""
        return f"{self.device}: {self.fault.replace('_', ' ')} at {self.at:g} s"
