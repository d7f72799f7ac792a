"""What limits compensation is reported, and once that it is over."""

import pytest
from winch_controller_node.core.supervision.modes import Mode

from tests.supervised import Supervised

DT = 0.05
HELD, OVER = ("AUTHORITY_LIMITED", pytest.approx(30.0)), ("AUTHORITY_RESTORED", pytest.approx(100.0))
CODES = ("AUTHORITY_LIMITED", "AUTHORITY_RESTORED")


def told(loop, seconds, share, *, authority=1.0, factor=1.0, compensates=True):
    """Return what is reported while a winch whose gain is known so well allows a `share` for some time."""
    found = []
    modes = loop.supervisor.modes
    for _ in range(round(seconds / DT)):
        loop.enter(Mode.COMPENSATING if compensates else Mode.MANUAL, authority=authority)
        modes.set_factor(factor)
        found += [one for one in loop.step(winch={"share": share}).alarms if one.code in CODES]
    return [(alarm.name, alarm.values["percent"]) for alarm in found]


def test_what_was_told_is_taken_back_once_when_all_is_compensated():
    loop = Supervised()
    assert told(loop, 10.0, 0.3, authority=0.3) == [HELD]
    assert told(loop, 20.0, 1.0, authority=0.6) == [], "authority is on its way"
    (over,) = told(loop, 200.0, 1.0)
    assert over == OVER


def test_what_was_told_is_not_taken_back_while_something_else_still_holds_a_part_back():
    loop = Supervised()
    assert told(loop, 10.0, 0.3, authority=0.3) == [HELD]
    assert told(loop, 100.0, 1.0, authority=0.3) == [], "the sea asks for more than the winch can give"
    (over,) = told(loop, 10.0, 1.0)
    assert over == OVER


def test_nothing_is_taken_back_that_was_not_told():
    loop = Supervised()
    assert told(loop, 4.0, 0.3) == []
    assert told(loop, 100.0, 1.0) == []


def test_a_moment_without_it_takes_nothing_back():
    loop = Supervised()
    assert told(loop, 10.0, 0.3) == [HELD]
    for _ in range(5):
        assert told(loop, 4.0, 1.0) == told(loop, 1.0, 0.3) == []


def test_what_lasts_is_told_each_minute():
    assert told(Supervised(), 180.0, 0.3) == [HELD] * 3


def test_an_end_of_compensation_takes_nothing_back():
    loop = Supervised()
    assert told(loop, 10.0, 0.3) == [HELD]
    assert told(loop, 100.0, 1.0, compensates=False) == []
    assert told(loop, 100.0, 1.0) == []


@pytest.mark.parametrize("factor", [0.5, 0.8])
def test_of_a_factor_what_it_allows_is_all(factor):
    loop = Supervised()
    assert told(loop, 10.0, 0.3) == [HELD]
    (over,) = told(loop, 10.0, 1.0, authority=factor, factor=factor)
    assert over == ("AUTHORITY_RESTORED", pytest.approx(100.0 * factor))
