"""Budgets of a node's time in a tick, as a scenario states them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from heave_node.interface.topics import ALL_TOPICS

ALL = "all"
"""Stands for every node."""
NODES = (ALL, "recorder", *sorted({topic.publisher for topic in ALL_TOPICS} - {""}))


class TimeBudget(NamedTuple):
    """Largest times of a node in real time [s]; infinity: none is stated."""

    period: float = math.inf  # from one of its ticks to the next
    age: float = math.inf  # from the start of a tick to its answer; of the clock master to the last answer of all nodes
    work: float = math.inf  # processor time of its part of a tick


def budget_of(node: str, budgets: Iterable[str]) -> TimeBudget:
    """Return the budget of a `node` by `budgets` like `winch_controller=work:0.005`, those of ALL first.

    Raises ValueError for any other text, and for a node that is none.
    """
    limits = [_parsed(text) for text in budgets]
    found = {quantity: limit for name in (ALL, node) for of, quantity, limit in limits if of == name}
    return TimeBudget(**found)


def _parsed(text: str) -> tuple[str, str, float]:
    node, _, rest = text.partition("=")
    quantity, _, number = rest.partition(":")
    try:
        limit = float(number)
    except ValueError:
        limit = math.nan
    if not node or quantity not in TimeBudget._fields or not 0.0 < limit < math.inf:
        known = ", ".join(TimeBudget._fields)
        raise ValueError(f"time_budgets: {text} must be NODE=QUANTITY:S, QUANTITY one of {known}, S above 0")
    if node not in NODES:
        raise ValueError(f"time_budgets: {text}: no such node; known: {', '.join(NODES)}")
    return node, quantity, limit
