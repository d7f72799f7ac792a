"""The active design and its successors."""

import dataclasses
import time
from dataclasses import replace

import numpy as np
import pytest
from winch_controller_node.core.design_in_force import DesignInForce, designed
from winch_controller_node.design.design import design_controller
from winch_controller_node.design.wire import parts_of
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.redesign import Redesign

DT = 0.05


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda p: dataclasses.replace(p, winch=dataclasses.replace(p.winch, command_delay=0.4)),
            "payout_rate_command_5",
        ),
        (lambda p: dataclasses.replace(p, weights=dataclasses.replace(p.weights, command=0.0)), "weights.command"),
        (lambda p: dataclasses.replace(p, mpc=dataclasses.replace(p.mpc, horizon=0.1)), "mpc.horizon"),
    ],
    ids=["different states", "no cost", "no law"],
)
def test_what_cannot_be_redesigned_leaves_everything_as_it_was(change, message):
    in_force = DesignInForce(WinchControllerParameters(), tick_period=DT)
    before = in_force.parameters, in_force.design, in_force.law
    with pytest.raises(DesignError, match=message):
        in_force.take(in_force.prepared(change(in_force.parameters), 0.0))
    assert all(
        now is then for now, then in zip((in_force.parameters, in_force.design, in_force.law), before, strict=True)
    )


def test_another_winch_keeps_every_state_and_repeats_the_oldest_command():
    in_force = DesignInForce(WinchControllerParameters(), tick_period=DT)
    old = in_force.design.model
    winch = dataclasses.replace(in_force.parameters.winch, command_delay=0.3)
    other = dataclasses.replace(in_force.parameters, winch=winch)
    matrix, _ = in_force.take_design(other, design_controller(other, tick_period=DT))
    new, x = in_force.design.model, np.random.default_rng(1).standard_normal(old.order)
    carried = matrix @ x
    for name in old.state_names:
        assert carried[new.state(name)] == x[old.state(name)]
    for index in (5, 6):
        assert carried[new.state(f"payout_rate_command_{index}")] == x[old.state("payout_rate_command_4")]


# a design that another process makes


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
