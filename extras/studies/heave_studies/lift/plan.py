"""A lift as its plan states it: a scenario with vessel, cable, unit and winch, and the phases of the lift.

    title: A 12 t unit to 1,500 m
    scenario: unit_1500               # a shipped name, or a file beside the plan
    set: {system.cable.breaking_force: 6.0e5}
    periods: [7, 9, 12]               # peak periods for which limits are computed [s]
    alpha: 0.7                        # the forecast must stay below alpha times the limit
    wanted: {dynamic_amplification: "<= 1.3"}       # criteria of every phase
    phases:
      - {name: lowering, depth: [20, 1400], speed: 0.5, compensated: true}
      - {name: landing, depth: [1490, 1500], speed: 0.2, compensated: true, may_wait: true,
         wanted: {significant_residual_m: "<= 0.25"}}

Depths are of the unit below still water, negative in air. A phase whose depths have both signs crosses the surface.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, TypeVar

from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.settings import Setting, make_setting
from heave_node.criteria import Criterion, parse_criterion
from heave_node.files.given_files import as_list, as_mapping, read_stated, refuse_keys
from heave_node.loads.strength import ATTACHMENT, ROPE, WINCH_PULL
from heave_node.parameters import Given, ParameterError, build_parameters, check_ranges, parameter

from heave_studies.lift.figures import PLANNED
from heave_studies.study.study_file import stated_scenario

P = TypeVar("P")

AIR, SURFACE, WATER = "air", "surface", "water"
"""Where a phase takes place."""

LOADS = ("dynamic_amplification", "tension_ratio_min", "tension_max_n", "slack_percent", ROPE, WINCH_PULL, ATTACHMENT)
"""Figures that are known in air and at the surface."""

_OF_PHASE = {"name", "set", "wanted"}
_OF_PLAN = {"scenario", "set", "wanted", "phases", "title", "ask"}


@dataclass(frozen=True)
class PhaseParameters:
    """What a phase does."""

    depth: tuple[float, ...] = parameter((0.0, 0.0), "m",
        description="Depth of the unit at the start and at the end; negative in air.", length=2)  # fmt: skip
    speed: float = parameter(0.0, "m/s", 0.0, 5.0, "Mean speed of the winch; 0: the phase has a duration.")
    duration: float = parameter(0.0, "s", 0.0, None, "Planned duration; 0: the way over the speed.")
    compensated: bool = parameter(False, description="The plan is to compensate in this phase.")
    may_wait: bool = parameter(False,
        description="The lift may wait before this phase: the unit is safe until it begins.")  # fmt: skip
    slew: tuple[float, ...] = parameter((), "rad",
        description="Slew of the crane at the start and at the end; none: reference pose.")  # fmt: skip

    def __post_init__(self) -> None:
        check_ranges(self)
        if len(self.slew) not in (0, 2):
            raise ValueError(f"slew must hold two angles, start and end, got {list(self.slew)}")


@dataclass(frozen=True)
class PlanParameters:
    """What holds for the whole lift."""

    periods: tuple[float, ...] = parameter((7.0, 9.0, 12.0), "s", 2.0, 30.0, "Peak periods of the limits, ascending.")
    alpha: float = parameter(1.0, "", 0.1, 1.0, "Forecast wave height over the limit that is allowed.")
    contingency: float = parameter(0.0, "", 0.0, 10.0, "Contingency time over the planned duration of a phase.")
    seeds: int = parameter(4, "", 1, 50, "Seas of each crossing of the surface.")
    height: float = parameter(0.0, "m", 0.0, 30.0, "Hs at which loads are listed; 0: that of the scenario.")
    period: float = parameter(0.0, "s", 0.0, 30.0, "Tp of the same sea; 0: that of the scenario.")

    def __post_init__(self) -> None:
        check_ranges(self)
        if not self.periods or list(self.periods) != sorted(set(self.periods)):
            raise ValueError(f"periods must be ascending, got {list(self.periods)}")


@dataclass(frozen=True)
class Phase:
    """A phase of a lift."""

    name: str  # of it
    does: PhaseParameters  # what it does
    settings: tuple[Setting, ...]  # changes of the scenario in this phase
    criteria: tuple[Criterion, ...]  # that hold in it, on figures that are known where it takes place

    @property
    def kind(self) -> str:
        """Where it takes place: AIR, SURFACE or WATER."""
        low, high = min(self.does.depth), max(self.does.depth)
        return AIR if high <= 0.0 else SURFACE if low < 0.0 else WATER

    @property
    def duration(self) -> float:
        """Planned duration [s]."""
        first, last = self.does.depth
        return self.does.duration or abs(last - first) / self.does.speed

    @property
    def rate(self) -> float:
        """Mean speed of the unit, positive downwards [m/s]."""
        return (self.does.depth[1] - self.does.depth[0]) / self.duration


@dataclass(frozen=True)
class Plan:
    """A lift, read and checked."""

    path: Path  # of its file
    title: str  # of the lift
    scenario: str  # shipped name or file
    settings: tuple[Setting, ...]  # changes of the scenario in every phase
    whole: PlanParameters  # what holds for the whole lift
    phases: tuple[Phase, ...] = field(default_factory=tuple)  # in their order
    ask: Mapping[str, object] = field(default_factory=dict)  # what its answer is to use, as of a study

    def with_settings(self, settings: Sequence[Setting] = ()) -> Scenario:
        """Return the scenario of the lift, with further `settings`."""
        return load_scenario(self.scenario, settings=[*self.settings, *settings])

    @property
    def sea(self) -> tuple[float, float]:
        """Hs [m] and Tp [s] in which loads are listed."""
        sea = self.with_settings().parameters["wave_vessel"]
        return self.whole.height or sea.significant_wave_height, self.whole.period or sea.peak_period


def read_plan(path: Path) -> Plan:
    """Return the plan in the file at `path`; raise ParameterError, in one line, for what is wrong with it."""
    _, content = read_stated(path, {*_OF_PLAN, *_names(PlanParameters)}, ("scenario", "phases"))
    entries = as_list(content["phases"], f"{path}: phases")
    common = _criteria(content.get("wanted") or {}, str(path))
    phases = tuple(_phase(entry, f"{path}: phase {number}", common) for number, entry in enumerate(entries, 1))
    names = [phase.name for phase in phases]
    if twice := next((name for name in names if names.count(name) > 1), ""):
        raise ParameterError(f"{path}: two phases are called {twice}")
    return Plan(
        path,
        str(content.get("title") or path.stem),
        stated_scenario(path, content),
        _settings(content.get("set") or {}, f"{path}: set"),
        _own(content, PlanParameters, str(path)),
        phases,
        as_mapping(content.get("ask") or {}, f"{path}: ask"),
    )


def _phase(entry: Any, where: str, common: Mapping[str, Criterion]) -> Phase:
    content = as_mapping(entry, where)
    if not content.get("name"):
        raise ParameterError(f"{where}: name is missing")
    where = f"{where} ({content['name']})"
    refuse_keys(content, {*_OF_PHASE, *_names(PhaseParameters)}, where)
    if "depth" not in content:
        raise ParameterError(f"{where}: depth is missing: the depths of the unit at start and end [m], as [20, 1400]")
    does = _own(content, PhaseParameters, where)
    if does.duration == 0.0 and (does.speed == 0.0 or does.depth[0] == does.depth[1]):
        raise ParameterError(f"{where}: needs a duration [s], or a speed [m/s] and two depths that differ")
    own = _criteria(content.get("wanted") or {}, where)
    phase = Phase(str(content["name"]), does, _settings(content.get("set") or {}, f"{where}: set"), ())
    if phase.kind != WATER:
        if beyond := next((key for key in own if key not in LOADS), ""):
            raise ParameterError(f"{where}: wanted: {beyond} is known in water alone; here: {', '.join(LOADS)}")
        common = {key: one for key, one in common.items() if key in LOADS}
    if not (criteria := {**common, **own}):
        raise ParameterError(f'{where}: no criteria: add wanted, as in {{dynamic_amplification: "<= 1.3"}}')
    if does.compensated and phase.kind == AIR:
        raise ParameterError(f"{where}: compensated: limits in air are those of the locked winch; leave it out")
    return replace(phase, criteria=tuple(criteria.values()))


def _criteria(wanted: Any, where: str) -> dict[str, Criterion]:
    where = f"{where}: wanted"
    criteria = [parse_criterion(Given(bound, key, where)) for key, bound in as_mapping(wanted, where).items()]
    if strange := next((one.kpi for one in criteria if one.kpi not in PLANNED), ""):
        raise ParameterError(f"{where}: {strange} is no figure that a plan predicts; it takes {', '.join(PLANNED)}")
    return {one.kpi: one for one in criteria}


def _settings(values: Any, where: str) -> tuple[Setting, ...]:
    return tuple(make_setting(place, value, f"{where}: {place}") for place, value in as_mapping(values, where).items())


def _names(kind: type) -> list[str]:
    return [one.name for one in fields(kind)]


def _own(content: Mapping[str, Any], kind: type[P], where: str) -> P:
    """Return the parameter set `kind` with its values of the `content`."""
    return build_parameters(kind, {name: content[name] for name in _names(kind) if name in content}, where=where)
