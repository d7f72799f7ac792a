"""The two-state cable and its sensitivity equations (thesis 6.2.3), integrated by the classical Runge-Kutta scheme."""

from __future__ import annotations

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

PAIRS = 5
"""Pairs (value, rate): x, and its derivatives by a, b, start heave, start rate."""


@inner_kernel
def _slopes(state: Array, e: float, a: float, b: float, is_quadratic: bool, out: Array) -> None:
    x, v = state[0], state[1]
    if is_quadratic:
        drag = v * abs(v)
        drag_slope = 2.0 * abs(v)
    else:
        drag = v
        drag_slope = 1.0
    out[0] = v
    out[1] = (e - x - b * drag) / a
    for pair in range(1, PAIRS):
        value, rate = state[2 * pair], state[2 * pair + 1]
        out[2 * pair] = rate
        out[2 * pair + 1] = -(value + b * drag_slope * rate) / a
    out[3] += (x + b * drag - e) / a**2
    out[5] -= drag / a


@kernel
def respond(a: float, b: float, x: float, v: float, e: Array, e_middle: Array, h: float, is_quadratic: bool) -> Array:
    """Return x and its derivatives by a, b, start heave and start rate at each sample, shape (N, 5).

    Parameters
    ----------
    a, b : of the model; x, v : start [m], [m/s]
    e : outlet motion (boom-tip heave less payout) at the samples, shape (N,); e_middle : between them, shape (N-1,) [m]
    h : sample period [s]
    is_quadratic : drag b v abs(v) instead of b v
    """
    n = len(e)
    out = np.empty((n, PAIRS))
    state = np.zeros(2 * PAIRS)
    state[0], state[1] = x, v
    state[6] = 1.0
    state[9] = 1.0
    k1, k2, k3, k4 = np.empty(2 * PAIRS), np.empty(2 * PAIRS), np.empty(2 * PAIRS), np.empty(2 * PAIRS)
    for k in range(n):
        out[k] = state[::2]
        if k == n - 1:
            break
        _slopes(state, e[k], a, b, is_quadratic, k1)
        _slopes(state + 0.5 * h * k1, e_middle[k], a, b, is_quadratic, k2)
        _slopes(state + 0.5 * h * k2, e_middle[k], a, b, is_quadratic, k3)
        _slopes(state + h * k3, e[k + 1], a, b, is_quadratic, k4)
        state += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return out
