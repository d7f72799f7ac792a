"""Law industrial: its poles are those of the rule, and it inverts the lag that the plain feed-forward leaves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from heave_node.parameters import build_parameters
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.industrial import rule_gain
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05


def design(**winch: object):
    values = {"law": "industrial", **{f"winch.{name}": value for name, value in winch.items()}}
    return design_controller(build_parameters(WinchControllerParameters, values, where="test"), tick_period=DT)


@pytest.mark.parametrize(("lag", "delay"), [(0.15, 0.2), (1.0, 0.5), (0.5, 0.33), (0.05, 0.1)])
@pytest.mark.parametrize("position_gain", [0.0, 0.5])
def test_a_payout_left_over_comes_back_at_the_gain_of_the_loop_and_the_lag_is_gone(
    lag: float, delay: float, position_gain: float
) -> None:
    """With lag and delay inverted the outlet obeys e' = -k e: T p'' + (1 + T k) p' + k p = (T s + 1)(s + k) p = 0."""
    made = design(time_constant=lag, command_delay=delay, position_gain=position_gain)
    law, model = made.make_law(), made.model
    keep = [
        i for i, name in enumerate(model.state_names) if name.startswith(("payout", made.command + "_"))
    ]  # the drum and the commands on their way; the sea does not move
    closed = (model.A - model.B @ law.gain[None, :])[np.ix_(keep, keep)]
    slowest = max(np.linalg.eigvals(closed), key=abs)
    k = rule_gain(delay + 0.5 * DT, lag)
    # a command held over a tick of 50 ms, k up to 2/s: what sampling leaves of it
    assert -math.log(abs(slowest)) / DT == pytest.approx(k, rel=0.06)
    assert abs(slowest.imag) < 1e-9


def test_the_rule_keeps_a_phase_margin_of_75_degrees_round_the_delay() -> None:
    for delay in (0.05, 0.2, 1.0):
        # k/s exp(-s delay) crosses over at k
        margin = 90.0 - math.degrees(rule_gain(delay, 0.0) * delay)
        assert margin >= 75.0
    assert rule_gain(0.0, 1e-3) == 2.0


def test_a_boom_tip_that_moves_evenly_is_followed_with_its_own_rate() -> None:
    made = design()
    law, model = made.make_law(), made.model
    x = np.zeros(model.order)
    x[model.state("payout_rate")] = 0.3
    x[[i for i, name in enumerate(model.state_names) if name.startswith(made.command + "_")]] = 0.3
    state = LoopState(x, Reference(), 0.0)
    # the drum moves at 0.3 m/s where the boom tip rests: ordered to stop, and to make good the overshoot
    winch = made.parameters.winch
    k = rule_gain(winch.command_delay + 0.5 * DT, winch.time_constant)
    gone = 0.3 * (winch.command_delay + 0.5 * DT)
    assert law.command(state).value == pytest.approx(-k * (gone + winch.time_constant * 0.3), rel=1e-6)


def test_a_winch_that_takes_payouts_is_refused() -> None:
    with pytest.raises(DesignError, match="law industrial commands a rate"):
        design(law="first_order").make_law()
