"""The lift under compensation: a short run of the whole loop, from which standard deviations go with the wave height.

The loop is nearly linear up to the limits of the winch, which are criteria of their own. One run at one place, near the
limit, gives every signal over the motion of the boom tip in the same record: speeds over its speed, accelerations over
its acceleration, the rest over its heave. So most of the scatter of a short record falls out. The nominal winch, cable
and sea are the true ones, so that the adviser has nothing to learn and is left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from heave_bags.analyse.events import COMPENSATES
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.settings import Setting
from heave_node.numerics.arrays import Array
from heave_node.scenario import WILDCARD

from heave_studies.lift.figures import STILL, Motion, Swing
from heave_studies.lift.plan import Plan
from heave_studies.lift.response import HEIGHT, OMEGAS, PhaseScene, phase_scene, swing

T = TypeVar("T")

SETTLE, MEASURE = 60.0, 120.0
"""Time before a record counts, and that of it that counts [s]."""
NEAR = 0.7
"""Height of the run over that at which the winch reaches its limits in the largest of `WAVES` waves."""
WAVES = 100.0
LEAST_ACTIVE = 0.98
"""Share of the record in which compensation must be active."""
TRIES = 3
SAME_LENGTH = 0.1
"""Lengths that differ by no more than this share have the same runs."""
SWING = 0.3
"""A swing goes from so far below to so far above the mean, over the standard deviation: noise does not."""


@dataclass(frozen=True)
class Compensated:
    """What a run of the loop gave."""

    motion: Motion | None  # at Hs = 1 m; None: compensation was lost in every height that was tried
    # largest height at which it was seen to hold, where it was lost in a higher sea [m]; infinite: never lost
    held: float
    share: float = 1.0  # of the boom tip's heave that is left at the top of the cable, by standard deviations [-]


class Runs:
    """What was found by runs, for one peak period: phases at nearly the same length of cable share it."""

    def __init__(self) -> None:
        self._known: list[tuple[object, float, object]] = []

    def near(self, what: Callable[..., T], plan: Plan, scene: PhaseScene, length: float, *others: float) -> T:
        """Return `what` of a `plan`, `scene`, `length` of cable [m] and `others`, or what was found of one like it."""
        key = (what, scene.period, scene.phase.settings, scene.arm)
        for other, at, found in self._known:
            if other == key and abs(at - length) <= SAME_LENGTH * length:
                return found  # type: ignore[return-value]  # of the same function
        result = what(plan, scene, length, *others)
        self._known.append((key, length, result))
        return result


def compensated(plan: Plan, scene: PhaseScene, length: float, measure: float = MEASURE) -> Compensated:
    """Return how unit, cable and winch move at Hs = 1 m under compensation.

    Parameters
    ----------
    plan, scene : of the phase
    length : of cable out [m]
    measure : time that counts [s]
    """
    height = _height(scene)
    for attempt in range(TRIES):
        record = run_loop(plan, scene, length, height, SETTLE + measure)
        works = np.isin(record.modes, COMPENSATES)[record.column("time") >= SETTLE]
        if float(np.mean(works)) >= LEAST_ACTIVE:
            tip, payout = (record.column(name, after=SETTLE) for name in ("boom_tip", "payout"))
            share = float(np.std(tip - payout) / np.std(tip))
            return Compensated(_measured(scene, record), height if attempt else math.inf, share)
        height *= 0.5
    return Compensated(None, 0.0)


def run_loop(plan: Plan, scene: PhaseScene, length: float, height: float, duration: float, seed: int = 1) -> LoopRecord:
    """Run the whole loop at a fixed length.

    Parameters
    ----------
    plan, scene : of the phase
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
    settings = [Setting(node, name, value, "heave study") for (node, name), value in values.items()]
    scenario = phase_scene(plan, scene.phase, scene.period, settings).scenario
    return ClosedLoop(loop_parameters(scenario), has_adviser=False).run()


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


def _measured(scene: PhaseScene, record: LoopRecord) -> Motion:
    time, tip = (record.column(name, after=SETTLE) for name in ("time", "boom_tip"))

    def of(name: str, derivative: int = 0) -> Swing:
        like, exact = tip, swing(scene.density * OMEGAS ** (2 * derivative))
        for _ in range(derivative):
            like = np.gradient(like, time)
        found = swing_of(record.column(name, after=SETTLE), float(time[-1] - time[0]))
        return found.times(exact.sigma / float(np.std(like)))._replace(width=exact.width if derivative else 1.0)

    return Motion(of("top_tension"), of("unit_tension"), of("unit"), of("payout_rate", 1), of("payout_acceleration", 2))


def swing_of(values: Array, duration: float) -> Swing:
    """Return how a signal of so long a `duration` [s] swings, from its samples: `values`. Noise on it is no swing."""
    about = values - np.mean(values)
    sigma = float(np.std(about))
    if sigma <= 0.0:
        return STILL
    signs = np.sign(about[np.abs(about) > SWING * sigma])
    return Swing(sigma, max(float(np.count_nonzero(np.diff(signs) > 0.0)), 1.0) / duration)
