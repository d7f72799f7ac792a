"""How fast the static solve is, and how near to MoorPy's, on catenaries between two ends in still water."""

from __future__ import annotations

import importlib.util
import math
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from heave_statics.problems import submerged_cable
from heave_statics.system import StaticSection, static_cable

_ROUNDS = 5
_NODES = 20
"""Points along the line that MoorPy is asked for; as many segments has ours."""


class Catenary(NamedTuple):
    """A cable between two ends."""

    name: str  # what it is like
    length: float  # unstretched [m]
    stiffness: float  # EA [N]
    weight: float  # in water, per length [N/m]
    across: float  # where the second end lies from the first [m]
    up: float  # where the second end lies from the first [m]


CATENARIES = (
    Catenary("slack", 120.0, 1e7, 50.0, 60.0, 40.0),
    Catenary("taut and steep", 100.0, 1e6, 30.0, 30.0, 96.0),
    Catenary("sloped", 150.0, 1e8, 20.0, 100.0, 80.0),
    Catenary("long", 5000.0, 1e8, 5.0, 4000.0, 2000.0),
)


def measure_statics(solves: int = 200) -> list[dict[str, Any]]:
    """Return `cable`, `ms`, `peer_ms`, `ratio_to_moorpy` and `difference_percent` for each of the `CATENARIES`.

    Time is processor time of one solve from nothing known, the best of five rounds of so many `solves` in turns. The
    difference is that of the tension at the upper end. Without the package moorpy the last three are NaN.
    """
    has_peer = importlib.util.find_spec("moorpy") is not None
    return [_measure(one, solves, has_peer=has_peer) for one in CATENARIES]


def _measure(one: Catenary, solves: int, *, has_peer: bool) -> dict[str, Any]:
    solvers = [_own(one), *([_peer(one)] if has_peer else [])]
    tensions = [solve() for solve in solvers]
    best = [math.inf] * len(solvers)
    for _ in range(_ROUNDS):
        best = [min(before, _milliseconds(solve, solves)) for before, solve in zip(best, solvers, strict=True)]
    own, peer = best[0], best[1] if has_peer else math.nan
    return {
        "cable": one.name,
        "ms": own,
        "peer_ms": peer,
        "ratio_to_moorpy": peer / own,
        "difference_percent": 100.0 * abs(tensions[-1] / tensions[0] - 1.0) if has_peer else math.nan,
    }


def _milliseconds(solve: Callable[[], float], solves: int) -> float:
    started = time.process_time()
    for _ in range(solves):
        solve()
    return 1e3 * (time.process_time() - started) / solves


def _own(one: Catenary) -> Callable[[], float]:
    cable = static_cable([StaticSection(one.length, one.stiffness, one.weight)], segments=_NODES)

    def solve() -> float:
        shape = submerged_cable(cable, (0.0, 0.0, 0.0), (one.across, 0.0, one.up))
        return float(np.linalg.norm(shape.end_force))

    return solve


def _peer(one: Catenary) -> Callable[[], float]:
    # a peer for benchmarks, not a dependency of a run
    from moorpy.Catenary import catenary  # noqa: PLC0415

    def solve() -> float:
        # CB below zero: the seabed lies so far below the first end that the line does not touch it
        _, _, across, up, _ = catenary(
            one.across, one.up, one.length, one.stiffness, one.weight, CB=-one.length, nNodes=_NODES
        )
        return math.hypot(across, up)

    return solve
