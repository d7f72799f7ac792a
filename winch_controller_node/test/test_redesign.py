"""A redesign in a process of its own is the design that the controller would have made itself."""

import time
from dataclasses import replace

import numpy as np
import pytest
from winch_controller_node.core.design_in_force import designed
from winch_controller_node.design.wire import parts_of
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.redesign import Redesign

DT = 0.05
LONGEST = 60.0
"""Wall time that a process may take on a busy machine [s]."""


def taken(redesign):
    deadline = time.monotonic() + LONGEST
    while (prepared := redesign.take()) is None:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return prepared


@pytest.mark.parametrize("payout", [5.0, 60.0], ids=["at the length of the parameters", "at another one"])
def test_the_design_of_the_process_is_that_of_the_controller_to_the_bit(payout):
    parameters = WinchControllerParameters()
    prepared = taken(Redesign(parameters, payout, DT))
    expected = designed(parameters, payout, DT)
    assert prepared.parameters == parameters
    found = parts_of(prepared.design).arrays
    assert {name: a.tobytes() for name, a in found.items()} == {
        name: a.tobytes() for name, a in parts_of(expected).arrays.items()
    }
    np.testing.assert_array_equal(prepared.law.gain, expected.make_law().gain)


def test_what_cannot_be_designed_is_said_as_it_would_be_here():
    parameters = WinchControllerParameters()
    parameters = replace(parameters, sensors=replace(parameters.sensors, use=("mru", "depth")))
    with pytest.raises(DesignError, match="must include the encoder"):
        taken(Redesign(parameters, 0.0, DT))
