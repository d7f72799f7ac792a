"""The linear plant solves thesis Eq. 6.2."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_sim_node.errors import BadMotionError
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.vertical.linear_plant import LinearPlant
from heave_node.numerics.kinematics import PointMotion
from scipy.integrate import solve_ivp

A, B = 0.8959, 0.1658
TICK = 0.05


def make() -> LinearPlant:
    return LinearPlant(CableSimParameters(), inertia=A, damping=B)


def tip(z: float, rate: float) -> PointMotion:
    return PointMotion(0.0, np.array([0.0, 0.0, z]), np.array([0.0, 0.0, rate]), np.zeros(3))


def test_it_agrees_with_a_quadrature_of_the_differential_equation() -> None:
    plant = make()
    rest = plant.unit_motion()[0][2]
    rng = np.random.default_rng(1)
    values, rates = np.cumsum(rng.normal(0.0, 0.05, 41)), rng.normal(0.0, 0.5, 41)
    values -= values[0]
    payouts, payout_rates = 0.3 * values[::-1] - 0.3 * values[-1], -0.3 * rates[::-1]

    def forcing(t: float) -> float:
        k = min(int(t / TICK), 39)
        s = t / TICK - k
        basis = (2 * s**3 - 3 * s**2 + 1, s**3 - 2 * s**2 + s, -2 * s**3 + 3 * s**2, s**3 - s**2)
        x, v = values - payouts, rates - payout_rates
        return float(basis[0] * x[k] + basis[1] * TICK * v[k] + basis[2] * x[k + 1] + basis[3] * TICK * v[k + 1])

    for k in range(40):
        plant.advance(
            TICK,
            tip(values[k], rates[k]),
            tip(values[k + 1], rates[k + 1]),
            payouts[k],
            payout_rates[k],
            payouts[k + 1],
            payout_rates[k + 1],
        )
    reference = solve_ivp(
        lambda t, y: [y[1], (forcing(t) - y[0] - B * y[1]) / A],
        (0.0, 40 * TICK),
        [0.0, 0.0],
        max_step=TICK / 8,
        rtol=1e-10,
        atol=1e-12,
    ).y[:, -1]
    assert plant.unit_motion()[0][2] - rest == pytest.approx(reference[0], abs=1e-7)
    assert plant.unit_motion()[1][2] == pytest.approx(reference[1], abs=1e-7)
    acceleration = (forcing(40 * TICK) - reference[0] - B * reference[1]) / A
    assert plant.unit_motion()[2][2] == pytest.approx(acceleration, abs=1e-6)


@pytest.mark.parametrize("omega", [0.3, 1.0, 2.0])
def test_its_steady_answer_is_the_transfer_function(omega: float) -> None:
    plant = make()
    rest = plant.unit_motion()[0][2]
    ticks = int(600.0 / TICK)
    heave = []
    for k in range(ticks):
        ends = [tip(math.sin(omega * t), omega * math.cos(omega * t)) for t in (k * TICK, (k + 1) * TICK)]
        plant.advance(TICK, *ends, 0.0, 0.0, 0.0, 0.0)
        heave.append(plant.unit_motion()[0][2] - rest)
    t = TICK * np.arange(1, ticks + 1)
    late = t > 300.0
    basis = np.column_stack([np.sin(omega * t[late]), np.cos(omega * t[late])])
    sine, cosine = np.linalg.lstsq(basis, np.array(heave)[late], rcond=None)[0]
    expected = 1.0 / (1.0 - A * omega**2 + 1j * B * omega)
    assert complex(sine, cosine) == pytest.approx(expected, rel=1e-5)


def test_payout_lowers_the_unit_by_its_length_and_pays_no_tension() -> None:
    plant = make()
    rest, tension = plant.unit_motion()[0][2], plant.top_tension
    for k in range(4000):
        plant.advance(TICK, tip(0.0, 0.0), tip(0.0, 0.0), min(0.01 * k, 2.0), 0.0, min(0.01 * (k + 1), 2.0), 0.0)
    assert plant.unit_motion()[0][2] - rest == pytest.approx(-2.0, abs=1e-3)
    assert plant.top_tension == pytest.approx(tension, rel=1e-3)
    assert plant.unstretched_length == pytest.approx(302.0)


def test_motion_that_is_not_finite_is_refused() -> None:
    with pytest.raises(BadMotionError):
        make().advance(TICK, tip(0.0, 0.0), tip(math.nan, 0.0), 0.0, 0.0, 0.0, 0.0)


def test_payout_that_jumps_between_intervals_is_refused() -> None:
    with pytest.raises(BadMotionError, match=r"payout_start 0\.5 m differs"):
        make().advance(TICK, tip(0.0, 0.0), tip(0.0, 0.0), 0.5, 0.0, 0.5, 0.0)
