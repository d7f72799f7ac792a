"""A lift from plan to as-built: plans refused, figures by hand, limits, weather windows, phases found in a bag."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas
import pytest
from heave_bags.analyse.run_record import RunRecord
from heave_bags.signals import RunSignals, Signal
from heave_bringup.cli import main
from heave_bringup.settings import Setting
from heave_node.criteria import Criterion
from heave_node.loads.strength import ROPE
from heave_node.parameters import ParameterError
from heave_studies.lift.as_built import IN_PART, NOT_REACHED, as_built
from heave_studies.lift.figures import GAUSSIAN, PLANNED, Motion, Place, Shape, Swing, expected_largest
from heave_studies.lift.forecast import read_forecast, warnings, windows
from heave_studies.lift.limits import Limit, PeriodLimits, largest_height, phase_limits, scaled
from heave_studies.lift.plan import AIR, SURFACE, WATER, Plan, read_plan
from heave_studies.lift.response import OMEGAS, locked_places, phase_scene
from heave_studies.lift.runs import Compensated, Runs, cross, crossings, shape_of_tension, swing_of
from heave_studies.lift.study import LiftStudy, judged_rows, limits_in, phase_table
from heave_studies.operability.limits import LOST_LIMIT
from heave_studies.operability.seas import SeaRecord, at_equal_steps
from heave_studies.study.study_file import find_study

HEAD = 'scenario: unit_1500\nwanted: {dynamic_amplification: "<= 1.3"}\nphases:\n'
LANDING = "  - {name: landing, depth: [1480, 1500], speed: 0.2, compensated: true}\n"


def _plan(folder: Path, text: str) -> Plan:
    (folder / "plan.yaml").write_text(text)
    return read_plan(folder / "plan.yaml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("phases: []\n", "scenario is missing"),
        (HEAD + "  - {depth: [0, 10], speed: 1}\n", "phase 1: name is missing"),
        (HEAD + "  - {name: a, depth: [0, 10]}\n", r"phase 1 \(a\): needs a duration"),
        (HEAD + "  - {name: a, speed: 1}\n", r"phase 1 \(a\): depth is missing"),
        (HEAD + "  - {name: a, depth: [0, 10], sped: 1}\n", "unknown key sped; known: .*speed"),
        (HEAD + "  - {name: a, depth: [0, 10], speed: -1}\n", r"speed = -1.0 is not allowed"),
        (
            HEAD + "  - {name: a, depth: [-9, -8], speed: 1, compensated: true}\n",
            "limits in air are those of the locked",
        ),
        (HEAD + LANDING + LANDING, "two phases are called landing"),
        (HEAD + '  - {name: a, depth: [0, 9], speed: 1, wanted: {kappa: "<= 1"}}\n', "kappa is no figure that a plan"),
        (
            HEAD + '  - {name: a, depth: [-9, -8], speed: 1, wanted: {unit_sigma_m: "<= 1"}}\n',
            "unit_sigma_m is known in water alone; here: dynamic_amplification",
        ),
        (
            HEAD.replace("dynamic_amplification", "unit_sigma_m") + "  - {name: a, depth: [-9, -8], speed: 1}\n",
            "no criteria: add wanted",
        ),
        ("periods: [9, 7]\n" + HEAD + LANDING, "periods must be ascending"),
    ],
)
def test_a_plan_that_is_wrong_is_refused_in_one_line_that_says_where(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(ParameterError, match=words) as caught:
        _plan(tmp_path, text)
    assert "plan.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_shipped_plan_is_right_and_takes_place_in_air_at_the_surface_and_in_water() -> None:
    plan = read_plan(find_study("lift"))
    assert [phase.kind for phase in plan.phases][:3] == [AIR, SURFACE, WATER]


def test_the_largest_value_expected_is_that_of_the_extreme_value_distribution() -> None:
    """Cartwright and Longuet-Higgins 1956: sqrt(2 ln N) + 0.5772 / sqrt(2 ln N) standard deviations."""
    largest = expected_largest(np.array([0.0]), [Swing(2.0, 0.1)], np.array([10_000.0]))
    root = math.sqrt(2.0 * math.log(1000.0))
    assert largest == pytest.approx(2.0 * (root + 0.5772 / root), rel=2e-3)


def test_places_that_are_alike_are_one_place() -> None:
    swing = Swing(1.0, 0.1)
    whole = expected_largest(np.array([1.0]), [swing], np.array([900.0]))
    parts = expected_largest(np.full(3, 1.0), [swing] * 3, np.full(3, 300.0))
    assert parts == pytest.approx(whole, rel=1e-6)


def _place(sigma: float) -> Place:
    return Place(1000.0, 1e5, 0.0, 8e4, 0.0, Motion(Swing(sigma, 0.1), Swing(sigma, 0.1), Swing(0.1, 0.1)))


def test_the_figures_of_a_swing_are_those_of_its_largest_value() -> None:
    """100 cycles: sqrt(2 (ln 100 + 0.5772)) = 3.2192 standard deviations."""
    places, capacity = [_place(1e4)], {ROPE: 5e5}
    assert PLANNED["dynamic_amplification"](places, capacity) == pytest.approx(1.32192, rel=1e-4)
    assert PLANNED["tension_ratio_min"](places, capacity) == pytest.approx(1.0 - 0.32192, rel=1e-4)
    assert PLANNED["rope_safety_factor"](places, capacity) == pytest.approx(5.0 / 1.32192, rel=1e-4)
    assert PLANNED["significant_residual_m"](places, capacity) == pytest.approx(0.4)
    assert math.isnan(PLANNED["winch_pull_factor"](places, capacity))


def test_slack_is_expected_where_the_smallest_tension_at_the_unit_is_below_zero() -> None:
    """3.2192 standard deviations of 80 kN at the unit: 24.85 kN."""
    assert PLANNED["slack_percent"]([_place(2.4e4)], {}) == 0.0
    found = PLANNED["slack_percent"]([_place(4e4)], {})
    assert found == pytest.approx(100.0 * 0.02275, rel=1e-3)  # the normal distribution at 2 standard deviations


def test_a_limit_is_where_its_figure_reaches_the_bound() -> None:
    criteria = [Criterion("dynamic_amplification", "<=", 1.32192), Criterion("tension_ratio_min", ">=", 0.5)]
    found = largest_height(criteria, lambda key, h: PLANNED[key](scaled([_place(5e3)], h), {}), 3.0, 10.0)
    assert found.height == pytest.approx(2.0, rel=5e-3)
    assert found.governs == "dynamic_amplification"


@pytest.mark.parametrize("guess", [0.5, 3.0, 8.0])
def test_few_values_of_a_figure_find_its_limit(guess: float) -> None:
    asked: list[float] = []

    def figure(height: float) -> float:
        asked.append(height)
        return 1.0 + 0.1 * height + 0.005 * height**2 if height < 7.0 else math.nan

    exact = (-0.1 + math.sqrt(0.01 + 0.02 * 0.4)) / 0.01
    assert largest_height(
        [Criterion("x", "<=", 1.4)], lambda _, h: figure(h), guess, 15.0, 0.02
    ).height == pytest.approx(exact, rel=0.02)
    assert len(asked) <= 8


def test_a_unit_in_air_swings_its_tension_by_mass_times_acceleration(tmp_path: Path) -> None:
    plan = _plan(tmp_path, HEAD + "  - {name: deck, depth: [-5, -5], duration: 600}\n")
    scene = phase_scene(plan, plan.phases[0], 9.0)
    (place,) = locked_places(scene, 2.0)
    step = OMEGAS[1] - OMEGAS[0]
    acceleration = 2.0 * math.sqrt(float(np.sum(scene.density * OMEGAS**4)) * step)
    assert place.motion.tension.sigma == pytest.approx((12000.0 + 5.0 * 3.4) * acceleration, rel=0.01)
    assert place.static == pytest.approx((12000.0 + 5.0 * 3.4) * scene.plant.gravity, rel=1e-3)


def test_a_slewing_crane_counts_where_it_heaves_most(tmp_path: Path) -> None:
    text = HEAD.replace("unit_1500", "crane_slew") + "  - {name: deck, depth: [-5, -5], duration: 600SLEW}\n"
    sigma = {}
    for slew in ("", ", slew: [1.5708, 2.618]", ", slew: [2.618, 2.618]"):
        plan = _plan(tmp_path, text.replace("SLEW", slew))
        sigma[slew] = locked_places(phase_scene(plan, plan.phases[0], 9.0), 1.0)[0].motion.tension.sigma
    port, both, astern = sigma.values()
    assert both == pytest.approx(max(port, astern))
    with pytest.raises(ParameterError, match="slew: needs a crane"):
        bare = _plan(tmp_path, HEAD + "  - {name: deck, depth: [-5, -5], duration: 600, slew: [0, 1]}\n")
        phase_scene(bare, bare.phases[0], 9.0)


def test_a_strength_that_is_not_stated_is_asked_for(tmp_path: Path) -> None:
    head = "set: {system.cable.breaking_force: 0.0}\n" + HEAD
    plan = _plan(tmp_path, head.replace('dynamic_amplification: "<= 1.3"', 'rope_safety_factor: ">= 2"') + LANDING)
    with pytest.raises(ParameterError, match=r"set system\.cable\.breaking_force"):
        phase_limits(plan, plan.phases[0], 9.0, 1.0, Runs())


def test_a_plan_to_compensate_with_a_winch_that_does_not_is_refused(tmp_path: Path) -> None:
    plan = _plan(tmp_path, "set: {winch_controller.law: off}\n" + HEAD + LANDING)
    with pytest.raises(ParameterError, match=r"landing: compensated: the winch does not compensate"):
        phase_limits(plan, plan.phases[0], 9.0, 1.0, Runs())


class _Lost(Runs):
    def near(self, *_: object) -> Compensated:  # type: ignore[override]
        return Compensated(None, 0.0)


def test_compensation_that_is_lost_at_the_surface_leaves_no_limit_of_its_own(tmp_path: Path) -> None:
    box = ", ".join(f"system.unit.box.{side}: 3.0" for side in ("length", "breadth", "height"))
    text = f"seeds: 1\nset: {{{box}, cable_sim.wave.source: sea, system.boom_tip_height: 15.0}}\n{HEAD}"
    plan = _plan(
        tmp_path, text.replace("1.3", "1.6") + "  - {name: splash, depth: [-5, 1], speed: 0.3, compensated: true}\n"
    )
    found = phase_limits(plan, plan.phases[0], 9.0, 1.0, _Lost())
    assert found.locked.height > 0.0
    assert found.planned(plan.phases[0]) == Limit(0.0, LOST_LIMIT)


def test_a_crane_that_stands_moves_the_boom_tip_no_other_way_than_without_it(tmp_path: Path) -> None:
    text = HEAD.replace("unit_1500", "crane_slew") + "  - {name: deck, depth: [-5, -5], duration: 20}\n"
    plan = _plan(tmp_path, text)
    scene = phase_scene(plan, plan.phases[0], 9.0)
    assert scene.scenario.parameters["wave_vessel"].crane.is_fitted
    still = [Setting(node, name, value, "test") for (node, name), value in scene.still_crane.items()]
    without = phase_scene(plan, plan.phases[0], 9.0, still)
    assert not without.scenario.parameters["wave_vessel"].crane.is_fitted
    assert without.density == pytest.approx(scene.density)


def _forecast(heights: list[float]) -> SeaRecord:
    index = pandas.date_range("2026-11-27", periods=len(heights), freq="h", tz="UTC")
    return at_equal_steps("f.csv", pandas.DataFrame({"hs": heights, "tp": 9.0}, index=index), ())


def _two_phases(folder: Path, *, may_wait: bool) -> tuple[Plan, dict[str, list[PeriodLimits]]]:
    text = "alpha: 0.5\nperiods: [7, 11]\n" + HEAD
    text += "  - {name: one, depth: [20, 30], duration: 3600}\n"
    text += f"  - {{name: two, depth: [30, 40], duration: 3600, may_wait: {str(may_wait).lower()}}}\n"
    plan = _plan(folder, text)
    limits = {
        name: [PeriodLimits(name, period, Limit(height, "x")) for period in (7.0, 11.0)]
        for name, height in (("one", 4.0), ("two", 2.0))
    }
    return plan, limits


def test_phases_that_may_not_wait_need_one_window_together(tmp_path: Path) -> None:
    plan, limits = _two_phases(tmp_path, may_wait=False)
    one, two = windows(plan, limits, _forecast([1.9, 1.9, 1.9, 0.9, 0.9]))
    assert (one.waiting, two.waiting) == (2.0, 0.0)
    assert one.utilisation == pytest.approx(1.9 / (0.5 * 4.0))
    assert two.utilisation == pytest.approx(0.9)


def test_a_phase_that_may_wait_waits_for_itself(tmp_path: Path) -> None:
    plan, limits = _two_phases(tmp_path, may_wait=True)
    one, two = windows(plan, limits, _forecast([1.9, 1.9, 1.9, 0.9, 0.9]))
    assert (one.waiting, two.waiting) == (0.0, 2.0)


def test_a_contingency_time_makes_the_window_longer_and_may_leave_none(tmp_path: Path) -> None:
    plan, limits = _two_phases(tmp_path, may_wait=True)
    longer = replace(plan, whole=replace(plan.whole, contingency=1.0))
    one, two = windows(longer, limits, _forecast([1.9, 1.9, 0.9]))
    assert (one.waiting, two.start) == (0.0, None)
    assert one.utilisation == pytest.approx(0.95)


def test_a_gap_in_the_forecast_is_no_weather_to_go_in(tmp_path: Path) -> None:
    plan, limits = _two_phases(tmp_path, may_wait=True)
    one, two = windows(plan, limits, _forecast([0.5, math.nan, 0.5, 0.5]))
    assert (one.waiting, two.waiting) == (0.0, 1.0)
    (tmp_path / "s.csv").write_text("hs,7,9\n1,3,4\n2,1,2\n")
    with pytest.raises(ParameterError, match=r"s\.csv: is a scatter diagram"):
        read_forecast(tmp_path / "s.csv")


def test_a_phase_has_its_window_also_when_those_before_it_used_up_their_contingency(tmp_path: Path) -> None:
    """Two phases of an hour, each of which may take two: the second may last until the end of the fourth hour."""
    plan, limits = _two_phases(tmp_path, may_wait=False)
    longer = replace(plan, whole=replace(plan.whole, contingency=1.0))
    one, _ = windows(longer, limits, _forecast([0.9, 0.9, 0.9, 1.1]))
    assert one.start is None
    one, two = windows(longer, limits, _forecast([1.9, 0.9, 0.9, 0.9]))
    assert (one.waiting, two.waiting) == (0.0, 0.0)


def test_a_forecast_beyond_the_periods_of_the_plan_is_said(tmp_path: Path) -> None:
    plan, _ = _two_phases(tmp_path, may_wait=True)
    forecast = _forecast([1.0, 1.0])
    assert warnings(plan, forecast) == []
    forecast.states.loc[forecast.states.index[0], "tp"] = 14.0
    (words,) = warnings(plan, forecast)
    assert "1 of 2 peak periods lie outside 7 to 11 s" in words


def _record(depths: list[float], peaks: list[float]) -> RunRecord:
    time = np.arange(0.0, 400.0, 0.5)
    depth = np.interp(time, np.linspace(0.0, 400.0, len(depths)), depths)
    tension = 1e5 * np.ones(time.size)
    for number, peak in enumerate(peaks):
        tension[np.searchsorted(time, 100.0 + 200.0 * number)] = peak
    signals = RunSignals(
        unit_height=Signal(time, -depth), tension=Signal(time, tension), static_tension=Signal(time[:1], tension[:1])
    )
    return RunRecord("bag", signals, 0.0, 400.0)


TWO_DEPTHS = "  - {name: down, depth: [20, 110], speed: 0.5}\n  - {name: low, depth: [111, 200], speed: 0.5}\n"


def test_a_bag_is_judged_by_phase_as_its_unit_gets_deeper(tmp_path: Path) -> None:
    plan = _plan(tmp_path, HEAD + TWO_DEPTHS)
    down, low = as_built(plan, _record([10.0, 210.0], [1.2e5, 1.5e5]))
    assert (down.state, low.state) == ("passed", "FAILED")
    assert down.judged[0].value == pytest.approx(1.2, rel=1e-3)
    assert low.failures[0].startswith("low: Dynamic amplification 1.500")
    assert down.end <= low.start


def test_the_tension_at_rest_is_that_of_the_phase_not_of_the_deck(tmp_path: Path) -> None:
    """The unit hung in air at 150 kN when the bag began; in water it hangs at 100 kN, with peaks of 120 and 150 kN."""
    plan = _plan(tmp_path, HEAD + TWO_DEPTHS)
    record = _record([10.0, 210.0], [1.2e5, 1.5e5])
    record.signals.static_tension = Signal(np.zeros(1), np.full(1, 1.5e5))
    down, low = as_built(plan, record)
    assert [one.judged[0].value for one in (down, low)] == pytest.approx([1.2, 1.5], rel=1e-3)


def test_a_ship_without_the_truth_is_judged_by_what_its_sensors_tell(tmp_path: Path) -> None:
    """Lowered at 0.4 m/s with a heave of 0.1 m at 9 s; residual 4 x 0.1/sqrt(2). The attachment has no sensor."""
    text = HEAD.replace('"<= 1.3"', '"<= 1.3", rope_safety_factor: ">= 3", attachment_safety_factor: ">= 3", ')
    text = text.replace("wanted", "set: {system.cable.breaking_force: 494000.0}\nwanted").replace(", }", "}")
    text = text.replace(
        "attachment_safety_factor", 'significant_residual_m: "<= 0.3", slack_percent: "<= 0", attachment_safety_factor'
    )
    plan = _plan(tmp_path, "period: 9\n" + text + TWO_DEPTHS)
    record = _record([10.0, 210.0], [1.2e5, 1.5e5])
    height = record.signals.unit_height
    height.value += 0.1 * np.sin(2.0 * np.pi / 9.0 * height.time)
    record.signals.static_tension = Signal()
    record.sources["unit height"] = "measured"
    down, low = as_built(plan, record)
    by_key = {one.criterion.kpi: one for one in low.judged}
    assert by_key["dynamic_amplification"].value == pytest.approx(1.5, rel=0.01)
    assert by_key["rope_safety_factor"].value == pytest.approx(494.0 / 150.0, rel=0.01)  # of the plan's rope
    assert by_key["significant_residual_m"].value == pytest.approx(4.0 * 0.1 / math.sqrt(2.0), rel=0.03)
    assert by_key["slack_percent"].got == "unknown, it needs the tension at the load"
    assert "the tension at the load" in by_key["attachment_safety_factor"].got
    assert low.state == "FAILED"
    assert [words.split(" ")[1] for words in low.failures] == ["Dynamic"]
    # from 20 m on: a depth sensor notices the waves of 9 s down to 63 m
    assert down.state == IN_PART
    assert math.isnan(next(one.value for one in down.judged if one.criterion.kpi == "significant_residual_m"))


def test_a_phase_that_the_bag_does_not_reach_is_reported_as_such(tmp_path: Path) -> None:
    plan = _plan(tmp_path, HEAD + TWO_DEPTHS)
    record = _record([10.0, 90.0], [1.2e5])
    down, low = as_built(plan, record)
    assert (down.state, low.state) == ("passed", NOT_REACHED)
    beyond = _plan(tmp_path, HEAD + "  - {name: far, depth: [900, 950], speed: 0.5}\n" + TWO_DEPTHS)
    assert [one.state for one in as_built(beyond, record)] == [NOT_REACHED, "passed", NOT_REACHED]
    with pytest.raises(ParameterError, match=r"its unit is at 900 to 950 m depth"):
        as_built(plan, _record([900.0, 950.0], []))
    with pytest.raises(ParameterError, match="does not say how deep"):
        as_built(plan, RunRecord("bag", RunSignals(), 0.0, 1.0))


def test_noise_on_a_signal_does_not_swing() -> None:
    """A sine of 0.1 Hz with 5 % of noise at 20 Hz; by its derivative it would swing 0.3 times a second."""
    time = np.arange(0.0, 200.0, 0.05)
    noise = 0.05 * np.random.default_rng(1).standard_normal(time.size)
    found = swing_of(np.sin(0.2 * np.pi * time) + noise, 200.0)
    assert found.rate == pytest.approx(0.1, rel=0.06)
    assert found.sigma == pytest.approx(1.0 / math.sqrt(2.0), rel=0.01)


def test_groups_and_hard_peaks_lower_the_largest_value() -> None:
    """Narrow: Vanmarcke 1975. Kurtosis of 2.5: x + (x^3 - 3 x)/48 of a Gaussian (Winterstein 1988), solved by hand."""
    place = np.array([0.0]), np.array([1000.0])
    plain = expected_largest(place[0], [Swing(1.0, 0.1)], place[1])
    narrow = expected_largest(place[0], [Swing(1.0, 0.1, width=0.2)], place[1])
    hard = expected_largest(place[0], [Swing(1.0, 0.1, shape=Shape(2.5))], place[1])
    assert plain == pytest.approx(3.2192, rel=1e-3)
    assert 0.9 * plain < narrow < 0.97 * plain
    assert hard + (hard**3 - 3.0 * hard) / 48.0 == pytest.approx(plain, rel=1e-3)
    skewed = expected_largest(place[0], [Swing(1.0, 0.1, shape=Shape(3.0, -0.3))], place[1])
    assert skewed + 0.05 * (skewed**2 - 1.0) == pytest.approx(plain, rel=1e-2)
    assert expected_largest(place[0], [Swing(1.0, 0.1, shape=Shape(3.0, -0.3)).mirrored], place[1]) > plain


def test_the_peaks_of_a_light_cable_without_drag_are_gaussian(tmp_path: Path) -> None:
    text = HEAD.replace("wanted", "set: {system.unit.drag_coefficient: [0, 0, 0]}\nwanted")
    plan = _plan(tmp_path, text + "  - {name: short, depth: [300, 300], duration: 600}\n")
    scene = phase_scene(plan, plan.phases[0], 9.0)
    assert shape_of_tension(plan, scene, 310.0, 1.0) == pytest.approx(GAUSSIAN, abs=0.3)


@pytest.mark.slow
def test_the_limit_at_resonance_is_that_of_runs_of_the_plant(tmp_path: Path) -> None:
    """Eight seeds: the standard error of their mean is 4 %, and within it and 5 % of the method the limits agree."""
    text = HEAD.replace("wanted", "set: {winch_controller.law: off, cable_sim.segments: 8}\nwanted")
    plan = _plan(tmp_path, text + "  - {name: resonance, depth: [1400, 1480], speed: 0.2}\n")
    limit = phase_limits(plan, plan.phases[0], 9.0, 1.0, Runs()).locked
    scene = phase_scene(plan, plan.phases[0], 9.0)
    ways = crossings(plan, scene, range(1, 9), segments=8)
    found = [cross(way, limit.height)["dynamic_amplification"] for way in ways]
    assert np.mean(found) - 1.0 == pytest.approx(0.3, rel=0.09)


DECK = HEAD + "  - {name: deck, depth: [-5, -5], duration: 600}\n"


def test_the_command_prints_limits_and_writes_page_and_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_lift.yaml").write_text("alpha: 0.5\nperiods: [8]\nheight: 2\nperiod: 8\n" + DECK)
    (tmp_path / "f.csv").write_text(
        "time,hs,tp\n2026-11-27T00:00Z,9.5,8\n2026-11-27T01:00Z,0.5,8\n2026-11-27T02:00Z,1,8\n"
    )
    arguments = ["study", "my_lift.yaml", "--ask", "forecast=f.csv", "--processes", "1"]
    assert main([*arguments, "--json", "lift.json"]) == 0
    printed = capsys.readouterr().out
    assert "deck" in printed
    assert "GO after 1 h of waiting" in printed
    page = (tmp_path / "studies" / "my_lift" / "page.html").read_text()
    assert "Forecast and what the lift allows" in page
    found = json.loads((tmp_path / "lift.json").read_text())
    locked = found["limits"][0]["locked"]
    assert (locked["height"], locked["governs"]) == (pytest.approx(0.09 * 8.0**2), "")
    assert found["windows"][0]["start"] == "2026-11-27T01:00:00+00:00"
    (tmp_path / "f.csv").write_text("time,hs,tp\n2026-11-27T00:00Z,9.5,8\n2026-11-27T01:00Z,9.5,8\n")
    assert main(arguments) == 3
    assert "NO-GO: no window for deck" in capsys.readouterr().out


def frame_of(limits: dict[str, list[PeriodLimits]]) -> pandas.DataFrame:
    """Return the table of a lift with these limits, the winch locked."""
    rows = [
        {"phase": name, "period_s": one.period, "winch": "locked", "limit_m": one.locked.height,
         "governs": one.locked.governs, **one.locked.values}
        for name, of in limits.items()
        for one in of
    ]  # fmt: skip
    return pandas.DataFrame(rows)


def test_plan_and_bag_stand_in_one_table(tmp_path: Path) -> None:
    plan = _plan(tmp_path, "periods: [9]\n" + HEAD + TWO_DEPTHS)
    values = dict.fromkeys(PLANNED, 0.0) | {"dynamic_amplification": 1.25}
    limits = {name: [PeriodLimits(name, 9.0, Limit(2.5, "dynamic_amplification", values))] for name in ("down", "low")}
    built = as_built(plan, _record([10.0, 210.0], [1.2e5, 1.5e5]))
    study = LiftStudy(plan, 2.0, 9.0, limits, built=built)
    head, rows = phase_table(study)
    assert [row[head.index("way")] for row in rows] == ["20 to 110 m, 3 min, locked", "111 to 200 m, 3 min, locked"]
    assert [row[head.index("planned") :] for row in rows] == [["passed", "passed"], ["passed", "FAILED"]]
    head, rows = judged_rows(study)
    assert [row[head.index("planned") :] for row in rows] == [["1.250", "1.200"], ["1.250", "1.500, FAILED"]]
    assert limits_in(frame_of(limits)) == limits
