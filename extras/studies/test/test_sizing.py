"""Which winch: knees and hours of cases whose answers are known, and the command."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pandas
import pytest
from cable_sim_node.winch.parameters import WinchParameters
from heave_bags.analyse import kpi_set
from heave_bringup.cli import main
from heave_node.criteria import Criterion
from heave_node.parameters import ParameterError
from heave_studies.operability.limits import HEIGHT, PERIOD
from heave_studies.sizing import (
    PLACES,
    STOP,
    Candidate,
    as_link,
    candidates,
    even_seas,
    knees,
    own_winch,
    size_winches,
)
from heave_studies.study import cases as engine
from heave_studies.study.runs import CaseResult, Task

OWN = Candidate(speed=2.0, acceleration=1.5, power=math.inf, delay=0.2)
RESIDUAL = Criterion("significant_residual_m", "<=", 0.3)
POWER_PER_METRE, CYCLES_PER_METRE, RANGE_PER_METRE = 1e4, 100.0, 5e3
"""Pretended cases: power, cycles of bending and tension, range of tension in a sea of 1 m."""


def kpis_of(speed: float, height: float) -> dict[str, float]:
    """Return figures of a winch whose limit is twice its speed in metres of Hs, up to 3 m."""
    limit = min(2.0 * speed, 3.0)
    return dict.fromkeys(kpi_set.DEFINITION_OF, 0.0) | {
        "significant_residual_m": 0.3 * height / limit,
        "power_peak_w": 10.0 * POWER_PER_METRE * height,
        "power_rms_w": POWER_PER_METRE * height,
        "energy_wh_per_h": POWER_PER_METRE * height,
        "energy_regenerated_wh_per_h": 0.5 * POWER_PER_METRE * height,
        "bending_cycles_per_h": CYCLES_PER_METRE * height,
        "time_above_half_rating_percent": 10.0 * height,
        "tension_cycles_per_h": CYCLES_PER_METRE * height,
        "tension_range_equivalent_n": RANGE_PER_METRE * height,
    }


def frame_of(winches: list[Candidate], heights=(1.0, 2.0, 4.0), periods=(8.0, 11.0)) -> pandas.DataFrame:
    """Return the table of a study of these winches."""
    link = as_link(winches, 1.5)
    rows = []
    for number in range(len(winches)):
        places = {place: link[place][number] for place in PLACES}
        for period in periods:
            for height in heights:
                head = {"case": len(rows) + 1, "seed": 1, "nominal": False, **places, PERIOD: period, HEIGHT: height}
                outcome = {"failure": "", "lost": False, "reason": "", "met": True, "missed": "", "breaches": ""}
                rows.append({**head, **outcome, "compensating_share": 1.0, **kpis_of(winches[number].speed, height)})
    return pandas.DataFrame(rows)


def sized(values):
    frame = frame_of(candidates(OWN, 1e5, {"speed": values, "acceleration": [], "power": [], "delay": []}))
    return size_winches(frame, [RESIDUAL], even_seas(frame))


def test_the_knee_is_where_a_sweep_gives_95_percent_of_its_best():
    found = sized([0.5, 1.0, 1.5])
    # limits of 1, 2, 3 and 3 m of 4 m; heights count in 25 even steps, so that a share is exact to one of them
    assert [one.share for one in found] == pytest.approx([0.75, 0.25, 0.5, 0.75], abs=1.0 / 25)
    (knee,) = knees(found)
    between = (0.95 * found[0].share - found[2].share) / (found[3].share - found[2].share)
    assert knee.value == pytest.approx(1.0 + 0.5 * between)
    assert not knee.is_open


def test_a_sweep_whose_cheapest_winch_is_enough_says_so():
    (knee,) = knees(sized([1.5, 1.75]))
    assert (knee.value, knee.is_open, knee.text) == (1.5, True, "at most 1.5")


def test_of_a_delay_the_long_one_is_the_cheap_one():
    tried = candidates(OWN, 1e5, {"speed": [], "acceleration": [], "power": [], "delay": [0.4, 0.8]})
    frame = frame_of(tried)
    frame["significant_residual_m"] = [0.075 * row[HEIGHT] * row[PLACES[3]] / 0.2 for _, row in frame.iterrows()]
    found = size_winches(frame, [RESIDUAL], even_seas(frame))
    (knee,) = knees(found)  # limits of 4, 2 and 1 m: 95 % of 4 m lie between 0.2 and 0.4 s
    assert 0.2 < knee.value < 0.3
    assert not knee.is_open


def test_an_hour_is_a_mean_over_the_workable_seas():
    one = sized([0.5])[1]  # works up to 1 m of 4 m: even steps of 0.16 m, whose mean below 1 m is 0.48 m
    assert one.duty["energy_wh_per_h"] == pytest.approx(POWER_PER_METRE * 0.48)
    assert one.duty["bending_cycles_per_h"] == pytest.approx(CYCLES_PER_METRE * 0.48)
    assert one.duty["power_peak_w"] == pytest.approx(10.0 * POWER_PER_METRE * 0.88)
    assert one.duty["energy_regenerated_wh_per_h"] == pytest.approx(0.5 * one.duty["energy_wh_per_h"])


def test_the_duty_cycle_of_an_hour_is_load_cycles_a_range_of_equal_damage_and_time_at_high_load():
    duty = sized([0.5])[1].duty  # even steps of 0.16 m from 0.08 to 0.88 m
    assert duty["tension_cycles_per_h"] == pytest.approx(CYCLES_PER_METRE * 0.48)
    assert duty["time_above_half_rating_percent"] == pytest.approx(4.8)
    heights = [0.08 + 0.16 * step for step in range(6)]
    of_equal_damage = (sum(height**4 for height in heights) / 6) ** 0.25
    assert duty["tension_range_equivalent_n"] == pytest.approx(RANGE_PER_METRE * of_equal_damage)
    assert of_equal_damage > 0.48, "the high seas do more than their share"


def test_a_winch_that_can_work_nowhere_has_no_hour():
    one = sized([0.01])[1]
    assert one.share == 0.0
    assert math.isnan(one.duty["power_peak_w"])


def test_the_sweeps_begin_at_the_scenario_and_each_changes_one_particular():
    tried = candidates(OWN, 1e5, dict.fromkeys(("speed", "acceleration", "power", "delay")))
    assert tried[0] == OWN
    for one in tried[1:]:
        differing = [
            name for name in ("speed", "acceleration", "power", "delay") if getattr(one, name) != getattr(OWN, name)
        ]
        assert differing == [one.sweep]
    # power is tried as shares of static tension times speed limit
    assert [one.power for one in tried if one.sweep == "power"] == pytest.approx([2e4, 4e4, 8e4])


def test_a_weaker_winch_stops_with_all_that_it_has():
    link = as_link(candidates(OWN, 1e5, {"speed": [], "acceleration": [0.5], "power": [], "delay": []}), 1.2)
    assert link[STOP] == (1.2, 0.5)


def test_a_drive_with_its_physics_has_no_such_limits():
    with pytest.raises(ParameterError, match=r"drive = electric.*speed_servo"):
        own_winch(WinchParameters(drive="electric"))


def pretended(task: Task) -> CaseResult:
    settings = task.case.settings
    kpis = kpis_of(float(settings[PLACES[0]]), float(settings[HEIGHT]))  # type: ignore[arg-type]
    return CaseResult(task.case, kpis, "", 1.0)


def test_the_study_answers_for_each_winch(tmp_path: Path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(engine, "run_task", pretended)
    command = [
        *("study", "sizing", "--vary", f"{HEIGHT}=1,2,4", "--ask", "speed=[0.5, 1]", "--ask", "delay=[]"),
        *("--require", "significant_residual_m<=0.3", "--json", "answer.json", "--processes", "1"),
    ]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "all seas up to Hs 4 m" in said
    answer = json.loads((tmp_path / "answer.json").read_text())
    assert len(answer["winches"]) == 1 + 2 + 3 + 3
    assert set(answer["knees"]) == {"speed", "acceleration", "power"}
    page = (tmp_path / "studies" / "sizing" / "page.html").read_text()
    assert page.count('class="figure"') == 3
    for heading in ("half of rated speed or power", "cycles of the top tension", "damage-equivalent tension range"):
        assert heading in said
        assert heading in page
    assert "Fewer than 3 seeds show no confidence" in page
    assert "m = 4 (stranded steel wire rope" in " ".join(page.split())
