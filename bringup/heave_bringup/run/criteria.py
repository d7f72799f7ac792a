"""Criteria on figures of merit, of the scenario and of the command line: checked, and said, before a run begins."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass

from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.kpis.definition import POSSIBLE
from heave_bags.analyse.run_record import BAG, replaced_nodes, sea_source
from heave_bags.analyse.verdict import LEAST_SHARE, LEAST_WINDOW, open_loop, required_words, too_short
from heave_node.criteria import UNITS_OF_KEYS, Criterion, end_of, parse_criterion
from heave_node.parameters import Given, ParameterError

from heave_bringup.scenarios import Scenario

_REQUIREMENT = re.compile(r"\s*(\w+)\s*([<>]=?.*)")


def parse_requirement(text: str) -> Criterion:
    """Return the criterion that `text` is, the value of an option `--require KPI<VALUE`.

    Raises ParameterError for what is not a criterion, or names no figure of merit.
    """
    option = f"--require {text!r}"
    found = _REQUIREMENT.fullmatch(text)
    if found is None:
        raise ParameterError(
            f"{option}: must be KPI<VALUE, KPI<=VALUE, KPI>VALUE or KPI>=VALUE, as in significant_residual<5cm"
        )
    criterion = parse_criterion(Given(found[2], found[1], option))
    refuse_unknown(criterion, option)
    return criterion


def refuse_unknown(criterion: Criterion, where: str) -> None:
    """Raise ParameterError, naming `where` it is, for a criterion on no figure of merit, or that none meets."""
    if criterion.kpi not in DEFINITION_OF:
        ratio = criterion.kpi.removesuffix(end_of(criterion.kpi))
        if ratio in DEFINITION_OF:
            raise ParameterError(f"{where}: {ratio} is a ratio or a count, its bound takes no unit but %")
        siblings = [end_of(key) for key in DEFINITION_OF if key.removesuffix(end_of(key)) == ratio]
        if siblings and end_of(criterion.kpi):
            takes = " or ".join(", ".join(UNITS_OF_KEYS[end]) for end in siblings)
            raise ParameterError(f"{where}: {ratio}: the bound has the unit of another quantity; it takes {takes}")
        near = difflib.get_close_matches(criterion.kpi, DEFINITION_OF)
        helps = f"did you mean {' or '.join(near)}?" if near else f"known: {', '.join(DEFINITION_OF)}"
        raise ParameterError(f"{where}: {criterion.kpi} is not a figure of merit; {helps}")
    best = next(of for end, of in POSSIBLE.items() if criterion.kpi.endswith(end))[criterion.relation[0] == ">"]
    if not criterion.is_met(best):
        raise ParameterError(f"{where}: cannot be met: the best possible {criterion.kpi} is {best:g}")


BASELINE_LAW = "industrial"
"""Law of the baseline, by its name in the registry: what makers of winches do."""

LAW = "winch_controller.law"
"""Place of the law among the parameters of a case."""


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
    if scenario.moves_winch:
        bounds.append(f"compensation active (at least {100.0 * LEAST_SHARE:.0f} % of the time)")
    bounds.append("no overload of rope, winch or attachment")
    sea = sea_source(others, run.seed)
    window = f"{run.transient:g} s to {run.duration:g} s, {'sea ' if sea.startswith('from') else ''}{sea}"
    return Announcement(f"{scenario.name}, judged from {window}: {'; '.join(bounds)}", is_judged=True)


def _not_judged(scenario: Scenario, required: Sequence[Criterion], why_not: str) -> Announcement:
    what = "will be judged by --require only" if required else "will not be judged"
    return Announcement(f"{scenario.name} {what}: {why_not}", is_judged=False)
