"""Near the winch's limits, by the sea or by a unit that is far off, law lqg commands as the law that knows them."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.laws.parts.near_limits import BEGINS, ENDS, MEMORY
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05
DESIGN = design_controller(WinchControllerParameters(law="lqg"), tick_period=DT).with_own_gains()
LIMITS = DESIGN.limits
RATE = DESIGN.model.row("boom_tip_heave_rate")
ACCELERATION = (RATE @ DESIGN.model.A - RATE) / DT


def state_at(share: float) -> np.ndarray:
    """Return a state whose boom tip takes this share of the nearest limit."""
    x = np.zeros(DESIGN.model.order)
    x[[DESIGN.model.state(name) for name in DESIGN.sea_states]] = 1.0
    taken = max(abs(float(RATE @ x)) / LIMITS.speed, abs(float(ACCELERATION @ x)) / LIMITS.acceleration)
    return x * share / taken


class Near:
    """Law lqg, asked for whether the limits are near where the boom tip and the unit take shares of theirs."""

    def __init__(self):
        self.law = DESIGN.make_law()

    def are_near(self, tip, unit=0.0):
        x = state_at(tip)
        heave = DESIGN.model.state("unit_heave")
        largest = self.law.core.law["unit_share"][0] * self.law.winch.record["speed"][0]
        x[heave] = unit * largest / self.law.gain[heave]
        self.law.command(LoopState(x, Reference(), DESIGN.cable.static_tension))
        return bool(self.law.core.state["is_near"][0])


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(-2.0, 2.0), max_size=30))
def test_up_and_down_are_alike_and_the_sea_is_near_the_limits_only_after_it_was(shares):
    up, down = Near(), Near()
    highest = 0.0
    for share in shares:
        highest = max(highest, abs(share))
        are_near = up.are_near(share)
        assert are_near == down.are_near(-share)
        assert not are_near or highest > BEGINS
        assert are_near or abs(share) <= BEGINS


def test_a_wave_is_remembered_until_a_decay_of_first_order_has_taken_it_well_away_from_the_limits():
    limits = Near()
    assert limits.are_near(1.5)
    ticks = 0
    while limits.are_near(0.0):
        ticks += 1
    assert ticks * DT == pytest.approx(MEMORY * math.log(1.5 / ENDS), abs=2 * DT)
    assert limits.are_near(1.0)
    limits.law.reset()
    assert not limits.are_near(0.0)


def test_a_unit_that_asks_for_all_that_it_may_is_remembered_as_a_wave_is():
    by_unit, by_wave = Near(), Near()
    assert not by_unit.are_near(0.0, 0.999 * BEGINS)
    assert by_unit.are_near(0.0, 1.0)
    assert by_wave.are_near(1.0)
    for _ in range(round(2.0 * MEMORY / DT)):
        assert by_unit.are_near(0.0) == by_wave.are_near(0.0)
    assert not by_unit.are_near(0.0)


def test_a_weaker_winch_is_nearer_to_its_limits():
    limits = Near()
    assert not limits.are_near(0.5)
    weak = {"speed": 0.5 * LIMITS.speed, "acceleration": 0.5 * LIMITS.acceleration}
    limits.law.take_limits(dataclasses.replace(LIMITS, **weak))
    assert limits.are_near(0.5)
