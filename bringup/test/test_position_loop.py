"""A drum with a position loop of its own, by `payout` of the commands, beside one that follows `payout_rate`.

The drum that goes by payout is the first-order winch of thesis Eq. 6.1, u' = (u_0 - u)/T; the one that goes by rate has
the same lag T. By linearity both move alike: V(s)/V_set(s) = U(s)/U_set(s) = 1/(1 + T s).
"""

import math

import numpy as np
import pytest
from heave_bringup import ClosedLoop, load_scenario, loop_parameters

DT = 0.05


def loop(*settings, duration):
    """Return the loop of 300 m of cable under `settings`."""
    own = ["winch_controller.law=lqg", f"all.duration={duration}", *settings]
    return ClosedLoop(loop_parameters(load_scenario("b2_calm_300", settings=own)))


@pytest.mark.parametrize("lag", [pytest.param(0.35, marks=pytest.mark.slow), 1.0])
def test_a_drum_that_goes_by_payout_compensates_as_one_that_goes_by_rate(lag):
    told = f"winch_controller.winch.time_constant={lag}"
    by_rate = loop(told, f"virtual_winch.time_constant={lag}", duration=180.0).run()
    by_payout = loop(
        told, "virtual_winch.law=first_order", f"virtual_winch.position_rate={1.0 / lag}", duration=180.0
    ).run()
    residual = by_rate.unit_sigma(after=90.0)
    assert residual < 0.05 * by_rate.uncompensated_sigma(after=90.0)
    assert by_payout.unit_sigma(after=90.0) == pytest.approx(residual, rel=0.1)


def commands(closed):
    """Run a loop; return its commands and the drum's payout at the start of each tick."""
    sent, drum, step = [], [], closed.winch.step

    def keep(tick, command, tension):
        sent.append(command)
        drum.append(closed.winch.state.payout)
        return step(tick, command, tension)

    closed.winch.step = keep
    requests = {50.0: "standby", 80.0: "compensating", 110.0: "standby", 140.0: "manual"}

    def request(tick, outputs):
        if (mode := requests.get(round(tick * DT, 6))) is not None:
            closed.controller.set_mode(mode)

    closed.run(request)
    return sent, np.array(drum)


@pytest.mark.parametrize("gain", [0.0, 1.0])
def test_payout_is_the_integral_of_the_rate_and_makes_no_step_at_a_change_of_mode(gain):
    """Through settling, compensation, two fade-outs to standby with the brake, and manual.

    What may differ is the leak to the drum, of a minute, and with a position gain the way within the delay.
    """
    sent, drum = commands(loop(f"system.winch.position_gain={gain}", duration=150.0))
    payout = np.array([command.payout for command in sent])
    braked = np.array([command.brake for command in sent])
    speeds = np.array([c.payout_rate + gain * (c.payout - at) for c, at in zip(sent, drum, strict=True)])
    assert {bool(one) for one in braked} == {True, False}
    moves = np.diff(payout)
    both = ~braked[1:] & ~braked[:-1]
    error = moves - DT * speeds[1:]
    assert np.max(np.abs(error[both])) < 2e-3 + DT * 0.3 * gain * np.max(np.abs(speeds))
    assert np.max(np.abs(moves[~both])) < DT * np.max(np.abs(speeds)) + 2e-3
    assert np.ptp(payout[~braked]) > 0.5


def test_the_mean_payout_is_what_the_winch_works_about():
    closed = loop(duration=60.0)
    sent, _ = commands(closed)
    means = np.array([command.mean_payout for command in sent])
    assert np.all(np.isfinite(means))
    assert np.ptp(means[400:]) < 0.1 * np.ptp([command.payout for command in sent[400:]])
    assert means[-1] == pytest.approx(closed.controller.mean.point.payout, abs=0.02)
    assert math.isfinite(sent[0].payout)
