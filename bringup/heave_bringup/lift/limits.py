"""The largest sea in which the criteria of a phase hold, by peak period, with the winch locked and compensated."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from cable_sim_node.errors import PlantError
from heave_node.criteria import Criterion
from heave_node.loads.strength import ATTACHMENT, ROPE, WINCH_PULL
from heave_node.parameters import ParameterError

from heave_bringup.lift.figures import GAUSSIAN, PLANNED, Capacity, Place, Places
from heave_bringup.lift.loop import Compensated, Loops, most_height
from heave_bringup.lift.plan import SURFACE, WATER, Phase, Plan
from heave_bringup.lift.response import PhaseScene, locked_places, phase_scene
from heave_bringup.lift.surface import Crossing, cross, crossings, regula_falsi
from heave_bringup.operability.limits import LOST_LIMIT
from heave_bringup.scenarios import Scenario

NEAR_ENOUGH = 0.002
"""Relative width at which the search for a height ends."""
SHARE_TIME = 30.0
"""Time of a run of the loop that is to say no more than what share of the boom tip's heave it leaves [s]."""
STEPS = 8
"""Times that the drag is linearised for the height at which it is wanted."""
CAPACITIES = {
    ROPE: ("rope", "system.cable.breaking_force"),
    WINCH_PULL: ("winch", "system.winch.rated_pull"),
    ATTACHMENT: ("attachment", "system.unit.attachment_breaking_force"),
}
Values = Mapping[str, float]


@dataclass(frozen=True)
class Limit:
    """A largest sea.

    Attributes
    ----------
    height : significant wave height [m]
    governs : figure that ends it; "": nothing does up to this height
    """

    height: float
    governs: str = ""

    @property
    def words(self) -> str:
        """The height for people."""
        return f"{self.height:.2f}" if self.governs else f"above {self.height:.1f}"


@dataclass(frozen=True)
class PeriodLimits:
    """What one phase may do in seas of one peak period.

    Attributes
    ----------
    phase : its name
    period : [s]
    locked, compensated : limits; None where compensation is not looked at
    locked_values, compensated_values : figures at the height of the plan
    """

    phase: str
    period: float
    locked: Limit
    compensated: Limit | None = None
    locked_values: Values = field(default_factory=dict)
    compensated_values: Values = field(default_factory=dict)

    def planned(self, phase: Phase) -> tuple[Limit, Values]:
        """Return the limit that counts for its `phase`, by whether the plan is to compensate in it, and the figures."""
        if phase.does.compensated and self.compensated is not None:
            return self.compensated, self.compensated_values
        return self.locked, self.locked_values


def period_limits(plan: Plan, phases: Sequence[Phase], period: float, height: float) -> list[PeriodLimits]:
    """Return the limits of phases in seas of one peak period; they share runs of the loop.

    Parameters
    ----------
    plan : of the lift
    phases : of it
    period : peak period [s]
    height : at which figures are listed [m]

    Raises ParameterError as `phase_limits` does.
    """
    loops = Loops(plan)
    return [phase_limits(loops, phase, period, height) for phase in phases]


def phase_limits(loops: Loops, phase: Phase, period: float, height: float) -> PeriodLimits:
    """Return the limits of a phase in seas of one peak period.

    Parameters
    ----------
    loops : of the plan
    phase : of the lift
    period : peak period [s]
    height : at which figures are listed [m]

    Raises ParameterError for a criterion on a part whose strength is not stated.
    """
    plan = loops.plan
    scene = phase_scene(plan, phase, period)
    capacity = _capacity(scene.scenario, phase, str(plan.path))
    if phase.does.compensated and not scene.scenario.moves_winch:
        raise ParameterError(
            f"{plan.path}: {phase.name}: compensated: the winch does not compensate (winch_controller.law: off): "
            "set another law, or leave compensated out"
        )
    if phase.kind == SURFACE:
        return _at_surface(loops, scene, capacity, height)
    locked = _settled_limit(scene, phase.criteria, capacity)
    kurtosis = GAUSSIAN
    if phase.kind == WATER:
        kurtosis = loops.kurtosis(scene, float(scene.lengths[_worst(scene, locked.height)]), locked.height)
        locked = _settled_limit(scene, phase.criteria, capacity, kurtosis, locked.height)
    values = figures_of(locked_places(scene, height, kurtosis), capacity)
    found = PeriodLimits(phase.name, period, locked, locked_values=values)
    if phase.kind != WATER or not scene.scenario.moves_winch:
        return found
    run = _loop_at_worst(loops, scene, locked.height)
    limit, values = _compensated_limit(scene, run, capacity, height)
    return replace(found, compensated=limit, compensated_values=values)


def figures_of(places: Places, capacity: Capacity) -> Values:
    """Return every figure of the `places` of a phase, with the `capacity` of its parts."""
    return {key: formula(places, capacity) for key, formula in PLANNED.items()}


def largest_height(criteria: Sequence[Criterion], figure: Callable[[str, float], float], most: float) -> Limit:
    """Return the largest height at which criteria hold, by halving.

    Parameters
    ----------
    criteria : that are to hold
    figure : value of a figure, by key and significant wave height [m]
    most : height up to which it is sought [m]
    """
    limit = Limit(most)
    for criterion in criteria:
        if criterion.is_met(figure(criterion.kpi, limit.height)):
            continue
        low, high = 0.0, limit.height
        while high - low > NEAR_ENOUGH * high and high > 0.01:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if criterion.is_met(figure(criterion.kpi, middle)) else (low, middle)
        limit = Limit(low, criterion.kpi)
    return limit


def scaled(places: Places, factor: float) -> list[Place]:
    """Return `places` that move a `factor` more."""
    names = ("tension", "attachment", "unit", "winch_speed", "winch_acceleration")
    return [replace(one, **{name: getattr(one, name).times(factor) for name in names}) for one in places]


def _settled_limit(
    scene: PhaseScene,
    criteria: Sequence[Criterion],
    capacity: Capacity,
    kurtosis: float = GAUSSIAN,
    guess: float | None = None,
) -> Limit:
    """Return the limit with the winch locked, drag linearised for the height of the limit itself."""
    most = most_height(scene.period)
    limit = Limit(0.3 * most if guess is None else guess)
    for _ in range(STEPS):
        before = max(limit.height, 0.1)
        places = scaled(locked_places(scene, before, kurtosis), 1.0 / before)
        limit = _linear_limit(places, criteria, capacity, most)
        if abs(limit.height - before) < 0.005 * before:
            break
    return limit


def _linear_limit(places: Places, criteria: Sequence[Criterion], capacity: Capacity, most: float) -> Limit:
    """Return the limit of `places` at Hs = 1 m that move in proportion to the height."""
    return largest_height(criteria, lambda key, height: PLANNED[key](scaled(places, height), capacity), most)


def _loop_at_worst(loops: Loops, scene: PhaseScene, height: float) -> Compensated:
    """Run the loop where the locked winch swings the tension most."""
    worst = _worst(scene, height)
    return loops.compensated(scene, locked_places(scene, 1.0)[worst], float(scene.lengths[worst]))


def _worst(scene: PhaseScene, height: float) -> int:
    """Return at which place of a phase the locked winch swings the tension most."""
    places = locked_places(scene, max(height, 0.1))
    return int(np.argmax([one.tension.sigma / one.static for one in places]))


def _compensated_limit(scene: PhaseScene, run: Compensated, capacity: Capacity, height: float) -> tuple[Limit, Values]:
    if run.place is None:
        return Limit(0.0, LOST_LIMIT), {}
    most = min(most_height(scene.period), run.held)
    criteria = [*scene.phase.criteria, *_winch_criteria(scene.scenario)]
    limit = _linear_limit([run.place], criteria, capacity, most)
    if not limit.governs and math.isfinite(run.held):
        limit = Limit(limit.height, LOST_LIMIT)
    return limit, figures_of(scaled([run.place], height), capacity)


def _winch_criteria(scenario: Scenario) -> list[Criterion]:
    winch = scenario.parameters["virtual_winch"]
    return [
        Criterion("winch_speed_max_mps", "<=", winch.speed_limit),
        Criterion("winch_acceleration_max_mps2", "<=", winch.acceleration_limit),
    ]


def _capacity(scenario: Scenario, phase: Phase, where: str) -> Capacity:
    plant, winch = scenario.parameters["cable_sim"], scenario.parameters["virtual_winch"]
    stated = {
        "rope": plant.cable.breaking_force,
        "winch": winch.rated_pull,
        "attachment": plant.unit.attachment_breaking_force,
    }
    for criterion in phase.criteria:
        part, place = CAPACITIES.get(criterion.kpi, ("", ""))
        if part and not stated[part]:
            raise ParameterError(f"{where}: {phase.name}: {criterion.kpi} needs the strength of the part: set {place}")
    return Capacity(**{part: value or math.nan for part, value in stated.items()})


def _at_surface(loops: Loops, scene: PhaseScene, capacity: Capacity, height: float) -> PeriodLimits:
    """Return the limits of a phase through the surface: the mean over the seeds."""
    ways, shares, lost = crossings(loops.plan, scene), [1.0], None
    calm = cross(ways[0], 0.0, 1.0, capacity)
    if scene.scenario.moves_winch:
        deepest = float(scene.lengths.max())
        run = loops.compensated(scene, locked_places(scene, 1.0)[0], deepest, SHARE_TIME)
        if run.place is not None:
            shares.append(run.share)
        else:
            lost = Limit(0.0, LOST_LIMIT)
    limits, values = [], []
    for share in shares:
        found: list[Limit] = []
        for way in ways:
            guess = found[-1].height if found else height
            found.append(_crossing_limit(way, share, capacity, guess, calm))
        names = [one.governs for one in found if one.governs]
        mean = float(np.mean([one.height for one in found]))
        limits.append(Limit(mean, max(names, key=names.count) if names else ""))
        at = [cross(way, height, share, capacity) for way in ways]
        values.append({key: float(np.mean([one[key] for one in at])) for key in at[0]})
    whole = PeriodLimits(scene.phase.name, scene.period, limits[0], locked_values=values[0])
    if len(shares) == 1:
        return replace(whole, compensated=lost)
    return replace(whole, compensated=limits[1], compensated_values=values[1])


def _crossing_limit(way: Crossing, share: float, capacity: Capacity, guess: float, calm: Values) -> Limit:
    """Return the limit of one crossing; a height at which the line cannot be followed any more is beyond it."""
    known: dict[float, Values] = {0.0: calm}

    def figure(key: str, height: float) -> float:
        if height not in known:
            try:
                known[height] = cross(way, height, share, capacity)
            except PlantError:
                known[height] = {}
        return known[height].get(key, math.nan)

    limit = Limit(most_height(way.scene.period))
    for criterion in way.scene.phase.criteria:
        if limit.governs and criterion.is_met(figure(criterion.kpi, limit.height)):
            continue
        found = regula_falsi(criterion, partial(figure, criterion.kpi), guess, limit.height)
        if found < limit.height:
            limit, guess = Limit(found, criterion.kpi), max(found, 0.1)
    return limit
