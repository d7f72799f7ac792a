"""Friction between drum and boom tip: efficiency of sheaves, the loop of the reading, what sticks."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.component import CableSim
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.parameters import RopePathParameters
from cable_sim_node.sensors.instruments import LoadCellParameters, SensorsParameters
from cable_sim_node.sensors.suite import RopePath
from heave_node.numerics.kinematics import PointMotion
from heave_node.parameters import ParameterError, build_parameters
from hypothesis import given
from hypothesis import strategies as st

TENSION, STIFFNESS = 36_500.0, 2e6


def readings(friction, tensions, payouts, stiffness=STIFFNESS):
    """Return the tension on the drum's side along these tensions at the boom tip [N] and payouts [m]."""
    path = RopePath(RopePathParameters(friction=friction, stiffness=stiffness), tension=tensions[0])
    read = []
    for tension, payout in zip(tensions, payouts, strict=True):
        path.advance(tension, payout)
        read.append(path.drum_tension)
    return np.array(read)


@pytest.mark.parametrize(("sheaves", "efficiency"), [(1, 0.98), (4, 0.96)])
def test_n_sheaves_have_the_efficiency_of_one_to_the_power_n(sheaves, efficiency):
    """Hauling takes T/e^n at the drum and lowering leaves T e^n."""
    friction = -sheaves * math.log(efficiency)
    out = np.linspace(0.0, 1.0, 21)
    lowering = readings(friction, [TENSION] * 21, out)[-1]
    hauling = readings(friction, [TENSION] * 21, -out)[-1]
    assert lowering == pytest.approx(TENSION * efficiency**sheaves, rel=1e-12)
    assert hauling == pytest.approx(TENSION / efficiency**sheaves, rel=1e-12)


def test_a_wrap_has_the_ratio_of_euler_and_eytelwein():
    """Half a turn at mu = 0.1: e^(mu theta) = 1.3691."""
    assert readings(0.1 * math.pi, [TENSION] * 2, [0.0, -1.0])[-1] == pytest.approx(1.3691 * TENSION, rel=1e-4)


@pytest.mark.parametrize("amplitude", [0.01, 0.1, 1.0])
def test_the_loop_of_the_reading_has_the_area_of_a_jenkin_element(amplitude):
    """Drum to and fro by a: H (2 a - H/k) a cycle, with H = 2 T sinh f; none where it only sticks."""
    friction, angle = 0.05, np.linspace(0.0, 4.0 * math.pi, 20_001)
    payouts = amplitude * np.sin(angle)
    read = readings(friction, [TENSION] * angle.size, payouts)
    last = angle >= 2.0 * math.pi - 1e-9
    area = -np.trapezoid(read[last], payouts[last])
    height = 2.0 * TENSION * math.sinh(friction)
    assert area == pytest.approx(height * (2.0 * amplitude - height / STIFFNESS), rel=1e-3)
    assert np.ptp(read[last]) == pytest.approx(height, rel=1e-9)
    small = 0.4 * height / STIFFNESS * np.sin(angle)
    stuck = readings(friction, [TENSION] * angle.size, small)
    assert np.trapezoid(stuck[last], small[last]) == pytest.approx(0.0, abs=1e-6 * height * small.max())


def test_a_locked_drum_reads_within_the_friction_of_what_pulls():
    """Nothing moves before the tension has left the reading by e^f; then it follows, so that peaks are read lower."""
    friction, angle = 0.05, np.linspace(0.0, 6.0 * math.pi, 6001)
    small = readings(friction, TENSION * (1.0 + 0.04 * np.sin(angle)), np.zeros(angle.size))
    assert np.all(small == TENSION)
    large = readings(friction, TENSION * (1.0 + 0.3 * np.sin(angle)), np.zeros(angle.size))[2001:]
    assert large.max() == pytest.approx(1.3 * TENSION * math.exp(-friction), rel=1e-5)
    assert large.min() == pytest.approx(0.7 * TENSION * math.exp(friction), rel=1e-5)


def test_a_drum_that_trembles_changes_the_reading_by_no_more_than_it_stretches():
    tremble = 1e-5 * np.random.default_rng(1).standard_normal(1000)
    read = readings(0.05, [TENSION] * 1000, tremble)
    assert np.all(np.abs(np.diff(read)) <= STIFFNESS * np.abs(np.diff(tremble)) + 1e-6)


@given(st.lists(st.tuples(st.floats(0.0, 1e6), st.floats(-100.0, 100.0)), min_size=1, max_size=50), st.floats(0.0, 1.0))
def test_the_reading_is_always_within_the_friction(path, friction):
    tensions, payouts = zip(*path, strict=True)
    read = readings(friction, tensions, payouts)
    slack = 1.0 + 1e-12
    assert np.all(read <= np.array(tensions) * math.exp(friction) * slack)
    assert np.all(read * slack >= np.array(tensions) * math.exp(-friction))


@given(st.lists(st.tuples(st.floats(0.0, 1e6), st.floats(-100.0, 100.0)), min_size=1, max_size=20))
def test_without_friction_the_reading_is_the_tension(path):
    tensions, payouts = zip(*path, strict=True)
    assert readings(0.0, tensions, payouts, stiffness=0.0).tolist() == list(tensions)


def test_friction_needs_something_that_gives():
    with pytest.raises(ParameterError, match=r"rope_path.friction needs rope_path.stiffness"):
        build_parameters(CableSimNodeParameters, {"rope_path.friction": 0.02}, where="my.yaml: cable_sim")


def test_the_load_cell_reads_less_while_the_drum_pays_out_and_more_while_it_hauls():
    friction, tick = 0.04, 0.05
    cell = dataclasses.replace(SensorsParameters(), load_cell=LoadCellParameters(noise=0.0))
    path = RopePathParameters(friction=friction, stiffness=STIFFNESS)
    plant = CableSim(CableSimNodeParameters(segments=10, rope_path=path, sensors=cell), seed=1, tick_period=tick)
    shares = []
    for k in range(1, 800):
        state, delivered = plant.readings(k)
        shares += [reading.value[0] / state.top_tension for reading in delivered["load_cell"]]
        angle = 2.0 * math.pi * min(k / 800.0, 1.0)
        payout = (1.0 - math.cos(angle), 2.0 * math.pi / 40.0 * math.sin(angle))
        plant.advance(k, PointMotion((k + 1) * tick), payout)
    assert shares[0] == pytest.approx(1.0, rel=1e-12)
    assert np.array(shares[40:380]) == pytest.approx(math.exp(-friction), rel=1e-9)
    assert np.array(shares[440:780]) == pytest.approx(math.exp(friction), rel=1e-9)
