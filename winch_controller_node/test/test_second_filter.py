"""The filter beside the active one: which readings it is compared by."""

import numpy as np
import pytest
from winch_controller_node.core.estimation.second_filter import RowEvidence

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
