"""The batch of lifts: within 2 % of the full loop where it covers a case, and flagged where it does not."""

from pathlib import Path

import numpy as np
import pandas
import pytest
import scipy.linalg
from heave_bags.analyse import kpi_set
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.settings import make_setting
from heave_studies.batch.kernel import hang, heights_seen
from heave_studies.batch.law import noises_seen, not_covered, stationary_gains
from heave_studies.batch.lifts import SEA_TRACKER, LiftBatch, NotCoveredError
from heave_studies.batch.line import SEEN_GONE, lanes_of
from heave_studies.study.cases import Cases, screening_words
from heave_studies.study.cost import LOOP
from heave_studies.study.engine import run_study
from heave_studies.study.plan import Study
from heave_studies.study.table import FLAG, SCREENED
from wave_vessel_node.component import boom_tip_heave
from wave_vessel_node.mru.mru import MotionReferenceUnit
from winch_controller_node.design.design import design_controller
from winch_controller_node.design.prediction import FilterModel
from winch_controller_node.design.seas import SeaTracker

HEIGHT, PERIOD = "system.sea.significant_wave_height", "system.sea.peak_period"
FIGURES = (
    *("unit_sigma_m", "uncompensated_sigma_m", "tension_max_n", "dynamic_amplification"),
    *("uncompensated_dynamic_amplification", "winch_speed_max_mps", "power_peak_w"),
)


def case(name: str = "unit_1500", **changes: object) -> Scenario:
    """Return a scenario with `changes`, their places with __ for the points."""
    places = {place.replace("__", "."): value for place, value in changes.items()}
    settings = [make_setting(place, value, "test") for place, value in places.items()]
    return load_scenario(name, settings=settings)


def in_sea(name: str, height: float, period: float, **changes: object) -> Scenario:
    """Return a scenario of 240 s in a sea of a `height` [m] and a `period` [s]."""
    sea = {HEIGHT.replace(".", "__"): height, PERIOD.replace(".", "__"): period}
    return case(name, **sea, all__duration=240.0, **changes)


@pytest.mark.parametrize(
    ("name", "height", "period", "law"),
    [
        ("unit_1500", 1.3, 10.0, "mpc"),
        ("unit_1500", 0.7, 13.5, "lqg"),
        ("b3_deep_900", 1.4, 11.0, "lqg"),
        ("b2_calm_300", 0.8, 12.0, "mpc"),
        ("unit_1500", 2.0, 9.0, "off"),
    ],
)
def test_figures_are_within_two_percent_of_the_full_loop(name: str, height: float, period: float, law: str) -> None:
    """The full loop is the reference: mean squares over two seeds."""
    scenario = in_sea(name, height, period, winch_controller__law=law)
    batch, parameters = LiftBatch(scenario), loop_parameters(scenario)
    found = np.zeros((2, len(FIGURES)))
    for seed, flown in zip((11, 12), batch.fly((11, 12)), strict=True):
        assert flown.flag == ""
        of_seed = type(parameters)(**{**vars(parameters), "seed": seed})
        record = ClosedLoop(of_seed, has_adviser=False).run()
        for row, one in enumerate((flown.record, record)):
            kpis = kpi_set.evaluate_run(run_signals(one, of_seed), scenario.run.transient, scenario.run.duration)
            found[row] += [kpis[key] ** 2 for key in FIGURES]
    known = found[1] > 0.0
    np.testing.assert_allclose(np.sqrt(found[0, known] / found[1, known]), 1.0, atol=0.02)


@pytest.mark.parametrize(("name", "height", "period"), [("unit_1500", 2.5, 9.0), ("b2_calm_300", 1.2, 8.0)])
def test_lanes_hang_as_the_line_of_the_plant_does(name: str, height: float, period: float) -> None:
    """The plant's own kernel is the reference, for as long as Newton's tolerance lets it: strains of 1e-4 squared."""
    batch = LiftBatch(in_sea(name, height, period, winch_controller__law="off"))
    course, ticks, seeds = batch._course([*range(8)]), 2000, [*range(8)]
    side_by_side, alone = np.zeros((2, ticks, 4, len(seeds)))
    lanes = lanes_of(batch._rest.arrays)
    hang(lanes, course, batch._timing, side_by_side)
    assert not lanes.seen[SEEN_GONE].any()
    for lane in seeds:
        assert batch._hang(lane, course, alone)
    scale = np.abs(alone).max(axis=(0, 2), keepdims=True)
    np.testing.assert_allclose(side_by_side / scale, alone / scale, atol=1e-8)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"cable_sim__current": [0.2, 0.0]}, "a current"),
        ({"system__cable__bending_stiffness": 1e3}, "bending"),
    ],
)
def test_a_line_that_does_not_hang_straight_down_in_still_water_runs_in_full(
    changes: dict[str, object], why: str
) -> None:
    with pytest.raises(NotCoveredError, match=why):
        LiftBatch(case(**changes))


def test_a_locked_line_that_comes_slack_is_the_plants_own_beside_a_lift_that_is_screened() -> None:
    winch = {"system__winch__speed_limit": 9.0, "system__winch__acceleration_limit": 20.0}
    (flown,) = LiftBatch(in_sea("b3_deep_900", 10.0, 10.0, winch_controller__law="lqg", **winch)).fly([1])
    tension = flown.record.column("uncompensated_tension")
    assert flown.flag == ""
    assert tension.min() == 0.0
    assert tension[0] < tension.max() < 8.0 * tension[0]


def test_gains_are_those_of_the_algebraic_riccati_equation() -> None:
    """scipy.linalg.solve_discrete_are is the reference, for sensors that all read in every tick."""
    random = np.random.default_rng(3)
    A, rows = 0.95 * scipy.linalg.orth(random.standard_normal((5, 5))), random.standard_normal((2, 5))
    Q, variances = np.diag(random.uniform(0.1, 1.0, 5)), np.array([0.3, 2.0])
    P = scipy.linalg.solve_discrete_are(A.T, rows.T, Q, np.diag(variances))
    gain = P @ rows.T @ np.linalg.inv(rows @ P @ rows.T + np.diag(variances))
    (found,) = stationary_gains(FilterModel(A, Q, [rows], [variances], [["a", "b"]]))
    np.testing.assert_allclose(found, gain, rtol=1e-9)


def test_the_sea_is_followed_as_the_core_follows_it() -> None:
    design = design_controller(case().parameters["winch_controller"], tick_period=0.05)
    time, core = 0.05 * np.arange(8000), SeaTracker(design)
    sigma = design.sigma["boom_tip_heave"]
    heave = sigma * (np.sin(0.7 * time) + 1.5 * np.sin(0.05 * time) * np.sin(0.8 * time))
    applied = []
    for value in heave:
        core.update(float(value))
        applied.append(float(core._record["applied"][0]))
    assert len(set(applied)) > 3
    np.testing.assert_allclose(heights_seen(heave, 0.05, sigma, SEA_TRACKER), applied, rtol=1e-12)


def test_the_noise_is_followed_as_the_core_follows_it() -> None:
    """The loop's own gates are the reference, read after 600 ticks of the same readings."""
    parameters = loop_parameters(in_sea("unit_1500", 1.0, 10.0))
    loop = ClosedLoop(parameters, has_adviser=False)
    for _ in range(600):
        loop.step()
    heave = boom_tip_heave(parameters.sea, parameters.seed, 0.05, 600)
    assert heave is not None
    read = MotionReferenceUnit(parameters.sea.mru, seed=parameters.seed, tick_period=0.05).series(heave)
    for row in range(2):
        sigma = loop.controller.observer.state["noises"][0][row]["sigma"]
        assert 0.01 * np.exp(noises_seen(read[:, row], 0.01)[-1]) == pytest.approx(float(sigma), rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"winch_controller__law": "industrial"}, "law industrial"),
        ({"virtual_winch__speed_gain": 0.8}, "virtual_winch.speed_gain = 0.8"),
        ({"cable_sim__unit__mass": 15e3}, "winch_controller.unit.mass = 12000.0, system.unit.mass = 15000.0"),
        ({"cable_sim__sensors__depth__bias": 0.2}, "cable_sim.sensors.depth.bias = 0.2"),
    ],
)
def test_what_is_not_covered_is_named(changes: dict[str, object], why: str) -> None:
    assert not_covered(case(**changes)) == why
    with pytest.raises(NotCoveredError, match=why[:20]):
        LiftBatch(case(**changes))


@pytest.mark.parametrize(
    ("scenario", "flag"),
    [
        (("b2_calm_300", 3.5, 6.0, {}), "a slack cable"),
        (("unit_1500", 1.0, 10.0, {"system__winch__speed_limit": 0.2}), "a limit of the winch"),
        (("unit_1500", 1.0, 10.0, {"system__winch__speed_limit": 0.3}), "near the winch's speed"),
    ],
)
def test_a_lift_that_leaves_what_is_linear_is_flagged(scenario: tuple, flag: str) -> None:  # type: ignore[type-arg]
    name, height, period, changes = scenario
    assert LiftBatch(in_sea(name, height, period, **changes)).fly([4])[0].flag == flag


def test_a_study_screens_what_it_can_and_runs_the_rest_in_full(tmp_path: Path) -> None:
    def study(has_screening: bool) -> Study:
        return Study(
            path=tmp_path / "two.yaml",
            scenario="unit_1500",
            duration=240.0,  # of 140 s the 20 that count hold 3 % of the start, which comes later in the full loop
            seeds=(1, 2),
            vary=({"winch_controller.law": ("mpc", "industrial")},),
            has_adviser=False,
            has_screening=has_screening,
        )

    frame, _ = run_study(Cases(study(True)), tmp_path / "screened", processes=1)
    full, _ = run_study(Cases(study(False)), tmp_path / "full", processes=1)
    assert frame[SCREENED].tolist() == [True, True, False, False]
    assert frame[FLAG].tolist() == ["", "", "law industrial", "law industrial"]
    assert not full[SCREENED].any()
    squares, of_full = frame["unit_sigma_m"] ** 2, full["unit_sigma_m"] ** 2
    assert np.sqrt(squares[:2].sum() / of_full[:2].sum()) == pytest.approx(1.0, abs=0.02), "as the page promises"
    assert squares[2:].tolist() == of_full[2:].tolist()
    assert screening_words(frame).startswith("2 of 4 cases were screened")
    assert screening_words(full) == ""
    loop = pandas.read_csv(tmp_path / "screened" / "cost.csv")[LOOP].tolist()
    assert loop[0] == loop[1] > 0.0, "lifts that were made together"
