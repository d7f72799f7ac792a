"""Landings of every unit on every cable: 1 to 200 t, EA/L of 5 to 5,000 kN/m, 0.05 to 0.5 m/s, Hs up to 2.5 m.

    python -m tests.campaigns.landings --draws 100

A landing is lost that does not end at constant tension with the unit on the bottom, or that was given up on the way.
Cables are strained by 0.02 to 0.5 % under the unit: what lies outside is no cable for that unit. Components run in
this process.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass

import numpy as np
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import Scenario, load_scenario
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY

STEEL, SPECIFIC_STIFFNESS = 7850.0, 4.0e7 / 0.028**2
"""Density of steel [kg/m^3]; EA over diameter squared of a wire rope [N/m^2]."""

METALLIC_AREA = 0.55
"""Area of a wire rope that is steel, over that of its circle."""

BEGIN = 60.0
"""Time at which lowering begins [s]."""

AFTER = 120.0
"""Time that is watched after the unit should have landed [s]."""

GIVE = 0.02
"""Penetration of the bottom by the unit's own weight [m]."""


@dataclass(frozen=True)
class Draw:
    """One landing."""

    number: int  # of the draw, and seed of the run
    stiffness: float  # EA/L [N/m]
    mass: float  # of the unit [kg]
    length: float  # of the cable [m]
    speed: float  # of lowering [m/s]
    wave_height: float  # significant [m]
    peak_period: float  # [s]

    @property
    def weight(self) -> float:
        """Weight of the unit in water [N]: of steel, half filled."""
        return 0.8 * self.mass * STANDARD_GRAVITY

    @property
    def height(self) -> float:
        """Height above the bottom at which lowering begins [m]."""
        return 2.0 + 30.0 * self.speed

    @property
    def landing_time(self) -> float:
        """Time at which the unit should touch the bottom [s]."""
        return BEGIN + self.height / self.speed + 10.0 * self.speed


def draw(number: int) -> Draw:
    """Return draw `number`: logarithmic in stiffness, mass, speed and length, even in the sea."""
    random = np.random.default_rng([13, number])
    while True:
        stiffness, mass, speed, length = np.exp(
            random.uniform(np.log([5e3, 1e3, 0.05, 100.0]), np.log([5e6, 200e3, 0.5, 3000.0]))
        )
        height, period = random.uniform([0.0, 6.0], [2.5, 12.0])
        one = Draw(number, stiffness, mass, length, speed, height, period)
        if 2e-4 < one.weight / (stiffness * length) < 5e-3:
            return one


def scenario(one: Draw) -> Scenario:
    """Return the landing of a draw as scenario b7_landing with other values."""
    diameter = math.sqrt(one.stiffness * one.length / SPECIFIC_STIFFNESS)
    steel = METALLIC_AREA * math.pi / 4.0 * diameter**2
    per_length = (STEEL - SEAWATER_DENSITY) * steel * STANDARD_GRAVITY
    stretch = (one.weight + 0.5 * per_length * one.length) / one.stiffness
    moving = 1.8 * one.mass
    ground = one.weight / GIVE
    values = {
        "all.duration": one.landing_time + AFTER,
        "all.transient": 30.0,
        "all.seed": one.number + 1,
        "system.length": one.length,
        "system.cable.diameter": diameter,
        "system.cable.displaced_diameter": math.sqrt(4.0 * steel / math.pi),
        "system.cable.mass_per_length": STEEL * steel,
        "system.cable.axial_stiffness": one.stiffness * one.length,
        "system.unit.mass": one.mass,
        "system.unit.volume": 0.2 * one.mass / SEAWATER_DENSITY,
        "system.unit.added_mass": [0.8 * one.mass] * 3,
        "system.winch.payout_maximum": 200.0,
        "system.sea.significant_wave_height": max(one.wave_height, 0.01),
        "system.sea.peak_period": one.peak_period,
        "wave_vessel.ramp": 20.0,
        "cable_sim.segments": 10,
        "cable_sim.seabed.depth": one.length + stretch + one.height,
        "cable_sim.seabed.unit_stiffness": ground,
        "cable_sim.seabed.unit_damping": 2.0 * math.sqrt(ground * moving),
        "winch_controller.programme.move_times": [BEGIN],
        "winch_controller.programme.move_payouts": [one.height + 10.0 + 2.0 * one.weight / one.stiffness],
        "winch_controller.programme.move_speeds": [one.speed],
        "winch_controller.programme.mode_times": [],
        "winch_controller.programme.modes": [],
    }
    return load_scenario("b7_landing", settings=[f"{name}={_text(value)}" for name, value in values.items()])


def _text(value: object) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(f"{float(item)!r}" if not isinstance(item, str) else item for item in value) + "]"
    return str(value) if isinstance(value, int) else f"{float(value)!r}"  # type: ignore[arg-type]


@dataclass(frozen=True)
class LandingFigures:
    """How a unit landed."""

    touchdown_speed: float  # of the unit at the first contact, downwards [m/s]
    rebound: float  # height above the place of first contact that it reached afterwards [m]
    time_to_tension: float  # from the first contact to constant tension [s]; infinite: never
    tension_share: float  # mean share of the weight that the cable carries over the last 30 s
    largest_tension: float  # after the contact over that of the last 10 s before it
    is_lost: bool  # it did not end at constant tension on the bottom, or was given up


def figures(record: LoopRecord, weight: float) -> LandingFigures:
    """Return how the unit of a `weight` in water [N] landed in a run."""
    time = record.column("time")
    touches = np.flatnonzero((record.column("touchdown_force") > 0.0) & (time > BEGIN))
    if not touches.size:
        return LandingFigures(math.nan, math.nan, math.inf, math.nan, math.nan, True)
    first = int(touches[0])
    modes = np.array(record.modes)
    held = np.flatnonzero(modes == "constant_tension")
    unit, tension = record.column("unit"), record.column("top_tension")
    before = (time > time[first] - 10.0) & (time < time[first] - 1.0)
    hanging = float(np.mean(tension[before]))
    share = 1.0 + (float(np.mean(tension[time > time[-1] - 30.0])) - hanging) / weight
    given_up = bool(np.any(~np.isin(modes[time > 40.0], ["compensating", "constant_tension"])))
    return LandingFigures(
        touchdown_speed=-float(record.column("unit_rate")[first]),
        rebound=float(np.max(unit[first + 1 :]) - unit[first]),
        time_to_tension=float(time[held[0]] - time[first]) if held.size else math.inf,
        tension_share=share,
        largest_tension=float(np.max(tension[first:])) / hanging,
        is_lost=given_up or modes[-1] != "constant_tension" or not held.size or held[0] < first,
    )


def show(one: Draw, found: LandingFigures) -> str:
    """Return one line of the table."""
    return (
        f"draw {one.number:3d}: {one.mass / 1e3:6.1f} t, EA/L {one.stiffness / 1e3:7.1f} kN/m, {one.length:5.0f} m, "
        f"{one.speed:.3f} m/s, Hs {one.wave_height:.2f} m: touchdown {found.touchdown_speed:.3f} m/s, rebound "
        f"{100 * found.rebound:6.2f} cm, constant tension after {found.time_to_tension:5.2f} s, carries "
        f"{found.tension_share:5.2f}, largest {found.largest_tension:.2f}{' LOST' if found.is_lost else ''}"
    )


def main() -> int:
    """Run the campaign; return 1 where a landing was lost."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=100, help="landings, from draw 0")
    parser.add_argument("--only", type=int, nargs="*", default=None, help="these draws only")
    options = parser.parse_args()
    numbers = range(options.draws) if options.only is None else options.only
    lost, rebounds = [], []
    for number in numbers:
        one = draw(number)
        found = figures(ClosedLoop(loop_parameters(scenario(one))).run(), one.weight)
        sys.stdout.write(show(one, found) + "\n")
        sys.stdout.flush()
        rebounds.append(found.rebound)
        lost += [number] if found.is_lost else []
    sys.stdout.write(
        f"{len(rebounds)} landings, {len(lost)} lost: {lost}; largest rebound {100 * np.nanmax(rebounds):.2f} cm, "
        f"{np.count_nonzero(np.array(rebounds) > 0.02)} above 2 cm\n"
    )
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
