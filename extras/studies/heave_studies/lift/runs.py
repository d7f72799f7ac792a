"""Runs of the plant along a phase, the winch on its mean speed, in seas that differ in their height alone.

Through the surface buoyancy, added mass and slam grow as the unit gets wet, which no linear model follows: the limit of
each seed is sought with the same waves, so that it depends on the height without scatter. Compensation leaves a share
of the boom tip's heave; what the winch adds to it is as ideal as that share says.

In water the linear model gives the standard deviation of the tension. Quadratic drag holds its highest waves down,
which kurtosis and skewness of short runs show (`figures.expected_largest`): they settle in records too short for
their largest value.

The loop is nearly linear up to the limits of the winch, which are criteria of their own. One run at one place, near the
limit, gives every signal over the motion of the boom tip in the same record: speeds over its speed, accelerations over
its acceleration, the rest over its heave. So most of the scatter of a short record falls out. The nominal winch, cable
and sea are the true ones, so that the adviser has nothing to learn and is left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.node_parameters import CableSimNodeParameters
from heave_bags.analyse.events import COMPENSATES
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.kpis.window import Window
from heave_bags.signals import RunSignals, Signal
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.settings import Setting
from heave_node.interface.waves import NO_WAVES, Waves
from heave_node.loads.strength import Strength
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion, smooth_ramp
from heave_node.parameters import ParameterError
from heave_node.scenario import WILDCARD
from wave_vessel_node.component import WaveVessel

from heave_studies.lift.figures import GAUSSIAN, STILL, Motion, Shape, Swing
from heave_studies.lift.plan import LOADS, SURFACE, Plan
from heave_studies.lift.response import HEIGHT, OMEGAS, PhaseScene, phase_scene, swing

RAMP, START = 20.0, 20.0
"""Time in which the sea begins, and in which the winch then gets up to its speed [s]."""
COMPONENTS = 150
"""Waves of a sea."""
COARSE, FINE = 4, 8
"""Segments of the short cable of a crossing, and of the long one in water."""
RECORD, COUNTED, STEP = 600.0, 2000.0, 0.1
"""Longest record in water, what counts of all, and step of its boom tip [s]."""
LARGEST_CHANGE = 0.1
"""Share by which the cable may get longer in a record."""


@dataclass(frozen=True)
class Way:
    """Everything about a run but the height of its sea."""

    plant: CableSimNodeParameters  # cable and unit at the start
    strengths: tuple[Strength, ...]  # of the parts of the lift
    speed: float  # of the winch, positive pays out [m/s]
    step: float  # from one motion of the boom tip to the next [s]
    tips: Sequence[PointMotion]  # motion of the boom tip by step at Hs = 1 m
    waves: Waves = NO_WAVES  # at Hs = 1 m that act on unit and cable


def crossings(plan: Plan, scene: PhaseScene, seeds: Sequence[int], segments: int = COARSE) -> list[Way]:
    """Return the ways of a phase from its first depth to its last, one for each seed.

    Parameters
    ----------
    plan, scene : of the phase
    seeds : of the seas
    segments : of the cable

    Raises ParameterError for a unit that does not get wet, or a sea that does not act on it.
    """
    plant, where = scene.plant, f"{plan.path}: {scene.phase.name}"
    if scene.phase.kind == SURFACE and (plant.unit.box.height <= 0.0 or plant.wave.source != "sea"):
        raise ParameterError(
            f"{where}: crosses the surface, and needs the size of the unit (system.unit.box.length, .breadth, .height) "
            "and a sea that acts on it (cable_sim.wave.source: sea)"
        )
    plant = replace(plant, length=float(scene.lengths[0]), segments=segments)
    time = RAMP + scene.phase.duration + 0.5 * START
    return _ways(plan, scene, plant, seeds, time, scene.scenario.run.tick_period)


def _ways(
    plan: Plan, scene: PhaseScene, plant: CableSimNodeParameters, seeds: Sequence[int], time: float, step: float
) -> list[Way]:
    values = {("wave_vessel", "components"): COMPONENTS, ("wave_vessel", "ramp"): RAMP, **scene.still_crane}
    settings = [Setting(node, name, value, "heave study") for (node, name), value in values.items()]
    vessel = phase_scene(plan, scene.phase, scene.period, settings).scenario.parameters["wave_vessel"]
    found = []
    for seed in seeds:
        sea = WaveVessel(vessel, seed=seed, tick_period=step)
        tips = sea.boom_tips(round(time / step) + 1)
        waves = sea.waves() if plant.wave.source == "sea" else NO_WAVES
        found.append(Way(plant, scene.strengths, scene.phase.rate, step, tips, waves))
    return found


def run_way(way: Way, height: float, share: float = 1.0) -> RunSignals:
    """Return tensions along a way; the phase begins after RAMP.

    Parameters
    ----------
    way : of one seed
    height : significant wave height [m]
    share : of the boom tip's heave that is left at the cable: 1 with the winch locked on its programme
    """
    plant, step, count = way.plant, way.step, len(way.tips) - 1
    mean, factors = np.array([0.0, 0.0, plant.boom_tip_height]), np.array([height, height, height * share])
    tips = [replace(one, position=mean + factors * (one.position - mean), velocity=factors * one.velocity)
            for one in way.tips]  # fmt: skip
    dynamics = CableDynamics(plant)
    dynamics.start_at_equilibrium(mean, 0.0, time=step)
    dynamics.set_waves(replace(way.waves, amplitude=height * way.waves.amplitude))
    at_rest, weight = dynamics.top_tension, plant.cable.weight_in_fluid(plant.water_density, plant.gravity)
    columns = np.empty((5, count))
    payout, speed = 0.0, 0.0
    for tick in range(count):
        after = way.speed * smooth_ramp((tick + 1) * step - RAMP, START)[0]
        then = payout + 0.5 * (speed + after) * step
        dynamics.advance(step, tips[tick], tips[tick + 1], payout, speed, then, after)
        payout, speed = then, after
        tensions = (dynamics.top_tension, dynamics.largest_top_tension, float(dynamics.segment_tensions[0]))
        columns[:, tick] = (at_rest + weight * payout, *tensions, float(dynamics.slack_segments > 0))
    time = np.asarray(step * np.arange(1, count + 1), dtype=np.float64)
    static, top, largest, unit, slack = (Signal(time, column) for column in columns)
    return RunSignals(
        static_tension=static,
        tension=top,
        largest_tension=largest,
        unit_tension=unit,
        slack=slack,
        strengths=way.strengths,
    )


def cross(way: Way, height: float, share: float = 1.0) -> Mapping[str, float]:
    """Return the figures of a crossing by a `way`, at a `height` of the sea [m] and a `share`, as of `run_way`."""
    window = Window(run_way(way, height, share), RAMP, math.inf)
    return {key: DEFINITION_OF[key].formula(window) for key in LOADS}


def shape_of_tension(plan: Plan, scene: PhaseScene, length: float, height: float) -> Shape:
    """Return kurtosis, at most that of a Gaussian, and skewness of the top tension, the winch on its mean speed.

    Parameters
    ----------
    plan, scene : of the phase
    length : of cable out in the middle of the records [m]
    height : significant wave height [m]
    """
    rate = scene.phase.rate
    record = min(RECORD, max(LARGEST_CHANGE * length / max(abs(rate), 1e-9), 3.0 * SETTLE))
    deep = replace(scene.plant.seabed, depth=0.0)
    plant = replace(scene.plant, length=length - 0.5 * rate * record, segments=FINE, seabed=deep)
    seeds = range(1, 1 + math.ceil(COUNTED / (record - SETTLE)))
    runs = [run_way(way, height) for way in _ways(plan, scene, plant, seeds, record, STEP)]
    second, third, fourth = np.mean([_moments(run.tension.window(SETTLE, math.inf)) for run in runs], axis=0)
    if second <= 0.0:
        return GAUSSIAN
    return Shape(float(min(fourth / second**2, GAUSSIAN.kurtosis)), float(third / second**1.5))


def _moments(tension: Signal) -> Array:
    """Return the second, third and fourth moments of a tension about its trend."""
    swings = tension.value - np.polyval(np.polyfit(tension.time, tension.value, 1), tension.time)
    return np.array([np.mean(swings**power) for power in (2, 3, 4)])


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
