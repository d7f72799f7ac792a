"""How a device is reached: a part of a map."""

from __future__ import annotations

import re
from dataclasses import dataclass
from ipaddress import ip_address
from typing import Any

from heave_devices.maps.channel import MapError, as_kind, outside, refuse, refuse_unknown

LOOPBACK = "127.0.0.1"
POLLED = ("modbus", "opcua")
"""Kinds of link that are asked for their values again and again."""
KINDS_OF_LINK = ("serial", "udp", "tcp", *POLLED)
_ENDPOINT = re.compile(r"opc\.tcp://[^/\s:]+:(?P<port>\d+)(/\S*)?")
_FORMS = (
    "{serial: PORT, baud: N}, {udp: HOST:PORT}, {tcp: HOST:PORT}, {modbus: HOST:PORT}, {opcua: 'opc.tcp://HOST:PORT'}"
)


@dataclass(frozen=True)
class Link:
    """How a device is reached."""

    kind: str  # of KINDS_OF_LINK
    place: str  # name of the serial port, host, or endpoint of OPC UA
    number: int  # baud rate, or port
    unit: int = 1  # of Modbus, unit identifier
    word_order: str = "big"  # of Modbus, `big`: the most significant word of a number comes first, or `little`
    period: float = 0.02  # of a polled link, wall time between two readings [s]
    sender: str = ""  # of udp, address of the one host that is heard; "": any

    def __str__(self) -> str:
        if self.kind == "opcua":
            return f"opcua {self.place}"
        return f"{self.kind} {self.place}{' at ' if self.kind == 'serial' else ':'}{self.number}"

    @property
    def is_polled(self) -> bool:
        """Whether it is asked for its values."""
        return self.kind in POLLED


def read_link(where: str, entry: Any) -> Link | None:
    """Return what an `entry` such as {serial: /dev/ttyUSB0, baud: 9600} or {udp: 127.0.0.1:7001} names; None: nothing.

    Raises MapError, with the place in the map, `where`, for what cannot be.
    """
    if entry is None:
        return None
    given = set(KINDS_OF_LINK) & set(entry) if isinstance(entry, dict) else set()
    if len(given) != 1:
        raise MapError(f"{where} must be one of {_FORMS}")
    (kind,) = given
    if kind == "serial":
        refuse_unknown(where, entry, ("serial", "baud"))
        baud = _number(where, entry, "baud", 9600, (50, 4_000_000))
        return Link("serial", as_kind(str, f"{where}: serial", entry["serial"]), baud)
    if kind == "opcua":
        return _opcua(where, entry)
    more = {"modbus": ("unit", "word_order", "period"), "udp": ("from",)}.get(kind, ())
    refuse_unknown(where, entry, (kind, *more))
    host, _, port = str(entry[kind]).rpartition(":")
    if not (port.isascii() and port.isdigit() and 1 <= int(port) <= 65535):
        raise MapError(f"{where}: {kind} = {entry[kind]!r} must be PORT, of this machine alone, or HOST:PORT")
    place, number = host or LOOPBACK, int(port)
    if kind != "modbus":
        return Link(kind, place, number, sender=_address(where, entry))
    order = entry.get("word_order", "big")
    if order not in ("big", "little"):
        raise MapError(f"{where}: word_order = {order!r} must be big or little")
    unit = _number(where, entry, "unit", 1, (0, 255))
    return Link(kind, place, number, unit=unit, word_order=order, period=_period(where, entry))


def _opcua(where: str, entry: Any) -> Link:
    refuse_unknown(where, entry, ("opcua", "period"))
    found = _ENDPOINT.fullmatch(str(entry["opcua"]))
    if found is None or not 1 <= int(found["port"]) <= 65535:
        raise MapError(
            f"{where}: opcua = {entry['opcua']!r} must be an endpoint such as opc.tcp://127.0.0.1:4840/winch"
        )
    return Link("opcua", str(entry["opcua"]), int(found["port"]), period=_period(where, entry))


def _address(where: str, entry: Any) -> str:
    text = as_kind(str, f"{where}: from", entry.get("from", ""))
    try:
        return str(ip_address(text)) if text else ""
    except ValueError:
        raise MapError(f"{where}: from = {text!r} must be the address of a host, such as 192.168.1.20") from None


def _number(where: str, entry: Any, name: str, usual: float, limits: tuple[float, float], unit: str = "") -> Any:
    """Return the number `name` of an `entry`, of the kind of the `usual` one. Raises MapError beyond its `limits`."""
    value = as_kind(type(usual), f"{where}: {name}", entry.get(name, usual))
    refuse(f"{where}: ", outside(name, value, *limits, unit))
    return value


def _period(where: str, entry: Any) -> float:
    return float(_number(where, entry, "period", 0.02, (0.002, 1.0), " s"))
