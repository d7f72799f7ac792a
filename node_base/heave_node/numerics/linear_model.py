"""Linear state-space models with named states, inputs, outputs and noises, for sea, vessel and controller alike.

Noise convention: a noise input is white with unit intensity (continuous: autocovariance delta(t)) or unit variance a
step (discrete), so that `G @ G.T` is the intensity or the covariance of the process noise. The one-sided spectrum in
rad/s of such noise is 1/pi. A shaping filter whose spectrum |H(i omega)|^2 is one-sided in rad/s is therefore driven
by noise of intensity pi (NOISE_INTENSITY): it has sqrt(pi) in G. Its stationary covariance P then obeys the Lyapunov
equation A P + P A' + pi B B' = 0, and the integral of its spectrum over omega > 0 is the variance. (Thesis Eq. 6.31
prints that equation without pi; the numbers printed beside it need it.)
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy
from numpy.typing import ArrayLike

from heave_node.numerics.arrays import Array

NOISE_INTENSITY = math.pi
"""Intensity of white noise whose one-sided spectral density in rad/s is 1."""


class ModelError(ValueError):
    """A model that cannot be built, connected or analysed; the message says which and why."""


@dataclass(frozen=True, eq=False)
class LinearModel:
    """dx/dt = A x + B u + G w, y = C x + D u; or x[k+1] = ... with the step `dt`."""

    A: Array  # shape (n, n)
    B: Array  # shape (n, m), inputs
    C: Array  # shape (p, n), outputs
    D: Array  # shape (p, m)
    G: Array  # shape (n, q), noise inputs of unit intensity (continuous) or unit variance (discrete)
    state_names: tuple[str, ...]  # length n
    input_names: tuple[str, ...]  # length m
    output_names: tuple[str, ...]  # length p
    noise_names: tuple[str, ...]  # length q
    dt: float | None = None  # step [s]; None: continuous
    _index: dict[str, int] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        n, m, p, q = map(len, (self.state_names, self.input_names, self.output_names, self.noise_names))
        shapes = {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m), "G": (n, q)}
        for name, shape in shapes.items():
            matrix = getattr(self, name)
            if matrix.shape != shape:
                raise ModelError(f"matrix {name} must have shape {shape} for the names given; got {matrix.shape}")
            if not np.all(np.isfinite(matrix)):
                raise ModelError(f"matrix {name} holds a value that is not finite")
        for names in (self.state_names, self.input_names, self.output_names):
            if len(set(names)) != len(names):
                raise ModelError(f"names must be unique; got {names}")
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
        """Return whether there is a state `name`."""
        return name in self._index

    def row(self, output: str) -> Array:
        """Return the row of C of `output`, shape (n,)."""
        if output not in self.output_names:
            raise ModelError(f"the model has no output {output}; it has {', '.join(self.output_names)}")
        return np.asarray(self.C[self.output_names.index(output)])

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
        return replace(
            self,
            A=self.A[np.ix_(keep, keep)],
            B=self.B[keep],
            C=self.C[np.ix_(outputs, keep)],
            D=self.D[outputs],
            G=self.G[keep],
            state_names=tuple(names),
            output_names=tuple(self.output_names[i] for i in outputs),
        )

    def with_outputs(self, rows: Mapping[str, Mapping[str, float] | Array]) -> LinearModel:
        """Return the model with further outputs of the state.

        `rows` has, by name of the output, a row of C, shape (n,), or the weights of states by name.
        """
        C = np.zeros((len(rows), self.order))
        for i, row in enumerate(rows.values()):
            if isinstance(row, Mapping):
                for name, weight in row.items():
                    C[i, self.state(name)] = weight
            else:
                C[i] = row
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
    """Build a model from columns and rows by name.

    Parameters
    ----------
    A : shape (n, n)
    states : names of the n states
    inputs, noises : columns of B and of G by name, each of length n
    outputs : rows of C by name, each of length n
    feedthrough : D by (output, input); what is not named is 0
    dt : step of a discrete model [s]; None: continuous
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

    The `blocks` are continuous, or discrete with one step; all outputs stay outputs. Raises ModelError for two blocks
    with one name of a state or output, different steps, or an algebraic loop.
    """
    steps = {block.dt for block in blocks}
    if len(steps) != 1:
        raise ModelError(f"blocks with different steps cannot be connected: {steps}")
    A, B, C, D, G = (scipy.linalg.block_diag(*[getattr(block, name) for block in blocks]) for name in "ABCDG")
    all_inputs = [name for block in blocks for name in block.input_names]
    outputs = [name for block in blocks for name in block.output_names]
    external = list(dict.fromkeys(name for name in all_inputs if name not in outputs))
    from_output, from_external = _routes(outputs, all_inputs), _routes(external, all_inputs)
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


def _routes(sources: Sequence[str], inputs: Sequence[str]) -> Array:
    """Return 1 where an input has the name of a source, else 0, shape (inputs, sources)."""
    return np.array([[float(name == source) for source in sources] for name in inputs]).reshape(
        len(inputs), len(sources)
    )


def with_feedback(model: LinearModel, gain: Array) -> LinearModel:
    """Return the closed loop under u = -gain x; what its inputs take is added to that command.

    Parameters
    ----------
    model : the open loop
    gain : shape (m, n)
    """
    gain = np.atleast_2d(gain)
    return replace(model, A=model.A - model.B @ gain, C=model.C - model.D @ gain)


def spectral_abscissa(model: LinearModel) -> float:
    """Return the largest real part (continuous) or magnitude (discrete) of the poles of a `model`."""
    poles = np.linalg.eigvals(model.A)
    return float(np.max(np.abs(poles) if model.dt is not None else poles.real, initial=-np.inf))


def is_stable(model: LinearModel) -> bool:
    """Return whether every mode of a `model` decays."""
    return spectral_abscissa(model) < (1.0 if model.dt is not None else 0.0)


def output_spectrum(model: LinearModel, output: str, omega: ArrayLike) -> Array:
    """Return the one-sided spectrum of an output under the model's noise, |C (i omega I - A)^-1 G|^2 / pi.

    Parameters
    ----------
    model : continuous and stable
    output : name of the output [unit]
    omega : [rad/s], any shape

    Returns
    -------
    density : [unit^2 s/rad], the shape of `omega`; its integral over omega > 0 is the variance of the output
    """
    omega = np.asarray(omega, dtype=float)
    resolvent = 1j * omega.reshape(-1, 1, 1) * np.eye(model.order) - model.A
    states = np.linalg.solve(resolvent, np.broadcast_to(model.G, (omega.size, *model.G.shape)))
    response = model.row(output) @ states
    return np.asarray((np.abs(response) ** 2).sum(axis=1).reshape(omega.shape) / NOISE_INTENSITY)


def state_covariance(model: LinearModel) -> Array:
    """Return the stationary covariance of the state under the model's noise, shape (n, n), by the Lyapunov equation.

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
    """Return the stationary standard deviation of each output under the model's noise, by name."""
    P = state_covariance(model)
    variance = np.einsum("ij,jk,ik->i", model.C, P, model.C)
    return {name: float(np.sqrt(max(value, 0.0))) for name, value in zip(model.output_names, variance, strict=True)}


def covariance_factor(covariance: Array) -> Array:
    """Return L with L L' = `covariance` (n, n), which may be singular: eigenvalues below rounding count as 0."""
    scale = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))
