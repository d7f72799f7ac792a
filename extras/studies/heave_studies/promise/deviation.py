"""A deviation from the nominal, a row of the table that draws it, and what chance gives."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TypeVar

import numpy as np
from heave_bringup.scenarios import load_scenario

Item = TypeVar("Item")


class Chance:
    """A stream of random numbers; the same for the same keys on every machine.

    Parameters
    ----------
    keys : whole numbers or words
    """

    def __init__(self, *keys: int | str) -> None:
        self.random = np.random.default_rng([zlib.crc32(key.encode()) if isinstance(key, str) else key for key in keys])

    def between(self, low: float, high: float) -> float:
        """Return a number of an even distribution from `low` to `high`."""
        return _short(float(self.random.uniform(low, high)))

    def spread(self, low: float, high: float) -> float:
        """Return a number whose logarithm has an even distribution, from `low` to `high`, both above 0."""
        return _short(math.exp(float(self.random.uniform(math.log(low), math.log(high)))))

    def beside(self, low: float, high: float, width: float, middle: float = 1.0) -> float:
        """Return a number of an even distribution, `low` to `high`, that is at least a `width` from the `middle`."""
        while True:
            value = self.between(low, high)
            if abs(value - middle) >= width:
                return value

    def happens(self, share: float) -> bool:
        """Return True in a `share` of the calls."""
        return bool(self.random.random() < share)

    def sign(self) -> float:
        """Return 1 or -1."""
        return 1.0 if self.happens(0.5) else -1.0

    def one_of(self, items: Sequence[Item], weights: Sequence[float] | None = None) -> Item:
        """Return one of the `items`, each as often as its weight says; without weights, all alike."""
        shares = None if weights is None else np.array(weights) / sum(weights)
        return items[int(self.random.choice(len(items), p=shares))]

    def number(self, low: int, high: int) -> int:
        """Return a whole number from `low` to `high`, both included."""
        return int(self.random.integers(low, high + 1))


def _short(value: float) -> float:
    """Return a number that can be read: six digits."""
    return float(f"{value:.6g}")


Settings = Mapping[str, object]

BELIEF = "winch_controller"
"""Node of the controller."""
TROUBLE = 30.0
"""Time after the beginning of compensation, or of a fault, from which on minutes are judged [s]."""


@dataclass(frozen=True)
class Nominal:
    """What the scenario of a draw has."""

    name: str  # of the scenario
    speed: float  # of the winch [m/s]
    acceleration: float  # of the winch [m/s^2]
    lag: float  # of the winch [s]
    delay: float  # of the winch [s]
    tension: float  # at rest, at the boom tip [N]
    stiffness: float  # EA of the cable [N]
    mass: float  # of the unit [kg]
    volume: float  # of the unit [m^3]
    added_mass: float  # of the unit [kg]
    drag: float  # coefficient of the unit [-]
    height: float  # of the sea [m]
    period: float  # of the sea [s]
    has_swell: bool  # the sea has two parts


@cache
def nominal(scenario: str) -> Nominal:
    """Return what the shipped `scenario` has."""
    belief = load_scenario(scenario).parameters[BELIEF]
    winch, unit, cable, sea = belief.winch, belief.unit, belief.cable, belief.sea
    density = belief.water_density
    return Nominal(
        name=scenario,
        speed=winch.speed_limit,
        acceleration=winch.acceleration_limit,
        lag=winch.time_constant,
        delay=winch.command_delay,
        tension=unit.weight_in_fluid(density) + belief.length * cable.weight_in_fluid(density),
        stiffness=cable.axial_stiffness,
        mass=unit.mass,
        volume=unit.volume,
        added_mass=unit.added_mass[2],
        drag=unit.drag_coefficient[2],
        height=sea.significant_wave_height,
        period=sea.peak_period,
        has_swell=sea.spectrum == "ochi_hubble",
    )


@dataclass(frozen=True)
class Fault:
    """A scheduled fault of a device."""

    group: str  # parameters in which it stands
    kind: str  # see `heave_node.interface.faults`
    start: float  # see `heave_node.interface.faults`
    duration: float  # see `heave_node.interface.faults`
    magnitude: float  # see `heave_node.interface.faults`


@dataclass(frozen=True)
class Deviation:
    """One thing that differs."""

    name: str  # of the row
    settings: Settings = field(default_factory=dict)  # of the simulated ship
    faults: tuple[Fault, ...] = ()  # scheduled besides
    # times, from and to, that are not judged [s]: the fault has just begun or ended, or a stop is requested
    excused: tuple[tuple[float, float], ...] = ()
    actions: tuple[tuple[float, str, float], ...] = ()  # of an operator: time [s], what, value


Drawing = Callable[[Chance, Nominal], Deviation]


@dataclass(frozen=True)
class Row:
    """A row of the table."""

    name: str  # what differs
    parts: tuple[str, ...]  # what a finding may blame for it
    draw: Drawing  # draws it
    slot: str = ""  # of rows with the same slot a draw has one at most; empty: the row has one to itself
    weight: float = 1.0  # how often it is drawn, over the others [-]


GROUPS = {
    "mru": "wave_vessel.mru",
    "depth": "cable_sim.sensors.depth",
    "load_cell": "cable_sim.sensors.load_cell",
    "encoder": "virtual_winch.encoder",
}
"""Node and group of each sensor's faults, by the controller's name of it."""

KINDS = ("scale", "scale", "freeze", "jump", "nan", "spike", "gap", "delay", "restart")
"""A scale error is drawn twice as often: no sample shows it."""

LOST_KINDS = ("freeze", "nan", "gap", "restart")
"""Kinds that leave nothing to read."""

NOT_OF = {"encoder": ("gap", "delay", "restart"), "depth": ("restart",), "load_cell": ("restart",)}
"""Kinds that a sensor cannot have."""


def drawn_fault(random: np.random.Generator) -> tuple[str, str, float]:
    """Return which sensor is at fault, how, and the magnitude of that, by `random` numbers."""
    sensor = str(random.choice(list(GROUPS)))
    kind = str(random.choice([kind for kind in KINDS if kind not in NOT_OF.get(sensor, ())]))
    sign = -1.0 if random.random() < 0.3 else 1.0
    magnitude = {
        "scale": sign * math.exp(random.uniform(math.log(0.3), math.log(3.0))),
        "jump": sign * random.uniform(0.05, 3.0) * (1e4 if sensor == "load_cell" else 1.0),
        "spike": sign * random.uniform(0.05, 30.0) * (1e4 if sensor == "load_cell" else 1.0),
        "delay": random.uniform(0.05, 3.0),
    }.get(kind, 0.0)
    return sensor, kind, round(float(magnitude), 3)
