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
    # parameters of an informed controller; empty: nothing helps; None: it has no parameter for that
    told: Settings | None = None
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
    weight: float = 1.0  # how often it is drawn, over the others
