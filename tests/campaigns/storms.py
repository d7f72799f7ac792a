"""Storms, landings and re-tensionings drawn by chance: the plant goes on, and no tick takes long.

    python -m tests.campaigns.storms --count 1000

Each draw hangs a unit on a cable of its own in a sea that often makes it slack; most have a bottom, on which the unit
lands and cable piles up; the boom tip then moves off, and the cable is hauled in again. Half of the draws heave only
and half stand in no current, so that cable is laid down exactly vertically; half have bending stiffness. Prints what
ended early and the longest ticks, and ends with status 1 where something is wrong.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas
from cable_sim_node.errors import PlantError
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SeabedParameters, UnitParameters
from heave_bringup.progress import ProgressLine
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion

from tests.campaigns.in_process import commit_line
from tests.validation.peers.driven_run import smooth_rise

TICK = 0.05
LONGEST_TICK = 0.025
"""Processor time that a tick may take [s]: half of it."""
RISE = 8.0
"""The sea grows in this time [s]."""


@dataclass(frozen=True)
class Storm:
    """A draw."""

    parameters: CableSimParameters  # of the plant
    amplitude: Array  # of the boom tip: three, x, y, z [m]
    period: float  # of the boom tip [s]
    phase: float  # of the boom tip [rad]
    payout: float  # let out, and later hauled in again [m]
    moved: Array  # how far the boom tip moves off in between, x and y [m]

    @property
    def paying_time(self) -> float:
        """How long the payout takes [s], at 1 m/s at most, or in 75 s."""
        return min(max(1.875 * abs(self.payout), 10.0), 75.0)

    @property
    def moving_start(self) -> float:
        """When the boom tip begins to move off [s]."""
        return self.paying_time + 10.0

    @property
    def hauling_start(self) -> float:
        """When the cable begins to be hauled in again [s]."""
        return self.moving_start + 25.0

    @property
    def duration(self) -> float:
        """Of the run [s]."""
        return self.hauling_start + self.paying_time + 15.0

    def boom_tip(self, t: float) -> PointMotion:
        """Return the motion of the boom tip at `t` [s]."""
        omega = 2.0 * math.pi / self.period
        size, slope = smooth_rise(t / RISE)
        angle = omega * t + self.phase
        position = self.amplitude * size * math.sin(angle)
        velocity = self.amplitude * (slope / RISE * math.sin(angle) + size * omega * math.cos(angle))
        size, slope = smooth_rise((t - self.moving_start) / 20.0)
        position[:2] += self.moved * size
        velocity[:2] += self.moved * slope / 20.0
        return PointMotion(t, position, velocity)

    def payout_at(self, t: float) -> tuple[float, float]:
        """Return payout [m] and its rate [m/s] at `t` [s]."""
        out, out_slope = smooth_rise(t / self.paying_time)
        back, back_slope = smooth_rise((t - self.hauling_start) / self.paying_time)
        return self.payout * (out - back), self.payout * (out_slope - back_slope) / self.paying_time


def draw(number: int) -> Storm:
    """Return draw `number`: cables of 20 to 1,500 m, segments of 2 m or more, strains at rest up to 0.3 %."""
    random = np.random.default_rng([20, number])

    def spread(low: float, high: float) -> float:
        return float(np.exp(random.uniform(math.log(low), math.log(high))))

    length = spread(20.0, 1500.0)
    segments = int(min(random.integers(5, 61), max(length / 2.0, 1.0)))
    diameter, modulus = spread(0.01, 0.08), spread(2e9, 1.2e11)
    area = 0.25 * math.pi * diameter**2
    stiffness = modulus * area
    buoyant_share = random.uniform(0.1, 0.7)
    mass = max(stiffness * spread(1e-4, 3e-3) / 9.81 / (1.0 - buoyant_share), 20.0)
    has_bed, heaves_only, is_stiff = random.random() < 0.7, random.random() < 0.5, random.random() < 0.5
    current = (0.0, 0.0) if random.random() < 0.5 else tuple(random.uniform(-1.0, 1.0, 2))
    slope = (0.0, 0.0) if random.random() < 0.5 or any(current) else tuple(random.uniform(-0.3, 0.3, 2))
    depth = 1.03 * length + random.uniform(4.0, 14.0)
    amplitude = random.uniform(-1.0, 1.0, 3) * (2.0, 2.0, 5.0)
    if heaves_only:
        amplitude[:2] = 0.0
    payout = (depth - length) * random.uniform(1.2, 2.0) + random.uniform(0.0, 0.2) * length
    return Storm(
        CableSimParameters(
            length=length,
            segments=segments,
            current=current,
            cable=CableParameters(
                diameter=diameter,
                mass_per_length=random.uniform(1400.0, 6000.0) * area,
                axial_stiffness=stiffness,
                bending_stiffness=stiffness * diameter**2 / 16.0 * random.uniform(0.01, 1.0) if is_stiff else 0.0,
                internal_damping=0.0 if random.random() < 0.5 else stiffness * spread(1e-4, 1e-2),
            ),
            unit=UnitParameters(
                mass=mass,
                volume=mass / 1025.0 * buoyant_share,
                added_mass=(mass * random.uniform(0.1, 1.5),) * 3,
                drag_area=(0.01 * mass ** (2.0 / 3.0) * random.uniform(0.5, 2.0),) * 3,
            ),
            seabed=SeabedParameters(depth=depth if has_bed else 0.0, slope=slope),
        ),
        amplitude=amplitude,
        period=random.uniform(4.0, 14.0),
        phase=random.uniform(0.0, 2.0 * math.pi),
        payout=payout if has_bed else random.uniform(-0.15, 0.15) * length,
        moved=random.uniform(-1.0, 1.0, 2) * random.choice([0.0, 0.03, 0.15]) * length,
    )


@dataclass
class Outcome:
    """What became of a storm."""

    error: str = ""  # why it ended early; "" where it did not
    slack_ticks: int = 0  # ticks at whose end a segment was slack
    longest_tick: float = 0.0  # processor time [s]
    fastest_node: float = 0.0  # [m/s]
    cost: float = 0.0  # processor time per simulated time


def run(storm: Storm) -> Outcome:
    """Run a storm to its end, or until the plant cannot go on."""
    outcome = Outcome()
    plant = CableDynamics(storm.parameters)
    try:
        plant.start_at_equilibrium(np.zeros(3))
        plant.top_tension  # noqa: B018 (compiled before the clock runs)
        tip, payout = storm.boom_tip(0.0), storm.payout_at(0.0)
        for k in range(round(storm.duration / TICK)):
            next_tip, next_payout = storm.boom_tip((k + 1) * TICK), storm.payout_at((k + 1) * TICK)
            start = time.thread_time()
            plant.advance(TICK, tip, next_tip, *payout, *next_payout)
            used = time.thread_time() - start
            tip, payout = next_tip, next_payout
            outcome.longest_tick = max(outcome.longest_tick, used)
            outcome.cost += used / storm.duration
            outcome.slack_ticks += plant.slack_segments > 0
            outcome.fastest_node = max(outcome.fastest_node, float(np.abs(plant.node_velocities).max()))
            if not math.isfinite(outcome.fastest_node):
                raise PlantError("a velocity is not a finite number")
    except PlantError as error:
        outcome.error = str(error)
    return outcome


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign and return the status of the process."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000, metavar="N", help="how many storms (default 1000)")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first one (default 0)")
    options = parser.parse_args(arguments)
    for number in (0, 1, 2, 3):  # compiles
        run(draw(number))
    numbers, found = range(options.first, options.first + options.count), []
    with ProgressLine() as progress:
        for number in numbers:
            found.append(run(draw(number)))
            progress.show(f"storm {number}", len(found) / options.count)
    outcomes = pandas.DataFrame(found, index=pandas.Index(numbers, name="storm"))
    ended = outcomes[outcomes["error"] != ""]
    heads = ["longest_tick", "fastest_node", "cost"]
    slack = f"{len(outcomes)} storms, {(outcomes['slack_ticks'] > 0).sum()} with slack cable, {len(ended)} ended early"
    tables = (table.to_string() for table in (ended, outcomes.nlargest(5, "longest_tick"), outcomes[heads].describe()))
    print(commit_line(), slack, *tables, sep="\n")  # noqa: T201
    return int(bool(len(ended)) or outcomes["longest_tick"].max() > LONGEST_TICK)


if __name__ == "__main__":
    sys.exit(main())
