"""Named models, connection, exact sampling, exact delay."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from winch_controller_node.model.blocks import RATE_COMMAND, CableModel, cable_block, mru_block, winch_block
from winch_controller_node.model.linear_model import (
    ModelError,
    delay_command,
    discretise,
    interconnect,
    is_stable,
    linear_model,
    output_sigma,
    state_covariance,
)
from winch_controller_node.model.models import (
    shadow_model,
)
from winch_controller_node.parameters.model import MruModelParameters, WinchModelParameters


def oscillator(noise=0.0):
    return linear_model(
        [[0.0, 1.0], [-4.0, -0.4]],
        states=("x", "v"),
        inputs={"u": [0.0, 1.0]},
        outputs={"x": [1.0, 0.0]},
        noises={"w": [0.0, noise]},
    )


def test_a_name_that_does_not_exist_is_named_with_those_that_do():
    with pytest.raises(ModelError, match="no state y; it has x, v"):
        oscillator().state("y")


def test_a_matrix_of_the_wrong_shape_is_refused_with_both_shapes():
    with pytest.raises(ValueError, match=r"reshape|shape"):
        linear_model([[0.0, 1.0]], states=("x", "v"))


def test_blocks_in_a_loop_without_a_state_are_refused():
    through = {"feedthrough": {("y", "u"): 1.0}, "inputs": {"u": []}, "outputs": {"y": []}}
    back = {"feedthrough": {("u", "y"): 1.0}, "inputs": {"y": []}, "outputs": {"u": []}}
    blocks = [linear_model(np.zeros((0, 0)), states=(), **side) for side in (through, back)]
    with pytest.raises(ModelError, match="algebraic loop"):
        interconnect(blocks)


def test_stationary_variance_of_an_oscillator_is_the_closed_form():
    # x'' + 2 z w x' + w^2 x = s white of intensity q: variance q / (4 z w^3)
    sigma = output_sigma(oscillator(noise=0.3))["x"]
    assert sigma**2 == pytest.approx(0.09 / (2.0 * 0.4 * 4.0), rel=1e-12)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.01, 1.0))
def test_sampling_keeps_the_stationary_covariance(dt):
    model = oscillator(noise=0.3)
    assert state_covariance(discretise(model, dt)) == pytest.approx(state_covariance(model), rel=1e-9, abs=1e-12)


def test_an_unstable_model_has_no_stationary_covariance():
    with pytest.raises(ModelError, match="not stable"):
        state_covariance(linear_model([[0.1]], states=("x",), noises={"w": [1.0]}))


@settings(max_examples=20, deadline=None)
@given(st.floats(0.0, 0.31), st.integers(0, 2**31))
def test_the_sampled_delay_is_exact_for_any_delay(delay, seed):
    # reference: the winch integrated by solve_ivp with the command switched exactly at t_k + delay
    dt = 0.05
    winch = winch_block(WinchModelParameters())
    commands = np.random.default_rng(seed).standard_normal(12)
    sampled = delay_command(winch, dt, delay, [RATE_COMMAND])
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


def test_the_mru_states_are_its_high_pass():
    mru = mru_block(MruModelParameters(high_pass_period=60.0, high_pass_damping=0.7))
    cut_off = 2.0 * math.pi / 60.0
    for omega in (0.05, 0.2, 0.8):
        s = 1j * omega
        inputs = np.array([1.0, s])  # heave and its rate
        outputs = mru.C @ np.linalg.solve(s * np.eye(2) - mru.A, mru.B @ inputs) + mru.D @ inputs
        exact = s**2 / (s**2 + 2.0 * 0.7 * cut_off * s + cut_off**2)
        assert outputs == pytest.approx([exact, s * exact], rel=1e-9)


def test_the_shadow_unit_follows_the_cables_transfer_function():
    cable = CableModel(2.0, 0.3)
    model = shadow_model(cable, 0.05)
    omega = 0.7
    t = 0.05 * np.arange(4000)
    heave, rate = np.sin(omega * t), omega * np.cos(omega * t)
    x = np.zeros(2)
    trace = []
    for inputs in zip(heave, rate, strict=True):
        trace.append(x[0])
        x = model.A @ x + model.B @ np.array(inputs)
    basis = np.column_stack([np.sin(omega * t), np.cos(omega * t)])[2000:]
    amplitude = np.hypot(*np.linalg.lstsq(basis, np.array(trace)[2000:], rcond=None)[0])
    assert amplitude == pytest.approx(abs(1.0 / (1.0 - 2.0 * omega**2 + 0.3j * omega)), rel=1e-3)


def test_payout_lowers_the_unit_by_as_much_in_the_long_run():
    model = interconnect([cable_block(CableModel(2.0, 1.5)), winch_block(WinchModelParameters(law="first_order"))])
    assert is_stable(model)
    steady = -np.linalg.solve(model.A, model.B[:, list(model.input_names).index("payout_command")])
    assert steady[model.state("unit_heave")] == pytest.approx(-1.0)
    assert steady[model.state("payout")] == pytest.approx(1.0)
