"""The thread that has the link to the run: it listens, begins what viewers request, and takes the answers."""

from __future__ import annotations

import queue
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from heave_bringup.operate.link import RunLink
from heave_bringup.operate.requests import Task, WinchLimits, request_limits
from heave_bringup.operate.situation import Situation

from heave_panel.alarm_list import Alarm, AlarmList
from heave_panel.history import History

LOOK_PERIOD = 0.02
"""Wall time for which the link listens between two looks at what is requested [s]."""
COPY_PERIOD = 0.1
"""Wall time between two pictures of the situation for the pages [s]."""
LOG_LENGTH = 50
ENDING_TIME = 1.0
"""Wall time in which what needs its operator ends when the panel is closed [s]."""

Begin = Callable[[RunLink], Task]


@dataclass(frozen=True)
class Entry:
    """What came of a request: its `text`, whether it `is_refused`, and the simulated `time` [s]."""

    time: float
    text: str
    is_refused: bool


@dataclass
class Picture:
    """What the pages show: a copy, which the thread replaces and never changes."""

    situation: Situation = field(default_factory=Situation)  # of the run
    heard_at: float = 0.0  # monotonic wall time of the last word of the run [s]
    alarms: tuple[Alarm, ...] = ()  # the gravest first
    under_way: tuple[str, ...] = ()  # names of what was requested and is not done
    log: tuple[Entry, ...] = ()  # answers, the newest first
    limits: WinchLimits = field(default_factory=WinchLimits)  # of the winch as the controller assumes them

    @property
    def silence(self) -> float:
        """Wall time since the run said how it goes [s]."""
        return time.monotonic() - self.heard_at


@dataclass
class _Begun:
    name: str
    viewer: int
    task: Task


class RunWorker:
    """Serves a link in a thread of its own.

    Parameters
    ----------
    link : to the run; nobody else may use it from then on

    Attributes
    ----------
    picture : newest
    history : of the signals
    """

    def __init__(self, link: RunLink) -> None:
        self._link = link
        self._wanted: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._tasks: list[_Begun] = []
        self._log: deque[Entry] = deque(maxlen=LOG_LENGTH)
        self._alarms = AlarmList()
        self._limits = WinchLimits()
        self._is_closed = False
        self.history = History()
        self.picture = Picture(heard_at=link.heard_at)
        self._thread = threading.Thread(target=self._serve, name="run link")

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def close(self) -> None:
        """End, and leave ROS: the run goes on, a speed that is asked for ends."""
        self._is_closed = True
        self._thread.join()
        self._link.close()

    def begin(self, name: str, begin: Begin, viewer: int = 0) -> None:
        """Request something, from any thread.

        Parameters
        ----------
        name : in the list of what is under way
        begin : makes the task
        viewer : who requests it
        """

        def begun() -> None:
            try:
                self._tasks.append(_Begun(name, viewer, begin(self._link)))
            except ValueError as error:
                self._report(name, str(error), is_refused=True)

        self._wanted.put(begun)

    def acknowledge(self, key: str) -> None:
        """Acknowledge the alarm of a `key`, from any thread."""
        self._wanted.put(lambda: self._alarms.acknowledge(key))

    def let_go(self, viewer: int) -> None:
        """End what needs a `viewer` who is gone, from any thread: a speed ends, a move goes on."""

        def cancel() -> None:
            for begun in self._tasks:
                if begun.viewer == viewer and not hasattr(begun.task, "progress"):
                    begun.task.cancel()

        self._wanted.put(cancel)

    def _serve(self) -> None:
        limits = self._link.start(request_limits(self._take_limits))
        is_asking = True
        copied_at = 0.0
        while not self._is_closed:
            self._link.spin(LOOK_PERIOD)
            self._begin_what_is_wanted()
            self._look_at_tasks()
            is_asking = is_asking and limits.poll() is None
            self.history.note(self._link.situation)
            now = self._link.wall_time
            if now - copied_at >= COPY_PERIOD:
                copied_at = now
                self._copy()
        for begun in self._tasks:
            if not hasattr(begun.task, "progress"):
                begun.task.cancel()
        self._link.spin(ENDING_TIME if self._tasks else 0.0)

    def _begin_what_is_wanted(self) -> None:
        while not self._wanted.empty():
            self._wanted.get()()

    def _look_at_tasks(self) -> None:
        for begun in list(self._tasks):
            answer = begun.task.poll()
            if answer is not None:
                self._tasks.remove(begun)
                self._report(begun.name, answer.text, is_refused=answer.is_refused)

    def _report(self, name: str, text: str, *, is_refused: bool) -> None:
        self._log.appendleft(Entry(self._link.situation.time, f"{name}: {text}", is_refused))

    def _take_limits(self, limits: WinchLimits) -> None:
        self._limits = limits

    def _copy(self) -> None:
        situation = self._link.situation
        self._alarms.note(situation.time, situation.troubles)
        self.picture = Picture(
            replace(situation, troubles=dict(situation.troubles)),
            self._link.heard_at,
            self._alarms.alarms,
            tuple(begun.name for begun in self._tasks),
            tuple(self._log),
            self._limits,
        )
