"""The criteria that a study of seas is judged by, and what it needs of its grid."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.verdict import required_words
from heave_bags.report.parts import table
from heave_bringup.run.criteria import refuse_unknown
from heave_bringup.scenarios import Scenario, load_scenario
from heave_node.criteria import Criterion
from heave_node.loads.strength import FACTORS, LEAST
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


def with_strengths(frame: pandas.DataFrame, criteria: Sequence[Criterion]) -> list[Criterion]:
    """Return `criteria`, and beside them that no part carries more than it can, where its strength is stated.

    Parameters
    ----------
    frame : table of the cases, with the safety factors as figures of merit
    criteria : of the study; one on a safety factor stays as it is
    """
    chosen = {criterion.kpi for criterion in criteria}
    stated = [key for key in FACTORS if key in frame and (frame[key] > 0.0).any()]
    return [*criteria, *(Criterion(key, ">=", LEAST) for key in stated if key not in chosen)]


def criteria_table(criteria: Sequence[Criterion]) -> str:
    """Return the `criteria` of a study as HTML, under a heading."""
    rows = [[DEFINITION_OF[criterion.kpi].title, required_words(criterion)] for criterion in criteria]
    return f"<h2>Criteria</h2>{table(['figure of merit', 'required'], rows, texts=2)}"


def as_path(value: object) -> Path | None:
    """Return the file that a `value` of `--ask` names; None where it names none."""
    return None if value is None else Path(str(value))
