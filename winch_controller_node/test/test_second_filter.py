"""The filter beside the active one: which readings it is compared by."""

import numpy as np
from winch_controller_node.core.estimation.second_filter import SecondFilter
from winch_controller_node.design.design import design_controller
from winch_controller_node.model.estimator import Measurement
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05


def test_a_reading_that_neither_filter_predicts_says_nothing():
    """The load cell is watched, and no row of the filter where `sensors.use` leaves it out."""
    design = design_controller(WinchControllerParameters(), tick_period=DT)
    active = design.make_estimator()
    active.continue_at(0, np.zeros(design.model.order), design.initial_covariance)
    second = SecondFilter(design, design, active, 0, settling=0.0)
    assert "tension" not in active.measurements
    second.step(1, 0.0, [Measurement("tension", 1e3, 1), Measurement("mru_heave", 0.0, 1)], {})
    assert second.nats == 0.0
