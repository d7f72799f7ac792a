"""ROS shell of the adviser: observations in, beliefs out, and nobody's tick waits for it but in lockstep."""

from __future__ import annotations

from heave_msgs.msg import Observations as ObservationsMessage
from heave_node.interface import topics
from heave_node.ros.diagnostics import Health, Level, alarm_health
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.process import run_process
from heave_node.tick.roster import NOT_WAITED_FOR
from heave_node.tick.tick import Tick
from rclpy.serialization import deserialize_message

from winch_controller_node.advice import answering
from winch_controller_node.advice.answering import Answering
from winch_controller_node.advice.worker import Answer, Worker, WorkerError
from winch_controller_node.adviser.component import Adviser
from winch_controller_node.beliefs.beliefs import latency_ticks
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.node_parameters import WinchAdviserParameters, WinchControllerParameters


class WinchAdviserNode(ParticipantNode):
    """Answers each batch of `controller/observations` on `controller/beliefs`.

    In lockstep it may be behind by so many ticks that the answer to a batch is there when it becomes active: the
    clock master waits for it then, not sooner. In real time nobody waits. Where all nodes share one process, and in
    real time, a worker process does the work.
    """

    name = "winch_adviser"
    parameters_type = WinchAdviserParameters

    def __init__(self) -> None:
        super().__init__()
        # The batch that ends at tick k comes in tick k + 1, and its answer is active at tick k + N. Before that the
        # master ends tick k + N - 1, for which the adviser must have answered k + 1.
        lag = latency_ticks(self.run.tick_period) - 2
        self.lag = lag if self.run.is_lockstep else NOT_WAITED_FOR
        self._worker: Worker | None = None
        self._fault = ""

    @classmethod
    def make_adviser(cls, nominal: WinchControllerParameters, tick_period: float) -> answering.Adviser:
        """Return the adviser for `nominal` parameters and a `tick_period` [s]; for another to be put in its place."""
        return Adviser(nominal, tick_period=tick_period)

    @classmethod
    def make_answer(cls, tick_period: float) -> Answer:
        """Return what answers serialised observations at a `tick_period` [s]."""
        answers = Answering(cls.make_adviser, tick_period)
        return lambda data: answers.answer(deserialize_message(data, ObservationsMessage))

    def on_build(self) -> None:
        """Make the adviser, its input and its output."""
        self.beliefs = self.add_output(topics.CONTROLLER_BELIEFS)
        self.add_raw_input(topics.CONTROLLER_OBSERVATIONS, comes_alone=True)
        self._topic = self.resolve_topic_name(topics.CONTROLLER_OBSERVATIONS.name)
        self._has_worker = not self.run.is_lockstep and self.exchange is not None
        self._begin()

    def _begin(self) -> None:
        """Begin with an adviser that knows nothing."""
        if self._has_worker:
            self._worker = Worker(self.make_answer, self.run.tick_period)
        else:
            self._reply: Answer = self.make_answer(self.run.tick_period)

    def is_ready(self) -> bool:
        """Return whether observations would be answered at once."""
        return super().is_ready() and (self._worker is None or self._worker.is_ready())

    def on_reset(self) -> None:
        """Begin with an adviser that knows nothing."""
        self.on_exit()
        self._begin()

    def on_tick(self, tick: Tick) -> None:
        """Answer the batches that have come by `tick`."""
        del tick
        questions: list[bytes] = self.gate.take(self._topic)
        if self._worker is None:
            for question in questions:
                self.beliefs.publish(self._reply(question))
            return
        for question in questions:
            self._worker.ask(question)
        try:
            for answer in self._worker.answers():
                self.beliefs.publish(answer)
        except WorkerError as error:
            if not self._fault:
                self.get_logger().error(f"no more answers: {error}")
            self._fault = str(error)

    def diagnose(self) -> list[Health]:
        """Say how many answers were given, and whether more will come."""
        answered = {"answers": str(self.beliefs.published)}
        if self._fault:
            return [alarm_health("answers", ALARMS.alarm("ADVISER_LOST: ended", fault=self._fault), answered)]
        return [Health("answers", Level.OK, f"{self.beliefs.published} answers", answered)]

    def on_exit(self) -> None:
        """End the worker."""
        if self._worker is not None:
            self._worker.close()


def main() -> None:
    """Run the node until its run ends."""
    run_process(WinchAdviserNode)


if __name__ == "__main__":
    main()
