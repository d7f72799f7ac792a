"""The lift under compensation: a short run of the whole loop, from which standard deviations go with the wave height.

The loop is nearly linear up to the limits of the winch, which are criteria of their own. One run at one place, near the
limit, gives every signal over the heave of the boom tip in the same record: most of the scatter of a short record falls
out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from heave_bags.analyse.events import COMPENSATES
from heave_node.numerics.arrays import Array
from heave_node.scenario import WILDCARD

from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.lift.figures import STILL, Place, Swing
from heave_bringup.lift.peaks import kurtosis
from heave_bringup.lift.plan import Plan
from heave_bringup.lift.response import HEIGHT, OMEGAS, PhaseScene, phase_scene, swing
from heave_bringup.settings import Setting

SETTLE, MEASURE = 60.0, 120.0
"""Time before a record counts, and that of it that counts [s]."""
NEAR = 0.7
"""Height of the run over that at which the winch reaches its limits in the largest of `WAVES` waves."""
WAVES = 100.0
LEAST_ACTIVE = 0.98
"""Share of the record in which compensation must be active."""
TRIES = 3
SAME_LENGTH = 0.1
"""Lengths that differ by no more than this share have the same run."""


@dataclass(frozen=True)
class Compensated:
    """What a run of the loop gave.

    Attributes
    ----------
    place : at Hs = 1 m; None: compensation was lost in every height that was tried
    held : largest height at which it was seen to hold, where it was lost in a higher sea [m]; infinite: never lost
    share : of the boom tip's heave that is left at the top of the cable, by standard deviations [-]
    """

    place: Place | None
    held: float
    share: float = 1.0


class Loops:
    """The runs of the loop for one peak period: phases share those at nearly the same length.

    Parameters
    ----------
    plan : of the lift
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._known: list[tuple[object, float, Compensated]] = []
        self._kurtoses: list[tuple[object, float, float]] = []

    def kurtosis(self, scene: PhaseScene, length: float, height: float) -> float:
        """Return the kurtosis of the tension with the winch locked, see `peaks`; phases at nearly one length share it.

        Parameters
        ----------
        scene : of the phase
        length : of cable out [m]
        height : significant wave height [m]
        """
        key = (scene.period, scene.phase.settings, scene.arm)
        for other, at, found in self._kurtoses:
            if other == key and abs(at - length) <= SAME_LENGTH * length:
                return found
        self._kurtoses.append((key, length, kurtosis(scene, length, height)))
        return self._kurtoses[-1][2]

    def compensated(self, scene: PhaseScene, governing: Place, length: float, measure: float = MEASURE) -> Compensated:
        """Return how unit, cable and winch move at Hs = 1 m under compensation.

        Parameters
        ----------
        scene : of the phase
        governing : the place of the phase with the winch locked that stands for it
        length : of cable out there [m]
        measure : time that counts [s]
        """
        key = (scene.period, scene.phase.settings, scene.arm)
        for other, at, run in self._known:
            if other == key and abs(at - length) <= SAME_LENGTH * length:
                return _at(run, scene, governing)
        run = self._run(scene, governing, length, measure)
        self._known.append((key, length, run))
        return run

    def _run(self, scene: PhaseScene, governing: Place, length: float, measure: float) -> Compensated:
        height = _height(scene)
        for attempt in range(TRIES):
            record = run_loop(self.plan, scene, length, height, SETTLE + measure)
            works = np.isin(record.modes, COMPENSATES)[record.column("time") >= SETTLE]
            if float(np.mean(works)) >= LEAST_ACTIVE:
                tip, payout = (record.column(name, after=SETTLE) for name in ("boom_tip", "payout"))
                share = float(np.std(tip - payout) / np.std(tip))
                return Compensated(_measured(scene, record, governing), height if attempt else math.inf, share)
            height *= 0.5
        return Compensated(None, 0.0)


def _at(run: Compensated, scene: PhaseScene, governing: Place) -> Compensated:
    """Return what a `run` says of another phase: its motion, with the loads at rest of the `governing` place."""
    if run.place is None:
        return run
    names = ("tension", "attachment", "unit", "winch_speed", "winch_acceleration")
    moved = {name: getattr(run.place, name) for name in names}
    return replace(run, place=replace(governing, duration=scene.phase.duration, **moved))


def run_loop(plan: Plan, scene: PhaseScene, length: float, height: float, duration: float, seed: int = 1) -> LoopRecord:
    """Run the whole loop at a fixed length.

    Parameters
    ----------
    plan : of the lift
    scene : of the phase
    length : of cable out [m]
    height : significant wave height [m]
    duration : simulated time [s]
    seed : of sea and noise
    """
    values: dict[tuple[str, str], object] = {
        (WILDCARD, "system.length"): length,
        (WILDCARD, HEIGHT): height,
        (WILDCARD, "seed"): seed,
        (WILDCARD, "duration"): duration,
        (WILDCARD, "transient"): 0.0,
        ("cable_sim", "seabed.depth"): 0.0,
        **{("winch_controller", f"programme.{name}"): [] for name in ("move_times", "mode_times", "modes")},
        **{("winch_controller", f"programme.move_{name}"): [] for name in ("payouts", "speeds")},
        **scene.still_crane,
    }
    settings = [Setting(node, name, value, "heave lift") for (node, name), value in values.items()]
    scenario = phase_scene(plan, scene.phase, scene.period, settings).scenario
    return ClosedLoop(loop_parameters(scenario)).run()


def _height(scene: PhaseScene) -> float:
    """Return the height of the run [m]: NEAR that at which the winch reaches a limit, and below that of breaking."""
    winch = scene.scenario.parameters["virtual_winch"]
    largest = math.sqrt(2.0 * math.log(WAVES))
    speed, acceleration = (swing(scene.density * OMEGAS**power).sigma for power in (2, 4))
    room = max(winch.speed_limit - abs(scene.phase.rate), 0.1 * winch.speed_limit)
    heights = (room / (largest * speed), winch.acceleration_limit / (largest * acceleration))
    return float(min(NEAR * min(heights), most_height(scene.period)))


def most_height(period: float) -> float:
    """Return the height up to which limits are sought [m]: below that at which waves of a peak `period` [s] break."""
    return min(15.0, 0.09 * period**2)


def _measured(scene: PhaseScene, record: LoopRecord, governing: Place) -> Place:
    tip = record.column("boom_tip", after=SETTLE)
    scale = swing(scene.density).sigma / float(np.std(tip))
    time = record.column("time", after=SETTLE)

    def of(name: str) -> Swing:
        return _swing(record.column(name, after=SETTLE), float(time[1] - time[0])).times(scale)

    return replace(
        governing,
        duration=scene.phase.duration,
        tension=of("top_tension"),
        attachment=of("unit_tension"),
        unit=of("unit"),
        winch_speed=of("payout_rate")._replace(width=swing(scene.density * OMEGAS**2).width),
        winch_acceleration=of("payout_acceleration")._replace(width=swing(scene.density * OMEGAS**4).width),
    )


def _swing(values: Array, step: float) -> Swing:
    sigma = float(np.std(values))
    if sigma <= 0.0:
        return STILL
    return Swing(sigma, float(np.std(np.diff(values))) / step / sigma / (2.0 * math.pi))
