"""How a fade-out brings the drum back: which units it damps, and that it ends where that makes one swing more."""

import math

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.outlet_hold import SETTLED_SWING, OutletHold
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import WinchModelParameters
from winch_controller_node.supervision import supervisor

DT = 0.05


@pytest.mark.parametrize(
    ("time_constant", "inertia", "is_damped"),
    [
        (0.15, 0.13, False),  # 300 m, 3 t: a radian takes 0.36 s, as long as the winch lags behind
        (0.15, 7.2, True),  # 900 m, 10 t: 2.7 s
        (1.0, 7.2, True),
        (1.5, 7.2, True),
        (2.0, 7.2, False),
        (1.0, 3.0, False),
    ],
)
def test_a_fade_out_damps_a_unit_whose_swing_is_slow_against_the_winch(time_constant, inertia, is_damped):
    winch = WinchModelParameters(time_constant=time_constant)
    design = design_controller(WinchControllerParameters(winch=winch), tick_period=DT)
    swing = OutletHold(design.model, winch, inertia).settled_swing
    assert swing == (SETTLED_SWING if is_damped else math.inf)


def contrary_fade_out():
    """Return when the brake is on after a stop at 60 s [s], and how far the unit swings [m].

    The winch goes the other way once it is to damp the unit: each of its moves adds to the swing.
    """
    loop = ClosedLoop(loop_parameters(load_scenario("b3_deep_900", settings=["all.seed=3", "all.duration=130"])))
    command, braked = loop.controller._command, []
    ask = command._ask

    def contrary(tick, state, standing, decision):
        asked = ask(tick, state, standing, decision)
        return asked._replace(value=-3.0 * asked.value) if decision.is_damped else asked

    command._ask = contrary

    def stop(tick, outputs):
        if tick == round(60.0 / DT):
            loop.controller.set_mode("standby")
        if outputs.order.brake and tick * DT > 60.0:
            braked.append(tick * DT)

    record = loop.run(stop)
    return braked[0], float(np.ptp(record.column("unit", after=60.0)))


@pytest.mark.slow
def test_a_fade_out_that_makes_the_unit_swing_more_ends_under_the_brake(monkeypatch):
    brake, swing = contrary_fade_out()
    monkeypatch.setattr(supervisor, "WORSE_SWING", math.inf)
    late, wide = contrary_fade_out()
    assert brake < late - 10.0
    assert swing < 0.7 * wide
