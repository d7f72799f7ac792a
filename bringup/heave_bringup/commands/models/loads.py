"""What commands on models say of the strength of a lift: lines for people, and a verdict."""

from __future__ import annotations

from typing import TYPE_CHECKING

from heave_node.loads.strength import Strength, strengths
from heave_node.parameters import flatten

from heave_bringup.errors import VerdictError

if TYPE_CHECKING:
    from heave_bags.analyse.verdict import Verdict

    from heave_bringup.scenarios import Scenario


def strengths_in(scenario: Scenario) -> tuple[Strength, ...]:
    """Return what the parts of a `scenario` can carry, of those whose strength is stated."""
    return strengths(flatten(scenario.parameters["cable_sim"]), flatten(scenario.parameters["virtual_winch"]))


def load_lines(verdict: Verdict) -> list[str]:
    """Return the lines of a `verdict` on loads below a table, and what it could not judge."""
    return ["", *(verdict.lines() if verdict.loads else verdict.remarks)]


def refuse_failed(verdict: Verdict) -> None:
    """Raise VerdictError for a `verdict` that is FAILED."""
    if not verdict.is_good:
        raise VerdictError(verdict.failures)
