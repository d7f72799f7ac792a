"""The phases of a lift in a study file: each is simulated as a move of the controller's programme.

    phases:
      - {name: splash, depth: [-8, 12], speed: 0.25}
      - {name: landing, depth: [1490, 1500], speed: 0.2, compensated: true, may_wait: true,
         wanted: {significant_residual_m: "<= 0.25"}}

Depths are of the unit below still water, negative in air. A phase that takes longer than a run is run in PIECES: at its
start, in its middle, at its end.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from heave_bringup.scenarios import Scenario
from heave_node.criteria import parse_criterion
from heave_node.files.given_files import as_list, as_mapping, refuse_keys
from heave_node.parameters import Given, ParameterError, build_parameters, check_ranges, parameter

PHASE, DEPTH = "phase", "depth_m"
"""Places at which cases differ in the phase, and in the depth of the unit at its start [m]."""
PIECES = 3
"""Pieces of a phase that takes longer than a run."""
PROGRAMME = "winch_controller.programme"


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

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True)
class Phase:
    """A phase of a lift."""

    name: str  # of it
    does: PhaseParameters  # what it does
    changes: Mapping[str, object] = field(default_factory=dict)  # of the scenario in this phase, by place
    wanted: Mapping[str, str] = field(default_factory=dict)  # criteria, beside those of the study

    @property
    def duration(self) -> float:
        """Planned duration [s]."""
        first, last = self.does.depth
        return self.does.duration or abs(last - first) / self.does.speed

    @property
    def crosses_surface(self) -> bool:
        """Whether it begins in air and ends in water, or the other way round."""
        return min(self.does.depth) < 0.0 < max(self.does.depth)

    def depths(self, base: Scenario) -> list[float]:
        """Return the depths of the unit at the start of each piece that is run [m]; `base` is the study's scenario."""
        first, last = self.does.depth
        way = self._way(base)
        return [first] if way == last - first else np.linspace(first, last - way, PIECES).tolist()

    def _way(self, base: Scenario) -> float:
        """Return the way of a piece, positive down [m]."""
        first, last = self.does.depth
        return (last - first) * min((base.run.duration - base.run.transient) / self.duration, 1.0)

    def settings(self, depth: float, base: Scenario) -> dict[str, object]:
        """Return the values by place of a run of the phase from a `depth` [m] on; `base` is the study's scenario.

        Raises ParameterError for a depth above the boom tip, and for a move that the winch cannot do.
        """
        plant, winch = base.parameters["cable_sim"], base.parameters["virtual_winch"]
        length, way, transient = depth + plant.boom_tip_height, self._way(base), base.run.transient
        if length <= 0.0:
            raise ParameterError(
                f"{self.name}: depth = {list(self.does.depth)}: lies above the boom tip, which is "
                f"{plant.boom_tip_height:g} m above the water (system.boom_tip_height)"
            )
        if not winch.payout_minimum < way < winch.payout_maximum:
            raise ParameterError(
                f"{self.name}: moves the unit by {way:g} m: set system.winch.payout_minimum and .payout_maximum"
            )
        moves = [way] if way else []
        time = abs(way) * self.duration / abs(self.does.depth[1] - self.does.depth[0]) if way else self.duration
        return {
            **self.changes,
            "system.length": length,
            "all.duration": transient + min(time, base.run.duration - transient),
            "cable_sim.shadow_follows_programme": bool(moves),
            "cable_sim.seabed.depth": 0.0,
            f"{PROGRAMME}.mode_times": [],
            f"{PROGRAMME}.modes": [],
            f"{PROGRAMME}.move_times": [transient] * len(moves),
            f"{PROGRAMME}.move_payouts": moves,
            f"{PROGRAMME}.move_speeds": [abs(way) / time] * len(moves),
        }


def read_phases(given: Any, where: str) -> tuple[Phase, ...]:
    """Return the phases that are `given` in a study file; `where` opens the messages of a ParameterError."""
    phases = tuple(_phase(one, f"{where} {number}") for number, one in enumerate(as_list(given, where), 1))
    names = [phase.name for phase in phases]
    if twice := next((name for name in names if names.count(name) > 1), ""):
        raise ParameterError(f"{where}: two phases are called {twice}")
    return phases


def _phase(given: Any, where: str) -> Phase:
    content = as_mapping(given, where)
    if not content.get("name"):
        raise ParameterError(f"{where}: name is missing")
    where = f"{where} ({content['name']})"
    own = [one.name for one in fields(PhaseParameters)]
    refuse_keys(content, {"name", "set", "wanted", *own}, where)
    if "depth" not in content:
        raise ParameterError(f"{where}: depth is missing: the depths of the unit at start and end [m], as [20, 1400]")
    does = build_parameters(PhaseParameters, {name: content[name] for name in own if name in content}, where=where)
    if does.duration == 0.0 and (does.speed == 0.0 or does.depth[0] == does.depth[1]):
        raise ParameterError(f"{where}: needs a duration [s], or a speed [m/s] and two depths that differ")
    wanted = as_mapping(content.get("wanted") or {}, f"{where}: wanted")
    for key, bound in wanted.items():
        parse_criterion(Given(bound, key, f"{where}: wanted"))
    return Phase(str(content["name"]), does, dict(as_mapping(content.get("set") or {}, f"{where}: set")), dict(wanted))
