"""The winches of a sizing study: the scenario's own, and sweeps of one particular at a time about it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import pandas
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.parameters import ParameterError

SPEED, ACCELERATION, POWER, DELAY = "speed", "acceleration", "power", "delay"


@dataclass(frozen=True)
class Particular:
    """A particular of a winch that a buyer pays for."""

    name: str  # of it
    place: str  # of its parameter, for the winch and for the controller's belief of it
    unit: str  # in which people see it
    shares: tuple[float, ...]  # of the scenario's value, tried where none are given
    scale: float = 1.0  # that unit over the SI unit
    costs_when_small: bool = False  # a small value is the dear one, as of a delay

    def text(self, value: float) -> str:
        """Return a `value` as people see it."""
        return "no limit" if math.isinf(value) else f"{self.scale * value:.3g}"

    @property
    def heading(self) -> str:
        """Its name with the unit."""
        return f"{self.name} [{self.unit}]"


PARTICULARS = (
    Particular(SPEED, "system.winch.speed_limit", "m/s", (0.3, 0.5, 0.75)),
    Particular(ACCELERATION, "system.winch.acceleration_limit", "m/s^2", (0.3, 0.5, 0.75)),
    Particular(POWER, "system.winch.power_limit", "kW", (0.1, 0.2, 0.4), scale=1e-3),
    Particular(DELAY, "system.winch.command_delay", "s", (2.0, 4.0), costs_when_small=True),
)
"""Particulars in the order of `Candidate.values`; shares of power refer to static tension times speed limit."""

STOP = "virtual_winch.stop_deceleration"
"""Place of the deceleration of a stop, which cannot be above the acceleration limit."""

PLACES = (*(particular.place for particular in PARTICULARS), STOP)


@dataclass(frozen=True)
class Candidate:
    """A winch that one might buy."""

    speed: float  # its limit [m/s]; infinite: none
    acceleration: float  # its limit [m/s^2]; infinite: none
    power: float  # its limit [W]; infinite: none
    delay: float  # of its commands [s]
    sweep: str = ""  # name of the particular in which it differs from the scenario's own winch; "" is that one

    def value(self, particular: Particular) -> float:
        """Return its value of a `particular`."""
        return float(getattr(self, particular.name))

    @property
    def title(self) -> str:
        """What it is called: by what it differs in."""
        for particular in PARTICULARS:
            if particular.name == self.sweep:
                return f"{particular.name} {particular.text(self.value(particular))} {particular.unit}".strip()
        return "the scenario's"


def own_winch(winch: WinchParameters) -> Candidate:
    """Return the winch of a scenario as a candidate; raises ParameterError for a drive that has no such limits."""
    if winch.drive != "speed_servo":
        raise ParameterError(
            f"virtual_winch.drive = {winch.drive}: its limits follow from its physics; a study of sizes needs "
            "--set virtual_winch.drive=speed_servo"
        )
    return Candidate(winch.speed_limit, winch.acceleration_limit, winch.power_limit or math.inf, winch.command_delay)


def candidates(own: Candidate, static_tension: float, given: Mapping[str, Sequence[float] | None]) -> list[Candidate]:
    """Return the winches to be tried: the scenario's own first, then the sweeps.

    Parameters
    ----------
    own : winch of the scenario
    static_tension : at the top [N]; with the speed limit it gives the powers that are tried
    given : values by name of the particular, SI units; None takes shares of the scenario's, an empty list none

    Raises ParameterError for a value that is not above 0.
    """
    found = [own]
    for particular in PARTICULARS:
        values = given.get(particular.name)
        if values is None:
            whole = static_tension * own.speed if particular.name == POWER else own.value(particular)
            values = [share * whole for share in particular.shares if whole > 0.0]
        least = 0.0 if particular.name == DELAY else math.ulp(0.0)
        for value in values:
            if not least <= value < math.inf:
                raise ParameterError(
                    f"ask: {particular.name} = {value:g}: must be a number above 0 [{particular.unit}]"
                )
        others = sorted(set(values) - {own.value(particular)})
        found += [replace(own, **{particular.name: value}, sweep=particular.name) for value in others]
    return found


def as_link(winches: Sequence[Candidate], stop_deceleration: float) -> dict[str, tuple[object, ...]]:
    """Return candidates as parameters that move together.

    Parameters
    ----------
    winches : the candidates
    stop_deceleration : of the scenario's winch [m/s^2]; a weaker one stops with all it has
    """
    rows = [
        (
            winch.speed,
            winch.acceleration,
            0.0 if math.isinf(winch.power) else winch.power,
            winch.delay,
            min(stop_deceleration, winch.acceleration),
        )
        for winch in winches
    ]
    return {place: tuple(column) for place, column in zip(PLACES, zip(*rows, strict=True), strict=True)}


def of_frame(frame: pandas.DataFrame) -> list[tuple[Candidate, pandas.DataFrame]]:
    """Return the candidates in the table of a study (`frame`), the scenario's own first, each with its cases.

    Raises ParameterError where the table is of another study.
    """
    missing = [place for place in PLACES if place not in frame.columns]
    if missing:
        raise ParameterError(f"its cases do not vary {missing[0]}: it is no table of a sizing study")
    own: Candidate | None = None
    found = []
    for values, cases in frame.groupby(list(PLACES[:-1]), sort=False):
        speed, acceleration, power, delay = map(float, values)
        winch = Candidate(speed, acceleration, power or math.inf, delay)
        own = own or winch
        differing = [one.name for one in PARTICULARS if winch.value(one) != own.value(one)]
        found.append((replace(winch, sweep=differing[0] if differing else ""), cases))
    return found
