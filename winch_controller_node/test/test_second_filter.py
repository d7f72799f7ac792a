"""The filter beside the active one: which readings it is compared by."""

import numpy as np
import pytest
from winch_controller_node.core.estimation.second_filter import RowEvidence
from winch_controller_node.core.estimation.sense_design import ROWS, second_design
from winch_controller_node.design.design import carry_by_name, design_controller
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import SeaModelParameters

from tests.core_parts import Sensing

DT = 0.05


def evidence(*blocks):
    """Return evidence over blocks of readings, each the innovations of the active filter and of the second one."""
    row = RowEvidence()
    for readings in blocks:
        active, second = (sum(one[place] ** 2 for one in readings) for place in (0, 1))
        row.close(active, second, len(readings))
    return row.nats


def test_the_second_filter_is_right_where_it_explains_what_the_active_one_does_not():
    """The likelihood of a block with its noise profiled out is half the logarithm of the ratio of mean squares."""
    assert evidence([(5.0, 1.0)] * 20) == pytest.approx(0.5 * np.log(25.0))
    assert evidence([(1.0, 5.0)] * 20) == pytest.approx(-0.5 * np.log(25.0))


def test_two_filters_of_which_none_explains_the_readings_say_nothing_of_each_other():
    """A winch whose limits fell: an adviser with the right limits was given up for nominal values, 1.8 times nearer."""
    assert evidence(*[[(11.0, 6.0)] * 20] * 60) == 0.0


def test_one_that_explains_far_more_is_right_though_limits_act():
    assert evidence([(100.0, 5.0)] * 20) > 2.0


def test_a_jump_to_another_belief_is_no_evidence_against_it():
    """Innovations of the tick of a jump gave 12 nats at once against an encoder's scale that was right."""
    assert evidence(*[[(1.0, 1.0)] * 20] * 20, [(1e3, 1.0), *[(1.0, 1.0)] * 19]) < 5.0


def test_evidence_is_forgotten_within_some_waves():
    assert abs(evidence([(5.0, 1.0)] * 20, *[[(1.0, 1.0)] * 20] * 60)) < 0.1


def test_the_boom_tip_is_no_witness_of_where_the_drum_is():
    """It heaves with the ship: with the drum locked its heave named a sound drive."""
    estimator = design_controller(WinchControllerParameters(), tick_period=DT).make_estimator()
    compared = dict(zip(ROWS, second_design(estimator, by_count=True)["is_compared"], strict=False))
    assert {name for name, is_compared in compared.items() if is_compared}.isdisjoint(
        {"mru_heave", "mru_heave_rate", "payout"}
    )
    assert compared["unit_heave"]
    assert second_design(estimator, by_count=False)["is_compared"][ROWS.index("mru_heave")]


def test_another_sea_is_that_of_both_filters():
    """The filter that goes by the count kept the sea of before, and the active one was judged by the difference."""
    calm, rough = (
        design_controller(
            WinchControllerParameters(sea=SeaModelParameters(significant_wave_height=height)), tick_period=DT
        )
        for height in (1.0, 3.0)
    )
    estimation = Sensing(calm)
    estimation.estimator.step(0, 0.0, [])
    estimation.compare_count(0)
    noise = 2.0 * calm.make_estimator().process_noise
    estimation.estimator.set_process_noise(noise)
    estimation.compare_count(0)
    np.testing.assert_array_equal(estimation.by_count.process_noise, noise)
    estimation.carry(rough, carry_by_name(calm, rough))
    assert estimation.by_count.design is rough
    np.testing.assert_array_equal(estimation.by_count.process_noise, rough.make_estimator().process_noise)
    assert estimation.by_count.nats == 0.0
