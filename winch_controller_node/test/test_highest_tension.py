"""Above the highest tension the winch gives way, whatever the law asks."""

from types import SimpleNamespace

import pytest
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.law import LawCommand
from winch_controller_node.loop_command import LoopCommand
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import LimitParameters
from winch_controller_node.parameters.model import WinchModelParameters

DT = 0.05
RATIO = 1.2


def given_way(excess, *, brake=False, **winch):
    """Return the command and the excess over stiffness [m] for a tension so much [N] above the highest one."""
    parameters = WinchControllerParameters(
        law="lqg",
        limits=LimitParameters(maximum_tension_ratio=RATIO),
        winch=WinchModelParameters(**winch),
    )
    design = design_controller(parameters, tick_period=DT)
    command = LoopCommand(design, design.make_law())
    tick = SimpleNamespace(sensed=SimpleNamespace(tension=RATIO * design.cable.static_tension + excess))
    asked = command._give_way(LawCommand(0.1, active=("speed",)), tick, SimpleNamespace(brake=brake))
    return asked, excess / design.cable.stiffness


def test_the_winch_pays_out_the_excess_within_a_second():
    asked, stretch = given_way(5e3)
    assert asked.value == pytest.approx(0.1 + stretch / 1.0)
    assert asked.active == ("speed", "tension")


def test_a_slow_winch_takes_twice_its_lag():
    asked, stretch = given_way(5e3, command_delay=0.4, time_constant=0.5)
    assert asked.value == pytest.approx(0.1 + stretch / 1.8)


def test_nothing_is_added_below_the_highest_tension_or_under_a_brake():
    assert given_way(-1.0)[0] == LawCommand(0.1, active=("speed",))
    assert given_way(5e3, brake=True)[0] == LawCommand(0.1, active=("speed",))
