"""What is sent to a winch: a part of a map."""

from __future__ import annotations

import math
import re
import string
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from heave_devices.formats.datagram import CLOCKS, Layout, layout_of
from heave_devices.formats.number_kinds import split_bit, with_bits, wrapped
from heave_devices.formats.pattern import CHECKSUMS
from heave_devices.maps.channel import (
    MapError,
    as_kind,
    outside,
    placed,
    plain_entries,
    read_channel,
    refuse,
    refuse_unknown,
)
from heave_devices.maps.field_path import FieldPath
from heave_devices.maps.link import Link, read_link

_FORM = re.compile(r"[ +-]?0?\d{0,2}(\.\d{1,2})?[a-zA-Z]?")
ORDERS = ("payout", "payout_rate", "mean_payout", "brake", "enable", "reset", "sequence", "watchdog")
"""Orders for a winch: set-points, the payout that it works about, brake (1: stop and brake), its opposite `enable`,
`reset` (1: a latched fault is acknowledged), the number of the controller's command, and `watchdog`, which counts what
is sent.
"""
MOTIONS = {"payout": "payout", "payout_rate": "payout_rate", "mean_payout": "payout"}
"""Orders that have a unit and a direction: the quantity that each is one of."""
COUNTERS = ("sequence", "watchdog")
"""Orders that begin again after the largest number that their field holds."""
_EXAMPLE = dict.fromkeys(ORDERS, 0) | {"payout": 1.0, "payout_rate": 0.5, "mean_payout": 1.0, "sequence": 1}


@dataclass(frozen=True)
class Order:
    """One entry of what is sent to a winch by a message, a datagram or registers."""

    path: str  # where in the message; field of the datagram, register or node
    quantity: str  # one of ORDERS
    factor: float = 1.0  # entry = factor * quantity [-]


@dataclass(frozen=True)
class CommandMap:
    """What is sent to a winch for each command of the controller."""

    link: Link | None = None  # where lines and datagrams go; None: back on the line that the device speaks on
    line: str = ""  # text with {NAME} for each of ORDERS; "": something else
    checksum: str = ""  # is added to the line: `xor`, as NMEA 0183 has it, or none
    layout: Layout | None = None  # of a datagram; None: something else
    topic: str = ""  # of a message; "": something else
    type: str = ""  # of a message; "": something else
    # what is set in the message, in the datagram, or in the registers or nodes of the map's source
    orders: tuple[Order, ...] = ()
    timeout: float = 0.5  # without a command for so long the winch is ordered to stop and brake [s]
    # where drum or brake do not follow their orders for so long it is stopped and braked [s]; 0: not done
    supervision: float = 1.0

    @property
    def counts(self) -> bool:
        """Whether it sends a counter of its own: it is then sent again and again, also between commands."""
        if self.layout is not None and "sequence" in self.layout.fields:
            return True
        return any(order.quantity == "watchdog" for order in self.orders) or "{watchdog" in self.line

    def line_of(self, values: Mapping[str, float | int]) -> bytes:
        """Return the bytes to be sent for the `values` of ORDERS."""
        text = self.line.format_map(values)
        if self.checksum:
            compute, _ = CHECKSUMS[self.checksum]
            text += f"*{compute(text.lstrip('$').encode()):02X}"
        return f"{text}\r\n".encode()

    def datagram_of(self, values: Mapping[str, float | int], count: int, time: float) -> bytes:
        """Return the datagram to be sent.

        Parameters
        ----------
        values : of ORDERS
        count : of datagrams so far
        time : of the sender's clock [s]

        Raises ValueError where a value does not fit its field.
        """
        assert self.layout is not None
        fields = self.layout.fields
        numbers = self.numbers_of(values, lambda name: fields[name])
        if "sequence" in fields:
            numbers.setdefault("sequence", wrapped(fields["sequence"], count))
        for name, unit in CLOCKS.items():
            if name in fields:
                numbers[name] = wrapped(fields[name], int(time / unit))
        return self.layout.pack(numbers)

    def numbers_of(
        self, values: Mapping[str, float | int], kind_of: Callable[[str], str], *, has_bits: bool = True
    ) -> dict[str, float]:
        """Return what is set for the `values` of ORDERS, by name of the field, register or node.

        `kind_of` returns the kind of number that one holds; with `has_bits` a number behind a point names a bit.
        """
        numbers: dict[str, float] = {}
        for order in self.orders:
            name, bit = split_bit(order.path) if has_bits else (order.path, None)
            value = values[order.quantity]
            value = wrapped(kind_of(name), int(value)) if order.quantity in COUNTERS else order.factor * value
            with_bits(numbers, name, bit, value)
        return numbers


def read_command(entry: Any) -> CommandMap | None:
    """Return what an `entry` of a map says is sent to a winch; None: nothing. Raises MapError for what cannot be."""
    if entry is None:
        return None
    if not isinstance(entry, dict):
        raise MapError("command must give a line, a layout, or a topic with its type, and what is set")
    known = ("to", "line", "checksum", "layout", "byte_order", "topic", "type", "set", "timeout", "supervision")
    refuse_unknown("command", entry, known)
    given_orders = entry.get("set") or {}
    if not isinstance(given_orders, dict):
        raise MapError("command: set must say which field is which of " + ", ".join(ORDERS))
    orders = tuple(_order(str(path), given) for path, given in given_orders.items())
    layout = read_layout("command: ", entry)
    link = read_link("command: to", entry.get("to"))
    command = CommandMap(link, layout=layout, orders=orders, **plain_entries(CommandMap, "command: ", entry))
    _check(command)
    return command


def read_layout(where: str, entry: Mapping[str, Any]) -> Layout | None:
    """Return the layout that `layout` and `byte_order` of an `entry` state; None: none.

    Raises MapError, with the place in the map, `where`, for what cannot be.
    """
    fields = entry.get("layout")
    if fields is None:
        if "byte_order" in entry:
            raise MapError(f"{where}byte_order belongs to a layout")
        return None
    if not isinstance(fields, dict) or not all(isinstance(kind, str) for kind in fields.values()):
        raise MapError(f"{where}layout must list its fields with their kinds: {{sequence: uint16, speed: int32}}")
    with placed(f"{where}layout"):
        return layout_of({str(name): kind for name, kind in fields.items()}, str(entry.get("byte_order", "big")))


def _check(command: CommandMap) -> None:
    """Raise MapError where the entries of a command contradict each other."""
    given = {"line": command.line, "topic": command.topic, "layout": command.layout is not None}
    ways = [name for name, is_given in given.items() if is_given]
    which = "set: which field is which of " + ", ".join(ORDERS)
    refuse(
        "command",
        (
            len(ways) > 1 or not (ways or command.orders),
            " must have either a line, a layout, or a topic; or set alone, for registers and nodes",
        ),
        (ways == ["topic"] and not command.type, f": topic needs its type, and {which}"),
        (ways != ["line"] and not command.orders, f": {''.join(ways)} needs {which}"),
        (command.checksum not in ("", "xor"), f": checksum = {command.checksum!r} must be xor, or be left out"),
    )
    refuse(
        "command: ",
        outside("timeout", command.timeout, 0.05, 5.0, " s"),
        outside("supervision", command.supervision or 0.2, 0.2, 60.0, " s, or be 0"),
    )
    for order in command.orders:
        if ways == ["topic"]:
            with placed(f"command: set: {order.path}"):
                FieldPath(order.path)
        if command.layout is not None:
            refuse_unknown("command: set", {split_bit(order.path)[0]: None}, list(command.layout.fields))
    _check_line(command)


def _check_line(command: CommandMap) -> None:
    """Raise MapError for a line that cannot be filled in."""
    try:
        parts = list(string.Formatter().parse(command.line))
        for _, name, form, _ in parts:
            if name is not None and name not in ORDERS:
                raise MapError(f"command: line: {{{name}}} is unknown; known: {', '.join(ORDERS)}")
            if form and _FORM.fullmatch(form) is None:
                raise MapError(f"command: line: the form {form[:20]!r} must be one such as .4f, +8.3f or 05d")
        command.line_of(_EXAMPLE)
    except MapError:
        raise
    except (TypeError, LookupError, ValueError) as error:
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
    scale = as_kind(float, f"{where}: scale", given.get("scale", 1.0))
    if quantity not in MOTIONS:
        return Order(path, quantity, scale)
    channel = read_channel(MOTIONS[quantity], {name: given[name] for name in ("unit", "positive") if name in given})
    if not math.isfinite(scale) or scale == 0.0:
        raise MapError(f"{where}: scale = {scale:g} must not be 0")
    return Order(path, quantity, scale / channel.factor(MOTIONS[quantity]))
