"""Orders for a winch behind a map: the controller's commands, kept to the contract of a winch, and when to stop."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from heave_bringup.errors import CommandError
from heave_node.interface import topics
from heave_node.interface.codes import WinchFault
from heave_node.interface.messages import message_type
from heave_node.parameters import ParameterError
from heave_node.ros.transport.qos import qos_of
from heave_node.tick.tick import stamp_of
from heave_node.winch.motion_supervision import DrumReading, MotionSupervision
from rclpy.node import Node

from heave_devices.adapt.links import LinkReader
from heave_devices.adapt.messages import installed_type
from heave_devices.adapt.plc.polled import PolledLink
from heave_devices.formats.registers import register_of
from heave_devices.live.adapter import WINCH_STATE, Adapter
from heave_devices.live.winch_handshake import WinchHandshake, WinchOrder
from heave_devices.maps.command_map import ORDERS, CommandMap
from heave_devices.maps.device_map import DeviceMap
from heave_devices.maps.field_path import FieldPath

_DEFAULT_TIMEOUT = 0.5
Values = dict[str, float]


class Orders:
    """The orders to the device of an `adapter`, by a `link`, or, where that is None, by topics of a `node` alone.

    Attributes
    ----------
    handshake : the contract that is kept
    sent : commands passed on so far
    rate : of the drum, as it was read last [m/s]

    Raises CommandError where the way of the orders cannot be had. Not thread-safe: the caller locks.
    """

    def __init__(self, adapter: Adapter, node: Node, link: LinkReader | PolledLink | None) -> None:
        self._adapter = adapter
        self._command = adapter.device.command
        self._timeout = self._command.timeout if self._command else _DEFAULT_TIMEOUT
        self._link = link
        self._out: LinkReader | None = None
        self._unsent_since: float | None = None
        self._refusal = ""
        self._passed_on = 0
        self._commanded = 0.0
        self._supervision = MotionSupervision(self._command.supervision if self._command else 0.0)
        self._jumps = 0
        self.handshake = WinchHandshake(self._timeout)
        self.sent = 0
        self.rate = float("nan")
        self._send = self._sender(self._command, node) if self._command is not None else None

    @property
    def problem(self) -> str:
        """Why nothing can be sent now, in words; "" while all is well."""
        words = self.handshake.latch.words
        return self._refusal or (self._out.problem if self._out else "") or (f"stopped: {words}" if words else "")

    def take(self, order: WinchOrder) -> None:
        """Take an `order` of the controller, and pass it on."""
        now = time.monotonic()
        self.handshake.take(now, order, self.rate)
        self.sent += 1
        self._commanded = now
        self._pass_on(self.handshake.order(now))

    def guard(self) -> None:
        """Hold the winch where it cannot be seen or reached, or where commands have ended; called many times a second.

        A watchdog of the map's is fed here too.
        """
        if self._command is None:
            return
        now = time.monotonic()
        self._supervise(now)
        is_lost = self._adapter.watch.is_stale(now) or self._is_out_of_reach(now)
        is_in_use = self.handshake.is_released or bool(self.handshake.fault)
        words = self._refusal or (self._link.problem if self._link is not None else "")
        self.handshake.latch.hold(WinchFault.COMMAND_TIMEOUT, words, is_present=is_lost and is_in_use)
        if self._command.counts or (self.sent and now - self._commanded >= self._timeout):
            self._pass_on(self.handshake.order(now))

    def close(self) -> None:
        """Stop the winch."""
        if self._command is not None and (self.sent or self._command.counts):
            self._pass_on(self.handshake.order(time.monotonic())._replace(payout_rate=0.0, brake=True))
        if self._out is not None:
            self._out.close()

    def _supervise(self, now: float) -> None:
        """Hold the winch where drum or brake do not do what they are ordered."""
        newest, watch, count = self._adapter.newest, self._adapter.watch, self._adapter.drum_count
        if count.jumps > self._jumps:
            self._jumps = count.jumps
            self.handshake.latch.trip(WinchFault.DRIVE, count.words)
        words = self._adapter.speed_travel.words
        self.handshake.latch.hold(WinchFault.DRIVE, words, is_present=bool(words))
        if "payout" not in newest or watch.is_stale(now) or not self.sent:
            return
        order, brake = self.handshake.order(now), newest.get("brake", math.nan)
        drum = DrumReading(order.payout_rate, order.brake, newest["payout"], self.rate, brake)
        if found := self._supervision.look(now, drum):
            self.handshake.latch.trip(WinchFault.DRIVE, found)

    def _is_out_of_reach(self, now: float) -> bool:
        since = self._unsent_since
        if since is None and isinstance(self._link, PolledLink):
            since = self._link.unsent_since
        return since is not None and now - since > self._timeout

    def _pass_on(self, order: WinchOrder) -> None:
        """Send an order in the drive's own payout; a drum that is to stop is ordered to stay where it is.

        So nothing is sent to a position loop before the drive has said where it is.
        """
        place = self._adapter.newest.get("payout")
        if place is None or self._send is None:
            return
        zero = self._adapter.taker.zeros.get("payout", 0.0)
        payout = place if order.brake else order.payout
        mean = order.mean_payout if math.isfinite(order.mean_payout) else payout
        self._passed_on += 1
        values = {
            **{"payout": payout + zero, "payout_rate": order.payout_rate, "mean_payout": mean + zero},
            **{"brake": int(order.brake)},
            **{"enable": int(not order.brake), "reset": int(self.handshake.wants_reset)},
            **{"sequence": order.sequence, "watchdog": self._passed_on},
        }
        try:
            self._send(values)
            self._unsent_since, self._refusal = None, ""
        except ValueError as error:
            self._refusal = f"not sent: {error}"
            self._unsent_since = time.monotonic() if self._unsent_since is None else self._unsent_since

    def _sender(self, command: CommandMap, node: Node) -> Callable[[Values], None]:
        """Return what sends the values of an order to the winch."""
        if command.topic:
            return _message_sender(command, node, self._adapter.device.name)
        link = self._link
        if isinstance(link, PolledLink):
            is_modbus = link.link.kind == "modbus"

            def kind_of(name: str) -> str:
                return register_of(name).kind if is_modbus else "uint16"

            return lambda values: link.put(command.numbers_of(values, kind_of, has_bits=is_modbus))
        if command.link is None and link is None:
            raise ParameterError(f"{self._adapter.device.name}: command: say where it goes: to: {{udp: HOST:PORT}}")
        if command.link is not None:
            try:
                self._out = LinkReader(command.link, None)
            except CommandError as error:
                raise CommandError(f"command: {error}") from None
            self._out.start()
        out = self._out or link
        assert out is not None
        if command.layout is not None:
            return lambda values: out.send(command.datagram_of(values, self._passed_on, time.monotonic()))
        return lambda values: out.send(command.line_of(values))


def _message_sender(command: CommandMap, node: Node, name: str) -> Callable[[Values], None]:
    """Return what publishes the values of an order as a message.

    Raises ParameterError where the message has no such field.
    """
    kind = installed_type(command.type, f"{name}: command: {command.topic}")
    publisher = node.create_publisher(kind, command.topic, 10)
    paths = [(FieldPath(order.path), order) for order in command.orders]

    def message_of(values: Values) -> Any:
        message = kind()
        for path, entry in paths:
            path.put(message, entry.factor * float(values[entry.quantity]))
        if hasattr(message, "header"):
            message.header.stamp = stamp_of(time.time_ns())
        return message

    try:
        message_of(dict.fromkeys(ORDERS, 0.0))
    except (LookupError, TypeError, AssertionError) as error:
        raise ParameterError(f"{name}: command: set: {error}") from None
    return lambda values: publisher.publish(message_of(values))


def follow_commands(node: Node, device: DeviceMap, take: Callable[[Any], None]) -> None:
    """Let a `node` of ROS `take` the controller's commands where a `device` is a winch."""
    if device.command is None and WINCH_STATE not in device.outputs:
        return
    topic = topics.WINCH_COMMAND
    node.create_subscription(message_type(topic.type), topic.name, take, qos_of(topic.role))
