"""Constant tension: the filter of the load cell, the ramp of the set-point, and the law."""

import math

import numpy as np
import pytest
from heave_core.law import LoopNow, put
from heave_core.law_table import COMMAND_STATE, Way
from heave_core.library import new
from winch_controller_node.core.estimation.sense_design import FILTER_SHARE
from winch_controller_node.core.loop_command import commander
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.constant_tension import ConstantTension
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import TensionLawParameters

from tests.gates import MeanTension, TensionFilter

DT = 0.05


def test_the_filter_answers_a_step_as_a_first_order_lag_does():
    """1 - exp(-t/T); the filter's own step is that of implicit Euler, first order in dt/T."""
    time_constant = 8.0
    tension = TensionFilter(time_constant / FILTER_SHARE, tick_period=DT)
    tension.add(0.0)
    trace = []
    for _ in range(400):
        tension.add(1000.0)
        trace.append(tension.value)
    exact = 1000.0 * (1.0 - np.exp(-DT * np.arange(1, 401) / time_constant))
    np.testing.assert_allclose(trace, exact, atol=1000.0 * DT / time_constant)


def test_the_filter_begins_at_the_first_reading():
    tension = TensionFilter(2.0, tick_period=DT)
    assert math.isnan(tension.value)
    tension.add(50e3)
    assert tension.value == 50e3


class Held:
    """Constant tension in the core, of a design with these parameters of its law, above a unit that stands."""

    def __init__(self, **parameters):
        tension = TensionLawParameters(**parameters)
        self.design = design_controller(WinchControllerParameters(tension=tension, law="lqg"), tick_period=DT)
        state = new(COMMAND_STATE)
        self.tension = ConstantTension(state["tension"])
        law = self.design.make_law()
        self.core = commander(self.design, law.winch, law, state)
        winch, cable = self.design.parameters.winch, self.design.cable
        told = self.tension.take_design(
            self.design.model, cable, winch, tension, round_trip=self.design.wave_round_trip
        )
        put(self.core.design["tension"], told)
        self.tension.begin(cable.static_tension)

    def rate(self, stretch=0.0, *, outlet=0.0):
        """Return the rate command for a cable that is stretched by so much more than at rest [m], and so much out."""
        tension = self.design.cable.static_tension + self.design.cable.stiffness * stretch
        self.core.estimate[:] = 0.0
        self.core.estimate[self.design.model.state("payout")] = outlet
        self.core.act(LoopNow(Way.BY_TENSION, tension=tension, filtered_tension=tension, unit_stands=True))
        return self.core.made.asked


def test_the_set_point_takes_the_time_of_the_ramp_whatever_the_distance():
    held = Held(ramp_time=8.0)
    held.tension.begin(50e3)
    held.tension.hold(10e3)
    assert held.tension.target == 10e3
    trace = []
    for _ in range(200):
        held.rate()
        trace.append(held.tension.value)
    assert trace[159] == pytest.approx(10e3)
    assert trace[79] == pytest.approx(30e3, rel=1e-6)
    assert trace[-1] == pytest.approx(10e3, rel=1e-12)


def test_the_law_pays_out_under_too_much_tension_and_no_faster_than_its_limit():
    held = Held(time_constant=2.0, speed_limit=0.3)
    assert held.rate(0.0) == 0.0
    assert held.rate(0.1) == pytest.approx(0.1 / 2.0)
    assert held.rate(-0.1) == pytest.approx(-0.1 / 2.0)
    assert held.rate(50.0) == 0.3


def test_travel_ends_at_its_bound_and_the_way_back_stays_open():
    held = Held(time_constant=1.0, speed_limit=0.1, travel=1.0)
    held.tension.hold(held.design.cable.static_tension)
    outlet = 5.0
    for _ in range(4000):
        outlet += DT * held.rate(1.0, outlet=outlet)
    # at 0.1 m/s the average over 5 s is 0.5 m behind
    assert 1.0 <= outlet - 5.0 <= 1.5 + 0.1 * DT
    assert held.core.made.at_travel
    assert held.rate(-1.0, outlet=outlet) == pytest.approx(-0.1)


def test_half_of_the_travel_counts_beyond_what_the_change_of_tension_requires():
    held = Held(travel=1.0)
    held.tension.hold(held.design.cable.static_tension + 2.0 * held.design.cable.stiffness)
    held.rate()
    for outlet, is_half in ((2.4, False), (2.6, True)):
        for _ in range(2000):
            held.rate(outlet=outlet)
        assert bool(held.core.made.half_travelled) is is_half


@pytest.mark.parametrize("place", [(0.5, True), (0.0, False)], ids=["payout moved", "unit lifted"])
def test_the_mean_tension_begins_anew_where_the_situation_changes(place):
    mean = MeanTension(tick_period=DT)
    for _ in range(400):
        mean.add(48e3, 0.0, unit_stands=True)
    payout, stands = place
    for _ in range(20):
        mean.add(10e3, payout, unit_stands=stands)
    assert mean.mean.value == 10e3
    assert mean.mean.time == pytest.approx(1.0)
