"""Linear models sampled at ticks, exactly: held inputs, process noise, delayed commands."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy

from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel, ModelError, covariance_factor


def discretise(model: LinearModel, dt: float) -> LinearModel:
    """Return the exact sampled model: inputs held over the step, process noise integrated over it.

    Parameters
    ----------
    model : continuous
    dt : step [s]

    The discrete noise has as many unit-variance inputs as there are states. Raises ModelError for a model that is
    discrete already, or a negative step.
    """
    A, B, Q = sampled_matrices(model, dt)
    factor = covariance_factor(Q)
    names = tuple(f"noise_{i}" for i in range(factor.shape[1]))
    return replace(model, A=A, B=B, G=factor, noise_names=names, dt=dt)


def sampled_matrices(model: LinearModel, dt: float) -> tuple[Array, Array, Array]:
    """Return the matrices of the sampled model: exp(A dt), the integral of exp(A s) ds B, and the noise covariance.

    Parameters
    ----------
    model : continuous
    dt : step [s]

    Raises ModelError for a model that is discrete already, or a negative step.
    """
    if model.dt is not None:
        raise ModelError(f"the model is already discrete with a step of {model.dt:g} s")
    if dt < 0.0:
        raise ModelError(f"a step must not be negative; got {dt:g} s")
    n, m = model.B.shape
    held = np.zeros((n + m, n + m))
    held[:n, :n] = model.A
    held[:n, n:] = model.B
    transition = scipy.linalg.expm(held * dt)
    return transition[:n, :n], transition[:n, n:], _noise_of_a_step(model, dt)


def _noise_of_a_step(model: LinearModel, dt: float) -> Array:
    """Return the integral over the step of e^{A t} G G' e^{A' t} dt.

    Van Loan (1978) for a step that is short against the model's rates, since his e^{-A t} grows without bound; then
    doubled up to the whole step by Q_{2h} = Phi Q Phi' + Q.
    """
    n = model.order
    rate = float(np.abs(model.A).sum(axis=0).max(initial=0.0))
    doublings = max(0, math.ceil(math.log2(max(rate * dt, 1.0))))
    block = np.zeros((2 * n, 2 * n))
    block[:n, :n] = -model.A
    block[:n, n:] = model.noise_covariance
    block[n:, n:] = model.A.T
    exponential = scipy.linalg.expm(block * (dt / 2**doublings))
    transition: Array = exponential[n:, n:].T
    noise: Array = transition @ exponential[:n, n:]
    for _ in range(doublings):
        noise = transition @ noise @ transition.T + noise
        transition = transition @ transition
    return 0.5 * (noise + noise.T)


def delay_command(model: LinearModel, dt: float, delay: float, inputs: Sequence[str]) -> LinearModel:
    """Sample a continuous model whose commands take effect some time after the tick they belong to: exact.

    Parameters
    ----------
    model : continuous
    dt : tick period [s]
    delay : from the start of a command's tick to its effect [s]
    inputs : names of the inputs that are delayed; the others act at once

    The state is extended by past commands, `<input>_1` (the newest) to `<input>_n`; n = ceil(delay/dt). Where the
    delay is not a whole number of ticks, the older command acts on the first part of the tick and the newer one on the
    rest. Outputs' feedthrough of a delayed input becomes that of the command acting at the start of the tick. Raises
    ModelError for a negative delay.
    """
    if delay < 0.0:
        raise ModelError(f"a delay must not be negative; got {delay:g} s")
    ticks = delay / dt
    whole = round(ticks) if abs(ticks - round(ticks)) < 1e-6 else math.floor(ticks)
    part = max(ticks - whole, 0.0) if abs(ticks - round(ticks)) >= 1e-6 else 0.0
    sampled = discretise(model, dt)
    effects = {whole: sampled.B}
    if part > 0.0:
        rest, newer, _ = sampled_matrices(model, (1.0 - part) * dt)
        effects = {whole: newer, whole + 1: rest @ sampled_matrices(model, part * dt)[1]}
    for name in inputs:
        column = model.input_names.index(name)
        sampled = _append_chain(sampled, name, {age: effect[:, column] for age, effect in effects.items()})
    return sampled


def _append_chain(model: LinearModel, name: str, effects: Mapping[int, Array]) -> LinearModel:
    """Append the past values of the input `name`, where the one of `age` ticks ago acts through the column
    `effects[age]`, shape (n,).
    """
    length = max(effects)
    if length == 0:
        return model
    n, column = model.order, model.input_names.index(name)
    A = np.zeros((n + length, n + length))
    A[:n, :n] = model.A
    B = np.vstack([model.B, np.zeros((length, len(model.input_names)))])
    B[:, column] = 0.0
    B[n, column] = 1.0
    for i in range(1, length):
        A[n + i, n + i - 1] = 1.0
    for age, effect in effects.items():
        if age == 0:
            B[:n, column] += effect
        else:
            A[:n, n + age - 1] += effect
    C = np.hstack([model.C, np.zeros((len(model.output_names), length))])
    D = model.D.copy()
    C[:, n + length - 1] += D[:, column]
    D[:, column] = 0.0
    states = model.state_names + tuple(f"{name}_{i + 1}" for i in range(length))
    G = np.vstack([model.G, np.zeros((length, model.G.shape[1]))])
    return replace(model, A=A, B=B, C=C, D=D, G=G, state_names=states)
