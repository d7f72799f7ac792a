"""A deviation from the nominal, and a row of the table that draws it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache

from heave_bringup.scenarios import load_scenario

from tests.campaigns.draws.chance import Chance

Settings = Mapping[str, object]

BELIEF = "winch_controller"
"""Node whose parameters an informed controller gets."""


@dataclass(frozen=True)
class Nominal:
    """What the scenario of a draw has.

    Attributes
    ----------
    name : of the scenario
    speed, acceleration, lag, delay : of the winch [m/s], [m/s^2], [s], [s]
    tension : at rest, at the boom tip [N]
    stiffness : EA of the cable [N]
    mass, volume, added_mass, drag : of the unit [kg], [m^3], [kg], coefficient
    height, period : of the sea [m], [s]
    has_swell : the sea has two parts
    """

    name: str
    speed: float
    acceleration: float
    lag: float
    delay: float
    tension: float
    stiffness: float
    mass: float
    volume: float
    added_mass: float
    drag: float
    height: float
    period: float
    has_swell: bool


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
    """A scheduled fault of a device.

    Attributes
    ----------
    group : parameters in which it stands
    kind, start, duration, magnitude : see `heave_node.interface.faults`
    """

    group: str
    kind: str
    start: float
    duration: float
    magnitude: float


@dataclass(frozen=True)
class Deviation:
    """One thing that differs.

    Attributes
    ----------
    name : of the row
    settings : of the simulated ship
    told : parameters of an informed controller; empty: nothing helps; None: it has no parameter for that
    faults : scheduled besides
    excused : times, from and to, that are not judged [s]: the fault has just begun or ended, or a stop is requested
    actions : of an operator: time [s], what, value
    """

    name: str
    settings: Settings = field(default_factory=dict)
    told: Settings | None = None
    faults: tuple[Fault, ...] = ()
    excused: tuple[tuple[float, float], ...] = ()
    actions: tuple[tuple[float, str, float], ...] = ()


Drawing = Callable[[Chance, Nominal], Deviation]


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Attributes
    ----------
    name : what differs
    parts : what a finding may blame for it
    draw : draws it
    slot : of rows with the same slot a draw has one at most; empty: the row has one to itself
    weight : how often it is drawn, over the others
    """

    name: str
    parts: tuple[str, ...]
    draw: Drawing
    slot: str = ""
    weight: float = 1.0
