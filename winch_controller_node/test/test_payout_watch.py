"""Depth sensor and payout meter: both count from the surface, and one of them may count falsely."""

import math
from types import SimpleNamespace

import pytest
from winch_controller_node.core.supervision.watch.payout_watch import PayoutWatch

DT, WINDOW = 0.05, 8.0


def told(depth, *, length=300.0, height=10.0, payout=0.0, tolerance=0.01, known=lambda time: True, unit_weight=1.95e6):
    """Return the alarms of 60 s with a unit that heaves about a `depth` at which it rests [m].

    The cable stretches by 2 m below a weight of 1 MN/m times that: half of its own, of 100 kN, and the unit's.
    """
    design = SimpleNamespace(
        tick_period=DT,
        length=length,
        unit_weight=unit_weight,
        cable=SimpleNamespace(static_tension=unit_weight + 0.1e6, stiffness=1e6),
        parameters=SimpleNamespace(
            length=length, boom_tip_height=height, health=SimpleNamespace(payout_tolerance=tolerance)
        ),
    )
    watch, alarms = PayoutWatch(design), []
    for tick in range(round(60.0 / DT)):
        time = tick * DT
        depths = ((time, depth + 1.5 * math.sin(0.8 * time)),) if tick % 2 else ()
        alarms += [(time, one) for one in watch.update(depths, payout, WINDOW, is_known=known(time))]
    return alarms


def test_a_meter_that_reads_less_than_is_out_is_told_once_with_both_depths_after_a_wave():
    ((time, alarm),) = told(302.0)
    assert time == pytest.approx(WINDOW, abs=0.1)
    assert alarm.code == "PAYOUT_DEPTH_DISAGREE"
    assert alarm.values["out"] == 300.0
    assert alarm.values["expected"] == pytest.approx(292.0)
    assert alarm.values["depth"] == pytest.approx(302.0, abs=0.8)


@pytest.mark.parametrize("off", [-5.0, 0.0, 5.0])
def test_what_tide_draught_and_a_hundredth_of_the_cable_may_be_off_is_not_told(off):
    assert told(292.0 + off) == []


def test_cable_that_was_paid_out_counts_and_nothing_is_compared_while_it_is_not_known_where_the_unit_is():
    assert told(292.0 + 50.0 * (1.0 + 2.0 / 300.0), payout=50.0) == []
    assert told(302.0, known=lambda time: False) == []
    assert told(302.0, known=lambda time: time % 7.0 < 6.5) == []
    assert told(302.0, tolerance=0.0) == []


def test_a_spring_whose_preload_takes_the_weight_stretches_nothing():
    """A passive compensator of 20 m of travel under the weight, at its middle."""
    assert told(290.0, unit_weight=20e6) == []
