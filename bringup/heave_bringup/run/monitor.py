"""What the `heave` command learns of a run: the master's status and the controller's live figures."""

from __future__ import annotations

import re
import time

import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from heave_msgs.msg import CompensationKpi, TickStatus
from heave_node.interface import topics
from heave_node.ros.process import in_namespace
from heave_node.ros.spin import Spinner
from heave_node.ros.transport.qos import qos_of
from heave_node.ros.transport.strangers import PART as STRANGERS
from heave_node.tick.tick import seconds_of
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

DISCOVERY = 0.5
"""Wall time in which a run that is under way in this domain nearly always shows itself [s].

One that shows itself later is noticed during the run.
"""

_FIGURES = re.compile(r"[0-9.]+")
"""What changes in a message while the fault stays the same."""


class Monitor:
    """Listens to a run from outside; takes no part in it.

    Parameters
    ----------
    namespace : of the run; "" for none

    Attributes
    ----------
    status, kpi : the newest of each
    alarms : errors that the nodes reported on /diagnostics, in order, each once
    strangers : what they said of processes that publish where only others may, in order
    """

    def __init__(self, namespace: str = "") -> None:
        # The command handles Ctrl-C itself: it must end the nodes in order.
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node(
            "heave_command", namespace=namespace, cli_args=in_namespace(namespace), start_parameter_services=False
        )
        self.status: TickStatus | None = None
        self.kpi: CompensationKpi | None = None
        self.alarms: list[str] = []
        self.strangers: dict[str, None] = {}
        self._errors: dict[str, str] = {}
        self._taken = 0
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
        if message.header.stamp == Time():
            return
        for part in message.status:
            if part.level != DiagnosticStatus.ERROR:
                self._errors.pop(part.name, None)
            elif self._errors.get(part.name) != _FIGURES.sub("", part.message):
                self._errors[part.name] = _FIGURES.sub("", part.message)
                if part.name.endswith(f": {STRANGERS}"):
                    self.strangers |= dict.fromkeys(part.message.split("; "))
                self.alarms.append(f"t = {seconds_of(message.header.stamp):.2f} s: {part.name}: {part.message}")

    def take_alarms(self) -> list[str]:
        """Return the alarms that came since the last call."""
        new, self._taken = self.alarms[self._taken :], len(self.alarms)
        return new

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
