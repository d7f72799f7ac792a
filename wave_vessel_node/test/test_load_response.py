"""A ship that responds to its load: against the exact response of its three motions, and of two masses on a spring."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from wave_vessel_node.component import WaveVessel, boom_tip_heave
from wave_vessel_node.parameters import LoadResponseParameters, VesselParameters, WaveVesselParameters

TICK = 0.05
SHIP = LoadResponseParameters(displacement=5e6)
CALM = WaveVesselParameters(significant_wave_height=0.0, load_response=SHIP)
RAO = replace(CALM, vessel=VesselParameters(model="rao"))
ARM = np.array(CALM.vessel.boom_tip_arm)


def by_hand(omega):
    """Return heave, roll and pitch over a downward force at the boom tip, and the boom tip's own heave over it."""
    weight = SHIP.displacement * STANDARD_GRAVITY
    stiffness = np.array([SEAWATER_DENSITY * STANDARD_GRAVITY * 1500.0, weight * 1.5, weight * 110.0])
    own = 2.0 * math.pi / np.array([7.0, 12.0, 6.5])
    lever = np.array([1.0, ARM[1], -ARM[0]])
    response = lever / stiffness / (1.0 - (omega / own) ** 2 + 2j * np.array([0.3, 0.06, 0.3]) * omega / own)
    return -response, -(lever @ response)


def moved(parameters, tension, seconds):
    """Return the six motions and the boom tip's heave at each tick from 2 on under a tension over time."""
    vessel = WaveVessel(parameters, seed=1, tick_period=TICK)
    outputs = [vessel.step(tick, tension(tick * TICK)) for tick in range(1, round(seconds / TICK))]
    return (
        np.array([one.vessel.six[one.row, 0] for one in outputs]),
        np.array([(p.position[2], p.velocity[2], p.acceleration[2]) for p in (one.boom_tip for one in outputs)]),
    )


def harmonic(values, omega):
    """Return the complex amplitude of what follows sin(omega t), of the last ten periods."""
    time = TICK * np.arange(2, len(values) + 2)
    late = time > time[-1] - 20.0 * math.pi / omega
    basis = np.column_stack((np.sin(omega * time), np.cos(omega * time), np.ones_like(time)))[late]
    a, b, _ = np.linalg.lstsq(basis, values[late], rcond=None)[0]
    return a + 1j * b


@pytest.mark.parametrize("omega", [0.3, 0.52, 0.9, 1.5])
def test_heave_roll_and_pitch_answer_a_swinging_tension_as_by_hand(omega):
    """The force is known a tick before: it is carried on as it went, which is right to (omega dt)^2/2."""
    six, tip = moved(RAO, lambda t: 1e6 + 2e5 * math.sin(omega * t), 400.0)
    wanted, of_tip = by_hand(omega)
    accepted = (omega * TICK) ** 2 + (0.01 if omega == 0.52 else 1e-3)  # after 300 s roll still swings by 0.3 %
    for column, value in zip((2, 3, 4), wanted, strict=True):
        assert harmonic(six[:, column], omega) == pytest.approx(2e5 * value, rel=accepted, abs=1e-9)
    assert harmonic(tip[:, 0], omega) == pytest.approx(2e5 * of_tip, rel=accepted)
    assert harmonic(tip[:, 2], omega) == pytest.approx(-(omega**2) * 2e5 * of_tip, rel=accepted)


def test_the_second_order_vessel_has_the_same_boom_tip():
    """Its motion is that of the boom tip: heave takes what roll and pitch make there."""
    swing = lambda t: 1e6 + 2e5 * math.sin(0.9 * t)  # noqa: E731
    assert moved(CALM, swing, 60.0)[1] == pytest.approx(moved(RAO, swing, 60.0)[1], abs=1e-12)


def test_a_load_that_is_set_down_leaves_the_ship_higher_by_hydrostatics():
    _, tip = moved(RAO, lambda t: 1e6 if t < 10.0 else 6e5, 900.0)
    assert tip[-1, 0] == pytest.approx(-4e5 * by_hand(0.0)[1].real, rel=1e-3)
    assert tip[-1, 0] > 0.0


def test_two_masses_on_a_spring_swing_as_the_exact_solution():
    """Ship and 250 t on k = 2 MN/m, the winch moving the rope by 0.5 m at 6 s; a load of 5 %.

    (k + D) z = k (h - p), h = H k (z - h + p) by the ship's receptance H, D = -M w^2.
    """
    mass, k, omega = 2.5e5, 2e6, 2.0 * math.pi / 6.0
    vessel, sub = WaveVessel(RAO, seed=1, tick_period=TICK), 50
    z, v, tip, tips, loads = 0.0, 0.0, (0.0, 0.0), [], []
    damping = 0.05 * 2.0 * math.sqrt(k * mass)

    def pull(t, h, rate, z, v):
        stretch = h - 0.5 * math.sin(omega * t) - z
        return k * stretch + damping * (rate - 0.5 * omega * math.cos(omega * t) - v)

    for tick in range(1, 8000):
        t = tick * TICK
        out = vessel.step(tick, pull(t, *tip, z, v))
        after = (out.boom_tip.position[2], out.boom_tip.velocity[2])
        for part in range(sub):  # midpoint rule on the load, the boom tip as a cubic over the tick
            h = TICK / sub
            s = (part + 0.5) / sub
            place = tip[0] * (1 - s) ** 2 * (1 + 2 * s) + after[0] * s**2 * (3 - 2 * s)
            place += TICK * (tip[1] * s * (1 - s) ** 2 - after[1] * s**2 * (1 - s))
            rate = tip[1] + s * (after[1] - tip[1])
            zm, vm = z + 0.5 * h * v, v + 0.5 * h * pull(t + (s - 0.5 / sub) * TICK, place, rate, z, v) / mass
            z, v = z + h * vm, v + h * pull(t + s * TICK, place, rate, zm, vm) / mass
        tip = after
        tips.append(tip[0])
        loads.append(z)
    spring = k + 1j * omega * damping
    receptance = -by_hand(omega)[1]  # of the boom tip under an upward force
    # unknowns h, z: h = -receptance T, -M w^2 z = T, T = spring (h - p - z)
    matrix = np.array([[1.0 + receptance * spring, -receptance * spring], [-spring, spring - mass * omega**2]])
    h, of_load = np.linalg.solve(matrix, np.array([receptance * spring, -spring]) * 0.5)
    assert harmonic(np.array(tips), omega) == pytest.approx(h, rel=0.01)
    assert harmonic(np.array(loads), omega) == pytest.approx(of_load, rel=0.01)
    assert abs(h) > 0.02


def test_without_a_displacement_the_tension_moves_nothing():
    plain = replace(WaveVesselParameters(), ramp=0.0)
    runs = [WaveVessel(plain, seed=2, tick_period=TICK) for _ in range(2)]
    for tick in range(1, 60):
        one, other = runs[0].step(tick), runs[1].step(tick, 1e7 * tick)
        assert np.array_equal(one.boom_tip.position, other.boom_tip.position)


def test_the_sea_and_the_mru_stay_as_they_were_under_a_steady_load():
    """One tick a block gives the numbers of many: to roundoff; the sum by itself has no load and says so."""
    sea = replace(WaveVesselParameters(), ramp=0.0)
    given = replace(sea, load_response=SHIP)
    plain, steady = (WaveVessel(one, seed=2, tick_period=TICK) for one in (sea, given))
    for tick in range(1, 300):
        one, other = plain.step(tick), steady.step(tick, 1e6)
        assert other.boom_tip.position == pytest.approx(one.boom_tip.position, abs=1e-12)
        assert other.mru.heave == pytest.approx(one.mru.heave, abs=1e-9)
    assert boom_tip_heave(given, 2, TICK, 10) is None
