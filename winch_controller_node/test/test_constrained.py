import dataclasses

import numpy as np
import osqp
import pytest
import scipy.sparse as sp
from heave_bringup.scenarios import load_scenario
from heave_core.law_table import COMMAND_STATE, RowKind, Way
from heave_core.library import new
from heave_node.parameters import build_parameters
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.core.loop_command import commander
from winch_controller_node.design.design import design_controller
from winch_controller_node.design.prediction import error_covariances, predict_loop
from winch_controller_node.laws.law import LawDesign
from winch_controller_node.laws.mpc import (
    ConstrainedLaw,
    MpcParameters,
    constrained_gain,
    free_gain,
)
from winch_controller_node.laws.parts import plan
from winch_controller_node.laws.parts.governor import drum_ahead
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.laws.parts.plan import correction_knots
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import SeaModelParameters, WinchModelParameters

from tests.core_parts import LoopNow, bounds, part, pose

DT = 0.05


@pytest.fixture(scope="module")
def design():
    sea = SeaModelParameters(significant_wave_height=3.0, peak_period=8.0)
    return design_controller(WinchControllerParameters(sea=sea), tick_period=DT)


def make_law(design, **changes):
    parameters = design.parameters
    made_for = LawDesign(design.model, parameters.winch, design.limits, parameters.weights, design.gain)
    return ConstrainedLaw(made_for, MpcParameters(**changes))


def sea_state(design, size, seed=0):
    """A state of sea and vessel of `size` standard deviations, with a winch that follows the boom tip just now."""
    x = np.zeros(design.model.order)
    index = [design.model.state(name) for name in design.sea_states]
    P = design.initial_covariance[np.ix_(index, index)]
    values, vectors = np.linalg.eigh(P)
    draw = np.random.default_rng(seed).standard_normal(len(index))
    x[index] = size * vectors @ (np.sqrt(np.maximum(values, 0.0)) * draw)
    rate = float(design.model.row("boom_tip_heave_rate") @ x)
    x[design.model.state("payout")] = float(design.model.row("boom_tip_heave") @ x)
    x[design.model.state("payout_rate")] = rate
    x[[design.model.state(name) for name in design.delay_states]] = rate
    return LoopState(x, Reference(), design.cable.static_tension)


def test_without_a_limit_in_reach_the_constrained_law_is_the_lqr(design):
    law = make_law(design)
    state = sea_state(design, 0.05)
    command = law.command(state)
    assert command.value == pytest.approx(-float(law.gain @ state.x), rel=1e-12)
    assert command.status == "free"


def test_noise_alone_does_not_reach_the_acceleration_limit(design):
    law = make_law(design)
    state = sea_state(design, 0.05)
    winch = design.parameters.winch
    limit = design.limits.acceleration * winch.time_constant
    _, rate = drum_ahead(design.model, design.parameters.winch) @ state.x
    wanted = -float(law.gain @ state.x)
    beyond = next(scale for scale in np.arange(1.0, 50.0, 0.25) if abs(scale * (wanted - rate)) > 1.02 * limit)
    spared = law.command(LoopState(state.x * beyond, Reference(), design.cable.static_tension))
    assert spared.status == "free", "the plan may use the start of a tick"
    assert abs(spared.value - beyond * rate) < limit


def test_the_gain_spares_the_command_once_a_limit_shapes_the_plan_and_slides_back_after_it(design):
    law = make_law(design)
    full, sparing = free_gain(design.model, MpcParameters()), constrained_gain(design.model, MpcParameters())
    np.testing.assert_array_equal(law.gain, full)
    assert law.command(sea_state(design, 1.2)).status == "solved"
    np.testing.assert_array_equal(law.gain, sparing)
    remaining = []
    for _ in range(round(MpcParameters().release_time / DT)):
        assert law.command(sea_state(design, 0.05)).status == "free"
        remaining.append(np.linalg.norm(law.gain - full))
    assert np.all(np.diff(remaining) < 0.0)
    assert remaining[-1] == pytest.approx(np.exp(-1.0) * np.linalg.norm(sparing - full), rel=1e-6)


@pytest.mark.parametrize(
    ("rate", "lower", "upper"), [(0.0, -0.5, 0.5), (0.8, -0.5, 0.5), (1.8, -0.5, 0.2), (-1.8, -0.2, 0.5)]
)
def test_the_envelope_bounds_a_plan_about_the_mean_payout_and_the_winch_bounds_all_of_it(design, rate, lower, upper):
    """2 m/s of the winch, 0.5 m/s of the envelope: a mean payout at 0.8 m/s is planned as one that stands."""
    law, tension = make_law(design), design.cable.static_tension
    core = law.core
    core.pose((0.0, rate, rate, tension, tension, 0.0, 0.0, 0.5), np.zeros(design.model.order))
    part("bound_plan")(core.winch, core.law, core.problem, core.state)
    ends, found = core.law["ends"][0], law.planner.bounds()
    for kind in (RowKind.PLANNED_SPEED, RowKind.PLANNED_SET_POINT):
        rows = slice(ends[kind - 1] if kind else 0, ends[kind])
        for values, expected in zip(found, (lower, upper), strict=True):
            np.testing.assert_allclose(values[rows], expected, rtol=1e-12)


def plan_by_rollout(design, law, state):
    """Roll the model forward under the law's plan, tick by tick; return rates, payouts and commands."""
    model, x = design.model, state.x.copy()
    rates, payouts, commands = [], [], []
    for k in range(len(law.planner.basis)):
        command = float(law.planner.basis[k] @ law.planner.plan) - float(law.gain @ x)
        commands.append(command)
        rates.append(float(model.row("payout_rate") @ x))
        payouts.append(float(model.row("payout") @ x))
        x = model.A @ x + model.B[:, 0] * command
    return np.array(rates), np.array(payouts), np.array(commands)


@pytest.mark.parametrize("seed", range(4))
def test_the_plan_keeps_speed_and_acceleration_of_the_winch(design, seed):
    """Soft constraints give way by their price alone: 0.1 % in the 2 s ahead, where they are kept at every tick."""
    law = make_law(design)
    state = sea_state(design, 1.2, seed)
    command = law.command(state)
    assert command.status == "solved"
    assert set(command.active) & {"speed", "acceleration"}
    rates, _, _ = plan_by_rollout(design, law, state)
    soon = rates[len(design.delay_states) : 40]
    assert np.max(np.abs(soon)) <= 2.0 * 1.001
    assert np.max(np.abs(np.diff(soon))) <= 1.5 * DT * 1.001


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("position_gain", [0.0, 0.2])
def test_the_plan_asks_a_slow_servo_for_no_more_than_it_takes(seed, position_gain):
    """Of 1 s at 1 m/s^2 it needs a set-point 1 m/s ahead of its speed; a winch takes none beyond its speed limit."""
    winch = WinchModelParameters(time_constant=1.0, position_gain=position_gain)
    sea = SeaModelParameters(significant_wave_height=3.0, peak_period=8.0)
    slow = design_controller(WinchControllerParameters(sea=sea, winch=winch), tick_period=DT)
    law = make_law(slow)
    state = sea_state(slow, 1.5, seed)
    command = law.command(state)
    assert command.status == "solved"
    assert "speed" in command.active
    _, payouts, commands = plan_by_rollout(slow, law, state)
    delay = len(slow.delay_states)
    asked = commands[: 40 - delay] - position_gain * payouts[delay:40]
    assert np.max(np.abs(asked)) <= 2.0 * 1.001


def test_the_plan_is_the_optimum_that_osqp_finds_for_the_same_problem(design):
    """A peer with another method (ADMM) solves the QP with hard limits where there is a feasible plan."""
    law = make_law(design)
    state = sea_state(design, 1.0, 1)
    assert law.command(state).status == "solved"
    free = law.planner.rows.free @ state.x
    lower, upper = bounds(law, state)
    hessian = law.planner.basis.T @ law.planner.basis * DT
    peer = osqp.OSQP()
    rows = sp.csc_matrix(law.planner.rows.forced)
    settings = {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 400_000, "verbose": False}
    peer.setup(sp.csc_matrix(hessian), np.zeros(len(hessian)), rows, lower - free, upper - free, **settings)
    best = peer.solve(raise_error=True).x
    assert law.planner.plan @ hessian @ law.planner.plan == pytest.approx(best @ hessian @ best, rel=1e-3)


@given(horizon=st.floats(1.0, 60.0), dt=st.floats(0.005, 0.2))
def test_every_correction_has_a_tick_before_the_end_of_the_horizon(horizon, dt):
    """One that has none made the plan's cost singular, and its commands no numbers: 10.25 s at 20 Hz."""
    knots = correction_knots(horizon, dt)
    assert (knots[0], knots[-1]) == (0, round(horizon / dt))
    assert np.all(np.diff(knots) > 0)
    assert knots[-1] - knots[-2] > 1  # a hat reaches from the knot before to the one after, and is 0 at both


def test_an_unsolved_problem_follows_the_last_good_plan_and_says_so(design):
    law = make_law(design, iteration_limit=5)
    state = sea_state(design, 3.0, 2)
    command = law.command(state)
    assert command.status.startswith("not solved in")
    assert np.isfinite(command.value)
    assert law.command(state).status.startswith("not solved in")


def test_a_solver_that_was_prepared_takes_the_place_of_one_that_is_restarted_and_finds_the_same(design, monkeypatch):
    """To set one up takes longer than a tick may."""
    plain, prepared = make_law(design), make_law(design)
    state = sea_state(design, 3.0)
    plain.command(state)
    prepared.command(state)
    plain.reset()
    wanted = plain.command(state)
    prepared.prepare()
    monkeypatch.setattr(plan.daqp, "Model", None)
    prepared.reset()
    assert prepared.command(state) == wanted
    assert wanted.iterations > 0


def test_the_plan_is_followed_between_solutions(design):
    law = make_law(design, solve_ticks=4)
    state = sea_state(design, 2.0, 0)
    first = law.command(state)
    plan = law.planner.plan.copy()
    second = law.command(state)
    np.testing.assert_array_equal(plan, law.planner.plan)
    assert second.value - first.value == pytest.approx(float((law.planner.basis[1] - law.planner.basis[0]) @ plan))


def test_the_mean_payout_takes_its_share_of_the_speed(design):
    """While the mean is paid out at 1 m/s, compensation may add 1 m/s on that side and 3 m/s on the other."""
    law = make_law(design)
    state = sea_state(design, 2.0, 0)._replace(reference=Reference(rate=1.0))
    lower, upper = bounds(law, state)
    assert (lower[0], upper[0]) == (-3.0, 1.0)


def test_the_plan_keeps_below_a_highest_tension(design):
    """A unit that falls at 0.2 m/s pulls in half a second; the winch pays out before, and 30 % of it is not there."""
    state = sea_state(design, 0.3, 1)
    state.x[design.model.state("unit_heave_rate")] -= 0.2

    def planned(**changes):
        """Return the highest tension of the plan about the static one [N], and the command."""
        parameters, limits = design.parameters, dataclasses.replace(design.limits, **changes)
        made_for = LawDesign(design.model, parameters.winch, limits, parameters.weights, design.gain)
        law = ConstrainedLaw(made_for, MpcParameters())
        command = law.command(state)
        rows = next(kind.rows for kind in law.planner.rows.kinds if kind.name == "tension")
        return float(
            (law.planner.rows.free @ state.x + law.planner.rows.forced @ law.planner.plan)[rows].max()
        ), command

    highest, command = planned()
    assert highest > 0.1 * state.static_tension
    assert "tension" not in command.active
    bounded, command = planned(maximum_tension=state.static_tension + 0.7 * highest)
    assert command.status == "solved"
    assert "tension" in command.active
    assert bounded == pytest.approx(0.7 * highest, rel=0.005)


def test_a_first_order_winch_and_a_horizon_within_the_delay_are_refused_in_words(design):
    winch = WinchModelParameters(law="first_order")
    other = design_controller(WinchControllerParameters(winch=winch, law="lqg"), tick_period=DT)
    with pytest.raises(DesignError, match="bounds the winch's acceleration"):
        make_law(other)
    slow = dataclasses.replace(design.parameters, winch=WinchModelParameters(command_delay=1.5))
    late = design_controller(slow, tick_period=DT)
    with pytest.raises(DesignError, match=r"mpc\.horizon = 1 s must be longer"):
        make_law(late, horizon=1.0)


def test_authority_scales_the_sea_and_keeps_the_share_of_the_uncompensated_motion(design):
    """By linearity the shifted problem at authority 0 has no sea, and the unit's error is against its free motion."""
    law = make_law(design)
    core = commander(design, law.winch, law, new(COMMAND_STATE))
    x = np.arange(1.0, design.model.order + 1)

    def shifted(share):
        core.estimate[:] = x
        pose(core, LoopNow(Way.BY_LAW, share, heave=0.3, rate=0.1))
        return core.x.copy()

    none, whole = shifted(0.0), shifted(1.0)
    np.testing.assert_array_equal(whole, x)
    assert all(none[design.model.state(name)] == 0.0 for name in design.sea_states)
    assert none[design.model.state("unit_heave")] == pytest.approx(x[design.model.state("unit_heave")] - 0.3)


SLOW_WINCH = {
    "length": 20.0,
    "water_density": 0.0,
    "unit.mass": 1000.0,
    "unit.added_mass": (0.0, 0.0, 0.0),
    "winch.time_constant": 1.0,
    "winch.command_delay": 0.0,
    "winch.speed_limit": 1.125,
    "vessel.damping_ratio": 0.7,
}


@pytest.mark.parametrize("sea", [(1.0, 9.0), (3.4, 12.0)])
def test_on_a_slow_winch_the_constrained_law_promises_no_more_motion_than_the_state_feedback(sea):
    values = SLOW_WINCH | {"sea.significant_wave_height": sea[0], "sea.peak_period": sea[1]}
    values["vessel.natural_frequency"] = 3.0 * 2.0 * np.pi / sea[1]
    assert promised_ratio(build_parameters(WinchControllerParameters, values, where="test")) <= 1.0


@pytest.mark.parametrize("name", ["b2_calm_300", "b3_deep_900", "b4_limit_900_tp8", "b10_real_mru_swell"])
def test_away_from_the_limits_the_constrained_law_promises_no_more_motion_than_the_state_feedback(name):
    assert promised_ratio(load_scenario(name).parameters["winch_controller"]) <= 1.0


def promised_ratio(parameters):
    """Return the unit's standard deviation under law mpc without limits over that under law lqg."""
    design = design_controller(parameters, tick_period=DT)
    errors = error_covariances(design)
    gains = free_gain(design.model, parameters.mpc), design.gain
    mpc, lqg = (predict_loop(design, gain, errors).sigma["unit_heave"] for gain in gains)
    return mpc / lqg


@pytest.mark.parametrize("lag", [0.02, 0.005])
def test_a_winch_faster_than_a_tick_leaves_no_more_motion_than_one_that_is_as_slow(lag):
    """A hydraulic drive takes some milliseconds: its acceleration at the start of a tick is not that of the tick."""

    def promised(time_constant):
        winch = WinchModelParameters(time_constant=time_constant, command_delay=0.0)
        design = design_controller(WinchControllerParameters(winch=winch), tick_period=DT)
        gains = free_gain(design.model, MpcParameters()), constrained_gain(design.model, MpcParameters()), design.gain
        errors = error_covariances(design)
        return [predict_loop(design, gain, errors).sigma["unit_heave"] for gain in gains]

    assert np.all(np.array(promised(lag)) <= promised(DT))
