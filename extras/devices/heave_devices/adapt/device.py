"""One device in a run: its link or its topics, the topics of the suite that it publishes, and what is sent to it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from heave_bringup.errors import CommandError
from heave_node.crane.pose import pose_message
from heave_node.extras import how_to_install
from heave_node.interface import topics
from heave_node.interface.messages import SensorMessages, message_type
from heave_node.interface.sensors import SENSORS
from heave_node.parameters import ParameterError
from heave_node.ros.transport.qos import qos_of
from heave_node.tick.external_clock import ExternalClock
from heave_node.tick.simulated_clock import SimulatedClock
from heave_node.tick.tick import nanoseconds_of
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import qos_profile_sensor_data

from heave_devices.adapt.links import LinkReader
from heave_devices.adapt.messages import boom_tip, installed_type, winch_state
from heave_devices.adapt.orders import Orders, follow_commands
from heave_devices.adapt.plc.polled import Exchange, PolledLink
from heave_devices.formats.sample import Counters, Decoder, Sample
from heave_devices.live.adapter import Adapter, WinchReading
from heave_devices.live.winch_handshake import WinchOrder
from heave_devices.maps.device_map import DeviceMap

_SENSOR_OF = {sensor.topic.name: sensor for sensor in SENSORS.values()}


class LiveDevice:
    """A device that takes part, by its map, `device`, through the topics of a `node` of ROS.

    Attributes
    ----------
    adapter : what was made of what came
    link : the way to it; None: topics alone
    orders : for the device

    Raises CommandError where its link, or the type of one of its topics, cannot be had.
    """

    def __init__(self, device: DeviceMap, node: Node) -> None:
        self.device = device
        self.adapter = Adapter(device)
        self.link: LinkReader | PolledLink | None = None
        self._node = node
        self._lock = threading.Lock()
        self._decoder: Decoder | None = None
        self._publishers: dict[str, Publisher[Any]] = {}
        self._run_clock = SimulatedClock()
        self._stamps: dict[str, ExternalClock] = {}
        self._encode = {name: SensorMessages(_SENSOR_OF[name]) for name in device.outputs if name in _SENSOR_OF}
        self._open()
        for name in device.outputs:
            topic = topics.TOPIC_BY_NAME[name]
            self._publishers[name] = node.create_publisher(message_type(topic.type), name, qos_of(topic.role))
        self._follow_clock()
        self.orders = Orders(self.adapter, node, self.link)
        follow_commands(node, device, self._on_command)

    def _open(self) -> None:
        device = self.device
        if device.link is not None and device.is_polled:
            self.link = PolledLink(device.link, exchange_of(device), self._on_sample)
            return
        if device.link is not None and not device.format:
            raise ParameterError(f"{device.name}: has a source, but no format of its lines")
        if device.link is not None:
            self._decoder = device.decoder()
            self.link = LinkReader(device.link, self._on_bytes)
        elif not device.topics:
            raise ParameterError(
                f"{device.name}: says no source: add source: {{udp: PORT}}, {{tcp: HOST:PORT}} or "
                "{serial: PORT, baud: N}"
            )
        for topic, kind in device.topics.items():
            message = installed_type(kind, f"{device.name}: {topic}")
            self._node.create_subscription(message, topic, self._on_message(topic), qos_profile_sensor_data)

    def _follow_clock(self) -> None:
        """Move the simulated boom tip at each tick, where the map says so."""
        self._tip: Publisher[Any] | None = None
        if topics.MRU.name in self.device.outputs and self.device.boom_tip:
            kind = message_type(topics.BOOM_TIP.type)
            self._tip = self._node.create_publisher(kind, topics.BOOM_TIP.name, qos_of(topics.BOOM_TIP.role))
        if self._tip is not None or self.device.latency:
            self._node.create_subscription(message_type(topics.CLOCK.type), topics.CLOCK.name, self._on_clock, 10)

    def start(self) -> None:
        """Begin to read."""
        if self.link is not None:
            self.link.start()

    def close(self) -> None:
        """Stop the winch, and close the link."""
        with self._lock:
            self.orders.close()
        if self.link is not None:
            self.link.close()

    @property
    def counters(self) -> Counters | None:
        """What came on its line; None where it has none."""
        return None if self._decoder is None else self._decoder.counters

    @property
    def problem(self) -> str:
        """Why nothing can be read or sent now, in words; "" while all is well."""
        return (self.link.problem if self.link else "") or self.orders.problem

    def _on_bytes(self, data: bytes, is_whole: bool) -> None:
        now = time.monotonic()
        assert self._decoder is not None
        with self._lock:
            samples = self._decoder.feed(data)
            samples += self._decoder.end() if is_whole else []
            self._publish(self.adapter.on_samples(samples, now))

    def _on_sample(self, sample: Sample) -> None:
        with self._lock:
            self._publish(self.adapter.on_samples([sample], time.monotonic()))

    def _on_command(self, message: Any) -> None:
        self.command(WinchOrder(*[getattr(message, name) for name in WinchOrder._fields]))

    def command(self, order: WinchOrder) -> None:
        """Pass on an `order` of the controller."""
        with self._lock:
            self.orders.take(order)

    def guard(self) -> None:
        """Look after the winch, and leave the boom tip to the run's vessel where there is one; called often."""
        with self._lock:
            self.orders.guard()
        if self._tip is not None and self._has_vessel():
            self._node.get_logger().info(f"{self.device.name}: another node moves the boom tip, this device does not")
            self._node.destroy_publisher(self._tip)
            self._tip = None

    def _has_vessel(self) -> bool:
        """Return whether the run's vessel moves the boom tip, and no adapter that was killed and is still known."""
        tip = topics.BOOM_TIP
        if self._node.count_publishers(tip.name) < 2:
            return False
        return any(one.node_name == tip.publisher for one in self._node.get_publishers_info_by_topic(tip.name))

    def _on_message(self, topic: str) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            header = getattr(message, "header", None)
            stamp = None if header is None else nanoseconds_of(header.stamp) or None
            with self._lock:
                self._publish(self.adapter.on_message(topic, message, stamp, time.monotonic()))

        return take

    def _publish(self, made: list[tuple[str, Any]]) -> None:
        for name, made_reading in made:
            reading = self._without_latency(name, made_reading)
            if reading is None:
                continue
            if isinstance(reading, WinchReading):
                self.orders.rate = reading.payout_rate
                order = self.orders.handshake.order(time.monotonic())
                self._publishers[name].publish(winch_state(reading, order, self.orders.handshake))
            elif name == topics.CRANE_POSE.name:
                self._publishers[name].publish(pose_message(reading))
            else:
                self._publishers[name].publish(self._encode[name].message(reading))

    def _without_latency(self, name: str, reading: Any) -> Any:
        """Return a `reading` of the topic `name` with the latency of the map taken off its stamp.

        Its stamp is then simulated time, for an offset of clocks would hide it. None: no run has a time yet.
        """
        if not self.device.latency:
            return reading
        wall = time.monotonic_ns()
        arrival = self._run_clock.now(wall)
        if not arrival:
            return None
        clock = self._stamps.setdefault(name, ExternalClock(latency=self.device.latency))
        return reading._replace(stamp=max(1, clock.simulated_time(reading.stamp, arrival, wall)))

    def _on_clock(self, message: Any) -> None:
        with self._lock:
            self._run_clock.tick_began(nanoseconds_of(message.clock), time.monotonic_ns())
            motion = self.adapter.heave.at(time.monotonic())
        if motion is not None and self._tip is not None:
            self._tip.publish(boom_tip(message.clock, self.device.boom_tip_height, motion))


def exchange_of(device: DeviceMap) -> Exchange:
    """Return what asks the PLC of a `device` for the fields of its map, and sends it the orders.

    Raises CommandError where the library of its protocol is not installed.
    """
    link, command = device.link, device.command
    assert link is not None
    names = [name for channel in device.channels.values() for name in (channel.field, channel.valid) if name]
    fields = [device.bit_of(name)[0] for name in names]
    orders = [device.bit_of(order.path)[0] for order in command.orders] if command is not None else []
    try:
        if link.kind == "modbus":
            from heave_devices.adapt.plc.modbus import ModbusExchange  # noqa: PLC0415 - its library may be missing

            return ModbusExchange(link, fields, orders)
        from heave_devices.adapt.plc.opcua import OpcUaExchange  # noqa: PLC0415 - an extra

        return OpcUaExchange(link, fields, orders)
    except ImportError as error:
        how = how_to_install("opcua") if link.kind == "opcua" else "pip install 'pymodbus>=3.10'"
        raise CommandError(f"{device.name}: {link.kind} needs the package {error.name}; {how}") from None
