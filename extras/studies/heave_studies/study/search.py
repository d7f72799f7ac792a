"""The search for the worst case: CMA-ES over the unit cube of a study's draws.

Hansen, N. and Ostermeier, A. (2001), Completely derandomized self-adaptation in evolution strategies, Evolutionary
Computation 9, 159-195, as the package `cma` has it. It begins at the worst of the draws. The seed of the draws fixes
which points are asked for: a search that was ended asks for the same again, and is answered from the journal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from heave_node.extras import how_to_install
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from heave_node.parameters import ParameterError

from heave_studies.study.sampling import Draws

STREAM = "study/search"
"""Name of the random stream that the search draws from."""
WIDTH = 0.2
"""Standard deviation of the first generation, over the width of each range."""
LEAST_POPULATION = 5
"""Draws that a search begins with, at least."""


def load_cma() -> Any:
    """Return the package `cma`; raise ParameterError where it is missing."""
    try:
        import cma  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise ParameterError(f"search needs the package cma; {how_to_install('search')}") from error
    return cma


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
    random = random_stream(draws.seed, STREAM)
    options = {
        "bounds": [0.0, 1.0],
        "popsize": count,
        "randn": lambda *shape: random.standard_normal(shape),
        "seed": np.nan,
        "verbose": -9,
    }
    strategy = load_cma().CMAEvolutionStrategy(points[int(np.argmax(found))], WIDTH, options)
    while left >= count and not strategy.stop():
        asked = strategy.ask()
        yield np.array(asked)
        strategy.tell(asked, (-values()).tolist())
        left -= count
