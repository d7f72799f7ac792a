"""Latched means latched: rank, cause and release of a winch's faults."""

from itertools import product

import pytest
from heave_node.interface.codes import WinchFault, WinchRelease
from heave_node.winch.fault_latch import FAULTS, FaultLatch
from hypothesis import given
from hypothesis import strategies as st

FAULTS_OF_A_WINCH = list(WinchFault)[1:]


def test_each_fault_has_one_row_and_a_rank_of_its_own():
    assert set(FAULTS) == set(WinchFault)
    assert len({rule.rank for rule in FAULTS.values()}) == len(FAULTS)


@pytest.mark.parametrize(("first", "second"), list(product(FAULTS_OF_A_WINCH, repeat=2)))
def test_a_higher_fault_replaces_a_lower_one_and_never_the_other_way_round(first, second):
    latch = FaultLatch()
    latch.trip(first, "first")
    latch.trip(second, "second")
    highest = max(first, second, key=lambda fault: FAULTS[fault].rank)
    assert latch.fault is highest
    expected = "first; second" if first is second else "first" if highest is first else "second"
    assert latch.words == expected


def test_words_stay_until_the_fault_is_released():
    latch = FaultLatch()
    latch.trip(WinchFault.DRIVE, "the count jumped")
    latch.acknowledge()
    assert latch.words == "the count jumped"
    latch.release(is_at_rest=True)
    assert (latch.fault, latch.words) == (WinchFault.NONE, "")


def test_a_fault_whose_cause_lasts_can_be_acknowledged_and_not_released():
    latch = FaultLatch()
    latch.hold(WinchFault.DRIVE, is_present=True)
    latch.acknowledge()
    latch.hold(WinchFault.DRIVE, is_present=True)
    assert latch.is_acknowledged, "what lasts is no new trip"
    latch.release(is_at_rest=True)
    assert (latch.fault, latch.waits_for(is_at_rest=True)) == (WinchFault.DRIVE, WinchRelease.BRAKE_REQUEST)
    latch.hold(WinchFault.DRIVE, is_present=False)
    latch.release(is_at_rest=False)
    assert latch.waits_for(is_at_rest=False) is WinchRelease.STANDSTILL
    latch.release(is_at_rest=True)
    assert latch.fault is WinchFault.NONE


EVENTS = st.one_of(
    st.tuples(st.just("trip"), st.sampled_from(FAULTS_OF_A_WINCH)),
    st.tuples(st.just("hold"), st.sampled_from(FAULTS_OF_A_WINCH), st.booleans()),
    st.tuples(st.just("acknowledge")),
    st.tuples(st.just("release"), st.booleans()),
)


@given(st.lists(EVENTS, max_size=40))
def test_the_rank_falls_only_by_a_release_at_rest_after_an_acknowledgement_since_the_last_trip(events):
    latch, rank, acknowledged = FaultLatch(), 0, False
    for name, *values in events:
        present = set(latch._present)
        if name == "trip":
            latch.trip(*values)
            acknowledged = False
        elif name == "hold":
            latch.hold(values[0], is_present=values[1])
            acknowledged &= not (values[1] and values[0] not in present)
        elif name == "acknowledge":
            latch.acknowledge()
            acknowledged = rank > 0
        else:
            latch.release(is_at_rest=values[0])
        now = FAULTS[latch.fault].rank
        assert now >= rank or (name == "release" and values[0] and acknowledged and not present and now == 0)
        rank = now


def test_what_is_found_again_with_other_figures_is_said_once():
    latch = FaultLatch()
    for distance in (0.11, 0.12, -0.13):
        latch.trip(WinchFault.DRIVE, f"the drum has moved by {distance:+.2f} m")
    latch.trip(WinchFault.DRIVE, "the brake does not open")
    assert latch.words == "the drum has moved by +0.11 m; the brake does not open"
