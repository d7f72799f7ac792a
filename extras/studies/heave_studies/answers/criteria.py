"""The criteria that a study of seas is judged by, and what it needs of its grid."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.verdict import required_words
from heave_bags.report.parts import table
from heave_bringup.run.criteria import refuse_unknown
from heave_bringup.scenarios import Scenario, load_scenario
from heave_node.criteria import Criterion
from heave_node.parameters import ParameterError

from heave_studies.operability.limits import HEIGHT, PERIOD
from heave_studies.study.plan import Study


def check_seas(study: Study, without: Sequence[str] = ()) -> None:
    """Refuse a study whose seas are no grid, or that has no criteria but for `without`, before a case is run."""
    for place in (HEIGHT, PERIOD):
        values = [float(str(one)) for one in next((link[place] for link in study.vary if place in link), ())]
        if len(values) < 2 or values != sorted(set(values)) or not values[0] > 0.0:
            raise ParameterError(
                f"{study.path}: vary: {place}: needs at least two values above 0 that rise, not {values}"
            )
    criteria_of(study, without)


def first_scenario(study: Study) -> Scenario:
    """Return the scenario of the first case of a `study`."""
    first = next(iter(study.cases()))
    return load_scenario(study.scenario_of(first), settings=study.settings_of(first))


def criteria_of(study: Study, without: Sequence[str] = ()) -> list[Criterion]:
    """Return the criteria of a `study`, its scenario's own but for those on figures `without` which it does not name.

    Raises ParameterError where there are none.
    """
    wanted = first_scenario(study).wanted
    for one in wanted:
        refuse_unknown(one, f"{study.path}: wanted")
    found = [one for one in wanted if one.kpi not in without or one.kpi in study.wanted]
    if not found:
        raise ParameterError("no criteria: give the study some (wanted), or --require, as in 'unit_sigma_m<0.05'")
    return found


def criteria_table(criteria: Sequence[Criterion]) -> str:
    """Return the `criteria` of a study as HTML, under a heading."""
    rows = [[DEFINITION_OF[criterion.kpi].title, required_words(criterion)] for criterion in criteria]
    return f"<h2>Criteria</h2>{table(['figure of merit', 'required'], rows or [['none', '-']], texts=2)}"


def criteria_of_cases(study: Study) -> str:
    """Return the criteria that the cases of a `study` are judged by as HTML: those of each scenario that they have."""
    firsts = {study.scenario_of(case): case for case in study.cases()}
    found = {name: load_scenario(name, settings=study.settings_of(case)).wanted for name, case in firsts.items()}
    if len({repr(one) for one in found.values()}) == 1:
        return criteria_table(next(iter(found.values())))
    rows = [
        [Path(name).stem, DEFINITION_OF[one.kpi].title, required_words(one)] for name in found for one in found[name]
    ]
    return f"<h2>Criteria</h2>{table(['scenario', 'figure of merit', 'required'], rows, texts=3)}"


def as_path(value: object) -> Path | None:
    """Return the file that a `value` of `--ask` names; None where it names none."""
    return None if value is None else Path(str(value))
