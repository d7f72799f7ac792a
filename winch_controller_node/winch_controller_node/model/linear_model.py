"""Linear state-space models with named states, inputs and outputs, and what is done with all of them.

Conventions: noise inputs are white with unit intensity (continuous, two-sided) or unit variance a step (discrete), so
that `G @ G.T` is the intensity or the covariance of the process noise. A one-sided spectrum S(omega) of a shaping
filter driven in rad/s asks for white noise of intensity pi: whoever makes such a filter puts sqrt(pi) into G.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.linalg
from heave_node.arrays import Array
from numpy.typing import ArrayLike
from wave_vessel_node.sea.state_space import covariance_factor


class ModelError(ValueError):
    """A model that cannot be built, connected or analysed; the message says which and why."""


def _empty() -> Array:
    return np.zeros((0, 0))


@dataclass(frozen=True)
class LinearModel:
    """dx/dt = A x + B u + G w, y = C x + D u; or x[k+1] = ... with the step `dt`.

    Attributes
    ----------
    A : shape (n, n)
    B : shape (n, m), inputs
    C : shape (p, n), outputs
    D : shape (p, m)
    G : shape (n, q), noise inputs of unit intensity (continuous) or unit variance (discrete)
    state_names, input_names, output_names, noise_names : lengths n, m, p, q
    dt : step [s]; None: continuous
    """

    A: Array
    B: Array
    C: Array
    D: Array
    G: Array
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    noise_names: tuple[str, ...]
    dt: float | None = None
    _index: dict[str, int] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        n, m, p, q = map(len, (self.state_names, self.input_names, self.output_names, self.noise_names))
        wanted = {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m), "G": (n, q)}
        for name, shape in wanted.items():
            matrix = getattr(self, name)
            if matrix.shape != shape:
                raise ModelError(f"matrix {name} must have shape {shape} for the names given; got {matrix.shape}")
            if not np.all(np.isfinite(matrix)):
                raise ModelError(f"matrix {name} holds a value that is not finite")
        for names in (self.state_names, self.input_names, self.output_names):
            if len(set(names)) != len(names):
                raise ModelError(f"names must differ from one another; got {names}")
        self._index.update({name: i for i, name in enumerate(self.state_names)})

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.state_names)

    @property
    def noise_covariance(self) -> Array:
        """G G': intensity (continuous) or covariance of a step (discrete) of the process noise, shape (n, n)."""
        return self.G @ self.G.T

    def state(self, name: str) -> int:
        """Return the index of the state `name`; ModelError when there is none."""
        if name not in self._index:
            raise ModelError(f"the model has no state {name}; it has {', '.join(self.state_names)}")
        return self._index[name]

    def has_state(self, name: str) -> bool:
        """Tell whether there is a state `name`."""
        return name in self._index

    def row(self, output: str) -> Array:
        """Return the row of C of `output`, shape (n,)."""
        if output not in self.output_names:
            raise ModelError(f"the model has no output {output}; it has {', '.join(self.output_names)}")
        return self.C[self.output_names.index(output)]

    def select_states(self, names: Sequence[str]) -> LinearModel:
        """Return the subsystem of the states `names`, outputs that need other states left out.

        Raises ModelError where a kept state is driven by one left out.
        """
        keep = [self.state(name) for name in names]
        drop = [i for i in range(self.order) if i not in keep]
        driven = np.argwhere(self.A[np.ix_(keep, drop)])
        if driven.size:
            i, j = driven[0]
            raise ModelError(f"state {names[i]} is driven by {self.state_names[drop[j]]}, which is left out")
        outputs = [i for i in range(len(self.output_names)) if not np.any(self.C[i, drop])]
        return LinearModel(
            A=self.A[np.ix_(keep, keep)],
            B=self.B[keep],
            C=self.C[np.ix_(outputs, keep)],
            D=self.D[outputs],
            G=self.G[keep],
            state_names=tuple(names),
            input_names=self.input_names,
            output_names=tuple(self.output_names[i] for i in outputs),
            noise_names=self.noise_names,
            dt=self.dt,
        )

    def with_outputs(self, rows: Mapping[str, Mapping[str, float]]) -> LinearModel:
        """Return the model with further outputs, each a weighted sum of states given by name."""
        C = np.zeros((len(rows), self.order))
        for i, weights in enumerate(rows.values()):
            for name, weight in weights.items():
                C[i, self.state(name)] = weight
        return replace(
            self,
            C=np.vstack([self.C, C]),
            D=np.vstack([self.D, np.zeros((len(rows), len(self.input_names)))]),
            output_names=self.output_names + tuple(rows),
        )


def linear_model(
    A: ArrayLike,
    *,
    states: Sequence[str],
    inputs: Mapping[str, ArrayLike] | None = None,
    outputs: Mapping[str, ArrayLike] | None = None,
    feedthrough: Mapping[tuple[str, str], float] | None = None,
    noises: Mapping[str, ArrayLike] | None = None,
    dt: float | None = None,
) -> LinearModel:
    """Build a model from columns and rows by name: `inputs` and `noises` are columns, `outputs` rows, all of length n.

    `feedthrough[(output, input)]` fills D.
    """
    inputs, outputs, noises = inputs or {}, outputs or {}, noises or {}
    n = len(states)
    D = np.zeros((len(outputs), len(inputs)))
    for (output, name), value in (feedthrough or {}).items():
        D[list(outputs).index(output), list(inputs).index(name)] = value
    return LinearModel(
        A=np.asarray(A, dtype=float).reshape(n, n),
        B=_columns(inputs, n),
        C=_columns(outputs, n).T,
        D=D,
        G=_columns(noises, n),
        state_names=tuple(states),
        input_names=tuple(inputs),
        output_names=tuple(outputs),
        noise_names=tuple(noises),
        dt=dt,
    )


def _columns(columns: Mapping[str, ArrayLike], n: int) -> Array:
    if not columns:
        return np.zeros((n, 0))
    return np.column_stack([np.asarray(column, dtype=float).reshape(n) for column in columns.values()])


def interconnect(blocks: Sequence[LinearModel]) -> LinearModel:
    """Connect blocks by name: an input that has the name of some block's output is fed by it, the others stay inputs.

    All outputs stay outputs. Blocks are continuous, or discrete with one step.

    Raises
    ------
    ModelError : two blocks with one name of a state or output, different steps, or an algebraic loop
    """
    steps = {block.dt for block in blocks}
    if len(steps) != 1:
        raise ModelError(f"blocks with different steps cannot be connected: {steps}")
    A = scipy.linalg.block_diag(*[block.A for block in blocks])
    B = scipy.linalg.block_diag(*[block.B for block in blocks])
    C = scipy.linalg.block_diag(*[block.C for block in blocks])
    D = scipy.linalg.block_diag(*[block.D for block in blocks])
    G = scipy.linalg.block_diag(*[block.G for block in blocks])
    all_inputs = [name for block in blocks for name in block.input_names]
    outputs = [name for block in blocks for name in block.output_names]
    external = list(dict.fromkeys(name for name in all_inputs if name not in outputs))
    from_output = np.array([[float(name == output) for output in outputs] for name in all_inputs]).reshape(
        len(all_inputs), len(outputs)
    )
    from_external = np.array([[float(name == other) for other in external] for name in all_inputs]).reshape(
        len(all_inputs), len(external)
    )
    loop = np.eye(len(outputs)) - D @ from_output
    if abs(np.linalg.det(loop)) < 1e-12:
        raise ModelError("the blocks form an algebraic loop: some output depends on itself without a state between")
    C_closed = np.linalg.solve(loop, C)
    D_closed = np.linalg.solve(loop, D @ from_external)
    return LinearModel(
        A=A + B @ from_output @ C_closed,
        B=B @ (from_output @ D_closed + from_external),
        C=C_closed,
        D=D_closed,
        G=G,
        state_names=tuple(name for block in blocks for name in block.state_names),
        input_names=tuple(external),
        output_names=tuple(outputs),
        noise_names=tuple(name for block in blocks for name in block.noise_names),
        dt=steps.pop(),
    )


def discretise(model: LinearModel, dt: float) -> LinearModel:
    """Return the exact sampled model: inputs held over the step, process noise integrated by Van Loan's method.

    The discrete noise has as many unit-variance inputs as there are states.
    """
    A, B, Q = sampled_matrices(model, dt)
    factor = covariance_factor(Q)
    names = tuple(f"noise_{i}" for i in range(factor.shape[1]))
    return replace(model, A=A, B=B, G=factor, noise_names=names, dt=dt)


def sampled_matrices(model: LinearModel, dt: float) -> tuple[Array, Array, Array]:
    """Return exp(A dt), the integral of exp(A s) ds B, and the noise covariance over the step `dt` (Van Loan 1978)."""
    if model.dt is not None:
        raise ModelError(f"the model is already discrete with a step of {model.dt:g} s")
    if dt < 0.0:
        raise ModelError(f"a step must not be negative; got {dt:g} s")
    n, m = model.B.shape
    held = np.zeros((n + m, n + m))
    held[:n, :n] = model.A
    held[:n, n:] = model.B
    transition = scipy.linalg.expm(held * dt)
    van_loan = np.zeros((2 * n, 2 * n))
    van_loan[:n, :n] = -model.A
    van_loan[:n, n:] = model.noise_covariance
    van_loan[n:, n:] = model.A.T
    exponential = scipy.linalg.expm(van_loan * dt)
    A = exponential[n:, n:].T
    Q = A @ exponential[:n, n:]
    return transition[:n, :n], transition[:n, n:], 0.5 * (Q + Q.T)


def delay_command(model: LinearModel, dt: float, delay: float, inputs: Sequence[str]) -> LinearModel:
    """Sample a continuous model whose inputs `inputs` take effect `delay` seconds after the tick they belong to: exact.

    The state is extended by past commands, `<input>_1` (the newest) to `<input>_n`; n = ceil(delay/dt). Where the
    delay is not a whole number of ticks, the older command acts on the first part of the tick and the newer one on the
    rest. Outputs' feedthrough of a delayed input becomes that of the command acting at the start of the tick.
    """
    if delay < 0.0:
        raise ModelError(f"a delay must not be negative; got {delay:g} s")
    ticks = delay / dt
    whole = round(ticks) if abs(ticks - round(ticks)) < 1e-6 else int(np.floor(ticks))
    part = max(ticks - whole, 0.0) if abs(ticks - round(ticks)) >= 1e-6 else 0.0
    sampled = discretise(model, dt)
    B_new, B_old = sampled.B, np.zeros_like(sampled.B)
    if part > 0.0:
        rest, B_new, _ = sampled_matrices(model, (1.0 - part) * dt)
        B_old = rest @ sampled_matrices(model, part * dt)[1]
    for name in inputs:
        column = model.input_names.index(name)
        length = whole + (1 if part > 0.0 else 0)
        sampled = _append_chain(sampled, name, length, (whole, B_new[:, column]), (whole + 1, B_old[:, column]), part)
    return sampled


def _append_chain(
    model: LinearModel, name: str, length: int, new: tuple[int, Array], old: tuple[int, Array], part: float
) -> LinearModel:
    """Append past values of input `name`.

    The command of `new[0]` ticks ago acts through column `new[1]`, likewise `old`.
    """
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
    for age, effect in (new, old) if part > 0.0 else (new,):
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


def with_feedback(model: LinearModel, gain: Array) -> LinearModel:
    """Return the closed loop under u = -gain x; its inputs then add to the command. `gain` has shape (m, n)."""
    gain = np.atleast_2d(gain)
    return replace(model, A=model.A - model.B @ gain, C=model.C - model.D @ gain)


def spectral_abscissa(model: LinearModel) -> float:
    """Return the largest real part (continuous) or magnitude (discrete) of the poles."""
    poles = np.linalg.eigvals(model.A)
    return float(np.max(np.abs(poles) if model.dt is not None else poles.real, initial=-np.inf))


def is_stable(model: LinearModel) -> bool:
    """Tell whether all poles lie left of the imaginary axis (continuous) or inside the unit circle (discrete)."""
    return spectral_abscissa(model) < (1.0 if model.dt is not None else 0.0)


def state_covariance(model: LinearModel) -> Array:
    """Return the stationary covariance of the state under the model's noise, by the Lyapunov equation.

    Continuous: A P + P A' + G G' = 0 (thesis Eq. 6.31 with the noise intensity as this module defines it); discrete:
    P = A P A' + G G'.

    Raises ModelError where the model is not stable: there is no stationary covariance then.
    """
    if not is_stable(model):
        raise ModelError("the model is not stable: it has no stationary covariance")
    Q = model.noise_covariance
    if model.dt is None:
        P = scipy.linalg.solve_continuous_lyapunov(model.A, -Q)
    else:
        P = scipy.linalg.solve_discrete_lyapunov(model.A, Q)
    return np.asarray(0.5 * (P + P.T))


def output_sigma(model: LinearModel) -> dict[str, float]:
    """Return the stationary standard deviation of each output without feedthrough noise, by name."""
    P = state_covariance(model)
    variance = np.einsum("ij,jk,ik->i", model.C, P, model.C)
    return {name: float(np.sqrt(max(value, 0.0))) for name, value in zip(model.output_names, variance, strict=True)}
