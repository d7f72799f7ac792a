"""Draws of a study: random, spread evenly over the space of what is drawn, or a search for the worst case in it.

The search is CMA-ES over the unit cube of the draws: Hansen, N. and Ostermeier, A. (2001), Completely derandomized
self-adaptation in evolution strategies, Evolutionary Computation 9, 159-195, as the package `cma` has it. It begins at
the worst of the draws. Their seed fixes which points are asked for: a search that was ended asks for the same again,
and is answered from the journal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from scipy.stats import qmc

from heave_studies.study.workers import optional

AS_LIST = "[]"
"""End of a place whose drawn value is the one entry of a list, as of the faults of a device."""
STREAM = "campaign/draws"
"""Name of the random stream that draws come from."""


def _random(count: int, dimensions: int, seed: int) -> Array:
    return random_stream(seed, STREAM).uniform(size=(count, dimensions))


def _latin(count: int, dimensions: int, seed: int) -> Array:
    return np.asarray(qmc.LatinHypercube(dimensions, seed=random_stream(seed, STREAM)).random(count))


def _sobol(count: int, dimensions: int, seed: int) -> Array:
    whole = int(np.ceil(np.log2(count)))  # the sequence is balanced at powers of two only
    return np.asarray(qmc.Sobol(dimensions, seed=random_stream(seed, STREAM)).random_base2(whole))[:count]


def _saltelli(count: int, dimensions: int, seed: int) -> Array:
    """Return Saltelli's sample, for Sobol' indices; `count` is made a power of two, times dimensions + 2."""
    sample = optional("SALib.sample.sobol", "draw.method: saltelli", "sensitivity")
    whole = 2 ** int(np.ceil(np.log2(count)))
    return np.asarray(sample.sample(problem(dimensions), whole, calc_second_order=False, seed=seed))


def problem(dimensions: int) -> dict[str, Any]:
    """Return the unit cube of so many `dimensions` as SALib takes it."""
    return {"num_vars": dimensions, "names": [str(n) for n in range(dimensions)], "bounds": [[0.0, 1.0]] * dimensions}


SALTELLI = "saltelli"
METHODS: Mapping[str, Callable[[int, int, int], Array]] = {
    "random": _random,
    "latin": _latin,
    "sobol": _sobol,
    SALTELLI: _saltelli,
}
"""Methods of spreading draws: number, dimensions and seed give points of the unit cube, (count, dimensions)."""


@dataclass(frozen=True)
class Draws:
    """Random values of parameters."""

    count: int  # of draws; Latin hypercubes and Sobol sequences depend on it
    seed: int = 1  # fixes them
    method: str = "random"  # key of METHODS
    uniform: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # smallest and largest value by place
    # the same, even in the logarithm; both above 0
    log_uniform: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    choose: Mapping[str, tuple[object, ...]] = field(default_factory=dict)  # values of which one is taken, by place
    first: int | None = None  # only so many of them are used; None: all

    def __post_init__(self) -> None:
        if self.count < 1:
            raise ValueError(f"draw.count = {self.count}: must be at least 1")
        if self.method not in METHODS:
            raise ValueError(f"draw.method = {self.method}: must be one of {', '.join(METHODS)}")
        names = [*self.uniform, *self.log_uniform, *self.choose]
        if not names:
            raise ValueError("draw: has nothing to draw: give uniform, log_uniform or choose")
        twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
        if twice:
            raise ValueError(f"draw: {twice[0]} is drawn twice")
        for name, (low, high) in {**self.uniform, **self.log_uniform}.items():
            if not low <= high or (name in self.log_uniform and low <= 0.0):
                lowest = " above 0" if name in self.log_uniform else ""
                raise ValueError(f"draw: {name} = [{low:g}, {high:g}]: must be a smallest{lowest} and a largest value")
        for name, choices in self.choose.items():
            if not choices:
                raise ValueError(f"draw.choose: {name}: has nothing to choose from")

    @property
    def names(self) -> tuple[str, ...]:
        """Places that are drawn, each a dimension."""
        return (*self.uniform, *self.log_uniform, *self.choose)

    def points(self) -> Array:
        """Return the draws as points of the unit cube, shape (draws, dimensions)."""
        return METHODS[self.method](self.count, len(self.names), self.seed)[: self.first]

    def values(self) -> list[dict[str, object]]:
        """Return the values of each draw by place."""
        return [self.at(point) for point in self.points()]

    def at(self, point: Array) -> dict[str, object]:
        """Return the values by place at a `point` of the unit cube, shape (dimensions,)."""
        found: dict[str, object] = {}
        for name, share in zip(self.names, point, strict=True):
            value = self._value(name, float(share))
            found[name.removesuffix(AS_LIST)] = [value] if name.endswith(AS_LIST) else value
        return found

    def _value(self, name: str, share: float) -> object:
        if name in self.choose:
            choices = self.choose[name]
            return choices[min(int(share * len(choices)), len(choices) - 1)]
        if name in self.uniform:
            low, high = self.uniform[name]
            return low + (high - low) * share
        low, high = self.log_uniform[name]
        return float(low * (high / low) ** share)


SEARCH_STREAM = "study/search"
"""Name of the random stream that the search draws from."""
WIDTH = 0.2
"""Standard deviation of the first generation, over the width of each range."""
LEAST_POPULATION = 5
"""Draws that a search begins with, at least."""
CMA = partial(optional, "cma", "search", "search")
"""Gives the package of the search; raises ParameterError where it is missing."""


def generations(draws: Draws, runs: int, values: Callable[[], Array]) -> Iterator[Array]:
    """Yield the points of the unit cube that are asked for, one generation after the other, shape (n, dimensions).

    Parameters
    ----------
    draws : the first generation; their count is that of each
    runs : points in all, at most
    values : gives what was found at the points of the last generation, which is made large; shape (n,)
    """
    points = draws.points()[:runs]
    yield points
    found = values()
    left, count = runs - len(points), len(points)
    random = random_stream(draws.seed, SEARCH_STREAM)
    options = {
        "bounds": [0.0, 1.0],
        "popsize": count,
        "randn": lambda *shape: random.standard_normal(shape),
        "seed": np.nan,
        "verbose": -9,
    }
    strategy = CMA().CMAEvolutionStrategy(points[int(np.argmax(found))], WIDTH, options)
    while left >= count and not strategy.stop():
        asked = strategy.ask()
        yield np.array(asked)
        strategy.tell(asked, (-values()).tolist())
        left -= count
