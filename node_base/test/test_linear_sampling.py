"""Exact sampling: held inputs, noise of a step, delayed commands."""

import itertools
import math

import numpy as np
import pytest
from heave_node.numerics.linear_model import ModelError, linear_model, state_covariance
from heave_node.numerics.linear_sampling import delay_command, discretise, sampled_matrices
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm


def oscillator(natural, damping, noise=1.0):
    return linear_model(
        [[0.0, 1.0], [-(natural**2), -2.0 * damping * natural]],
        states=("x", "v"),
        inputs={"u": [0.0, 1.0]},
        outputs={"x": [1.0, 0.0]},
        noises={"w": [0.0, noise]},
    )


def servo(lag=0.15):
    """A winch whose rate follows its command with a lag."""
    return linear_model(
        [[0.0, 1.0], [0.0, -1.0 / lag]],
        states=("payout", "rate"),
        inputs={"command": [0.0, 1.0 / lag]},
        outputs={"acceleration": [0.0, -1.0 / lag]},
        feedthrough={("acceleration", "command"): 1.0 / lag},
    )


@given(st.floats(0.1, 3.0), st.floats(0.05, 3.0), st.floats(0.01, 20.0))
@settings(max_examples=40)
def test_sampling_keeps_the_stationary_covariance(natural, damping, dt):
    system = oscillator(natural, damping)
    P = state_covariance(system)
    transition, _, noise = sampled_matrices(system, dt)
    np.testing.assert_allclose(transition, expm(system.A * dt), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(transition @ P @ transition.T + noise, P, rtol=1e-8, atol=1e-10 * P.max())
    np.testing.assert_allclose(state_covariance(discretise(system, dt)), P, rtol=1e-8, atol=1e-10 * P.max())


@given(st.floats(0.2, 2.0), st.floats(0.1, 1.0))
@settings(max_examples=20)
def test_two_short_steps_make_one_long_step(natural, damping):
    system = oscillator(natural, damping)
    A, B, Q = sampled_matrices(system, 0.1)
    A2, B2, Q2 = sampled_matrices(system, 0.2)
    np.testing.assert_allclose(A @ A, A2, rtol=1e-10, atol=1e-13)
    np.testing.assert_allclose(A @ B + B, B2, rtol=1e-10, atol=1e-13)
    np.testing.assert_allclose(A @ Q @ A.T + Q, Q2, rtol=1e-9, atol=1e-14)


def test_a_step_that_is_long_against_the_fastest_rate_keeps_its_noise():
    # x' = -a x + w: variance of a step (1 - e^{-2 a dt}) / (2 a); Van Loan's e^{a dt} alone would overflow
    stiff = linear_model([[-5000.0]], states=("x",), noises={"w": [1.0]})
    assert sampled_matrices(stiff, 1.0)[2][0, 0] == pytest.approx(1e-4, rel=1e-12)


def test_a_model_without_states_can_be_sampled():
    sampled = discretise(linear_model(np.zeros((0, 0)), states=(), inputs={"u": []}), 0.05)
    assert (sampled.order, sampled.dt) == (0, 0.05)


def test_what_is_sampled_already_or_backwards_is_refused():
    with pytest.raises(ModelError, match=r"already discrete with a step of 0\.1 s"):
        discretise(discretise(oscillator(1.0, 0.1), 0.1), 0.1)
    with pytest.raises(ModelError, match="must not be negative"):
        discretise(oscillator(1.0, 0.1), -0.1)
    with pytest.raises(ModelError, match="must not be negative"):
        delay_command(servo(), 0.05, -0.1, ["command"])


@settings(max_examples=20)
@given(st.floats(0.0, 0.31), st.integers(0, 2**31))
def test_the_sampled_delay_is_exact_for_any_delay(delay, seed):
    # reference: the winch integrated by solve_ivp with the command switched exactly at t_k + delay
    dt, winch = 0.05, servo()
    commands = np.random.default_rng(seed).standard_normal(12)
    sampled = delay_command(winch, dt, delay, ["command"])
    x = np.zeros(sampled.order)
    for command in commands:
        x = sampled.A @ x + sampled.B[:, 0] * command

    exact = np.zeros(2)
    edges = np.unique(np.concatenate(([0.0, 12 * dt], np.arange(12) * dt + delay)))
    for start, end in itertools.pairwise(edges):
        if end > 12 * dt + 1e-12:
            break
        k = math.floor((0.5 * (start + end) - delay) / dt)
        held = commands[k] if k >= 0 else 0.0
        solution = solve_ivp(
            lambda t, y, u=held: winch.A @ y + winch.B[:, 0] * u, (0, end - start), exact, rtol=1e-11, atol=1e-13
        )
        exact = solution.y[:, -1]
    assert x[:2] == pytest.approx(exact, abs=1e-8)


def test_an_output_with_feedthrough_shows_the_command_that_acts_at_the_start_of_the_tick():
    sampled = delay_command(servo(), 0.05, 0.12, ["command"])
    assert sampled.state_names == ("payout", "rate", "command_1", "command_2", "command_3")
    np.testing.assert_allclose(sampled.C, [[0.0, -1.0 / 0.15, 0.0, 0.0, 1.0 / 0.15]])
    np.testing.assert_array_equal(sampled.D, [[0.0]])
