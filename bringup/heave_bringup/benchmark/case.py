"""A case of the benchmark: a problem for each seed, when it is judged, and what has been published of it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Protocol

import numpy as np

from heave_bringup.benchmark.interface import Controller, Facts
from heave_bringup.benchmark.outcome import Outcome
from heave_bringup.benchmark.worlds.motions import HIGHEST, Motion


class World(Protocol):
    """A problem ready to run once."""

    def run(self, controller: Controller) -> Outcome:
        """Run to the end under a controller."""
        ...


@dataclass(frozen=True)
class Problem:
    """One run's world, what an entrant knows of it, and all that defines it, for the digest.

    Attributes
    ----------
    facts : what the entrant knows
    world : to run once
    definition : all that defines the world, for the digest; the facts come to it
    motion : of the boom tip, for references that may look ahead; None where there is none to give
    """

    facts: Facts
    world: World
    definition: Mapping[str, object]
    motion: Motion | None = None

    def facts_with_preview(self) -> Facts:
        """Return the facts with the boom tip's true future; raises ValueError where it cannot be given."""
        motion = self.motion
        if motion is None:
            raise ValueError(f"case {self.facts.case} has no preview")

        def preview(time: float) -> tuple[float, float, float, float, float]:
            a, b, c, d, e = (float(row[0]) for row in motion.at(np.array([time]), HIGHEST))
            return a, b, c, d, e

        return replace(self.facts, preview=preview)


@dataclass(frozen=True)
class Case:
    """A case.

    Attributes
    ----------
    name, title : in tables
    seeds : of the standard; the same for every entrant
    start, end : judged window [s]
    duration : of the run [s]
    make : makes the problem of a seed, so long [s]; raises ParameterError where something is missing
    published : what others have reached, by whom [m]
    """

    name: str
    title: str
    seeds: tuple[int, ...]
    start: float
    end: float
    duration: float
    make: Callable[[int, float], Problem]
    published: Mapping[str, float] = field(default_factory=dict)

    def shortened(self, duration: float) -> Case:
        """Return the case with a run of at most `duration` [s]; raises ValueError where nothing is left to judge."""
        if duration <= self.start:
            raise ValueError(
                f"{duration:g} s leaves nothing of case {self.name}, which is judged from {self.start:g} s"
            )
        return replace(self, duration=min(duration, self.duration), end=min(duration, self.end))


def definition_of(case: Case, problem: Problem) -> dict[str, object]:
    """Return all that defines a run of `problem` in `case`, entrant and versions apart."""
    facts = asdict(replace(problem.facts, preview=None))
    window = {"start": case.start, "end": case.end, "duration": case.duration}
    return {"case": case.name, "window": window, "facts": facts, **problem.definition}


def digest(content: object) -> str:
    """Return the first 16 digits of the SHA-256 of a content's canonical JSON."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), default=_plain)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _plain(value: object) -> object:
    if isinstance(value, np.generic):
        return value.item()
    return str(value)
