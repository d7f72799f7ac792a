"""The clairvoyant's plan: the optimum that another solver finds for the same problem, within its bounds."""

from __future__ import annotations

import numpy as np
import osqp
import pytest
import scipy.sparse as sp
from scipy.signal import lsim
from winch_controller_node.design.clairvoyant import clairvoyant_heave
from winch_controller_node.model.blocks import CableModel

CABLE, STEP = CableModel(4.0, 0.3), 0.2
TIME = STEP * np.arange(90)
TIP = 1.5 * np.sin(0.9 * TIME) + 0.8 * np.sin(1.3 * TIME + 1.0)


def unit_of(outlet: np.ndarray, start: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Return a x'' + b x' + x = outlet, the outlet straight between samples, by scipy."""
    a, b = CABLE.a, CABLE.b
    system = ([[0.0, 1.0], [-1.0 / a, -b / a]], [[0.0], [1.0 / a]], [[1.0, 0.0]], [[0.0]])
    _, heave, _ = lsim(system, outlet, TIME, X0=start)
    return heave


def optimum(payout: float, rate: float, acceleration: float) -> float:
    """Return the least root mean square that OSQP finds over start values and accelerations, the problem condensed."""
    n = TIME.size
    columns, rows_p, rows_v = [], [], []
    for k in range(n - 1 + 4):
        a = np.zeros(n - 1)
        x0, p0, v0 = (0.0, 0.0), 0.0, 0.0
        if k < n - 1:
            a[k] = 1.0
        else:
            x0, p0, v0 = [
                ((1.0, 0.0), 0.0, 0.0),
                ((0.0, 1.0), 0.0, 0.0),
                ((0.0, 0.0), 1.0, 0.0),
                ((0.0, 0.0), 0.0, 1.0),
            ][k - n + 1]
        v = v0 + np.concatenate([[0.0], STEP * np.cumsum(a)])
        p = p0 + np.concatenate([[0.0], np.cumsum(STEP * v[:-1] + 0.5 * STEP**2 * a)])
        columns.append(unit_of(-p, x0))
        rows_p.append(p)
        rows_v.append(v)
    M, free = np.column_stack(columns), unit_of(TIP)
    bounded = np.vstack([np.column_stack(rows_p), np.column_stack(rows_v), np.eye(n - 1, n + 3)])
    box = np.concatenate([np.full(n, payout), np.full(n, rate), np.full(n - 1, acceleration)])
    solver = osqp.OSQP()
    cost = sp.csc_matrix(M.T @ M + 1e-9 * np.eye(n + 3))
    settings = {"verbose": False, "eps_abs": 1e-6, "eps_rel": 1e-6, "max_iter": 400_000}
    solver.setup(cost, M.T @ free, sp.csc_matrix(bounded), -box, box, **settings)
    return float(np.sqrt(np.mean((free + M @ solver.solve(raise_error=True).x) ** 2)))


@pytest.mark.parametrize("bounds", [(2.0, 1.0, 0.9), (50.0, 0.8, 5.0), (0.7, 5.0, 5.0), (5.0, 5.0, 0.6)])
def test_the_plan_is_the_optimum_that_osqp_finds(bounds: tuple[float, float, float]) -> None:
    found = float(np.sqrt(np.mean(clairvoyant_heave(CABLE, bounds, TIP, STEP) ** 2)))
    assert found == pytest.approx(optimum(*bounds), rel=2e-3, abs=5e-5)


def test_within_all_bounds_nothing_is_left() -> None:
    assert np.abs(clairvoyant_heave(CABLE, (1e4, 20.0, 20.0), TIP, STEP)).max() < 1e-3
