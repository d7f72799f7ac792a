"""A drum that the sea outruns turns early and catches up without haste; kinematics of constant acceleration."""

import math

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.kpi import window_ratios
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.parts.late_drum import LateDrum
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import WinchModelParameters

DT = 0.05
SHARE = 0.4
"""Speed that the unit's own error may ask for [m/s]."""


def make_drum(delay=0.2):
    winch = WinchModelParameters(command_delay=delay)
    design = design_controller(WinchControllerParameters(winch=winch), tick_period=DT)
    drum = LateDrum(design.model, winch, design.limits, gain=design.gain, largest_share=SHARE)
    return design, drum


DESIGN, DRUM = make_drum()


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(-5.0, 5.0), min_size=DESIGN.model.order, max_size=DESIGN.model.order))
def test_up_and_down_are_alike_and_no_more_is_forgiven_than_there_is(values):
    x = np.array(values)
    assert DRUM.forgiven(-x) == pytest.approx(-DRUM.forgiven(x))
    assert DRUM.turn_early(-x) == pytest.approx(-DRUM.turn_early(x))
    displaced = x.copy()
    displaced[DESIGN.model.state("payout")] -= DRUM.forgiven(x)
    # what is left is less, and of the same sign: the drum is never sent past the boom tip
    left = DRUM.forgiven(displaced)
    assert abs(left) <= abs(DRUM.forgiven(x))
    assert left * DRUM.forgiven(x) >= 0.0


@pytest.mark.parametrize("offset", [0.1, 0.5, 2.0])
def test_a_drum_that_is_off_is_asked_for_no_more_speed_than_it_can_stop_from(offset):
    """From a speed v a drum stops over v^2 / (2 a); a tenth of a, the winch's limit, is for that."""
    design, drum = DESIGN, DRUM
    x = np.zeros(design.model.order)
    x[design.model.state("payout")] = offset
    gain = design.gain[design.model.state("payout")]
    speed = gain * (offset - drum.forgiven(x))
    contrary = min(max(design.gain[design.model.state("unit_heave")], 0.0) * offset, SHARE)
    assert speed - contrary <= math.sqrt(2.0 * 0.1 * design.limits.acceleration * offset) + 1e-9
    assert drum.forgiven(x) >= 0.0


def test_a_sea_within_the_limits_is_followed_and_a_steep_one_makes_the_drum_turn_before_the_boom_tip():
    design, drum = DESIGN, DRUM
    x = np.zeros(design.model.order)
    sea = [design.model.state(name) for name in design.sea_states]
    x[sea] = np.random.default_rng(1).standard_normal(len(sea))
    rates, peak = [], design.model.row("boom_tip_heave_rate")
    ahead = x
    for _ in range(round(3.0 / DT)):
        rates.append(float(peak @ ahead))
        ahead = design.model.A @ ahead
    steepest = np.max(np.abs(np.diff(rates))) / DT
    within = 0.9 * design.limits.acceleration / steepest
    assert drum.turn_early(within * x) == pytest.approx(0.0, abs=1e-12)
    # far beyond the limit the drum is sent towards where the boom tip's speed will be
    steep = 20.0 * within * x
    after = 20.0 * within * np.array(rates[round(0.2 / DT) :])
    extreme = after[np.argmax(np.abs(after - after[0]))]
    assert drum.turn_early(steep) * (extreme - after[0]) > 0.0


def test_drum_and_boom_tip_are_compared_at_the_same_moment_though_the_delay_ends_within_a_tick():
    """Just before the end of a tick the error is that at its end; a tick apart it would be 5 cm off at 1 m/s."""
    errors = []
    for delay in (0.25, 0.2499):
        design, drum = make_drum(delay)
        model = design.model
        x = np.zeros(model.order)
        x[model.state("payout_rate")] = 1.0
        x[[model.state(name) for name in design.delay_states]] = 1.0
        x[model.state("vessel_heave_rate")] = 1.0
        errors.append(float(drum._error @ x))
    assert errors[1] == pytest.approx(errors[0], abs=0.001)


@pytest.mark.slow
@pytest.mark.parametrize("period", [6.0, 7.0])
def test_lqg_keeps_a_unit_in_a_sea_far_steeper_than_believed(period):
    """Belief Hs 1.5 m, Tp 10 s; this seed had 2.2 (6 s) and 1.15 times the motion without compensation."""
    loop = ["winch_controller.law=lqg", "all.seed=62", "all.duration=130"]
    sea = ["wave_vessel.significant_wave_height=4.5", f"wave_vessel.peak_period={period}"]
    record = ClosedLoop(loop_parameters(load_scenario("b3_deep_900", settings=[*loop, *sea]))).run()
    unit = record.column("unit") + record.column("depth_set_point")
    _, ratios = window_ratios(record.column("time"), unit, record.column("uncompensated"), 30.0)
    assert np.max(ratios) < 1.05
