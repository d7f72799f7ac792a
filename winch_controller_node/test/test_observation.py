"""What becomes of a sample whose readings the estimator refuses."""

from types import SimpleNamespace

import pytest
from heave_node.interface.sensors import MruReading
from heave_node.parameters import build_parameters
from winch_controller_node.component import WinchController
from winch_controller_node.estimation.consistency import Consistency
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.model.estimator import Innovation
from winch_controller_node.node_parameters import WinchControllerParameters


@pytest.mark.parametrize("refused", [("mru_heave",), ("mru_heave", "mru_heave_rate")])
def test_a_sample_is_refused_once_however_many_of_its_readings_are(refused):
    """Counted twice, the samples accepted would become fewer than none, which no message can carry."""
    controller = WinchController(
        build_parameters(WinchControllerParameters, {}, where="test"), tick_period=0.05, seed=1
    )
    observer, estimator = controller.observer, controller.estimator
    sample = MruReading(0.05, 0.1, 0.0, 0.0, 0.0, 0, 1)
    observer.observe(1, Measurements(mru=(sample,)), estimator, 0.0)
    assert (observer.gates["mru"].state(0.05).accepted, observer.gates["mru"].state(0.05).refused) == (1, 0)
    innovations = {name: Innovation(1.0, 0.1, 100.0, name not in refused) for name in ("mru_heave", "mru_heave_rate")}
    observer.learn(SimpleNamespace(measurements=estimator.measurements, innovations=innovations), Consistency(0.05))
    assert (observer.gates["mru"].state(0.05).accepted, observer.gates["mru"].state(0.05).refused) == (0, 1)
