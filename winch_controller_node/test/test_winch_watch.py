"""What the controller makes of a winch that says which of its limits acts."""

import numpy as np
import pytest
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.interface.codes import WinchLimit
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.readings import WinchOrder, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.supervision.watch.winch_watch import WinchWatch

DT = 0.05


@pytest.mark.parametrize("name", [WinchLimit.SPEED, WinchLimit.TORQUE, WinchLimit.PRESSURE, WinchLimit.FLOW])
def test_a_limit_is_learnt_whatever_the_winch_calls_it(name):
    """A drum of 0.4 m/s, where 2 m/s are believed, that is asked for 0.8 m/s by a sea of 9 s."""
    parameters = WinchControllerParameters()
    watch = WinchWatch(design_controller(parameters, tick_period=DT))
    drum = VirtualWinch(WinchParameters(speed_limit=0.4), tick_period=DT)
    drum.step(0, WinchCommand(1))
    found = parameters.winch
    for tick in range(1, 600):
        rate = 0.8 * np.sin(0.7 * tick * DT)
        watch.give(WinchOrder(tick + 1, 0.0, rate, brake=False))
        state = drum.step(tick, WinchCommand(tick + 1, 0.0, rate))
        says = name if state.limits_hit & WinchLimit.SPEED else WinchLimit.NONE
        reading = WinchReading(
            tick * DT, state.encoder_payout, 0.0, brake=False, command_sequence=tick, limits_hit=int(says)
        )
        watch.watch(reading, state.encoder_payout, parameters)
        found = watch.improved_winch(tick, found) or found
    # a little less is used of a limit that was learnt
    assert 0.36 < found.speed_limit < 0.41


@pytest.mark.parametrize(("late", "every"), [(1, 97), (1, 140), (6, 97)])
def test_a_machine_that_stalls_now_and_then_is_not_taken_for_a_weak_winch(late, every):
    """Each `every` ticks the commands of `late` ticks come together with the next, to a winch that is as believed."""
    parameters = WinchControllerParameters()
    watch = WinchWatch(design_controller(parameters, tick_period=DT))
    drum = VirtualWinch(WinchParameters(), tick_period=DT)
    drum.step(0, WinchCommand(1))
    found, noise = parameters.winch, np.random.default_rng(1)
    for tick in range(1, 1600):
        rate = 0.8 * np.sin(1.1 * tick * DT) + 0.03 * noise.standard_normal()
        watch.give(WinchOrder(tick + 1, 0.0, rate, brake=False))
        stalls = tick > late and tick % every < late
        state = drum.step(tick, None if stalls else WinchCommand(tick + 1, 0.0, rate))
        reading = WinchReading(
            tick * DT,
            state.encoder_payout,
            0.0,
            brake=False,
            command_sequence=state.command_sequence,
            limits_hit=int(state.limits_hit),
        )
        watch.watch(reading, state.encoder_payout, parameters)
        found = watch.improved_winch(tick, found) or found
    assert found == parameters.winch
