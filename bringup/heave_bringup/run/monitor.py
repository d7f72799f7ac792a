"""What the `heave` command learns of a run: the master's status and the controller's live figures."""

from __future__ import annotations

import time

import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from heave_bags.analyse.events import ALARMS_PART, MODE_PART, SENSOR_PARTS
from heave_msgs.msg import CompensationKpi, TickStatus
from heave_node.interface import topics
from heave_node.interface.alarm import kind_of
from heave_node.interface.codes import time_key, time_of
from heave_node.ros.process import node_beside
from heave_node.ros.spin import Spinner
from heave_node.ros.transport.qos import qos_of
from heave_node.ros.transport.strangers import PART as STRANGERS
from heave_node.tick.tick import seconds_of

from heave_bringup.run.live_figures import LiveFigures

DISCOVERY = 0.5
"""Wall time in which a run that is under way in this domain nearly always shows itself [s].

One that shows itself later is noticed during the run.
"""


class Monitor:
    """Listens to a run from outside; takes no part in it.

    Parameters
    ----------
    namespace : of the run; "" for none
    is_open_loop : see LiveFigures

    Attributes
    ----------
    status, kpi : the newest of each
    live : the mode of the controller, and what it lost
    strangers : what they said of processes that publish where only others may, in order
    """

    def __init__(self, namespace: str = "", *, is_open_loop: bool = False) -> None:
        # the command must end the nodes in order
        self._node = node_beside("heave_command", namespace)
        self.status: TickStatus | None = None
        self.kpi: CompensationKpi | None = None
        self.live = LiveFigures(is_open_loop=is_open_loop)
        self._news: list[str] = []
        self.strangers: dict[str, None] = {}
        self._errors: dict[str, str] = {}
        self._taken: dict[str, DiagnosticArray] = {}
        self._over_since = 0.0
        self._node.create_subscription(
            TickStatus, topics.TICK_STATUS.name, self._on_status, qos_of(topics.TICK_STATUS.role)
        )
        self._node.create_subscription(
            CompensationKpi, topics.CONTROLLER_KPI.name, self._on_kpi, qos_of(topics.CONTROLLER_KPI.role)
        )
        self._node.create_subscription(
            DiagnosticArray, topics.DIAGNOSTICS.name, self._on_diagnostics, qos_of(topics.DIAGNOSTICS.role)
        )
        self._spinner = Spinner(self._node)

    def _on_status(self, message: TickStatus) -> None:
        was_over = self.is_over
        self.status = message
        if self.is_over and not was_over:
            self._over_since = time.monotonic()

    def _on_kpi(self, message: CompensationKpi) -> None:
        self.kpi = message

    def spin_until_over(self, seconds: float) -> None:
        """Listen until the master says that the run is over, or for `seconds` of wall time."""
        deadline = time.monotonic() + seconds
        while not self.is_over and time.monotonic() < deadline:
            self.spin(0.02)

    @property
    def is_over(self) -> bool:
        """Whether the master has said that the run is over, well or not."""
        return self.status is not None and self.status.state in (TickStatus.ENDED, TickStatus.FAILED)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        """Note each new error once; it is noted again if it comes back after it had cleared.

        Stamp 0 marks what happens outside of simulated time: whom the clock master waits for shows as progress.
        """
        if message.header.stamp == Time() or not message.status:
            return
        sender = message.status[0].name.partition(": ")[0]
        if self._taken.get(sender) == message:
            return  # a tick that was sent again is answered again
        self._taken[sender] = message
        lines: list[str] = []
        for part in sorted(message.status, key=lambda part: part.name != ALARMS_PART):  # the cause before its effect
            if part.name == MODE_PART:
                time_of_tick = seconds_of(message.header.stamp)
                reported = {value.key: value.value for value in part.values}
                lines += self.live.note_modes(time_of_tick, part.message, reported)
                if self.live.is_reported:
                    continue
            if part.name == ALARMS_PART:
                lines += [f"{reported.key}: {reported.value}" for reported in part.values]
            if part.level != DiagnosticStatus.ERROR:
                self._errors.pop(part.name, None)
            elif self._errors.get(part.name) != (kind := kind_of(part.message)):
                self._errors[part.name] = kind
                if part.name.endswith(f": {STRANGERS}"):
                    self.strangers |= dict.fromkeys(part.message.split("; "))
                if not part.name.startswith(SENSOR_PARTS):  # the controller's own alarms tell it, when it was
                    lines.append(f"{time_key(_raised(message, part))}: {part.name}: {part.message}")
        self._news += sorted(lines, key=lambda line: time_of(line.partition(": ")[0]) or 0.0)

    def take_news(self) -> list[str]:
        """Return the alarms and losses of compensation that came since the last call."""
        news, self._news = self._news, []
        return news

    @property
    def is_over_for(self) -> float:
        """Wall time since the master said that the run is over [s]; 0 before."""
        return time.monotonic() - self._over_since if self.is_over else 0.0

    def spin(self, seconds: float) -> None:
        """Listen for `seconds` of wall time."""
        self._spinner.spin_for(seconds)

    def another_run(self) -> bool:
        """Return whether another run's clock master is in this ROS domain."""
        deadline = time.monotonic() + DISCOVERY
        while time.monotonic() < deadline:
            self.spin(0.1)
            if self.masters():
                return True
        return False

    def masters(self) -> int:
        """Return the number of clock masters in this ROS domain."""
        return self._node.count_publishers(topics.TICK_START.name)

    def close(self) -> None:
        """Leave ROS."""
        self._spinner.close()
        self._node.destroy_node()
        rclpy.try_shutdown()


def _raised(message: DiagnosticArray, part: DiagnosticStatus) -> float:
    """Return when what a `part` of a `message` reports was raised [s], by its own values where they have it."""
    times = [time_of(one.key) for one in part.values if one.value == part.message]
    return next((time for time in times if time is not None), seconds_of(message.header.stamp))
