"""The registry of laws: what a law states of itself is what the controller does with it."""

import dataclasses

import numpy as np
import pytest
from heave_node.parameters import ParameterError, build_parameters, describe
from winch_controller_node.core.component import WinchController
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.laws.law import ControlLaw, LawCommand
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.laws.registry import LAWS
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.validation.peers.reference_systems import DEEP_900

DT = 0.05


def parameters(**values):
    named = {name.replace("__", "."): value for name, value in values.items()}
    return build_parameters(WinchControllerParameters, named, where="test")


@pytest.mark.parametrize("name", LAWS)
def test_each_law_has_a_group_of_its_own_parameters_or_none(name):
    groups = {info.name.split(".")[0] for info in describe(WinchControllerParameters) if "." in info.name}
    assert (name in groups) is (LAWS[name].parameters_type is not None)


def test_an_unknown_law_is_refused_with_those_that_are_known():
    with pytest.raises(ParameterError, match=f"one of {', '.join(LAWS)}"):
        parameters(law="pid")


@pytest.mark.parametrize("name", LAWS)
def test_every_law_is_at_rest_when_nothing_moves(name):
    design = design_controller(parameters(law=name), tick_period=DT)
    law = design.make_law()
    state = LoopState(np.zeros(design.model.order), Reference(), design.cable.static_tension)
    assert law.command(state).value == 0.0
    law.reset()
    assert law.command(state).value == 0.0


def test_a_law_is_refused_without_the_sensor_that_it_needs():
    with pytest.raises(DesignError, match="law feedforward needs the sensor mru"):
        WinchController(parameters(law="feedforward", sensors__use=("depth", "encoder")), tick_period=DT)


def test_a_law_that_does_not_move_the_winch_keeps_the_brake_on():
    controller = WinchController(parameters(law="off"), tick_period=DT)
    outputs = [controller.step(tick, Measurements()) for tick in range(1, 10)]
    assert all(output.order.brake and output.mode == "off" for output in outputs)


def test_a_law_of_anybody_joins_by_a_class_and_an_entry(monkeypatch):
    """A class that says what it is, and its name in the registry: the design makes it, with its own parameters."""

    class Damper(ControlLaw):
        name, summary, keeps_limits = "damper", "damps the unit", True

        def __init__(self, design, own):
            super().__init__(design, own)
            self.gain = np.where([state == "unit_heave_rate" for state in design.model.state_names], 2.0, 0.0)

        def command(self, state):
            return LawCommand(-float(self.gain @ state.x))

    monkeypatch.setitem(LAWS, "damper", Damper)
    controller = WinchController(dataclasses.replace(parameters(), law="damper"), tick_period=DT)
    report = controller.step(1, Measurements()).report
    assert report.law == "damper"
    assert report.gain[report.state_names.index("unit_heave_rate")] == 2.0
    assert controller.mode.value == "standby"


def test_the_effort_of_the_unit_regulator_is_that_of_a_simulated_loop():
    """It acts when the unit has moved, later than the boom tip, and so with more speed than that; lqg predicts it."""
    deep = build_parameters(WinchControllerParameters, DEEP_900 | {"law": "lqr"}, where="test")
    design = design_controller(deep, tick_period=DT)
    law, model, rng = design.make_law(), design.model, np.random.default_rng(1)
    x, rates = np.zeros((model.order, 64)), []
    through = float(model.D[model.output_names.index("payout_rate"), 0])
    for k in range(6000):
        command = -law.gain @ x
        if k > 2000:
            tip = model.row("boom_tip_heave_rate") @ x
            rates.append((model.row("payout_rate") @ x + through * command, tip))
        x = model.A @ x + np.outer(model.B[:, 0], command) + model.G @ rng.standard_normal((model.G.shape[1], 64))
    drum, tip = np.std(rates, axis=(0, 2))
    # 64 runs of 200 s, some 1300 waves: 3 %
    assert law.effort.speed == pytest.approx(drum / tip, rel=0.05)
    assert law.effort.speed > 1.0
    assert design_controller(dataclasses.replace(deep, law="lqg"), tick_period=DT).make_law().effort.speed == 1.0
