"""Campaigns: one scenario, many cases (seeds, a grid of settings, random draws), one table.

A campaign file is YAML:

    scenario: b9_model_error
    duration: 600                     # optional; the scenario's own otherwise
    seeds: [1, 2, 3]                  # or a number of seeds, counted from 1
    set: {winch_controller.law: mpc}  # for every case
    vary: {system.sea.peak_period: [8, 10, 12]}        # every combination; the sea and the controller's belief of it
    draw:                                              # random cases, seeded
      count: 64
      seed: 1
      nominal: true                                    # before them the scenario itself, to compare with
      uniform: {cable_sim.cable.axial_stiffness: [1.1e7, 2.0e7]}  # the plant alone
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib import resources
from pathlib import Path
from typing import Any

import yaml
from heave_node.numerics.randomness import random_stream
from heave_node.parameters import ParameterError
from heave_node.scenario import WILDCARD, parse_yaml

from heave_bringup.settings import Setting, make_setting

_KEYS = {"scenario", "duration", "seeds", "set", "vary", "draw"}
_DRAW_KEYS = {"count", "seed", "nominal", "uniform"}


@dataclass(frozen=True)
class Case:
    """One run of a campaign.

    Attributes
    ----------
    number : counted from 1
    seed : of the run
    settings : values by place (`system.sea.peak_period`) by which it differs from the other cases
    is_nominal : the scenario itself, without the changes that every other case has
    """

    number: int
    seed: int
    settings: Mapping[str, object]
    is_nominal: bool = False

    @property
    def label(self) -> str:
        """Say in short what the case is."""
        if self.is_nominal:
            return f"seed={self.seed} nominal"
        differences = " ".join(f"{name.split('.', 1)[1]}={_short(value)}" for name, value in self.settings.items())
        return f"seed={self.seed} {differences}".strip()


@dataclass(frozen=True)
class Campaign:
    """A campaign file, read and checked.

    Attributes
    ----------
    path : of the file
    scenario : shipped name or file
    duration : simulated time of a case [s]; None takes the scenario's
    seeds : of every combination and draw
    common : changes of the scenario in every case but nominal ones, by place (`system.sea.peak_period`)
    vary : values by place; every combination is a case
    draw_count, draw_seed : number of random draws, and the seed that fixes them
    has_nominal : whether the scenario itself runs before the draws
    uniform : bounds of the random draws by place
    duration_source : option that set the duration in the place of the file
    """

    path: Path
    scenario: str
    duration: float | None
    seeds: tuple[int, ...]
    common: Mapping[str, object] = field(default_factory=dict)
    vary: Mapping[str, tuple[object, ...]] = field(default_factory=dict)
    draw_count: int = 0
    draw_seed: int = 1
    has_nominal: bool = False
    uniform: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    duration_source: str = ""

    def settings_of(self, case: Case) -> list[Setting]:
        """Return a case as changes of the scenario; raises ParameterError for an unknown parameter."""
        changes = {} if case.is_nominal else {**self.common, **case.settings}
        settings = [make_setting(place, value, f"{self.path}: {place}") for place, value in changes.items()]
        settings.append(Setting(WILDCARD, "seed", case.seed, f"{self.path}: seeds"))
        if self.duration is not None:
            source = self.duration_source or f"{self.path}: duration"
            settings.append(Setting(WILDCARD, "duration", self.duration, source))
        return settings

    def cases(self) -> Iterator[Case]:
        """Yield every case: nominal ones, then seeds within draws within combinations."""
        number = 0
        for seed in self.seeds if self.has_nominal else ():
            number += 1
            yield Case(number, seed, {}, is_nominal=True)
        combinations = itertools.product(*self.vary.values())
        for combination in combinations:
            chosen = dict(zip(self.vary, combination, strict=True))
            for drawn in self._draws():
                for seed in self.seeds:
                    number += 1
                    yield Case(number, seed, {**chosen, **drawn})

    def shortened(self, *, duration: float | None, draws: int | None) -> Campaign:
        """Return the campaign with another duration, or with only its first draws.

        Parameters
        ----------
        duration : of a case [s]; None leaves what the file says
        draws : number of draws; None leaves what the file says
        """
        return replace(
            self,
            duration=self.duration if duration is None else duration,
            duration_source="" if duration is None else f"--duration {duration:g}",
            draw_count=self.draw_count if draws is None else min(draws, self.draw_count),
        )

    def _draws(self) -> Iterator[dict[str, object]]:
        if not self.draw_count:
            yield {}
            return
        stream = random_stream(self.draw_seed, "campaign/draws")
        for _ in range(self.draw_count):
            yield {name: float(stream.uniform(low, high)) for name, (low, high) in self.uniform.items()}


def find_campaign(name: str) -> Path:
    """Return the file of the shipped campaign `name`, or the file `name`; raise ParameterError where neither is."""
    folder = Path(str(resources.files("heave_bringup"))) / "campaigns"
    shipped = {path.stem: path for path in sorted(folder.glob("*.yaml"))}
    path = shipped.get(name, Path(name))
    if not path.is_file():
        raise ParameterError(f"{name}: no such campaign or file; shipped are: {', '.join(shipped)}")
    return path


def read_campaign(path: Path) -> Campaign:
    """Read and check the campaign file `path`; raise ParameterError, in one line, for what is wrong with it."""
    try:
        content = parse_yaml(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ParameterError(f"{path}: cannot be read: {error.strerror}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ParameterError(f"{path}: is not valid YAML: {' '.join(str(error).split())}") from error
    if not isinstance(content, Mapping) or "scenario" not in content:
        raise ParameterError(f"{path}: must be a mapping with at least the key scenario")
    _refuse_unknown(content, _KEYS, str(path))
    draw = content.get("draw") or {}
    _refuse_unknown(draw, _DRAW_KEYS, f"{path}: draw")
    try:
        return Campaign(
            path=path,
            scenario=str(content["scenario"]),
            duration=float(content["duration"]) if "duration" in content else None,
            seeds=_seeds(content.get("seeds", 1)),
            common=dict(content.get("set") or {}),
            vary={name: tuple(values) for name, values in (content.get("vary") or {}).items()},
            draw_count=int(draw.get("count", 0)),
            draw_seed=int(draw.get("seed", 1)),
            has_nominal=bool(draw.get("nominal", False)),
            uniform={name: (float(low), float(high)) for name, (low, high) in (draw.get("uniform") or {}).items()},
        )
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{path}: {error}") from error


def _seeds(value: Any) -> tuple[int, ...]:
    seeds = tuple(range(1, value + 1)) if isinstance(value, int) else tuple(int(seed) for seed in value)
    if not seeds:
        raise ValueError("seeds must be a number of at least 1 or a list of seeds")
    return seeds


def _refuse_unknown(content: Mapping[str, object], known: set[str], where: str) -> None:
    unknown = sorted(set(content) - known)
    if unknown:
        raise ParameterError(f"{where}: unknown key {unknown[0]}; known:  {', '.join(sorted(known))}")


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
