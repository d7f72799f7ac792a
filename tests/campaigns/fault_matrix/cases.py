"""Cases of the matrix: a loop at a moment of a lift, with a belief that is off, and the faults that begin there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from heave_studies.promise.cases import LAWS, Case, _with
from heave_studies.promise.deviation import Chance, Row
from heave_studies.promise.table import DEVIATIONS

from tests.campaigns.fault_matrix.faults import KINDS, Fault, drawn
from tests.campaigns.fault_matrix.moments import MOMENTS, Moment, depth_of

BRANCHES = 4
"""Faults that begin in copies of one loop."""

OFF = 0.5
"""Share of the loops in which something is other than assumed."""

SUPERVISED = 0.5
"""Share of the drives that have a supervision of drum and brake of their own."""

BELIEFS: tuple[Row, ...] = tuple(row for row in DEVIATIONS if row.name not in ("fault", "encoder scale"))
"""What may be off: all that draws have but other faults."""


@dataclass(frozen=True)
class Base:
    """A loop that runs to a moment."""

    number: int  # of the loop
    moment: str  # name of it
    case: Case  # scenario, law, seed and what is off

    @property
    def of(self) -> Moment:
        """The moment."""
        return next(one for one in MOMENTS if one.name == self.moment)

    @property
    def words(self) -> str:
        """Return it in words."""
        off = "; ".join(self.case.deviations) or "nominal"
        supervised = ", drive supervised" if self.case.settings["virtual_winch.supervision_time"] else ""
        return f"{self.moment} {self.case.scenario} {self.case.law} seed {self.case.seed}, {off}{supervised}"


@dataclass(frozen=True)
class Cell:
    """A case."""

    index: int  # of the case
    base: Base  # the loop
    fault: Fault  # that begins
    offset: float  # time from the moment until it does [s]

    @property
    def words(self) -> str:
        """Return it in words."""
        return f"{self.index:4d} {self.fault.words} at {self.offset:.3g} s of {self.base.words}"


def base(seed: int, number: int) -> Base:
    """Return loop `number` of a `seed`; each eleven loops in a row have all moments."""
    order = np.random.default_rng([seed, number // len(MOMENTS)]).permutation(len(MOMENTS))
    moment = MOMENTS[int(order[number % len(MOMENTS)])]
    chance = Chance("fault matrix", seed, number)
    scenario = chance.one_of(moment.scenarios)
    case = Case("matrix", seed, number, scenario, chance.one_of(LAWS), chance.number(1, 1_000_000), settings={})
    rows = [chance.one_of(BELIEFS, [row.weight for row in BELIEFS])] if chance.happens(OFF) else []
    case = _with(case, rows, chance)
    settings = {**case.settings, **moment.settings, **depth_of(scenario)}
    settings["virtual_winch.supervision_time"] = 1.0 if chance.happens(SUPERVISED) else 0.0
    return Base(number, moment.name, replace(case, settings=settings))


def cell(seed: int, index: int, branches: int = BRANCHES) -> Cell:
    """Return case `index` of a `seed`, so many `branches` a loop; as many in a row as there are kinds have them all."""
    order = np.random.default_rng([seed, 1, index // len(KINDS)]).permutation(len(KINDS))
    kind = KINDS[int(order[index % len(KINDS)])]
    loop = base(seed, index // branches)
    chance = Chance("fault", seed, index)
    return Cell(index, loop, drawn(kind, chance), chance.between(0.0, loop.of.window))
