"""The envelope in the loop: a fault behind it drives the drum no further than the sea explains.

Without it (`envelope.active` false) a drum under orders 100 times too large travels 1.5 m, and one of a drive 100 times
too quick 2.1 m: the campaign's table, `python -m tests.campaigns.envelope`, has all cases with and without.
"""

from functools import lru_cache

import pytest

from tests.campaigns.envelope import CASES, run

FURTHEST = {
    "frozen encoder b2 seed 3": 1.2,
    "order x100 b2 seed 1": 0.8,
    "drive x100 b2 seed 1": 0.6,
    "drive x3 b2 seed 1": 0.5,
    "drive reversed b2 seed 1": 0.4,
}
"""Cases, and travel from the fault on [m]: heave of the last minute 0.3 m, 1.5 times that and 0.3 m to either side."""


@lru_cache
def found(name):
    return run(CASES[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", FURTHEST)
def test_a_fault_drives_the_drum_no_further_than_the_sea_explains(name):
    one = found(name)
    assert one.bound[0] == 0
    assert one.travel < FURTHEST[name]
    assert one.mode in ("stopped", "standby")
