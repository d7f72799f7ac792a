"""Limits of a lift study beside brute force: runs of the plant and of the whole loop along each phase, many seeds.

The brute-force limit is where the mean over the seeds of the figure that ends the limit reaches its bound, on the line
from a calm sea through runs at the predicted limit or, where the winch ends it, below. Locked: the plant with its
winch at the mean speed. Compensated: the whole loop, sea to winch, with the move of the phase as its programme.

    python -m tests.campaigns.lift_limits lift --phases resonance landing --periods 9 --seeds 8
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from heave_bags.analyse.kpi_set import evaluate
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.settings import Setting
from heave_node.criteria import Criterion
from heave_node.scenario import WILDCARD
from heave_studies.lift.limits import phase_limits
from heave_studies.lift.plan import WATER, Phase, Plan, read_plan
from heave_studies.lift.response import HEIGHT, PhaseScene, phase_scene
from heave_studies.lift.runs import Runs, Way, cross, crossings
from heave_studies.operability.limits import CALM
from heave_studies.study.study_file import find_study

ABOUT, BELOW = 1.0, 0.55
"""Height of the runs over the predicted limit; that of a limit of the winch, beyond which its figure stays."""
FIRST_SEED = 101
"""Of the runs: the predictions use those from 1 on."""
LEAD = 180.0
"""Time before the move of a run of the loop [s]: until then the controller may limit its authority to learn the sea."""


@cache
def _way(plan: Plan, phase: Phase, period: float, seed: int) -> Way:
    scene = phase_scene(plan, phase, period)
    return crossings(plan, scene, [seed], segments=scene.plant.segments)[0]


def plant_figure(plan: Plan, scene: PhaseScene, kpi: str, height: float, seed: int) -> float:
    """Return a figure of the locked plant along a phase.

    Parameters
    ----------
    plan, scene : of the phase
    kpi : key of the figure
    height : significant wave height [m]
    seed : of the sea
    """
    return cross(_way(plan, scene.phase, scene.period, seed), height)[kpi]


def loop_figure(plan: Plan, scene: PhaseScene, kpi: str, height: float, seed: int) -> float:
    """Return a figure of the whole loop along a phase; arguments as of `plant_figure`."""
    phase = scene.phase
    first, last = phase.does.depth
    values = {
        (WILDCARD, HEIGHT): height,
        (WILDCARD, "seed"): seed,
        (WILDCARD, "duration"): LEAD + phase.duration,
        (WILDCARD, "transient"): LEAD,
        **scene.still_crane,
        (WILDCARD, "system.length"): float(scene.lengths[0]),
        ("winch_controller", "programme.move_times"): [LEAD],
        ("winch_controller", "programme.move_payouts"): [last - first],
        ("winch_controller", "programme.move_speeds"): [abs(phase.rate)],
        (WILDCARD, "system.winch.payout_minimum"): -abs(last - first) - 30.0,
        (WILDCARD, "system.winch.payout_maximum"): abs(last - first) + 30.0,
    }
    settings = [Setting(node, name, value, "brute force") for (node, name), value in values.items()]
    parameters = loop_parameters(phase_scene(plan, phase, scene.period, settings).scenario)
    signals = run_signals(ClosedLoop(parameters).run(), parameters)
    return evaluate(signals, LEAD, LEAD + phase.duration)[kpi]


def brute_force(
    figure: Callable[[float, int], float], criterion: Criterion, height: float, seeds: int
) -> tuple[float, float]:
    """Return the limit by runs, and its standard error over the seeds.

    Parameters
    ----------
    figure : of a height and a seed
    criterion : that ends the limit
    height : of the runs [m]
    seeds : number of them
    """
    values = np.array([figure(height, seed) for seed in range(FIRST_SEED, FIRST_SEED + seeds)])
    _say(f"  {criterion.kpi} at {height:.3f} m by seed: {', '.join(f'{value:.4g}' for value in values)}")
    calm = CALM.get(criterion.kpi, 0.0)
    mean = float(values.mean())
    reached = height * (criterion.bound - calm) / (mean - calm)
    error = float(values.std(ddof=1)) / math.sqrt(seeds) / abs(mean - calm) if seeds > 1 else math.nan
    return reached, error * reached


def compare(plan: Plan, phase: Phase, period: float, seeds: int, *, is_compensated: bool) -> str:
    """Return a line that compares a limit of a phase with brute force.

    Parameters
    ----------
    plan, phase : of the lift
    period : peak period [s]
    seeds : of the runs
    is_compensated : of the loop, not the locked winch
    """
    found = phase_limits(plan, phase, period, 1.0, Runs())
    limit = found.compensated if is_compensated else found.locked
    way = "compensated" if is_compensated else "locked"
    if limit is None or not limit.governs:
        return f"{phase.name:12s} {period:5.1f} {way:12s} no limit"
    scene = phase_scene(plan, phase, period)
    winch = scene.scenario.parameters["virtual_winch"]
    bounds = {
        "winch_speed_max_mps": winch.speed_limit,
        "winch_acceleration_max_mps2": winch.acceleration_limit,
    }
    known = {one.kpi: one for one in phase.criteria}
    criterion = known.get(limit.governs) or Criterion(limit.governs, "<=", bounds[limit.governs])
    run = loop_figure if is_compensated else plant_figure

    def figure(height: float, seed: int) -> float:
        return run(plan, scene, limit.governs, height, seed)

    share = BELOW if limit.governs in bounds and limit.governs not in known else ABOUT
    reached, error = brute_force(figure, criterion, share * limit.height, seeds)
    difference = 100.0 * (limit.height / reached - 1.0)
    return (
        f"{phase.name:12s} {period:5.1f} {way:12s} {limit.governs:28s} predicted {limit.height:.3f} m, "
        f"brute force {reached:.3f} +- {error:.3f} m, {difference:+.1f} %"
    )


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main() -> None:
    """Compare, as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("plan")
    parser.add_argument("--phases", nargs="+")
    parser.add_argument("--periods", nargs="+", type=float)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--way", choices=("locked", "compensated", "both"), default="both")
    options = parser.parse_args()
    plan = read_plan(find_study(options.plan))
    phases = [phase for phase in plan.phases if not options.phases or phase.name in options.phases]
    for phase in phases:
        for period in options.periods or plan.whole.periods:
            if options.way != "compensated":
                still = replace(plan, settings=(*plan.settings, Setting("winch_controller", "law", "off", "locked")))
                _say(compare(still, phase, period, options.seeds, is_compensated=False))
            if options.way != "locked" and phase.kind == WATER:
                _say(compare(plan, phase, period, options.seeds, is_compensated=True))


if __name__ == "__main__":
    main()
