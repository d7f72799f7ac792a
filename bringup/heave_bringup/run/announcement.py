"""What a run will be judged by, said before it starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.read_run import SHORTEST_WINDOW
from heave_bags.analyse.verdict import LEAST_SHARE, open_loop, required_words
from heave_node.criteria import Criterion

from heave_bringup.scenarios import Scenario

ENOUGH = 60.0
"""Length of the evaluation window that is proposed where a run has none [s]: some six waves."""


@dataclass(frozen=True)
class Announcement:
    """The first line of a run: `text`; `is_judged`: a verdict will be given."""

    text: str
    is_judged: bool


def announce(scenario: Scenario, required: Sequence[Criterion] = (), played: Sequence[str] = ()) -> Announcement:
    """Return what a run of the `scenario` will be judged by: the time that counts, and the criteria.

    `required` are the criteria of the command line, `played` the nodes in whose place a bag takes part.
    """
    run = scenario.run
    if why_not := open_loop(played):
        return Announcement(f"{scenario.name} will not be judged: {why_not}", is_judged=False)
    if run.duration < run.transient + SHORTEST_WINDOW:
        return Announcement(
            f"{scenario.name} will not be judged: it ends at {run.duration:g} s, before its figures start to count at "
            f"{run.transient:g} s (transient); for a verdict use --duration {run.transient + ENOUGH:g} or longer",
            is_judged=False,
        )
    criteria = dict.fromkeys((*scenario.wanted, *required))
    bounds = [f"{DEFINITION_OF[one.kpi].title} ({required_words(one)})" for one in criteria]
    bounds += (
        [f"compensation active (at least {100.0 * LEAST_SHARE:.0f} % of the time)"] if scenario.moves_winch else []
    )
    bounds += ["no overload of rope, winch or attachment"]
    window = f"{run.transient:g} s to {run.duration:g} s, seed {run.seed}"
    return Announcement(f"{scenario.name}, judged from {window}: {'; '.join(bounds)}", is_judged=True)
