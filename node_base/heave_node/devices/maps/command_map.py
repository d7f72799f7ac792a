"""How a device is reached, and what is sent to a winch: two parts of a map."""

from __future__ import annotations

import math
import re
import string
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from heave_node.devices.maps.channel import MapError, as_kind, read_channel, refuse_unknown
from heave_node.devices.maps.field_path import FieldPath
from heave_node.devices.maps.quantities import QUANTITIES

LOOPBACK = "127.0.0.1"
_FORM = re.compile(r"[ +-]?0?\d{0,2}(\.\d{1,2})?[a-zA-Z]?")
ORDERS = ("payout", "payout_rate", "brake", "sequence")
"""What can be sent to a winch."""


@dataclass(frozen=True)
class Link:
    """How a device is reached.

    Attributes
    ----------
    kind : serial, udp, tcp
    place : name of the serial port, or host
    number : baud rate, or port
    """

    kind: str
    place: str
    number: int

    def __str__(self) -> str:
        return f"{self.kind} {self.place}{' at ' if self.kind == 'serial' else ':'}{self.number}"


@dataclass(frozen=True)
class Order:
    """One entry of what is sent to a winch by a message.

    Attributes
    ----------
    path : where in the message
    quantity : one of ORDERS
    factor : entry = factor * quantity
    """

    path: str
    quantity: str
    factor: float = 1.0


@dataclass(frozen=True)
class CommandMap:
    """What is sent to a winch for each command of the controller.

    Attributes
    ----------
    link : where lines go; None: back on the line that the device speaks on
    line : text with {payout}, {payout_rate}, {brake}, {sequence}; "": a message instead
    checksum : is added to the line: `xor`, as NMEA 0183 has it, or none
    topic, type, orders : of the message
    timeout : without a command for so long the winch is told to stop and brake [s]
    """

    link: Link | None = None
    line: str = ""
    checksum: str = ""
    topic: str = ""
    type: str = ""
    orders: tuple[Order, ...] = ()
    timeout: float = 0.5

    def line_of(self, values: Mapping[str, float | int]) -> bytes:
        """Return the bytes to be sent for the `values` of ORDERS."""
        text = self.line.format_map(values)
        if self.checksum:
            value = 0
            for letter in text.lstrip("$").encode():
                value ^= letter
            text += f"*{value:02X}"
        return f"{text}\r\n".encode()


def read_link(where: str, entry: Any) -> Link | None:
    """Return what an `entry` such as {serial: /dev/ttyUSB0, baud: 9600} or {udp: 127.0.0.1:7001} names; None: nothing.

    Raises MapError, with the place in the map, `where`, for what cannot be.
    """
    if entry is None:
        return None
    if not isinstance(entry, dict) or len({"serial", "udp", "tcp"} & set(entry)) != 1:
        raise MapError(f"{where} must be one of {{serial: PORT, baud: N}}, {{udp: HOST:PORT}}, {{tcp: HOST:PORT}}")
    if "serial" in entry:
        refuse_unknown(where, entry, ("serial", "baud"))
        baud = as_kind(int, f"{where}: baud", entry.get("baud", 9600))
        if not 50 <= baud <= 4_000_000:
            raise MapError(f"{where}: baud = {baud} must be from 50 to 4000000")
        return Link("serial", as_kind(str, f"{where}: serial", entry["serial"]), baud)
    kind = "udp" if "udp" in entry else "tcp"
    refuse_unknown(where, entry, (kind,))
    host, _, port = str(entry[kind]).rpartition(":")
    if not (port.isascii() and port.isdigit() and 1 <= int(port) <= 65535):
        raise MapError(f"{where}: {kind} = {entry[kind]!r} must be PORT, of this machine alone, or HOST:PORT")
    return Link(kind, host or LOOPBACK, int(port))


def read_command(entry: Any) -> CommandMap | None:
    """Return what an `entry` of a map says is sent to a winch; None: nothing. Raises MapError for what cannot be."""
    if entry is None:
        return None
    if not isinstance(entry, dict):
        raise MapError("command must give a line, or a topic with its type and what is set")
    refuse_unknown("command", entry, ("to", "line", "checksum", "topic", "type", "set", "timeout"))
    words = {
        name: as_kind(str, f"command: {name}", entry.get(name, "")) for name in ("line", "checksum", "topic", "type")
    }
    given_orders = entry.get("set") or {}
    if not isinstance(given_orders, dict):
        raise MapError("command: set must say which field of the message is which of " + ", ".join(ORDERS))
    orders = tuple(_order(path, given) for path, given in given_orders.items())
    timeout = as_kind(float, "command: timeout", entry.get("timeout", 0.5))
    command = CommandMap(read_link("command: to", entry.get("to")), orders=orders, timeout=timeout, **words)
    if bool(command.line) == bool(command.topic):
        raise MapError("command must have either a line, or a topic")
    if command.topic and not (command.type and command.orders):
        raise MapError("command: topic needs its type, and set: which field is which of " + ", ".join(ORDERS))
    if not 0.05 <= timeout <= 5.0:
        raise MapError(f"command: timeout = {timeout:g} must be from 0.05 to 5 s")
    if command.checksum not in ("", "xor"):
        raise MapError(f"command: checksum = {command.checksum!r} must be xor, or be left out")
    _check_line(command)
    return command


def _check_line(command: CommandMap) -> None:
    """Raise MapError for a line that cannot be filled in."""
    try:
        parts = list(string.Formatter().parse(command.line))
        for _, name, form, _ in parts:
            if name is not None and name not in ORDERS:
                raise MapError(f"command: line: {{{name}}} is unknown; known: {', '.join(ORDERS)}")
            if form and _FORM.fullmatch(form) is None:
                raise MapError(f"command: line: the form {form[:20]!r} must be one such as .4f, +8.3f or 05d")
        command.line_of({"payout": 1.0, "payout_rate": 0.5, "brake": 0, "sequence": 1})
    except (TypeError, LookupError) as error:
        raise MapError(f"command: line: {error}") from None
    except MapError:
        raise
    except ValueError as error:
        raise MapError(f"command: line: {error}") from None


def _order(path: str, entry: Any) -> Order:
    where = f"command: set: {path}"
    given = {"quantity": entry} if isinstance(entry, str) else entry
    if not isinstance(given, dict):
        raise MapError(f"{where} must name one of {', '.join(ORDERS)}")
    refuse_unknown(where, given, ("quantity", "unit", "positive", "scale"))
    quantity = given.get("quantity", "")
    if quantity not in ORDERS:
        raise MapError(f"{where}: quantity = {quantity!r} must be one of {', '.join(ORDERS)}")
    try:
        FieldPath(path)
    except ValueError as error:
        raise MapError(f"{where}: {error}") from None
    scale = as_kind(float, f"{where}: scale", given.get("scale", 1.0))
    if quantity not in QUANTITIES:
        return Order(path, quantity, scale)
    channel = read_channel(quantity, {name: given[name] for name in ("unit", "positive") if name in given})
    if not math.isfinite(scale) or scale == 0.0:
        raise MapError(f"{where}: scale = {scale:g} must not be 0")
    return Order(path, quantity, scale / channel.factor(quantity))
