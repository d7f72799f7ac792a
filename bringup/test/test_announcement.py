"""The first line of a run says what it will be judged by, and figures count from when compensation is settled."""

from __future__ import annotations

import numpy as np
import pytest
from heave_bags.analyse.events import COMPENSATES
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.run.criteria import announce, parse_requirement
from heave_bringup.scenarios import load_scenario, shipped_scenarios

LAST_PART = 10.0
"""Time before the figures count in which compensation must have been at full authority [s]."""

SHIPPED = sorted(name for name, path in shipped_scenarios().items() if path.parent.name == "scenarios")


@pytest.mark.parametrize("name", SHIPPED)
def test_a_run_says_what_counts_before_it_starts(name: str) -> None:
    scenario = load_scenario(name)
    said = announce(scenario)
    assert said.is_judged
    assert f"{scenario.run.transient:g} s to {scenario.run.duration:g} s" in said.text
    for criterion in scenario.wanted:
        assert DEFINITION_OF[criterion.kpi].title in said.text


@pytest.mark.parametrize("name", SHIPPED)
def test_a_run_that_ends_before_its_figures_count_says_so_before_it_starts_and_how_long_it_must_be(name: str) -> None:
    transient = load_scenario(name).run.transient
    for after in (0.5, 4.0, 59.0):  # a minute is some six waves
        said = announce(load_scenario(name, settings=[f"all.duration={transient + after}"]))
        assert not said.is_judged
        assert f"--duration {transient + 60.0:g}" in said.text
    assert announce(load_scenario(name, settings=[f"all.duration={transient + 60.0}"])).is_judged


def test_a_run_in_which_commands_move_nothing_says_before_it_starts_that_it_is_not_judged() -> None:
    said = announce(load_scenario("b2_calm_300"), replaced=("cable_sim=bag", "virtual_winch=bag"))
    assert (said.is_judged, "cable_sim and virtual_winch" in said.text) == (False, True)


@pytest.mark.parametrize("source, words", [("=bag", "from a bag"), ("", "from another wave_vessel")])
def test_a_sea_that_is_not_the_scenarios_is_not_given_its_seed(source: str, words: str) -> None:
    said = announce(load_scenario("b2_calm_300"), replaced=(f"wave_vessel{source}",))
    assert said.is_judged
    assert (f"sea {words}" in said.text, "seed" in said.text) == (True, False)


def test_a_criterion_of_the_command_line_is_said_once() -> None:
    scenario = load_scenario("b3_deep_900")
    same = parse_requirement("unit_sigma_m<=0.005")
    assert announce(scenario, [same]).text == announce(scenario).text
    assert "at most 2 cm" in announce(scenario, [parse_requirement("max_abs_heave<=2cm")]).text


@pytest.mark.parametrize("name", SHIPPED)
def test_figures_count_from_when_compensation_is_settled(name: str) -> None:
    """Compensation is active, and authority is no longer fading in."""
    scenario = load_scenario(name)
    if not scenario.moves_winch:
        return
    short = load_scenario(name, settings=[f"all.duration={scenario.run.transient}"])
    record = ClosedLoop(loop_parameters(short)).run()
    last = record.column("time") >= scenario.run.transient - LAST_PART
    assert np.isin(np.array(record.modes)[last], COMPENSATES).all()
    assert record.column("authority")[last].min() > 0.99
