"""What a bag carries of the strength of a lift: from its scenario to figures of merit, verdict and report."""

import pytest
from heave_bags.analyse import analysis
from heave_bags.analyse.read_run import read_run
from heave_bags.analyse.verdict import judge
from heave_bags.report import report
from made_up_run import SCENARIO, MadeUpRun, write_run

STATED = SCENARIO.replace(
    b"system: {winch: {", b"system: {cable: wire_28mm_6x36, unit: {attachment_breaking_force: 6.0e+5}, winch: {"
)
HEAVY = MadeUpRun(duration=30.0, mean_tension=528_500.0, tension=1_500.0)
"""Its top tension swings up to 530 kN, its tension at the unit stays at 528.5 kN."""


def test_a_wire_of_494_kn_that_carried_530_kn_failed(tmp_path):
    write_run(tmp_path / "run", HEAVY, scenario=STATED)
    record = read_run(tmp_path / "run")
    values = record.kpis()
    assert values["rope_safety_factor"] == pytest.approx(494.0 / 530.0, rel=1e-3)
    verdict = judge(record, moves_winch=False)
    assert verdict.state == "FAILED"
    assert [check.state for check in verdict.loads] == ["FAILED", "FAILED"]
    assert verdict.loads[1].factor == pytest.approx(600.0 / 528.5)
    page = report.render([record])
    assert 'class="tile"' in page
    assert "safety factor of the rope" in page


def test_the_factor_in_table_and_verdict_is_that_of_the_largest_load_of_the_whole_run(tmp_path):
    write_run(tmp_path / "run", HEAVY, scenario=STATED)
    record = read_run(tmp_path / "run")
    record.signals.tension.value[:5] = 988_000.0  # in the transient, which other figures leave out
    factor = record.kpis()["rope_safety_factor"]
    assert factor == pytest.approx(494.0 / 988.0, rel=1e-3)
    assert factor == judge(record, moves_winch=False).loads[0].factor
    assert record.kpis(15.0, 20.0)["rope_safety_factor"] > 0.9, "of a window, that of the window"


def test_a_bag_whose_scenario_states_no_strength_has_no_factor(tmp_path):
    write_run(tmp_path / "run", MadeUpRun(duration=30.0))
    (record,) = analysis.analyse([tmp_path / "run"])
    assert record.signals.strengths == ()
    assert analysis.to_json(record)["rope_safety_factor"] is None
    assert "safety factor" not in analysis.table([record])
