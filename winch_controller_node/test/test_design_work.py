"""Designing beside the tick: a design is begun in one tick and takes effect at the boundary of another."""

from concurrent.futures import Executor, Future

import pytest
from winch_controller_node.design.work import DesignWork


class Desk(Executor):
    """An executor that works when it is told to, as a slow machine would."""

    def __init__(self) -> None:
        self.waiting: list[tuple[Future, object]] = []

    def submit(self, fn, /, *args, **kwargs):
        future: Future = Future()
        self.waiting.append((future, fn))
        return future

    def work(self) -> None:
        for future, make in self.waiting:
            future.set_result(make())
        self.waiting.clear()


def test_work_without_an_executor_takes_effect_in_a_fixed_tick():
    work = DesignWork[str](ticks=20)
    work.begin(100, lambda: "design")
    assert [tick for tick in range(100, 130) if work.take(tick)] == [120]


def test_work_on_a_fast_machine_takes_effect_in_the_same_tick_as_in_lockstep():
    desk = Desk()
    work = DesignWork[str](ticks=20, executor=desk)
    work.begin(100, lambda: "design")
    desk.work()
    assert [tick for tick in range(100, 130) if work.take(tick)] == [120]


def test_ticks_go_on_while_a_slow_machine_designs():
    desk = Desk()
    work = DesignWork[str](ticks=20, executor=desk)
    work.begin(100, lambda: "design")
    assert [work.take(tick) for tick in range(100, 150)] == [None] * 50
    assert work.is_under_way
    desk.work()
    assert work.take(150) == "design"
    assert not work.is_under_way


def test_what_went_wrong_is_told_where_the_result_is_taken():
    def fail() -> str:
        raise ValueError("no such winch")

    work = DesignWork[str](ticks=2)
    work.begin(5, fail)
    assert work.take(6) is None
    with pytest.raises(ValueError, match="no such winch"):
        work.take(7)
    assert not work.is_under_way


def test_a_result_that_is_dropped_never_takes_effect():
    work = DesignWork[str](ticks=2)
    work.begin(5, lambda: "design")
    work.drop()
    assert work.take(9) is None
