"""One device in a run: its link or its topics, the topics of the suite that it publishes, and what is sent to it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from heave_node.devices.formats.sample import Counters, Decoder
from heave_node.devices.live.adapter import WINCH_STATE, Adapter, WinchReading
from heave_node.devices.live.winch_handshake import WinchHandshake, WinchOrder
from heave_node.devices.maps.device_map import DeviceMap
from heave_node.devices.maps.field_path import FieldPath
from heave_node.interface import topics
from heave_node.interface.messages import SensorMessages, message_type
from heave_node.interface.sensors import SENSORS
from heave_node.ros.transport.qos import qos_of
from heave_node.tick.tick import nanoseconds_of, stamp_of
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import qos_profile_sensor_data

from heave_bringup.adapt.links import LinkReader, Sender
from heave_bringup.adapt.messages import boom_tip, installed_type, winch_state
from heave_bringup.errors import CommandError

_SENSOR_OF = {sensor.topic.name: sensor for sensor in SENSORS.values()}
_DEFAULT_TIMEOUT = 0.5


class LiveDevice:
    """A device that takes part.

    Parameters
    ----------
    device : the map
    node : of ROS, whose topics are used

    Attributes
    ----------
    adapter : what was made of what came
    link : the way to it; None: topics alone
    sent : commands passed on so far

    Raises CommandError where its link, or the type of one of its topics, cannot be had.
    """

    def __init__(self, device: DeviceMap, node: Node) -> None:
        self.device = device
        self.adapter = Adapter(device)
        self.link: LinkReader | None = None
        self.sent = 0
        self._commanded = 0.0
        self._node = node
        self._lock = threading.Lock()
        self._decoder: Decoder | None = None
        self._timeout = device.command.timeout if device.command else _DEFAULT_TIMEOUT
        self._handshake = WinchHandshake(self._timeout)
        self._run_time = 0
        self._rate = float("nan")
        self._publishers: dict[str, Publisher[Any]] = {}
        self._encode = {name: SensorMessages(_SENSOR_OF[name]) for name in device.outputs if name in _SENSOR_OF}
        self._open()
        for name in device.outputs:
            topic = topics.TOPIC_BY_NAME[name]
            self._publishers[name] = node.create_publisher(message_type(topic.type), name, qos_of(topic.role))
        self._follow_clock()
        self._send: Callable[[WinchOrder], None] = self._sender()

    def _open(self) -> None:
        device = self.device
        if device.link is not None and not device.format:
            raise CommandError(f"{device.name}: has a source, but no format of its lines")
        if device.link is not None:
            self._decoder = device.decoder()
            self.link = LinkReader(device.link, self._on_bytes)
        elif not device.topics:
            raise CommandError(
                f"{device.name}: says no source: add source: {{udp: PORT}}, {{tcp: HOST:PORT}} or "
                "{serial: PORT, baud: N}"
            )
        for topic, kind in device.topics.items():
            message = installed_type(kind, f"{device.name}: {topic}")
            self._node.create_subscription(message, topic, self._on_message(topic), qos_profile_sensor_data)

    def _follow_clock(self) -> None:
        """Move the simulated boom tip at each tick, where the map says so, and see when another run begins."""
        self._tip: Publisher[Any] | None = None
        if topics.MRU.name in self.device.outputs and self.device.boom_tip:
            kind = message_type(topics.BOOM_TIP.type)
            self._tip = self._node.create_publisher(kind, topics.BOOM_TIP.name, qos_of(topics.BOOM_TIP.role))
        if self._tip is not None or WINCH_STATE in self.device.outputs:
            self._node.create_subscription(message_type(topics.CLOCK.type), topics.CLOCK.name, self._on_clock, 10)

    def start(self) -> None:
        """Begin to read."""
        if self.link is not None:
            self.link.start()

    def close(self) -> None:
        """Stop the winch, and close the link."""
        with self._lock:
            if self.device.command is not None and self.sent:
                self._pass_on(self._handshake.order(time.monotonic())._replace(payout_rate=0.0, brake=True))
        if self.link is not None:
            self.link.close()
        if self._out is not None:
            self._out.close()

    @property
    def counters(self) -> Counters | None:
        """What came on its line; None where it has none."""
        return None if self._decoder is None else self._decoder.counters

    @property
    def problem(self) -> str:
        """Why nothing can be read or sent now, in words; "" while all is well."""
        return (self.link.problem if self.link else "") or (self._out.problem if self._out else "")

    def _on_bytes(self, data: bytes, is_whole: bool) -> None:
        now = time.monotonic()
        assert self._decoder is not None
        with self._lock:
            samples = self._decoder.feed(data)
            samples += self._decoder.end() if is_whole else []
            self._publish(self.adapter.on_samples(samples, now))

    def _on_message(self, topic: str) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            header = getattr(message, "header", None)
            stamp = None if header is None else nanoseconds_of(header.stamp) or None
            with self._lock:
                self._publish(self.adapter.on_message(topic, message, stamp, time.monotonic()))

        return take

    def _publish(self, made: list[tuple[str, Any]]) -> None:
        for name, reading in made:
            if isinstance(reading, WinchReading):
                self._rate = reading.payout_rate
                order = self._handshake.order(time.monotonic())
                self._publishers[name].publish(winch_state(reading, order, self._handshake))
            else:
                self._publishers[name].publish(self._encode[name].message(reading))

    def _on_clock(self, message: Any) -> None:
        with self._lock:
            before, self._run_time = self._run_time, nanoseconds_of(message.clock)
            if self._run_time < before:  # a controller that counts its commands from 1 again
                self._handshake = WinchHandshake(self._timeout)
            motion = self.adapter.heave.at(time.monotonic())
        if motion is not None and self._tip is not None:
            self._tip.publish(boom_tip(message.clock, self.device.boom_tip_height, motion))

    # commands

    def _sender(self) -> Callable[[WinchOrder], None]:
        """Return what sends an order to the winch, and take the controller's commands."""
        self._out: Sender | None = None
        command = self.device.command
        if command is None and WINCH_STATE not in self.device.outputs:
            return lambda _order: None
        topic = topics.WINCH_COMMAND
        self._node.create_subscription(message_type(topic.type), topic.name, self._on_command, qos_of(topic.role))
        if command is None:
            return lambda _order: None
        if command.topic:
            return self._message_sender()
        if command.link is None and self.link is None:
            raise CommandError(f"{self.device.name}: command: say where it goes: to: {{udp: HOST:PORT}}")
        self._out = Sender(command.link) if command.link is not None else None
        out = self._out or self.link
        assert out is not None
        return lambda order: out.send(command.line_of({**order._asdict(), "brake": int(order.brake)}))

    def _message_sender(self) -> Callable[[WinchOrder], None]:
        command = self.device.command
        assert command is not None
        kind = installed_type(command.type, f"{self.device.name}: command: {command.topic}")
        publisher = self._node.create_publisher(kind, command.topic, 10)
        paths = [(FieldPath(order.path), order) for order in command.orders]

        def message_of(order: WinchOrder) -> Any:
            message = kind()
            for path, entry in paths:
                path.put(message, entry.factor * float(getattr(order, entry.quantity)))
            if hasattr(message, "header"):
                message.header.stamp = stamp_of(time.time_ns())
            return message

        def send(order: WinchOrder) -> None:
            publisher.publish(message_of(order))

        try:
            message_of(WinchOrder(0.0, 0.0, brake=True, sequence=0))
        except (LookupError, TypeError, AssertionError) as error:
            raise CommandError(f"{self.device.name}: command: set: {error}") from None
        return send

    def _on_command(self, message: Any) -> None:
        now = time.monotonic()
        order = WinchOrder(message.payout, message.payout_rate, message.brake, message.sequence)
        with self._lock:
            self._handshake.take(now, order, self._rate)
            self._pass_on(self._handshake.order(now))
            self.sent += 1
            self._commanded = now

    def guard(self) -> None:
        """Tell the winch to stop where commands have ended, again and again; called many times a second."""
        now = time.monotonic()
        if self.device.command is None or not self.sent or now - self._commanded < self.device.command.timeout:
            return
        with self._lock:
            self._pass_on(self._handshake.order(now))

    def _pass_on(self, order: WinchOrder) -> None:
        """Send an order in the drive's own payout; a drum that is to stop is told to stay where it is.

        So nothing is sent to a position loop before the drive has said where it is.
        """
        place = self.adapter.newest.get("payout")
        if place is None:
            return
        payout = (place if order.brake else order.payout) + self.adapter.taker.zeros.get("payout", 0.0)
        self._send(order._replace(payout=payout))
