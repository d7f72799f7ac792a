"""An adviser behind its messages, in a worker process, and over the questions of a recorded run."""

import importlib
import os
import signal
import time
from pathlib import Path

import numpy as np
import psutil
import pytest

pytest.importorskip("heave_msgs")
from heave_msgs.msg import Beliefs as BeliefsMessage
from heave_msgs.msg import Observations as ObservationsMessage
from rclpy.serialization import deserialize_message
from winch_controller_node.advice.answering import Answering, compare_again
from winch_controller_node.advice.messages import beliefs_of, observations_message
from winch_controller_node.advice.worker import Worker, WorkerError
from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.design.wire import parameters_text
from winch_controller_node.interface.observations import READING_COLUMNS, TICK_COLUMNS, Observations
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05
NOMINAL = parameters_text(WinchControllerParameters())
OTHER = parameters_text(WinchControllerParameters(length=500.0))
LONGEST_WAIT = 60.0
"""Wall time in which a process begins on a busy machine [s]."""


class Counting:
    """Says how many batches it has seen, and of which nominal: an answer depends on all that came before."""

    def __init__(self, parameters, tick_period):
        self.length = parameters.length
        self.seen = 0

    def advise(self, observations):
        self.seen += 1
        return Beliefs(asked=observations.last, number=self.seen, authority=min(1.0, self.length / 500.0))


def question(batch, nominal=NOMINAL):
    """Return batch number `batch` of 20 ticks, from 1."""
    ticks = np.full((20, len(TICK_COLUMNS)), float(batch))
    observed = Observations(20 * batch - 19, ticks, (), np.zeros((0, len(READING_COLUMNS))), 0, 0)
    return observations_message(observed, nominal, 20 * batch * 50_000_000)


def read(data):
    return deserialize_message(data, ObservationsMessage)


def answered(answering, *questions):
    return [beliefs_of(deserialize_message(answering.answer(read(one)), BeliefsMessage)) for one in questions]


def test_an_answer_says_what_it_answers_and_is_stamped_with_the_last_tick_before_it_is_in_force():
    """Batch 1 ends at tick 20, t = 1 s; its answer is active at tick 40: the tick before begins at 1.95 s."""
    answer = deserialize_message(Answering(Counting, DT).answer(read(question(1))), BeliefsMessage)
    assert answer.asked == 20
    assert (answer.header.stamp.sec, answer.header.stamp.nanosec) == (1, 950_000_000)


def test_the_nominal_comes_with_the_observations_and_with_another_one_another_adviser_begins():
    answers = answered(Answering(Counting, DT), question(1), question(2), question(3, OTHER), question(4, OTHER))
    assert [answer.number for answer in answers] == [1, 2, 1, 2]
    assert [answer.authority for answer in answers] == [0.6, 0.6, 1.0, 1.0]


@pytest.fixture
def program(monkeypatch):
    """The module of the worker, where a new process finds it too."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    return importlib.import_module("worker_program")


def wait_for(worker, count):
    found, deadline = [], time.monotonic() + LONGEST_WAIT
    while len(found) < count:
        assert time.monotonic() < deadline
        found += worker.answers()
        time.sleep(0.01)
    return found


def test_a_worker_answers_in_order_in_a_process_of_its_own_and_nobody_waits_for_it(program):
    worker = Worker(program.make_answer, DT)
    try:
        for text in (b"one", b"two", b"three"):
            worker.ask(text)
        found = [answer.split() for answer in wait_for(worker, 3)]
    finally:
        worker.close()
    assert [text for _, _, text in found] == [b"one", b"two", b"three"]
    assert {float(period) for _, period, _ in found} == {DT}
    assert os.getpid() not in {int(pid) for pid, _, _ in found}


@pytest.mark.parametrize("how", ["raises", "is killed", "cannot begin"])
def test_a_worker_that_has_ended_is_told_and_is_no_reason_to_wait(program, how):
    worker = Worker(program.make_none if how == "cannot begin" else program.make_answer, DT)
    try:
        worker.ask(b"one")
        if how != "cannot begin":
            pid = int(wait_for(worker, 1)[0].split()[0])
        if how == "raises":
            worker.ask(b"fail")
        elif how == "is killed":
            os.kill(pid, signal.SIGKILL)
        words = {
            "raises": "ValueError: no answer",
            "is killed": "its process",
            "cannot begin": "ValueError: no adviser",
        }
        with pytest.raises(WorkerError, match=words[how]):
            wait_for(worker, 1)
        assert worker.is_ready()
    finally:
        worker.close()


def test_no_worker_is_left_behind(program):
    before = set(psutil.Process().children(recursive=True))
    worker = Worker(program.make_answer, DT)
    started = set(psutil.Process().children(recursive=True)) - before
    worker.close()
    _, left = psutil.wait_procs([one for one in started if "spawn_main" in str(one.cmdline())], timeout=LONGEST_WAIT)
    assert started
    assert not left


def test_a_recorded_run_answered_again_by_the_same_adviser_is_the_same_and_by_another_is_not():
    questions = [question(batch) for batch in range(1, 5)]
    run = Answering(Counting, DT)
    recorded = [(20 * (i + 1), run.answer(read(one))) for i, one in enumerate(questions)]
    same = compare_again(map(read, questions), recorded[:3], Counting, DT)
    assert (same.equal, same.different, same.unrecorded, same.unasked, same.is_same) == (3, (), 1, 0, True)

    class Another(Counting):
        def advise(self, observations):
            answer = super().advise(observations)
            return Beliefs(
                asked=answer.asked, number=answer.number, authority=0.5 if self.seen == 2 else answer.authority
            )

    other = compare_again(map(read, questions), recorded, Another, DT)
    assert (other.equal, other.different, other.is_same) == (3, (40,), False)
    gap = compare_again(map(read, questions[:1]), recorded, Counting, DT)
    assert (gap.equal, gap.unasked, gap.is_same) == (1, 3, False)


def test_a_run_that_was_reset_has_a_new_adviser_after_it():
    questions = [question(1), question(2), question(1), question(2)]
    recorded = []
    for first in (0, 2):
        run = Answering(Counting, DT)
        recorded += [(20 * (i + 1), run.answer(read(one))) for i, one in enumerate(questions[first : first + 2])]
    found = compare_again(map(read, questions), recorded, Counting, DT)
    assert (found.equal, found.is_same) == (4, True)
