"""The unit through the surface: runs of the plant in seas that differ in their height alone.

Buoyancy, added mass and slam grow as the unit gets wet, which no linear model follows. Each seed has one sea, of any
height: its limit is sought with the same waves, so that it depends on the height without scatter. Compensation leaves a
share of the boom tip's heave; what the winch adds to it is as ideal as that share says.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from cable_sim_node.line.dynamics import CableDynamics
from heave_node.criteria import Criterion
from heave_node.interface.waves import Waves
from heave_node.loads.strength import ATTACHMENT, ROPE, WINCH_PULL, safety_factor
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion
from heave_node.parameters import ParameterError
from heave_node.scenario import WILDCARD
from wave_vessel_node.component import WaveVessel

from heave_bringup.lift.figures import Capacity
from heave_bringup.lift.plan import Plan
from heave_bringup.lift.response import PhaseScene, phase_scene
from heave_bringup.settings import Setting

RAMP = 20.0
"""Time in which the sea begins, before the unit moves [s]."""
COMPONENTS, SEGMENTS = 150, 4
"""Waves of a sea, and segments of the short cable."""
CROSSING_WIDTH = 0.02
"""Relative width at which the search for the height of a crossing ends: a limit is the mean of several."""
TRIES = 8
"""Runs of one search."""


@dataclass(frozen=True)
class Crossing:
    """Everything about a crossing but the height of its sea.

    Attributes
    ----------
    scene : of the phase, with the sea of one seed
    tips : motion of the boom tip by tick at Hs = 1 m
    waves : at Hs = 1 m
    """

    scene: PhaseScene
    tips: Sequence[PointMotion]
    waves: Waves


def crossings(plan: Plan, scene: PhaseScene) -> list[Crossing]:
    """Return the crossings of a phase, one for each seed of the `plan`.

    `scene` is of the phase. Raises ParameterError for a unit that does not get wet, or a sea that does not act on it.
    """
    plant, where = scene.plant, f"{plan.path}: {scene.phase.name}"
    if plant.unit.box.height <= 0.0 or plant.wave.source != "sea":
        raise ParameterError(
            f"{where}: crosses the surface, and needs the size of the unit (system.unit.box.length, .breadth, .height) "
            "and a sea that acts on it (cable_sim.wave.source: sea)"
        )
    coarse = {("wave_vessel", "components"): COMPONENTS, ("cable_sim", "segments"): SEGMENTS}
    return [crossing(plan, scene, seed, coarse) for seed in range(1, plan.whole.seeds + 1)]


def crossing(plan: Plan, scene: PhaseScene, seed: int, settings: Mapping[tuple[str, str], object]) -> Crossing:
    """Return the phase in the sea of one seed.

    Parameters
    ----------
    plan : of the lift
    scene : of the phase
    seed : of the sea
    settings : changes of the scenario, by node and name
    """
    values = {
        (WILDCARD, "seed"): seed,
        ("wave_vessel", "ramp"): RAMP,
        (WILDCARD, "system.length"): float(scene.lengths[0]),
        **scene.still_crane,
        **settings,
    }
    changes = [Setting(node, name, value, "heave lift") for (node, name), value in values.items()]
    found = phase_scene(plan, scene.phase, scene.period, changes)
    step = found.scenario.run.tick_period
    sea = WaveVessel(found.scenario.parameters["wave_vessel"], seed=seed, tick_period=step)
    ticks = round((RAMP + scene.phase.duration) / step)
    tips = [sea.initial_boom_tip(), *(sea.step(tick).boom_tip for tick in range(1, ticks + 1))]
    return Crossing(found, tips, sea.waves())


def cross(way: Crossing, height: float, share: float, capacity: Capacity) -> Mapping[str, float]:
    """Return the figures of one crossing.

    Parameters
    ----------
    way : of one seed
    height : significant wave height [m]
    share : of the boom tip's heave that is left at the cable: 1 with the winch locked on its programme
    capacity : of the parts of the lift
    """
    scene, plant = way.scene, way.scene.plant
    step, rate = scene.scenario.run.tick_period, scene.phase.rate
    dynamics = CableDynamics(plant)
    dynamics.start_at_equilibrium(np.array([0.0, 0.0, plant.boom_tip_height]), 0.0, time=step)
    dynamics.set_waves(replace(way.waves, amplitude=height * way.waves.amplitude))
    weight = plant.cable.weight_in_fluid(plant.water_density, plant.gravity)
    static = np.full(len(way.tips) - 1, dynamics.top_tension)
    factors = np.array([height, height, height * share])
    mean = np.array([0.0, 0.0, plant.boom_tip_height])
    tips = [_scaled(tip, mean, factors) for tip in way.tips]
    largest, least, at_unit, slack = (np.zeros(len(tips) - 1) for _ in range(4))
    payout, speed = 0.0, 0.0
    for tick in range(len(tips) - 1):
        after = rate if (tick + 1) * step > RAMP else 0.0
        then = payout + 0.5 * (speed + after) * step
        dynamics.advance(step, tips[tick], tips[tick + 1], payout, speed, then, after)
        payout, speed = then, after
        static[tick] += weight * payout
        largest[tick], least[tick] = dynamics.largest_top_tension, dynamics.top_tension
        at_unit[tick], slack[tick] = float(dynamics.segment_tensions[0]), dynamics.slack_segments
    return _figures(static, largest, least, at_unit, slack, capacity, first=round(RAMP / step))


def _scaled(tip: PointMotion, mean: Array, factors: Array) -> PointMotion:
    return PointMotion(
        tip.time, mean + factors * (tip.position - mean), factors * tip.velocity, factors * tip.acceleration
    )


def _figures(
    static: Array, largest: Array, least: Array, at_unit: Array, slack: Array, capacity: Capacity, *, first: int
) -> Mapping[str, float]:
    peak = float(largest[first:].max())
    return {
        "dynamic_amplification": float((largest / static)[first:].max()),
        "tension_ratio_min": float((least / static)[first:].min()),
        "tension_max_n": peak,
        ROPE: safety_factor(capacity.rope, peak),
        WINCH_PULL: safety_factor(capacity.winch, peak),
        ATTACHMENT: safety_factor(capacity.attachment, float(at_unit[first:].max())),
        "slack_percent": 100.0 * float(np.mean(slack[first:] > 0.0)),
    }


def regula_falsi(criterion: Criterion, figure: Callable[[float], float], guess: float, most: float) -> float:
    """Return the height at which a figure that is nearly linear in it reaches its bound, with few values of it.

    Parameters
    ----------
    criterion : on the figure
    figure : its value by significant wave height [m]; NaN: beyond the bound
    guess : where the search begins [m]
    most : where it ends [m]
    """
    low, high = (0.0, figure(0.0)), (math.inf, math.nan)
    if not criterion.is_met(low[1]):
        return 0.0
    height = min(max(guess, 0.1 * most), most)
    for _ in range(TRIES):
        here = (height, figure(height))
        if criterion.is_met(here[1]):
            if height == most:
                return most
            other, low = (low if math.isinf(high[0]) else high), here
        else:
            other, high = low, here
        slope = (here[1] - other[1]) / (here[0] - other[0])
        target = height + (criterion.bound - here[1]) / slope if slope else math.nan
        ceiling = min(high[0], most, 2.0 * height)
        is_inside = low[0] < target < ceiling
        if is_inside and abs(target - height) < CROSSING_WIDTH * height:
            return target
        height = target if is_inside else ceiling if math.isinf(high[0]) else 0.5 * (low[0] + high[0])
    return low[0]
