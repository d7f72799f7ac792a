"""What becomes of a sample whose readings the estimator refuses."""

import math

import pytest
from heave_node.interface.sensors import MruReading
from heave_node.parameters import build_parameters
from winch_controller_node.core.component import WinchController
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.node_parameters import WinchControllerParameters


@pytest.mark.parametrize("refused", [("heave",), ("heave", "heave_rate")])
def test_a_sample_is_refused_once_however_many_of_its_readings_are(refused):
    """Counted twice, the samples accepted would become fewer than none, which no message can carry."""
    controller = WinchController(build_parameters(WinchControllerParameters, {}, where="test"), tick_period=0.05)
    gate = controller.observer.gates["mru"]
    for tick in range(1, 400):
        sample = MruReading(0.05 * tick, 0.01 * (tick % 2), 0.01 * (tick % 3), 0.0, 0.0, 0, tick)
        controller.step(tick, Measurements(mru=(sample,)))
    before = gate.state(20.0)
    far = sample._replace(time=20.0, **dict.fromkeys(refused, 0.25))
    controller.step(400, Measurements(mru=(far,)))
    after = gate.state(20.0)
    assert (after.accepted, after.refused) == (before.accepted, before.refused + 1)


@pytest.mark.parametrize("rate", [0.7, math.nan])
def test_an_operator_who_acknowledges_a_step_of_the_mru_has_it_read_again(rate):
    """A swell of 1 m and 9 s, by heave alone too; its reference is set 1.5 m higher in the run, and stays there."""
    controller = WinchController(build_parameters(WinchControllerParameters, {}, where="test"), tick_period=0.05)
    stepped, asked, end = 600, 900, 1400
    seen = []
    for tick in range(1, end):
        phase = 2.0 * math.pi / 9.0 * 0.05 * tick
        heave = math.sin(phase) + (1.5 if tick >= stepped else 0.0)
        sample = MruReading(0.05 * tick, heave, rate * math.cos(phase) * 2.0 * math.pi / 9.0 / 0.7, 0.0, 0.0, 0, tick)
        if tick == asked:
            controller.set_mode("standby")
        controller.step(tick, Measurements(mru=(sample,)))
        seen.append(controller.observer.gates["mru"].is_lost)
    assert not any(seen[: stepped - 2])
    assert all(seen[stepped + 5 : asked - 1])
    assert not any(seen[-100:])
