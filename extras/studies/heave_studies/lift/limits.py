"""The largest sea in which the criteria of a phase hold, by peak period, with the winch locked and compensated."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np
import pandas
from cable_sim_node.errors import PlantError
from heave_node.criteria import Criterion
from heave_node.loads.strength import ATTACHMENT, ROPE, WINCH_PULL
from heave_node.parameters import ParameterError

from heave_studies.lift.figures import GAUSSIAN, PLANNED, Capacity, Place, Places, Shape
from heave_studies.lift.plan import SURFACE, WATER, Phase, Plan
from heave_studies.lift.response import PhaseScene, locked_places, phase_scene
from heave_studies.lift.runs import Compensated, Runs, Way, compensated, cross, crossings, most_height, shape_of_tension
from heave_studies.operability.limits import LOST_LIMIT

NEAR_ENOUGH, NEAR_ENOUGH_RUN = 0.002, 0.02
"""Relative widths at which the search for a height ends: by formulas, and by runs, of which a limit is the mean."""
TRIES = 20
"""Values that a search takes."""
SHARE_TIME = 30.0
"""Time of a run of the loop that is to say no more than what share of the boom tip's heave it leaves [s]."""
STEPS = 8
"""Times that the drag is linearised for the height at which it is wanted."""
STATED_BY = {
    ROPE: "system.cable.breaking_force",
    WINCH_PULL: "system.winch.rated_pull",
    ATTACHMENT: "system.unit.attachment_breaking_force",
}
Values = Mapping[str, float]


@dataclass(frozen=True)
class Limit:
    """A largest sea."""

    height: float  # significant wave height [m]
    governs: str = ""  # figure that ends it; "": nothing does up to this height
    values: Values = field(default_factory=dict)  # figures at the height of the plan


@dataclass(frozen=True)
class PeriodLimits:
    """What one phase may do in seas of one peak period."""

    phase: str  # its name
    period: float  # [s]
    locked: Limit  # limit with the winch locked
    compensated: Limit | None = None  # limit with compensation; None where that is not looked at

    def planned(self, phase: Phase) -> Limit:
        """Return the limit that counts for its `phase`, by whether the plan is to compensate in it."""
        return self.compensated if phase.does.compensated and self.compensated is not None else self.locked


def curve_of(limits: Mapping[float, Limit]) -> pandas.DataFrame:
    """Return `limits` by period [s] as `operability.limits.limit_curve` does."""
    heights = [one.height for one in limits.values()]
    return pandas.DataFrame(
        {
            "period": list(limits),
            "limit": heights,
            "lower": math.nan,
            "is_open": [not one.governs for one in limits.values()],
            "is_below": False,
            "at_most": heights,
            "governs": [one.governs for one in limits.values()],
            "digits": 2,
        }
    )


def planned_curve(phase: Phase, limits: Sequence[PeriodLimits]) -> pandas.DataFrame:
    """Return those of the `limits` of a `phase` that count for it, by period."""
    return curve_of({one.period: one.planned(phase) for one in limits})


def period_limits(plan: Plan, phases: Sequence[Phase], period: float, height: float) -> list[PeriodLimits]:
    """Return the limits of phases in seas of one peak period; they share runs of loop and plant.

    Parameters
    ----------
    plan : of the lift
    phases : of it
    period : peak period [s]
    height : at which figures are listed [m]

    Raises ParameterError for a criterion on a part whose strength is not stated.
    """
    runs = Runs()
    return [phase_limits(plan, phase, period, height, runs) for phase in phases]


def phase_limits(plan: Plan, phase: Phase, period: float, height: float, runs: Runs) -> PeriodLimits:
    """Return the limits of a phase in seas of one peak period.

    Parameters
    ----------
    plan, phase : of the lift
    period : peak period [s]
    height : at which figures are listed [m]
    runs : of this period so far

    Raises ParameterError for a criterion on a part whose strength is not stated.
    """
    scene = phase_scene(plan, phase, period)
    capacity = {one.key: one.capacity for one in scene.strengths}
    for kpi in (one.kpi for one in phase.criteria):
        if kpi in STATED_BY and kpi not in capacity:
            raise ParameterError(
                f"{plan.path}: {phase.name}: {kpi} needs the strength of the part: set {STATED_BY[kpi]}"
            )
    if phase.does.compensated and not scene.scenario.moves_winch:
        raise ParameterError(
            f"{plan.path}: {phase.name}: compensated: the winch does not compensate (winch_controller.law: off): "
            "set another law, or leave compensated out"
        )
    if phase.kind == SURFACE:
        return _at_surface(plan, scene, height, runs)
    locked, places = _settled_limit(scene, capacity)
    worst = int(np.argmax([one.motion.tension.sigma / one.static for one in places]))
    length, shape = float(scene.lengths[worst]), GAUSSIAN
    if phase.kind == WATER:
        shape = runs.near(shape_of_tension, plan, scene, length, locked.height)
        locked, places = _settled_limit(scene, capacity, shape, locked.height)
    values = figures_of(locked_places(scene, height, shape), capacity)
    found = PeriodLimits(phase.name, period, replace(locked, values=values))
    if phase.kind != WATER or not scene.scenario.moves_winch:
        return found
    run = runs.near(compensated, plan, scene, length)
    return replace(found, compensated=_compensated_limit(scene, run, places[worst], capacity, height))


def figures_of(places: Places, capacity: Capacity) -> Values:
    """Return every figure of the `places` of a phase, with the `capacity` of its parts."""
    return {key: formula(places, capacity) for key, formula in PLANNED.items()}


def scaled(places: Places, factor: float) -> Places:
    """Return `places` that move a `factor` more."""
    return [replace(one, motion=one.motion.times(factor)) for one in places]


def largest_height(
    criteria: Sequence[Criterion],
    figure: Callable[[str, float], float],
    guess: float,
    most: float,
    width: float = NEAR_ENOUGH,
) -> Limit:
    """Return the largest height at which criteria hold.

    Parameters
    ----------
    criteria : that are to hold
    figure : value of a figure, by key and significant wave height [m]; NaN: beyond the bound
    guess : where the search begins [m]
    most : height up to which it is sought [m]
    width : relative width at which the search ends
    """
    limit = Limit(most)
    for criterion in criteria:
        if limit.governs and criterion.is_met(figure(criterion.kpi, limit.height)):
            continue
        found = _crossing(criterion, partial(figure, criterion.kpi), guess, limit.height, width)
        if found < limit.height:
            limit, guess = Limit(found, criterion.kpi), found
    return limit


def _crossing(criterion: Criterion, figure: Callable[[float], float], guess: float, most: float, width: float) -> float:
    """Return the height up to `most` at which a figure that is nearly linear in it reaches its bound."""
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
        if is_inside and abs(target - height) < width * height:
            return target
        if high[0] - low[0] < width * low[0]:
            return low[0]
        height = target if is_inside else ceiling if math.isinf(high[0]) else 0.5 * (low[0] + high[0])
    return low[0]


def _settled_limit(
    scene: PhaseScene, capacity: Capacity, shape: Shape = GAUSSIAN, guess: float | None = None
) -> tuple[Limit, Places]:
    """Return the limit with the winch locked, drag linearised for the height of the limit itself, and that motion."""
    most = most_height(scene.period)
    limit = Limit(0.3 * most if guess is None else guess)
    for _ in range(STEPS):
        before = max(limit.height, 0.1)
        places = locked_places(scene, before, shape)
        limit = _linear_limit(scaled(places, 1.0 / before), scene.phase.criteria, capacity, most)
        if abs(limit.height - before) < 0.005 * before:
            break
    return limit, places


def _linear_limit(places: Places, criteria: Sequence[Criterion], capacity: Capacity, most: float) -> Limit:
    """Return the limit of `places` at Hs = 1 m that move in proportion to the height."""
    return largest_height(
        criteria, lambda key, height: PLANNED[key](scaled(places, height), capacity), 0.3 * most, most
    )


def _compensated_limit(scene: PhaseScene, run: Compensated, rest: Place, capacity: Capacity, height: float) -> Limit:
    if run.motion is None:
        return Limit(0.0, LOST_LIMIT)
    places = [replace(rest, duration=scene.phase.duration, motion=run.motion)]
    winch = scene.scenario.parameters["virtual_winch"]
    criteria = [
        *scene.phase.criteria,
        Criterion("winch_speed_max_mps", "<=", winch.speed_limit),
        Criterion("winch_acceleration_max_mps2", "<=", winch.acceleration_limit),
    ]
    limit = _linear_limit(places, criteria, capacity, min(most_height(scene.period), run.held))
    governs = limit.governs or (LOST_LIMIT if math.isfinite(run.held) else "")
    return Limit(limit.height, governs, figures_of(scaled(places, height), capacity))


def _at_surface(plan: Plan, scene: PhaseScene, height: float, runs: Runs) -> PeriodLimits:
    """Return the limits of a phase through the surface: the mean over the seeds."""
    ways = crossings(plan, scene, range(1, plan.whole.seeds + 1))
    found = PeriodLimits(scene.phase.name, scene.period, _mean_limit(scene, ways, 1.0, height))
    if not scene.scenario.moves_winch:
        return found
    run = runs.near(compensated, plan, scene, float(scene.lengths.max()), SHARE_TIME)
    lost = run.motion is None
    return replace(found, compensated=Limit(0.0, LOST_LIMIT) if lost else _mean_limit(scene, ways, run.share, height))


def _mean_limit(scene: PhaseScene, ways: Sequence[Way], share: float, height: float) -> Limit:
    """Return the mean limit of crossings with a share of the heave, and their mean figures at a height."""
    found: list[Limit] = []
    calm = cross(ways[0], 0.0)
    for way in ways:
        figures = cache(partial(_crossed, way, share))
        guess = found[-1].height if found else height

        def figure(key: str, at: float, figures: Callable[[float], Values] = figures) -> float:
            return (figures(at) if at else calm).get(key, math.nan)

        most = most_height(scene.period)
        found.append(largest_height(scene.phase.criteria, figure, guess, most, NEAR_ENOUGH_RUN))
    values = pandas.DataFrame([_crossed(way, share, height) for way in ways]).mean().to_dict()
    names = Counter(one.governs for one in found if one.governs)
    governs = names.most_common(1)[0][0] if names else ""
    return Limit(float(np.mean([one.height for one in found])), governs, values)


def _crossed(way: Way, share: float, height: float) -> Values:
    """Return the figures of a crossing; none where the line cannot be followed any more."""
    try:
        return cross(way, height, share)
    except PlantError:
        return {}
