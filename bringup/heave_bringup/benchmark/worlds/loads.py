"""The load of a problem without a cable model: it hangs on a rope that does not stretch and weighs nothing.

While the rope is taut the load moves with it: unit = boom tip - payout. A rope cannot push: where that would need it,
the load falls, or stands on the bottom, until the rope comes taut again; what relative speed there is then is lost.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from heave_node.numerics.compiled import inner_kernel, kernel
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY

LONGEST_SUBSTEP = 1e-3
"""Inner step of a falling or standing load [s]."""


class Kinematics(NamedTuple):
    """Motion of the rope's lower end, positive up.

    Attributes
    ----------
    position, speed, acceleration : [m], [m/s], [m/s^2]
    """

    position: float
    speed: float
    acceleration: float


@dataclass(frozen=True)
class LoadState:
    """State of the load.

    Attributes
    ----------
    heave, rate : of the unit, from where it starts, positive up [m], [m/s]
    tension : in the rope [N]
    bottom_force : of the bottom on the unit, upwards [N]
    """

    heave: float
    rate: float
    tension: float
    bottom_force: float = 0.0


class Load(Protocol):
    """A load on a rope."""

    @property
    def state(self) -> LoadState:
        """State now."""
        ...

    def step(self, end: Kinematics, duration: float) -> None:
        """Move the rope's lower end to `end` within `duration` [s]."""
        ...


class CarriedLoad:
    """A load whose inertia is the drive's business: the rope feels a constant tension.

    Parameters
    ----------
    tension : [N]
    start : of the rope's lower end
    """

    def __init__(self, tension: float, start: Kinematics) -> None:
        self._tension = tension
        self.state = LoadState(start.position, start.speed, tension)

    def step(self, end: Kinematics, duration: float) -> None:
        """See `Load.step`. The load moves with the rope."""
        del duration
        self.state = LoadState(end.position, end.speed, self._tension)


class WetLoad(NamedTuple):
    """A load in water: mass [kg], weight in water [N], drag force per speed squared [N s^2/m^2], height above the
    bottom at the start [m] (infinite: no bottom), contact force stiffness d + damping d' sqrt(d): [N/m], [N s/m^1.5].
    """

    mass: float
    weight: float
    drag: float
    height: float
    stiffness: float
    damping: float


def mas409_load(height: float) -> WetLoad:
    """Return the payload and travelling block of course MAS409 (University of Agder), `height` above the bottom [m].

    12 t and 600 kg, 2 m^3, 1.5 m^2 at C_d 1.8; contact 1.8e6 d + 6.5e5 d' sqrt(d). Added mass is not part of it.
    """
    mass = 12_600.0
    weight = (mass - SEAWATER_DENSITY * 2.0) * STANDARD_GRAVITY
    return WetLoad(mass, weight, 0.5 * SEAWATER_DENSITY * 1.8 * 1.5, height, 1.8e6, 6.5e5)


class HangingLoad:
    """A load in water on a rope, with a bottom below it.

    Parameters
    ----------
    load : its numbers
    start : of the rope's lower end
    """

    def __init__(self, load: WetLoad, start: Kinematics) -> None:
        self._load = load
        self._end = start
        self.state = LoadState(start.position, start.speed, load.weight)

    def step(self, end: Kinematics, duration: float) -> None:
        """See `Load.step`."""
        substeps = max(1, math.ceil(duration / LONGEST_SUBSTEP - 1e-9))
        before = self.state
        heave, rate, tension, force = _advance(
            self._load, before.heave, before.rate, self._end, end, duration / substeps, substeps
        )
        self._end = end
        self.state = LoadState(heave, rate, tension, force)


@inner_kernel
def _contact(load: WetLoad, z: float, w: float) -> float:
    """Return the force of the bottom at heave z and rate w [N], never a pull."""
    depth = -load.height - z
    return max(load.stiffness * depth - load.damping * w * math.sqrt(depth), 0.0) if depth > 0.0 else 0.0


@inner_kernel
def _between(a: Kinematics, b: Kinematics, s: float, duration: float) -> tuple[float, float, float]:
    """Return the rope's lower end at the share s of the way: cubic in position, straight in acceleration."""
    h00, h10 = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * (1.0 - s) ** 2
    h01, h11 = s * s * (3.0 - 2.0 * s), s * s * (s - 1.0)
    position = h00 * a.position + h10 * duration * a.speed + h01 * b.position + h11 * duration * b.speed
    slope = 6.0 * s * (1.0 - s) * (b.position - a.position) / duration
    speed = slope + (1.0 - s) * (1.0 - 3.0 * s) * a.speed + s * (3.0 * s - 2.0) * b.speed
    return position, speed, a.acceleration + s * (b.acceleration - a.acceleration)


@kernel
def _advance(
    load: WetLoad, z: float, w: float, a: Kinematics, b: Kinematics, h: float, substeps: int
) -> tuple[float, float, float, float]:
    """Advance the load (semi-implicit Euler while the rope is slack); return heave, rate, tension, bottom's force."""
    tension = force = 0.0
    taut = z <= a.position
    for i in range(1, substeps + 1):
        position, speed, acceleration = _between(a, b, i / substeps, h * substeps)
        force = _contact(load, position, speed)
        tension = load.weight + load.mass * acceleration + load.drag * abs(speed) * speed - force
        if taut and tension > 0.0:
            z, w = position, speed
            continue
        tension = 0.0
        force = _contact(load, z, w)
        w += h * (force - load.weight - load.drag * abs(w) * w) / load.mass
        z += h * w
        taut = z <= position
        if taut:
            z, w = position, max(w, speed)
    return z, w, tension, force
