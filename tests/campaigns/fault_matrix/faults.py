"""The faults of the matrix: each kind of each device, how it is drawn, what an alarm has to name, when it shows."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from heave_node.interface.fault_kinds import faults_of
from heave_studies.promise.deviation import Chance

ALWAYS, MOVING, FASTER, RESTING, NEVER = "always", "moving", "faster", "resting", "never"
"""When a fault shows: at once; once the drum has moved, or was to move; once it was to move faster than it still can;
once the brake holds; not from inside."""

Drawing = Callable[[Chance], float]


def nothing(_: Chance) -> float:
    """Draw no magnitude."""
    return 0.0


def spread(low: float, high: float) -> Drawing:
    """Return how a magnitude is drawn, even in its logarithm."""
    return lambda chance: chance.spread(low, high)


def either(low: float, high: float) -> Drawing:
    """Return how a magnitude of either sign is drawn, even in its logarithm."""
    return lambda chance: chance.sign() * chance.spread(low, high)


def factor(chance: Chance) -> float:
    """Draw a scale error: reversed in a third of the draws, else 0.3 to 3, at least a quarter off."""
    if chance.happens(0.3):
        return -chance.spread(0.5, 2.0)
    while True:
        value = chance.spread(0.3, 3.0)
        if abs(math.log(value)) >= 0.25:
            return value


@dataclass(frozen=True)
class Kind:
    """A row of the table of faults."""

    device: str  # of the fault
    kind: str  # of the fault
    parts: tuple[str, ...]  # one of these an alarm has to name
    shows: str = ALWAYS  # when
    magnitude: Drawing = nothing  # how it is drawn
    lasts: bool = False  # never ends by itself

    @property
    def name(self) -> str:
        """Device and kind."""
        return f"{self.device} {self.kind}"


NOT_DRAWN = ("clear", "jitter")
"""Kinds that the matrix has no row for: one is no fault, the other came after the seeds of its cases were used."""


def _of_sensor(device: str, known: str, unit: float) -> list[Kind]:
    """Return the faults of a sensor; steps count in so many of its `unit`."""
    drawings = {
        "spike": either(0.5 * unit, 10.0 * unit),
        "jump": either(0.5 * unit, 10.0 * unit),
        "scale": factor,
        "rate": spread(0.2, 2.0),
        "delay": spread(0.5, 3.0),
    }
    hidden = ("freeze", "scale") if device == "encoder" else ()  # at rest a count shows neither
    return [
        Kind(device, kind, (device,), MOVING if kind in hidden else ALWAYS, drawings.get(kind, nothing))
        for kind in faults_of(known)
        if kind not in NOT_DRAWN
    ]


_WINCH: dict[str, tuple[str, Drawing]] = {
    "gap": (MOVING, nothing),
    "delay": (MOVING, spread(0.2, 1.5)),
    "drive": (ALWAYS, nothing),
    "emergency_stop": (ALWAYS, nothing),
    "reverse": (MOVING, nothing),
    "brake_slip": (RESTING, spread(0.02, 0.2)),
    "brake_open": (RESTING, spread(0.02, 0.2)),
    "brake_shut": (MOVING, nothing),
    "creep": (MOVING, spread(0.02, 0.1)),
    "low_pressure": (FASTER, spread(0.02, 0.2)),
}

KINDS: tuple[Kind, ...] = (
    *_of_sensor("mru", "mru", 1.0),
    *_of_sensor("encoder", "encoder", 1.0),
    *_of_sensor("depth", "sensor", 1.0),
    *_of_sensor("load_cell", "sensor", 1e5),
    *(Kind("winch", kind, ("winch",), *_WINCH[kind]) for kind in faults_of("winch") if kind not in NOT_DRAWN),
    Kind("orders", "nan", ("orders",)),
    Kind("orders", "reversed", ("winch", "encoder"), MOVING),
    Kind("orders", "factor", ("winch", "encoder"), MOVING, spread(3.0, 100.0)),
    Kind("orders", "stuck", ("winch", "encoder"), MOVING),
    Kind("clock", "mru", ("mru",), ALWAYS, either(0.3, 30.0)),
    Kind("clock", "depth", ("depth",), ALWAYS, either(0.5, 30.0)),
    Kind("clock", "winch", ("encoder", "winch"), ALWAYS, either(0.5, 30.0)),
    Kind("node", "wave_vessel", ("mru",)),
    Kind("node", "cable_sim", ("depth", "load_cell")),
    Kind("node", "virtual_winch", ("encoder", "winch"), MOVING),
    Kind("node", "winch_controller", ("winch",), MOVING),
    Kind("node", "stalled", ("loop", "winch"), NEVER, spread(0.15, 3.0)),
    Kind("adviser", "ends", ("adviser",), NEVER, lasts=True),
    Kind("adviser", "late", ("adviser",), NEVER, lasts=True),
    Kind("adviser", "nan", ("adviser", "orders"), NEVER, lasts=True),
    Kind("adviser", "encoder_scale", ("adviser", "encoder"), MOVING, spread(0.05, 0.6), lasts=True),
    Kind("adviser", "speed_gain", ("adviser", "winch"), MOVING, spread(0.1, 0.6), lasts=True),
    Kind("adviser", "command_delay", ("adviser", "winch"), MOVING, spread(0.5, 1.0), lasts=True),
    Kind("adviser", "inertia", ("adviser", "cable"), MOVING, spread(2.0, 8.0), lasts=True),
    Kind("adviser", "mru_scale", ("adviser", "mru"), MOVING, factor, lasts=True),
    Kind("adviser", "excluded", ("adviser", "mru", "depth"), MOVING, lasts=True),
)
"""All of them; `orders` are spoilt on their way to the drive, as by a link, a PLC or a drum that runs away."""

BY_NAME = {kind.name: kind for kind in KINDS}


@dataclass(frozen=True)
class Fault:
    """A fault that is drawn."""

    name: str  # of its kind
    magnitude: float = 0.0  # in the unit of its kind
    duration: float = 0.0  # [s]; 0: to the end

    @property
    def kind(self) -> Kind:
        """Row of the table."""
        return BY_NAME[self.name]

    @property
    def words(self) -> str:
        """Return it in words."""
        size = f" {self.magnitude:.3g}" if self.magnitude else ""
        return f"{self.name}{size}{f' for {self.duration:.3g} s' if self.duration else ''}"


def drawn(kind: Kind, chance: Chance) -> Fault:
    """Draw a fault of a `kind`: half of them end by themselves."""
    magnitude = kind.magnitude(chance)
    if kind.name == "node stalled":
        return Fault(kind.name, 0.0, magnitude)
    ends = chance.happens(0.5) and not kind.lasts
    return Fault(kind.name, magnitude, chance.spread(1.0, 30.0) if ends else 0.0)
