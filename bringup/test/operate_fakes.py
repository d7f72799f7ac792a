"""A run that is not there: answers and situations as a test sets them, and what was asked of it."""

from collections.abc import Callable

from heave_bringup.operate.requests import Answer, Request
from heave_bringup.operate.situation import ControllerStatus, RunStatus, Situation, WinchStatus


class Given:
    """A task whose answer a test gives."""

    def __init__(self, answer: Answer | None = None) -> None:
        self.answer = answer
        self.is_cancelled = False
        self.is_under_way = False
        self.progress: tuple[float, float, float] | None = None

    def poll(self) -> Answer | None:
        return self.answer

    def cancel(self) -> None:
        self.is_cancelled = True


class FakeLink:
    """The way to a run that is not there.

    Parameters
    ----------
    answer : of each request, by its service
    """

    def __init__(self, answer: Callable[[Request], Answer | None] = lambda _: Answer("ok")) -> None:
        self.situation = Situation(RunStatus(1, tick=100, time=5.0), ControllerStatus(5.0, "compensating"))
        self.wall_time = 0.0
        self.requests: list[Request] = []
        self.speeds: list[float] = []
        self.moves: list[tuple[float, float]] = []
        self.move = Given()
        self._answer = answer

    def start(self, request: Request) -> Given:
        self.requests.append(request)
        return Given(self._answer(request))

    def start_move(self, depth: float, speed: float) -> Given:
        self.moves.append((depth, speed))
        return self.move

    def cancel_moves(self) -> Given:
        return Given(Answer("no more"))

    def ask_speed(self, speed: float) -> None:
        self.speeds.append(speed)

    @property
    def asked(self) -> list[str]:
        """The services that were asked, in order."""
        return [request.service for request in self.requests]

    def says(self, time: float, mode: str = "compensating", payout: float = 0.0) -> None:
        """Let the controller speak at a simulated time."""
        self.situation.controller = ControllerStatus(time, mode, mean_payout=payout)

    def winch_says(self, time: float, *, brake: bool, rate: float = 0.0) -> None:
        """Let the winch speak at a simulated time."""
        self.situation.winch = WinchStatus(time, 0.0, rate, brake=brake)
