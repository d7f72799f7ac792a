"""Designs for the length that is out, adaptation to the sea, demand on the winch."""

import dataclasses
import math

import numpy as np
import pytest
from heave_node.numerics.linear_model import state_covariance
from heave_node.parameters import build_parameters
from winch_controller_node.adviser.component import Adviser
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.design_in_force import DesignInForce, designed
from winch_controller_node.core.estimation.observation_log import ROWS
from winch_controller_node.design.design import carry_sea, design_controller, length_followed
from winch_controller_node.design.feasibility import boom_tip_moments, feasibility_table, uncompensated_sigma
from winch_controller_node.design.prediction import predict_loop
from winch_controller_node.design.seas import PATIENCE, SeaSeen, SeaTracker, sea_that_was_seen, sigma_and_frequency
from winch_controller_node.interface.observations import READING_COLUMNS, TICK_COLUMNS, Observations
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.model.models import boom_tip_block
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.validation.peers.reference_systems import DEEP_900

DT = 0.05


def parameters(**values):
    named = {name.replace("__", "."): value for name, value in values.items()}
    return build_parameters(WinchControllerParameters, named, where="test: winch_controller")


def test_a_design_is_for_the_length_that_is_out_once_that_differs_by_a_twentieth():
    assert length_followed(parameters(length=300.0), 14.0, 300.0) == 300.0
    assert length_followed(parameters(length=300.0), 16.0, 300.0) == 316.0
    assert length_followed(parameters(length=10.0), -20.0, 10.0) == 1.0
    assert designed(parameters(length=300.0), 60.0, DT).length == 360.0
    own = design_controller(parameters(length=300.0), tick_period=DT, length=360.0)
    assert designed(parameters(length=300.0), 60.0, DT).gain == pytest.approx(own.gain, rel=1e-9)


def test_gains_of_the_length_that_is_out_hold_the_unit_stiller_than_those_of_the_first_length():
    """125 t from 50 m on, axial resonance at the sea's peak near 320 m; both with the estimator of the length that is
    out, so that the gains alone differ: those of another length are not the optimum.
    """
    unit = {name.replace(".", "__"): value for name, value in DEEP_900.items() if name != "length"}
    wanted = parameters(**unit, length=50.0, sea__significant_wave_height=1.5, sea__peak_period=10.0)
    first, gained = designed(wanted, 0.0, DT), []
    for length in (70.0, 120.0, 200.0, 320.0, 400.0):
        own = designed(wanted, length - 50.0, DT)
        fixed = predict_loop(dataclasses.replace(own, gain=first.gain)).sigma["unit_heave"]
        gained.append(1.0 - predict_loop(own).sigma["unit_heave"] / fixed)
    assert min(gained) > 0.0
    assert gained[3] > 0.1


def batch(first, payout, active):
    """Return a second in which nothing is read, the set-point at a `payout` [m], answer number `active` active."""
    ticks = np.zeros((20, len(TICK_COLUMNS)))
    ticks[:, TICK_COLUMNS.index("order_payout")] = payout
    ticks[:, TICK_COLUMNS.index("brake")] = 1.0
    return Observations(first, ticks, ROWS, np.zeros((0, len(READING_COLUMNS))), epoch=0, beliefs=active)


def test_the_adviser_answers_with_the_design_of_the_length_that_is_out_and_the_core_goes_on_with_it():
    wanted = parameters(length=100.0)
    adviser, controller = Adviser(wanted, tick_period=DT), WinchController(wanted, tick_period=DT)
    given = ((0.0, 0), (4.0, 0), (30.0, 0), (30.0, 1))
    answers = [adviser.advise(batch(20 * k + 1, *one)) for k, one in enumerate(given)]
    assert [one.design.length if one.design else None for one in answers] == [None, None, 130.0, None]
    assert [one.number for one in answers] == [0, 0, 1, 1]
    assert answers[2].values == {}
    for tick in range(1, 62):
        controller.step(tick, Measurements())
    assert controller.take(answers[2])
    before = controller.estimator.estimate.copy()
    for tick in range(62, 82):
        controller.step(tick, Measurements())
    assert controller.design.length == 130.0
    assert controller.design.gain == pytest.approx(designed(wanted, 30.0, DT).gain, rel=1e-9)
    assert controller.design.model.order == len(before)
    assert controller.beliefs.number == 1


@pytest.mark.parametrize("sea", [{"sea__significant_wave_height": 2.5}, {"sea__filter_form": "thesis"}])
def test_a_redesign_for_another_sea_goes_on_with_the_same_motion(sea):
    in_force = DesignInForce(parameters(sea__significant_wave_height=1.0), tick_period=DT)
    old = in_force.design
    prepared = in_force.prepared(parameters(**sea), 0.0)
    matrix, _ = in_force.take(prepared)
    x = np.linalg.cholesky(old.initial_covariance + 1e-12 * np.eye(old.model.order)) @ np.random.default_rng(
        0
    ).standard_normal(old.model.order)
    for output in ("boom_tip_heave", "unit_heave", "payout"):
        size = old.sigma["boom_tip_heave"]
        assert in_force.design.model.row(output) @ matrix @ x == pytest.approx(
            old.model.row(output) @ x, abs=0.01 * size
        )


def test_the_tracker_finds_a_sea_twice_as_high_and_scales_the_noise_by_four():
    design = design_controller(parameters(), tick_period=DT)
    tracker = SeaTracker(design)
    sigma = design.sigma["boom_tip_heave"]
    noise = None
    for k in range(round(2.0 * PATIENCE / DT)):
        found = tracker.update(2.0 * math.sqrt(2.0) * sigma * math.sin(0.8 * k * DT))
        noise = found if found is not None else noise
    wave = design.model.state("wave_5")
    assert noise is not None
    assert noise[wave, wave] == pytest.approx(4.0 * design.model.noise_covariance[wave, wave], rel=0.05)
    payout = design.model.state("payout_rate")
    assert noise[payout, payout] == pytest.approx(design.model.noise_covariance[payout, payout])


def test_a_sea_is_not_said_to_be_lower_before_many_waves_have_been_seen_but_higher_within_two():
    design = design_controller(parameters(), tick_period=DT)
    sigma = math.sqrt(2.0) * design.sigma["boom_tip_heave"]
    lower, higher = SeaTracker(design), SeaTracker(design)
    assert all(lower.update(0.5 * sigma * math.sin(0.8 * k * DT)) is None for k in range(round(0.9 * PATIENCE / DT)))
    assert any(higher.update(3.0 * sigma * math.sin(0.8 * k * DT)) is not None for k in range(round(16.0 / DT)))


def test_the_sea_that_is_seen_has_the_moments_that_were_seen():
    """A sea of twice the height and other period than assumed, after many waves."""
    belief, there = (
        parameters().sea,
        dataclasses.replace(parameters().sea, significant_wave_height=2.0, peak_period=9.5),
    )
    heave, frequency = sigma_and_frequency(there, parameters().vessel)
    seen = SeaSeen(waves=1e4, heave=heave, frequency=frequency)
    found = sea_that_was_seen(seen, belief, belief, parameters().vessel)
    assert found.peak_period == pytest.approx(9.5, rel=1e-3)
    assert found.significant_wave_height == pytest.approx(2.0, rel=1e-3)
    assert sea_that_was_seen(seen, belief, found, parameters().vessel) is None


def test_a_few_waves_change_a_sea_less_unless_it_is_refuted():
    belief = parameters().sea
    heave, frequency = sigma_and_frequency(belief, parameters().vessel)
    few = SeaSeen(3.0, heave, 0.5 * frequency)
    shrunk, taken = (
        sea_that_was_seen(dataclasses.replace(few, is_refuted=known), belief, belief, parameters().vessel)
        for known in (False, True)
    )
    assert belief.peak_period < shrunk.peak_period < taken.peak_period


def test_a_sea_is_refuted_by_what_it_predicts_badly_and_by_nothing_else():
    tracker = SeaTracker(design_controller(parameters(), tick_period=DT))
    for nis in np.random.default_rng(0).chisquare(1, 2000):
        tracker.note_innovation(float(nis), 0.02)
        assert not tracker.is_refuted
    for _ in range(100):
        tracker.note_innovation(9.0, 0.02)
    assert tracker.is_refuted


def test_a_sea_is_not_refuted_by_errors_that_only_a_perfect_instrument_sees():
    """Errors of 6 mm/s are six times what an instrument of 1 mm/s would have, and nothing to a winch."""
    tracker = SeaTracker(design_controller(parameters(), tick_period=DT))
    for _ in range(400):
        tracker.note_innovation(36.0, 0.001)
    assert not tracker.is_refuted


def test_waves_are_carried_over_to_another_sea_by_the_motion_that_they_bring_about():
    old = design_controller(parameters(), tick_period=DT)
    new = design_controller(parameters(sea__peak_period=1.5 * parameters().sea.peak_period), tick_period=DT)
    matrix, added = carry_sea(old, new)
    P = old.initial_covariance
    for ticks in (0, 10, 40):
        before = old.model.row("boom_tip_heave") @ np.linalg.matrix_power(old.model.A, ticks)
        after = new.model.row("boom_tip_heave") @ np.linalg.matrix_power(new.model.A, ticks) @ matrix
        assert (after - before) @ P @ (after - before) < 0.05**2 * before @ P @ before
    assert np.min(np.linalg.eigvalsh(added)) > -1e-12


@pytest.mark.parametrize("delay", [0.2, 0.6], ids=["same winch", "slower winch"])
def test_the_boom_tip_of_a_vessel_with_raos_goes_on_as_it_moves_in_another_sea(delay):
    """Its two-state model is another one in each sea: the tip takes 0.19 of its heave at 8 s, 0.24 at 9.6 s."""
    rao = {"vessel__model": "rao", "vessel__boom_tip_arm": (-20.0, 10.0, 15.0)}
    sea = {"sea__significant_wave_height": 4.5, "sea__peak_period": 8.0}
    old = design_controller(parameters(**rao, **sea, winch__command_delay=0.2), tick_period=DT)
    other = parameters(**rao, **sea | {"sea__peak_period": 9.6}, winch__command_delay=delay)
    in_force = DesignInForce(old.parameters, tick_period=DT)
    matrix, _ = in_force.take_design(other, design_controller(other, tick_period=DT))
    new, P = in_force.design, old.initial_covariance
    for output in ("boom_tip_heave", "boom_tip_heave_rate"):
        for ticks, largest in ((0, 1e-9), (4, 0.005), (20, 0.02), (60, 0.05)):
            before = old.model.row(output) @ np.linalg.matrix_power(old.model.A, ticks)
            after = new.model.row(output) @ np.linalg.matrix_power(new.model.A, ticks) @ matrix
            assert (after - before) @ P @ (after - before) <= largest**2 * (before @ P @ before), (output, ticks)


def test_a_state_that_is_carried_to_the_same_sea_foresees_the_same_swell():
    """A swell of 16.5 s beside a wind sea: three seconds of prediction did not show its state."""
    sea = {"sea__spectrum": "ochi_hubble", "sea__shape": 1.0, "sea__peak_period": 6.0, "sea__filter_states": 10}
    swell = {"sea__swell__significant_wave_height": 1.0, "sea__swell__peak_period": 16.5}
    old = design_controller(parameters(**sea, **swell), tick_period=DT)
    matrix, _ = carry_sea(old, old)
    P, row = old.initial_covariance, old.model.row("boom_tip_heave")
    for seconds in (1.0, 4.0, 8.0):
        foreseen = row @ np.linalg.matrix_power(old.model.A, round(seconds / DT))
        error = foreseen @ matrix - foreseen
        assert error @ P @ error < 0.02**2 * row @ P @ row


def test_boom_tip_moments_of_the_spectrum_are_near_those_of_its_filter():
    # the six-state filter has a relative L2 error of 1.1 % of the Bretschneider spectrum
    tip = boom_tip_block(parameters().sea, parameters().vessel)
    P = state_covariance(tip)
    m0, m2, _ = boom_tip_moments(parameters().sea, parameters().vessel)
    heave, rate = tip.row("boom_tip_heave"), tip.row("boom_tip_heave_rate")
    assert m0 == pytest.approx(heave @ P @ heave, rel=0.02)
    assert m2 == pytest.approx(rate @ P @ rate, rel=0.03)


def test_demand_goes_with_the_height_and_power_with_tension_times_speed():
    small, large = feasibility_table(parameters(), [1.0, 2.0], [8.0])
    assert large.speed == pytest.approx(2.0 * small.speed)
    assert large.stroke == pytest.approx(2.0 * small.stroke)
    tension = small.torque / 0.75
    assert small.power == pytest.approx(tension * small.speed)
    assert small.within_limits


def test_a_winch_too_slow_for_the_sea_is_not_within_limits():
    (row,) = feasibility_table(parameters(winch__speed_limit=0.2), [3.0], [8.0])
    assert not row.within_limits


def test_the_uncompensated_motion_of_a_short_stiff_cable_is_that_of_the_boom_tip():
    short = parameters(length=5.0)
    P = state_covariance(boom_tip_block(short.sea, short.vessel))
    row = boom_tip_block(short.sea, short.vessel).row("boom_tip_heave")
    assert uncompensated_sigma(short, 5.0) == pytest.approx(math.sqrt(row @ P @ row), rel=0.02)
