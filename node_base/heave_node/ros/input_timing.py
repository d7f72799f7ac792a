"""Wall times of a node: how messages from outside arrive, and its own ticks beside their budget."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from heave_node.ros.diagnostics import Health, Level
from heave_node.tick.durations import Durations
from heave_node.tick.time_budget import TimeBudget

LIBRARY = "libtracetools.so"
"""Of ros2_tracing, which rcl is linked with; without it, or built without LTTng, nothing is traced."""
TIMING = "timing"
"""Begins the name of a diagnostic status that holds a histogram of durations."""


class TickTrace:
    """The ticks of a node as the callback NODE/tick of the events callback_start and callback_end."""

    def __init__(self, node: str) -> None:
        self._callback = ctypes.c_void_p(id(self))
        self._library: ctypes.CDLL | None = None
        with suppress(OSError, AttributeError):  # there is none, or one that was built without its functions
            library = ctypes.CDLL(LIBRARY)
            library.ros_trace_rclcpp_callback_register(self._callback, f"{node}/tick".encode())
            self._library = library

    def began(self) -> None:
        """Mark the start of this node's part of a tick."""
        if self._library is not None:
            self._library.ros_trace_callback_start(self._callback, ctypes.c_bool(False))

    def ended(self) -> None:
        """Mark its end."""
        if self._library is not None:
            self._library.ros_trace_callback_end(self._callback)


class InputTiming:
    """Wall times of the messages of one external publisher, on the `topic` of this name."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.intervals = Durations()
        self.ages = Durations()
        self._arrived_at: float | None = None

    def arrived(self) -> None:
        """Note the arrival of a message."""
        now = time.monotonic()
        if self._arrived_at is not None:
            self.intervals.add(now - self._arrived_at)
        self._arrived_at = now

    def used(self) -> None:
        """Note that the newest message is used, whether it is new or was used before."""
        if self._arrived_at is not None:
            self.ages.add(time.monotonic() - self._arrived_at)

    def diagnose(self) -> list[Health]:
        """Return both as diagnostic statuses."""
        return [timing_health(f"interval {self.topic}", self.intervals), timing_health(f"age {self.topic}", self.ages)]


class TickTiming:
    """Wall times of the ticks of a `node` in real time, beside its `budget`; `tick_period` in [s].

    Each report covers the ticks since the last one: the largest of them is judged. Names, words and keys are those of
    diagnostic_updater's FrequencyStatus and TimeStampStatus.

    Attributes
    ----------
    work : processor time of its part of each tick
    ages : from the start of each tick to its answer
    """

    def __init__(self, node: str, budget: TimeBudget, tick_period: float) -> None:
        self.work, self.ages = Durations(), Durations()
        self._periods: list[float] = []  # since the last report [s]
        self._period_count = 0
        self._budget, self._tick_period = budget, tick_period
        self._trace = TickTrace(node)
        self._began: float | None = None
        self._worked, self._late_reports = 0.0, 0

    def began(self) -> None:
        """Note that the node begins its part of a tick."""
        self._trace.began()
        before, self._began, self._worked = self._began, time.monotonic(), time.thread_time()
        if before is not None:
            self._periods.append(self._began - before)

    def broke_off(self) -> None:
        """Note that no period leads to the next tick: it follows a pause, or begins another run."""
        self._began = None

    def ended(self, age: float | None = None) -> None:
        """Note its end, `age` after the start of the tick [s]; None where `ages` is kept by somebody else."""
        self.work.add(time.thread_time() - self._worked)
        if age is not None:
            self.ages.add(age)
        self._trace.ended()

    def diagnose(self) -> list[Health]:
        """Return processor time, period and age as diagnostic statuses: a warning where one is over its budget."""
        if not len(self.work):
            return []
        periods, self._periods, ages = self._periods, [], self.ages.take_new()
        self._period_count += len(periods)
        window = sum(periods)
        frequency = {
            "Events in window": str(len(periods)),
            "Events since startup": str(self._period_count),
            "Duration of window (s)": f"{window:f}",
            "Actual frequency (Hz)": f"{len(periods) / max(window, 1e-9):f}",
            "Target frequency (Hz)": f"{1.0 / self._tick_period:f}",
            "Minimum acceptable frequency (Hz)": f"{1.0 / self._budget.period:f}",
        }
        self._late_reports += max(ages, default=0.0) > self._budget.age
        stamps = {
            "Earliest timestamp delay:": f"{min(ages, default=0.0):f}",
            "Latest timestamp delay:": f"{max(ages, default=0.0):f}",
            "Latest acceptable timestamp delay:": f"{self._budget.age:f}",
            "Late diagnostic update count:": str(self._late_reports),
        }
        work = timing_health("work in a tick", self.work)
        met = Health("Frequency Status", Level.OK, "Desired frequency met", frequency)
        reasonable = Health("Timestamp Status", Level.OK, "Timestamps are reasonable.", stamps)
        return [
            _judged(work, self.work.take_new(), self._budget.work, "Processor time too long"),
            _judged(met, periods, self._budget.period, "Frequency too low"),
            _judged(reasonable, ages, self._budget.age, "Timestamps too far in past seen"),
        ]


def _judged(health: Health, new: Sequence[float], budget: float, words: str) -> Health:
    """Return `health`, or a warning with `words` where the largest of the `new` durations is over `budget` [s]."""
    largest = max(new, default=0.0)
    if largest <= budget:
        return health
    text = f"{words}: {1e3 * largest:.1f} ms, budget {1e3 * budget:g} ms"
    return replace(health, level=Level.WARN, message=text)


def timing_health(name: str, durations: Durations, **more: str) -> Health:
    """Return `durations` as a diagnostic status: `name` says which, `more` are further values."""
    return Health(f"{TIMING} {name}", Level.OK, durations.words(), {**durations.to_values(), **more})
