"""Criteria on figures of merit, checked before a run begins: those of the scenario and of the command line."""

from __future__ import annotations

import difflib
import re

from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_node.criteria import UNITS_OF_KEYS, Criterion, end_of, parse_criterion
from heave_node.parameters import Given, ParameterError

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
    """Raise ParameterError, naming `where` it is, for a criterion on what is not a figure of merit."""
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


BASELINE_LAW = "industrial"
"""Law of the baseline, by its name in the registry: what makers of winches do."""

LAW = "winch_controller.law"
"""Place of the law among the parameters of a case."""
