"""The waves of the running sea, as sea and vessel hand them to the plant: long-crested components in deep water."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from heave_node.numerics.arrays import Array

MOST_COMPONENTS = 20_000
"""More than a sea is ever drawn with: an array that is longer is refused."""


@dataclass(frozen=True)
class Waves:
    """Components of a sea about the origin of frame `world`, as in heave_msgs/WaveComponents.

    Elevation at (x, y), a time t after `start`, is r(t) times the sum of a cos(omega_e t - k (x cos d + y sin d) +
    phase), k = omega^2/g and r the `smooth_ramp`.

    Raises ValueError where arrays differ in length or are too long, or a number is not one of a wave.
    """

    frequency: Array  # omega in still water [rad/s], shape (n,), above 0
    encounter_frequency: Array  # omega_e, as met in `world`, which travels with the vessel [rad/s], shape (n,)
    amplitude: Array  # a [m], shape (n,)
    phase: Array  # at `start` [rad], shape (n,)
    direction: Array  # d that the component travels to, from world x towards y [rad], shape (n,)
    start: float = 0.0  # simulated time from which t counts, and at which the ramp begins [s]
    ramp: float = 0.0  # its duration [s]; 0: there is none

    def __post_init__(self) -> None:
        lengths = {len(column) for column in self.columns}
        if len(lengths) > 1 or max(lengths) > MOST_COMPONENTS:
            raise ValueError(
                f"wave components need columns of one length, at most {MOST_COMPONENTS}; got {sorted(lengths)}"
            )
        if not all(np.isfinite(column).all() for column in (*self.columns, [self.start, self.ramp])):
            raise ValueError("wave components hold numbers that are not finite")
        if self.ramp < 0.0 or np.any(self.frequency <= 0.0):
            raise ValueError("wave components need frequencies above 0, and a ramp that is not negative")

    @property
    def columns(self) -> tuple[Array, Array, Array, Array, Array]:
        """Frequency, encounter frequency, amplitude, phase and direction."""
        return self.frequency, self.encounter_frequency, self.amplitude, self.phase, self.direction


_NONE = np.zeros(0)
NO_WAVES = Waves(_NONE, _NONE, _NONE, _NONE, _NONE)
"""Still water, and what is published of a sea that has no components, or none that last."""


def from_start(waves: Waves, start: float, ramp: float) -> Waves:
    """Return `waves` whose times count from 0 as ones that count from `start` [s], with a `ramp` [s] from there on."""
    start = round(start * 1e9) * 1e-9  # as a stamp carries it
    return replace(waves, phase=waves.phase + waves.encounter_frequency * start, start=start, ramp=ramp)
