"""Constant tension and landing: compensation goes on from where the unit is."""

from dataclasses import replace

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import make_scenario
from winch_controller_node.core.estimation.handover import (
    SEEN_SIGMA,
    hand_over,
    hand_over_seen,
    hand_over_standing,
)
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.sensors import MruModelParameters
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.validation.peers.reference_systems import DEEP_900

DT = 0.05
CABLE = {**DEEP_900, "length": 570.0}
"""The 125 t unit of the landing benchmark, 50 kN in water."""
SEA = {"significant_wave_height": 1.5, "peak_period": 10.0}


def loop_above(seabed, duration, seed, *, winch=None, **controller):
    """Return the full plant with its static depth near 572.7 m above a seabed [m], and a quick start."""
    return ClosedLoop(
        loop_parameters(
            make_scenario(
                {
                    "/**": {"seed": seed, "duration": duration},
                    "wave_vessel": SEA | {"ramp": 10.0, "vessel.natural_frequency": 0.9, "vessel.damping_ratio": 0.4},
                    "cable_sim": CABLE | {"segments": 12, "seabed.depth": seabed, "seabed.unit_damping": 7e5},
                    "virtual_winch": winch or {},
                    "winch_controller": CABLE
                    | {f"sea.{name}": value for name, value in SEA.items()}
                    | {"modes.settling_time": 10.0, "modes.fade_in_time": 5.0}
                    | controller,
                }
            )
        )
    )


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.long)])
def test_a_unit_is_landed_held_and_lifted_off_without_touching_again(seed):
    programme = {
        "programme.move_times": [30.0],
        "programme.move_payouts": [6.0],
        "programme.move_speeds": [0.2],
        "programme.mode_times": [70.0],
        "programme.modes": ["compensating"],
        "tension.lift_height": 1.0,
        # a winch that holds tension follows already: whether it could is not asked again
        "entry.peak_use": 0.1,
    }
    record = loop_above(575.0, 100.0, seed, **programme).run()
    hangs = next(time for time, alarm in record.alarms if alarm.name == "UNIT_SUSPENDED: weighed")
    assert [
        alarm.name for time, alarm in record.alarms if time >= hangs and alarm.row.part in ("depth", "sensors")
    ] == []
    assert "TOUCHDOWN: weighed" in {alarm.name for _, alarm in record.alarms}
    force, time = record.column("touchdown_force"), record.column("time")
    first = time[np.argmax(force > 0.0)]
    assert abs(record.column("unit_rate")[np.argmax(force > 0.0)]) < 0.3
    # benchmark B7: the cable keeps a tenth of its static tension
    assert np.min(record.column("top_tension", after=first)) > 0.1 * record.column("top_tension")[0]
    stands = (force[time > hangs] > 0.0).astype(int)
    assert not stands[-1]
    assert np.count_nonzero(np.diff(stands) > 0) == 0


def test_compensation_after_constant_tension_holds_the_unit_where_it_is():
    loop = loop_above(2000.0, 100.0, 1, **{"tension.hanging": True})
    for _ in range(500):
        loop.step()
    loop.controller.set_mode("constant_tension")
    held = np.array([loop.step()[1] for _ in range(600)])
    loop.controller.set_mode("compensating")
    rows = np.array([loop.step()[1] for _ in range(400)])
    # constant tension leaves the unit drifting; where it was at the change is the mean from then on. The cable stays
    # taut in this sea: a unit that a slack cable has set going at its resonance is not stopped within half a second
    assert abs(held[-1, 2] - held[0, 2]) > 0.05
    # a unit under way goes on for the half second of delay and lag
    assert np.max(np.abs(rows[:, 2] - held[-1, 2])) < 0.05 + 0.5 * abs(held[-1, 11])
    assert np.max(np.abs(np.diff(rows[:, 5]))) <= 1.5 * DT + 1e-9


def random_loop(seed):
    model = design_controller(WinchControllerParameters(length=900.0), tick_period=DT).model
    rng = np.random.default_rng(seed)
    return model, rng.standard_normal(model.order), np.eye(model.order), rng.standard_normal(model.order)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_hand_over_moves_nothing_but_the_mean(seed):
    """Payout mean + p, unit -mean + x and the pull x0 - p - x are what they were; the unit is at its mean."""
    model, estimate, covariance, mean_state = random_loop(seed)
    after = hand_over(model, estimate, covariance, mean_state)
    before, now = estimate + mean_state, after.estimate + after.mean_state
    payout, unit = model.state("payout"), model.state("unit_heave")
    np.testing.assert_allclose(now, before, atol=1e-12)
    assert after.mean_state[payout] - mean_state[payout] == pytest.approx(after.lowered)
    assert after.estimate[unit] + after.mean_state[unit] + after.mean_state[payout] == pytest.approx(0.0, abs=1e-12)


def test_a_unit_that_stood_begins_with_the_measured_pull_and_the_measured_depth():
    model, estimate, covariance, mean_state = random_loop(4)
    after = hand_over_standing(model, estimate, covariance, mean_state, pull=-0.2, heave=0.7)
    whole = after.estimate + after.mean_state
    tip = float(model.row("boom_tip_heave") @ after.estimate)
    pull = tip - whole[model.state("payout")] - whole[model.state("unit_heave")]
    assert pull == pytest.approx(-0.2)
    assert np.min(np.linalg.eigvalsh(after.covariance)) > 0.0
    # the depth sensor's own row: heave and bias together read what was read, about the new mean
    seen = after.estimate[model.state("unit_heave")] - after.lowered + after.estimate[model.state("depth_bias")]
    assert seen == pytest.approx(0.7)


MRU_SIGMA = 0.1


@pytest.fixture(scope="module")
def followed_model():
    """Follow the scale of the MRU, which has a high-pass of its own, and the bias of the depth sensor."""
    mru = MruModelParameters(scale_sigma=MRU_SIGMA, high_pass_period=30.0)
    sensors = replace(WinchControllerParameters().sensors, mru=mru)
    return design_controller(WinchControllerParameters(length=900.0, sensors=sensors), tick_period=DT).model


def random_covariance(model, seed):
    factor = np.random.default_rng(seed).standard_normal((model.order, model.order))
    return factor @ factor.T / model.order


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_is_believed_after_a_wrong_scale_is_a_covariance(followed_model, seed):
    covariance = random_covariance(followed_model, seed)
    estimate = np.random.default_rng(seed).standard_normal(followed_model.order)
    before = (estimate.copy(), covariance.copy())
    _, after = hand_over_seen(followed_model, estimate, covariance, payout=0.4, unit=np.array([-0.3, 0.2]))
    np.testing.assert_array_equal(after, after.T)
    assert np.min(np.linalg.eigvalsh(after)) > -1e-12
    # the values assumed are not written into
    np.testing.assert_array_equal(estimate, before[0])
    np.testing.assert_array_equal(covariance, before[1])


def test_drum_and_unit_are_where_they_were_seen_and_all_else_is_as_it_was(followed_model):
    model, covariance = followed_model, random_covariance(followed_model, 4)
    estimate = np.random.default_rng(4).standard_normal(model.order)
    x, P = hand_over_seen(model, estimate, covariance, payout=0.4, unit=np.array([-0.3, 0.2]))
    seen = [model.state(name) for name in ("payout", "unit_heave", "unit_heave_rate")]
    doubted = [*seen, model.state("payout_rate")]
    others = [i for i in range(model.order) if i not in doubted]
    assert list(x[seen]) == [0.4, -0.3, 0.2]
    # the rate of the drum is that of what the winch was sent: nobody has seen it
    assert x[doubted[-1]] == estimate[doubted[-1]]
    np.testing.assert_array_equal(x[others], estimate[others])
    np.testing.assert_array_equal(P[np.ix_(others, others)], covariance[np.ix_(others, others)])
    np.testing.assert_array_equal(P[np.ix_(doubted, doubted)], SEEN_SIGMA**2 * np.eye(4))
    assert not np.any(P[np.ix_(doubted, others)])
