"""Devices beside a run, from the start to Ctrl-C: one node, a look each second."""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

from diagnostic_msgs.msg import DiagnosticArray
from heave_bringup.errors import CommandError
from heave_node.interface import topics
from heave_node.interface.codes import without_figures
from heave_node.ros.diagnostics import Health, Level, diagnostic_array
from heave_node.ros.process import leave_ros, node_beside
from heave_node.ros.spin import Spinner
from heave_node.ros.transport.environment import prepare_environment
from rclpy.parameter import Parameter

from heave_devices.adapt.device import LiveDevice
from heave_devices.adapt.report import figures_of, health_of
from heave_devices.maps.device_map import DeviceMap

GUARD_PERIOD = 0.05
"""Wall time between two looks at the commands [s]."""
LOOK_PERIOD = 1.0
"""Wall time between two diagnostics [s]."""
T = TypeVar("T")


class Session:
    """Runs the `devices` of some `maps`, in their order, beside a run in a `namespace`; "": none.

    Raises CommandError where one of them cannot be opened; none is left open then.
    """

    def __init__(self, maps: Sequence[DeviceMap], namespace: str = "") -> None:
        prepare_environment()
        name = re.sub(r"\W", "_", "_".join(device.name for device in maps))
        simulated_time = Parameter("use_sim_time", value=True)
        self._node = node_beside(f"adapter_{name}", namespace, parameter_overrides=[simulated_time])
        self.devices: list[LiveDevice] = []
        try:
            for device in maps:
                self.devices.append(LiveDevice(device, self._node))
        except BaseException:
            self._leave()
            raise
        self._spinner = Spinner(self._node)
        self._health = self._node.create_publisher(DiagnosticArray, topics.DIAGNOSTICS.name, 10)
        self._before: list[dict[str, float]] = [{} for _ in self.devices]
        self._reported: dict[str, str] = {}
        self._warned: set[str] = set()

    def run(self, duration: float) -> None:
        """Serve for `duration` seconds of wall time, infinity for ever, or until Ctrl-C."""
        for device in self.devices:
            device.start()
        end, look = time.monotonic() + duration, time.monotonic() + LOOK_PERIOD
        try:
            while (now := time.monotonic()) < end:
                self._spinner.spin_for(max(0.0, min(GUARD_PERIOD, end - now)))
                for device in self.devices:
                    device.guard()
                if now >= look:
                    look += LOOK_PERIOD
                    self._look()
        except KeyboardInterrupt:
            pass  # the way to end it
        finally:
            self._spinner.close()
            self._leave()

    def alone(self, move: Callable[[LiveDevice, Callable[[float], None]], T]) -> T:
        """Return what a `move` of the one winch, which takes it and what serves its topics for a time [s], returns.

        Raises CommandError where a controller commands it already.
        """
        with self.one() as (device, spin):
            spin(1.0)
            if self._node.count_publishers(topics.WINCH_COMMAND.name):
                raise CommandError("--wiggle: a controller is on winch/command: end its run first")
            return move(device, spin)

    @contextmanager
    def one(self) -> Iterator[tuple[LiveDevice, Callable[[float], None]]]:
        """Start the one device, and leave at the end; give it, and what serves its topics for a time [s]."""
        (device,) = self.devices
        device.start()
        try:
            yield device, self._spinner.spin_for
        finally:
            self._spinner.close()
            self._leave()

    def _look(self) -> None:
        parts = []
        for number, device in enumerate(self.devices):
            parts.append(health_of(device, self._before[number]))
            self._before[number] = figures_of(device)
        stamp = self._node.get_clock().now().to_msg()
        self._health.publish(diagnostic_array(self._node.get_name(), stamp, parts))
        for part in parts:
            self._report(part)

    def _report(self, part: Health) -> None:
        """Say on the terminal what stops a device, and that it goes on; and once what else is wrong: it is counted."""
        reported = self._reported.get(part.part, "")
        now = without_figures(part.message) if part.level in (Level.ERROR, Level.STALE) else ""
        self._reported[part.part] = now
        if now != reported:
            sys.stderr.write(f"{part.part}: {part.message if now else 'readings come again'}\n")
        elif part.level is Level.WARN and part.part not in self._warned:
            self._warned.add(part.part)
            sys.stderr.write(f"{part.part}: {part.message}; more of it is counted, and shown at the end\n")

    def _leave(self) -> None:
        for device in self.devices:
            device.close()
        leave_ros(self._node)
