"""The controller over seeds, on the full plant, without ROS: unit sigma, worse, kappa, and the time of a step.

    python benchmarks/controller.py b3_deep_900 b4_limit_900_tp8 --seeds 8 --duration 2100 --transient 300
    python benchmarks/controller.py b9_model_error --draws 64 --duration 2100 --transient 300
    python benchmarks/controller.py b6_resonance_payout --seeds 1 --transient 120 --set system.winch.speed_limit=1.0

Components run in this process, as the nodes would in lockstep: the numbers are those of `heave run`. kappa divides by
the bound of the sensors (LQG without limits) and that of the winch (clairvoyant, with the boom tip of each run). Beside
each stands what is left of the motion under the baseline law, which takes as long again (--no-baseline).
"""

from __future__ import annotations

import argparse
import json
import math
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from heave_bags.analyse import kpi_set
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.run.criteria import BASELINE_LAW
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.settings import Setting, make_setting
from heave_node.kpi import kappa
from heave_studies.kappa import bounds_of
from winch_controller_node.design.bounds import BOUND_STEP
from winch_controller_node.interface.readings import Measurements, Outputs

UNDER_BASELINE = f"winch_controller.law={BASELINE_LAW}"


@dataclass(frozen=True)
class Figures:
    """What one run gave: sigmas [m], the rest as named; step times in CPU milliseconds.

    `baseline_ratio` is the `ratio` of the same run under the baseline law; NaN: not known.
    """

    scenario: str
    law: str
    seed: int
    unit_sigma_m: float
    uncompensated_sigma_m: float
    outlet_efficiency: float
    max_abs_heave_m: float
    uncompensated_max_abs_heave_m: float
    kappa: float
    snaps: int
    uncompensated_snaps: int
    dynamic_amplification: float
    uncompensated_dynamic_amplification: float
    tension_min_n: float
    winch_speed_max_mps: float
    modes: str
    step_p50_ms: float
    step_p99_ms: float
    baseline_ratio: float = math.nan

    @property
    def ratio(self) -> float:
        """Motion of the unit over that of the uncompensated one."""
        return self.unit_sigma_m / self.uncompensated_sigma_m


def model_error(nominal: Scenario, draw: int) -> list[Setting]:
    """Return one draw of B9: mass and drag of the plant, servo and delay of the winch differ from the controller's
    model.

    Effective mass (and so a) +-30 %, drag (and so b) from 30 % less to four times, servo +-50 %, delay +-0.1 s; draw 0
    is nominal.
    """
    share = np.zeros(4) if draw == 0 else np.random.default_rng([9, draw]).uniform(-1.0, 1.0, 4)
    belief = nominal.parameters["winch_controller"].unit
    added = belief.added_mass[0] + 0.3 * share[0] * (belief.mass + belief.added_mass[0])
    least, most = (1.0, 1.0) if draw == 0 else (0.7, 4.0)
    drag = float(least * (most / least) ** (0.5 * (1.0 + share[1])))
    changes: dict[str, object] = {
        "cable_sim.unit.added_mass": [float(added)] * 3,
        "cable_sim.unit.drag_coefficient": [drag] * 3,
        "virtual_winch.time_constant": float(0.15 * (1.0 + 0.5 * share[2])),
        "virtual_winch.command_delay": float(0.2 + 0.1 * share[3]),
    }
    return [make_setting(place, value, f"draw {draw}: {place}") for place, value in changes.items()]


def run_once(scenario: Scenario) -> Figures:
    """Run one scenario and return its figures over the time after its transient."""
    parameters, transient = loop_parameters(scenario), scenario.run.transient
    loop = ClosedLoop(parameters)
    spent: list[float] = []
    step = loop.controller.step

    def timed(tick: int, measurements: Measurements) -> Outputs:
        start = time.process_time()
        outputs = step(tick, measurements)
        spent.append(1e3 * (time.process_time() - start))
        return outputs

    loop.controller.step = timed  # type: ignore[method-assign]
    record = loop.run()
    found = kpi_set.evaluate(run_signals(record, parameters), transient)
    bounds = _bounds(scenario, record)
    return Figures(
        scenario=scenario.name,
        law=parameters.controller.law,
        seed=scenario.run.seed,
        unit_sigma_m=found["unit_sigma_m"],
        uncompensated_sigma_m=found["uncompensated_sigma_m"],
        outlet_efficiency=found["outlet_efficiency"],
        max_abs_heave_m=found["max_abs_heave_m"],
        uncompensated_max_abs_heave_m=found["uncompensated_max_abs_heave_m"],
        kappa=kappa(found["unit_sigma_m"], *bounds),
        snaps=int(found["snaps"]),
        uncompensated_snaps=int(found["uncompensated_snaps"]),
        dynamic_amplification=found["dynamic_amplification"],
        uncompensated_dynamic_amplification=found["uncompensated_dynamic_amplification"],
        tension_min_n=found["tension_min_n"],
        winch_speed_max_mps=float(np.max(np.abs(record.column("payout_rate")))),
        modes=" ".join(sorted(set(record.modes))),
        step_p50_ms=float(np.percentile(spent, 50)),
        step_p99_ms=float(np.percentile(spent, 99)),
    )


def _bounds(scenario: Scenario, record: LoopRecord) -> tuple[float, float]:
    tip = record.column("boom_tip", after=scenario.run.transient)[:: round(BOUND_STEP / scenario.run.tick_period)]
    try:
        return bounds_of(scenario, tip, BOUND_STEP)
    except ValueError:
        return math.nan, math.nan


def show(figures: Figures) -> str:
    """Return one line of the table."""
    return (
        f"{figures.scenario:22s} {figures.law:11s} seed {figures.seed:2d}: unit {100 * figures.unit_sigma_m:7.3f} cm, "
        f"off {100 * figures.uncompensated_sigma_m:7.2f} cm, ratio {figures.ratio:7.4f} (baseline "
        f"{figures.baseline_ratio:.3f}), outlet efficiency "
        f"{100 * figures.outlet_efficiency:5.1f} %, largest {figures.max_abs_heave_m:.3f} m (off "
        f"{figures.uncompensated_max_abs_heave_m:.2f}), DAF {figures.dynamic_amplification:.3f} (off "
        f"{figures.uncompensated_dynamic_amplification:.2f}), kappa {figures.kappa:5.2f}, snaps {figures.snaps} (off "
        f"{figures.uncompensated_snaps}), step p50 {figures.step_p50_ms:.2f} p99 {figures.step_p99_ms:.2f} ms"
    )


def summary(name: str, runs: list[Figures]) -> str:
    """Return what the benchmarks ask of many runs, in one line."""
    sigmas = np.array([run.unit_sigma_m for run in runs])
    ratios = np.array([run.ratio for run in runs])
    baseline = np.array([run.baseline_ratio for run in runs])
    return (
        f"{name:22s} {len(runs)} runs: root mean square {100 * np.sqrt(np.mean(sigmas**2)):.3f} cm, median "
        f"{100 * np.median(sigmas):.3f} cm, 90th percentile {100 * np.percentile(sigmas, 90):.3f} cm, largest "
        f"{100 * sigmas.max():.3f} cm, worse {ratios.max():.4f}; baseline {baseline.mean():.3f}, worse "
        f"{baseline.max():.3f}"
    )


def main() -> None:
    """Run the campaign and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenarios", nargs="+", help="names of shipped scenarios, or files")
    parser.add_argument("--seeds", type=int, default=8, help="seeds 1 to N")
    parser.add_argument(
        "--draws", type=int, default=0, help="draws of wrong models (B9) instead of seeds; the first is nominal"
    )
    parser.add_argument("--law", default="", help="another law than the scenario's")
    parser.add_argument("--set", action="append", default=[], metavar="NODE.PARAM=VALUE", help="another parameter")
    parser.add_argument("--duration", type=float, default=2100.0, help="simulated time of a run [s]")
    parser.add_argument("--transient", type=float, default=300.0, help="time before the evaluation [s]")
    parser.add_argument(
        "--baseline", action=argparse.BooleanOptionalAction, default=True, help=f"law {BASELINE_LAW} beside each run"
    )
    parser.add_argument("--json", default="", help="file to write the figures to")
    options = parser.parse_args()
    everything: list[dict[str, object]] = []
    law = [f"winch_controller.law={options.law}"] if options.law else []
    run = [f"all.duration={options.duration}", f"all.transient={options.transient}"]
    for name in options.scenarios:
        runs = []
        for index in range(options.draws or options.seeds):
            seed = 1 + index % 4 if options.draws else 1 + index
            settings = [*law, *options.set, *run, f"all.seed={seed}"]
            errors = model_error(load_scenario(name, settings=settings), index) if options.draws else []
            figures = run_once(load_scenario(name, settings=[*errors, *settings]))
            if options.baseline:
                baseline = run_once(load_scenario(name, settings=[*errors, *settings, UNDER_BASELINE]))
                figures = replace(figures, baseline_ratio=baseline.ratio)
            runs.append(figures)
            print(show(runs[-1]), flush=True)
        print(summary(name, runs), flush=True)
        everything += [vars(run) for run in runs]
    if options.json:
        Path(options.json).write_text(json.dumps(everything, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
