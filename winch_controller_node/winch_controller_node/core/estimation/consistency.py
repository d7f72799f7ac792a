"""Consistency of the readings: whether they are as far off their prediction as their noise allows."""

from __future__ import annotations

import math
from collections.abc import Mapping

from heave_node.interface.alarm import Alarm

from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.model.estimator import Innovation

MEMORY = 20.0
"""Memory of the mean of the normalised innovations squared [s]."""

INCONSISTENT = 2.0
"""Mean of the normalised innovations squared above which a sensor is inconsistent with its model; 1 is consistent."""

QUIET, QUIET_TIME = 0.4, 60.0
"""Mean of the normalised innovations squared below which a sensor is quieter than nominal, and time until that is
reported [s]."""

UNEXPLAINED_TIME = 90.0
"""Time after which readings that are inconsistent without a pause count as unexplained [s]: the adviser judges a
minute, accepts an explanation after 10 s more, and a new assumption begins the count again."""

LARGEST = 25.0
"""Largest weight of one normalised innovation squared: a spike is no lasting error."""

ENCODER_ROW = "payout"
"""Readings of the encoder are not judged: the winch is identified by them."""


class Consistency:
    """How far the readings of each sensor are from their prediction, over some waves.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._means: dict[str, float] = {}
        self._time = 0.0
        self._quiet_times: dict[str, float] = {}
        self._reported_quiet: set[str] = set()
        self._is_reported = False

    def add(self, innovations: Mapping[str, Innovation]) -> None:
        """Take in the innovations of a tick, by measurement."""
        weight = self._dt / MEMORY
        for name, innovation in innovations.items():
            if name != ENCODER_ROW and math.isfinite(innovation.nis):
                before = self._means.get(name, 1.0)
                self._means[name] = before + weight * (min(innovation.nis, LARGEST) - before)
        for name, mean in self._means.items():
            self._quiet_times[name] = self._quiet_times.get(name, 0.0) + self._dt if mean < QUIET else 0.0
        self._time = self._time + self._dt if max(self._means.values(), default=1.0) > INCONSISTENT else 0.0

    def is_inconsistent(self, name: str) -> bool:
        """Return whether readings of the measurement `name` have been inconsistent of late, not in one reading."""
        return self._means.get(name, 1.0) > INCONSISTENT

    def newly_quiet(self) -> dict[str, float]:
        """Return the measurements that are nearer to their prediction than their noise allows, for a minute.

        They come by name with the mean of their normalised innovations squared, each once.
        """
        times = self._quiet_times.items()
        quiet = [name for name, time in times if time >= QUIET_TIME and name not in self._reported_quiet]
        self._reported_quiet.update(quiet)
        return {name: self._means[name] for name in quiet}

    @property
    def worst(self) -> tuple[str, float]:
        """Measurement that is predicted worst, and the mean of its normalised innovations squared."""
        return max(self._means.items(), key=lambda pair: pair[1], default=("", 1.0))

    @property
    def words(self) -> str:
        """Why the readings are not consistent yet, in words; empty where they are."""
        if self._time == 0.0:
            return ""
        name, mean = self.worst
        wait = MEMORY * math.log((mean - 1.0) / (INCONSISTENT - 1.0))
        return (
            f"innovations of {name} are {math.sqrt(mean):.1f} times their expected size, limit "
            f"{math.sqrt(INCONSISTENT):.1f}: about {wait:.0f} s more to settle; the sensors are compared meanwhile"
        )

    @property
    def time(self) -> float:
        """Time since which readings have been inconsistent without a pause [s]."""
        return self._time

    def news(self) -> list[Alarm]:
        """Return, once each time, that the readings disagree and nothing that is identified explains it."""
        is_unexplained = self._time >= UNEXPLAINED_TIME
        is_new, self._is_reported = is_unexplained and not self._is_reported, is_unexplained
        if not is_new:
            return []
        name, mean = self.worst
        return [ALARMS.alarm("SENSORS_DISAGREE", measurement=name, ratio=math.sqrt(mean), time=self._time)]

    def restart(self) -> None:
        """Begin again: something else is assumed from now on."""
        self._means = {}
        self._time = 0.0
        self._quiet_times = {}
