"""Linear systems driven by white noise: stationary covariance, exact discretisation, spectra.

Convention of the whole suite: spectra are one-sided in rad/s, so that white noise w of unit spectral density has the
autocovariance
`pi delta(t)`. With x' = A x + B w:  A P + P A' + pi B B' = 0, the spectrum of y = C x is |C (i omega I - A)^-1 B|^2,
and its integral over
omega > 0 is the variance C P C'. (Thesis Eq. 6.31 prints the Lyapunov equation without pi; its own numbers need it.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.arrays import Array
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import expm, solve_continuous_lyapunov

NOISE_INTENSITY = math.pi
"""Intensity of white noise whose one-sided spectral density in rad/s is 1."""


@dataclass(frozen=True)
class StateSpace:
    """x' = A x + B w, y = C x.

    Attributes
    ----------
    A : shape (n, n); B : shape (n, m); C : shape (p, n)
    names : what each state is, n of them
    """

    A: Array
    B: Array
    C: Array
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        n = len(self.names)
        if self.A.shape != (n, n) or self.B.shape[:1] != (n,) or self.C.shape[1:] != (n,):
            raise ValueError(
                f"A, B, C of {n} states must be ({n}, {n}), ({n}, m), (p, {n}); "
                f"got {self.A.shape}, {self.B.shape}, {self.C.shape}"
            )

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.names)

    def frequency_response(self, omega: ArrayLike) -> NDArray[np.complex128]:
        """Return C (i omega I - A)^-1 B, shape (len(omega), p, m)."""
        omega = np.atleast_1d(np.asarray(omega, dtype=float))
        resolvent = 1j * omega[:, None, None] * np.eye(self.order) - self.A
        response: NDArray[np.complex128] = self.C @ np.linalg.solve(
            resolvent, np.broadcast_to(self.B, (omega.size, *self.B.shape))
        )
        return response

    def spectrum(self, omega: ArrayLike) -> Array:
        """Return the one-sided spectrum of the first output under unit white noise on all inputs, shape of `omega`."""
        omega = np.asarray(omega, dtype=float)
        response = self.frequency_response(omega.ravel())
        density: Array = (np.abs(response[:, 0, :]) ** 2).sum(axis=1).reshape(omega.shape)
        return density

    def stationary_covariance(self) -> Array:
        """Return P of A P + P A' + pi B B' = 0; raises ValueError if the system is not stable."""
        if np.linalg.eigvals(self.A).real.max() >= 0.0:
            raise ValueError("the system is not stable: it has no stationary covariance")
        covariance: Array = solve_continuous_lyapunov(self.A, -NOISE_INTENSITY * self.B @ self.B.T)
        return 0.5 * (covariance + covariance.T)

    def output_variance(self) -> float:
        """Return the stationary variance of the first output."""
        return float(self.C[0] @ self.stationary_covariance() @ self.C[0])


def series(first: StateSpace, second: StateSpace) -> StateSpace:
    """Return `first` feeding `second` (thesis Eq. 6.28's stacking): states of `second` come first, outputs are those
    of `second`.
    """
    n, m = second.order, first.order
    A = np.zeros((n + m, n + m))
    A[:n, :n], A[:n, n:], A[n:, n:] = second.A, second.B @ first.C, first.A
    B = np.vstack((np.zeros((n, first.B.shape[1])), first.B))
    C = np.hstack((second.C, np.zeros((second.C.shape[0], m))))
    return StateSpace(A, B, C, second.names + first.names)


def discretise(system: StateSpace, period: float) -> tuple[Array, Array]:
    """Return (Phi, Q) of x_{k+1} = Phi x_k + w_k, cov w_k = Q, exactly.

    Q = pi * integral over one `period` [s] of e^{A t} B B' e^{A' t}: Van Loan (1978) for a step that is short against
    the
    system's rates (his e^{-A t} grows without bound), doubled up to the period by Q_{2h} = Phi Q Phi' + Q.
    """
    n = system.order
    rate = float(np.abs(system.A).sum(axis=0).max())
    doublings = max(0, math.ceil(math.log2(max(rate * period, 1.0))))
    block = np.zeros((2 * n, 2 * n))
    block[:n, :n] = -system.A
    block[:n, n:] = NOISE_INTENSITY * system.B @ system.B.T
    block[n:, n:] = system.A.T
    exponential = expm(block * (period / 2**doublings))
    transition: Array = exponential[n:, n:].T
    noise: Array = transition @ exponential[:n, n:]
    for _ in range(doublings):
        noise = transition @ noise @ transition.T + noise
        transition = transition @ transition
    return transition, 0.5 * (noise + noise.T)


def covariance_factor(covariance: Array) -> Array:
    """Return L with L L' = covariance, for a covariance that may be singular (eigenvalues below rounding are set to
    0).
    """
    scale = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    factor: Array = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    return factor
