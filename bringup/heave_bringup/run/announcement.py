"""What a run will be judged by, said before it starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.run_record import BAG, replaced_nodes, sea_source
from heave_bags.analyse.verdict import LEAST_SHARE, LEAST_WINDOW, open_loop, required_words, too_short
from heave_node.criteria import Criterion

from heave_bringup.scenarios import Scenario


@dataclass(frozen=True)
class Announcement:
    """The first line of a run: `text`; `is_judged`: a verdict will be given."""

    text: str
    is_judged: bool


def announce(scenario: Scenario, required: Sequence[Criterion] = (), replaced: Sequence[str] = ()) -> Announcement:
    """Return what a run of the `scenario` will be judged by: the time that counts, and the criteria.

    `required` are the criteria of the command line, `replaced` what takes the places of nodes (`replaced_nodes`).
    """
    run, others = scenario.run, replaced_nodes((*scenario.run.external, *replaced))
    if why_not := open_loop([node for node, kind in others.items() if kind == BAG]):
        return _not_judged(scenario, required, why_not)
    if why_not := too_short(run.duration - run.transient):
        transient = f"{why_not}; use --duration {run.transient + LEAST_WINDOW:g} or longer"
        return _not_judged(scenario, required, transient)
    criteria = dict.fromkeys((*scenario.wanted, *required))
    bounds = [f"{DEFINITION_OF[one.kpi].title} ({required_words(one)})" for one in criteria]
    bounds += (
        [f"compensation active (at least {100.0 * LEAST_SHARE:.0f} % of the time)"] if scenario.moves_winch else []
    )
    bounds += ["no overload of rope, winch or attachment"]
    sea = sea_source(others, run.seed)
    window = f"{run.transient:g} s to {run.duration:g} s, {'sea ' if sea.startswith('from') else ''}{sea}"
    return Announcement(f"{scenario.name}, judged from {window}: {'; '.join(bounds)}", is_judged=True)


def _not_judged(scenario: Scenario, required: Sequence[Criterion], why_not: str) -> Announcement:
    what = "will be judged by --require only" if required else "will not be judged"
    return Announcement(f"{scenario.name} {what}: {why_not}", is_judged=False)
