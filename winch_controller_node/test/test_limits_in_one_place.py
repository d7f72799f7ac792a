"""Whatever limits are learnt, all that the tick goes by has the same: nobody keeps a limit of its own."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_core.law_table import ACTIVE_WINCH
from heave_core.library import dtype_of
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.core.component import WinchController
from winch_controller_node.laws.parts.winch_limits import ActiveWinch, WinchLimits
from winch_controller_node.laws.registry import LAWS
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import WinchModelParameters

DT = 0.05


def reachable(*roots):
    """Yield every object that can be reached from the `roots` by attributes and items, once each."""
    left, seen = list(roots), {}
    while left:
        one = left.pop()
        if id(one) in seen or isinstance(one, str | bytes | int | float | type):
            continue
        seen[id(one)] = one
        yield one
        if isinstance(one, dict):
            left += [*one.keys(), *one.values()]
        elif isinstance(one, list | tuple | set | frozenset):
            left += list(one)
        elif type(one).__module__.startswith(("winch_controller_node", "heave_core")):
            left += list(getattr(one, "__dict__", {}).values())


def tick_path(controller):
    """Return what makes a command and judges it: not the nominal values, which an operator has stated."""
    return controller._command, controller._in_force, controller._supervisor.guard, controller._supervisor._limits


def field_values(limits, winch):
    return {
        "speed": limits.speed,
        "acceleration": limits.acceleration,
        "power": limits.power,
        "lowest": limits.payout_minimum,
        "highest": limits.payout_maximum,
        "least_tension": limits.minimum_tension,
        "most_tension": limits.maximum_tension,
        "static_tension": limits.static_tension,
        "gain": winch.speed_gain,
        "hauling_gain": winch.hauling_gain,
        "creep": winch.creep,
        "linear_step": limits.acceleration * DT / -math.expm1(-DT / winch.time_constant),
    }


@pytest.fixture(scope="module", params=LAWS)
def controller(request):
    return WinchController(WinchControllerParameters(law=request.param), tick_period=DT)


learnt = st.fixed_dictionaries(
    {
        "speed_limit": st.floats(0.1, 5.0),
        "acceleration_limit": st.floats(0.1, 5.0),
        "power_limit": st.just(0.0) | st.floats(1e4, 1e6),
        "speed_gain": st.floats(0.5, 2.0),
        "hauling_gain": st.floats(0.5, 2.0),
        "creep": st.floats(-0.1, 0.1),
    }
)


@settings(max_examples=10, deadline=None)
@given(values=learnt)
def test_every_holder_of_a_limit_has_the_active_one(controller, values):
    controller._in_force.take_limits(replace(controller.parameters.winch, **values))
    controller._take_law()
    limits, winch = controller.design.limits, controller.parameters.winch
    assert (limits.speed, limits.acceleration) == (values["speed_limit"], values["acceleration_limit"])
    found = list(reachable(*tick_path(controller)))
    assert all(one == limits for one in found if isinstance(one, WinchLimits))
    assert all(one == winch for one in found if isinstance(one, WinchModelParameters))
    records = [one for one in found if isinstance(one, np.ndarray) and one.dtype == dtype_of(ACTIVE_WINCH)]
    assert len(records) == sum(isinstance(one, ActiveWinch) for one in found) == 1, "law and command share the winch"
    for name, value in field_values(limits, winch).items():
        assert records[0][name][0] == pytest.approx(value, nan_ok=True), name


def test_the_share_of_the_unit_follows_the_speed_that_was_learnt():
    """A fifth of the speed limit: it stayed a fifth of the one that was assumed first."""
    controller = WinchController(WinchControllerParameters(law="lqg"), tick_period=DT)
    law = controller._in_force.law
    assert law.largest_share == pytest.approx(0.2 * 2.0)
    controller._in_force.take_limits(replace(controller.parameters.winch, speed_limit=1.0))
    assert law.largest_share == pytest.approx(0.2)
