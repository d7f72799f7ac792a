"""The suite's scenarios as cases: by the entrants' door a law does exactly what it does in the loop."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from heave_bringup.benchmark.entrants.table import Named
from heave_bringup.benchmark.interface import Command, Facts, Measurement
from heave_bringup.benchmark.outcome import figures_of
from heave_bringup.benchmark.suite_cases import suite_cases
from heave_bringup.benchmark.worlds.scenario_world import ScenarioWorld
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario

CASES = {case.name: case for case in suite_cases()}


def test_a_law_of_the_suite_gives_the_same_numbers_by_the_entrants_door() -> None:
    problem = CASES["b2_calm_300"].make(3, 40.0)
    entrant = Named("suite:lqg").load()(problem.facts)
    outcome = problem.world.run(entrant)
    assert isinstance(problem.world, ScenarioWorld)
    scenario = load_scenario("b2_calm_300", settings=["winch_controller.law=lqg", "all.seed=3", "all.duration=40"])
    record = ClosedLoop(loop_parameters(scenario)).run()
    np.testing.assert_array_equal(outcome.signals.payout_rate.value, record.column("payout_rate"))
    np.testing.assert_array_equal(outcome.signals.tension.value, record.column("top_tension"))


class Watcher:
    """Notes what it is given, and follows the MRU."""

    seen: list[Measurement]

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self.seen = []

    def step(self, measurement: Measurement) -> Command:
        self.seen.append(measurement)
        return Command(measurement.mru[-1].heave_rate if measurement.mru else 0.0)


def test_an_entrant_is_given_noisy_late_readings_and_nothing_else() -> None:
    problem = CASES["b3_deep_900"].make(1, 80.0)
    entrant = Watcher(problem.facts)
    outcome = problem.world.run(entrant)
    assert problem.facts.preview is None
    assert [field.name for field in dataclasses.fields(Measurement)] == [
        "time", "mru", "depth", "load_cell", "winch", "target",
    ]  # fmt: skip
    late = entrant.seen[1200:]
    boom_tip = np.interp([m.time for m in late], outcome.time, outcome.signals.boom_tip_heave.value)
    noise = np.array([m.mru[-1].heave for m in late]) - boom_tip
    assert float(noise.std()) == pytest.approx(0.01, rel=0.15)
    assert all(reading.time == pytest.approx(m.time - 0.1) for m in late for reading in m.depth)
    # the encoder's steps of 1 mm, and a command that takes effect 0.2 s, four ticks, after the start of its tick
    assert all(abs(m.winch.payout * 1e3 - round(m.winch.payout * 1e3)) < 1e-6 for m in late)
    assert late[0].winch.command == len(entrant.seen) - len(late) - 4


def test_belief_of_a_model_error_is_not_the_truth() -> None:
    problem = CASES["b9_model_error"].make(2, 400.0)
    world = problem.world
    assert isinstance(world, ScenarioWorld)
    assert problem.facts.winch.time_constant == 0.15
    assert world.scenario.parameters["virtual_winch"].time_constant != 0.15
    assert world.scenario.parameters["cable_sim"].unit.drag_coefficient == (4.0, 4.0, 4.0)


def test_seeds_make_other_seas_and_equal_seeds_equal_ones() -> None:
    def tip(seed: int) -> np.ndarray:
        problem = CASES["b2_calm_300"].make(seed, 20.0)
        return problem.world.run(Named("locked").load()(problem.facts)).signals.boom_tip_heave.value

    np.testing.assert_array_equal(tip(1), tip(1))
    assert np.abs(tip(1) - tip(2)).max() > 0.01


def test_locked_winch_leaves_the_uncompensated_motion() -> None:
    case = CASES["b2_calm_300"].shortened(160.0)
    problem = case.make(1, case.duration)
    figures = figures_of(problem.world.run(Named("locked").load()(problem.facts)), case.start, case.end)
    assert figures["unit_sigma_m"] == pytest.approx(figures["uncompensated_sigma_m"], rel=1e-6)
    assert math.isnan(figures["touchdown_speed_mps"])


def test_programme_of_depth_is_the_target_and_the_reading_of_it() -> None:
    case = CASES["b7_landing"]
    assert case.duration == 900.0
    problem = case.make(1, 170.0)
    entrant = Watcher(problem.facts)
    problem.world.run(entrant)
    # lowering begins at 150 s with 0.2 m/s
    assert entrant.seen[round(149.0 / 0.05)].target.payout == 0.0
    assert entrant.seen[-1].target.payout_rate == pytest.approx(0.2, rel=1e-3)
    assert 2.0 < entrant.seen[-1].target.payout < 4.0
