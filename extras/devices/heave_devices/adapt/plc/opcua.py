"""OPC UA by asyncua, an extra: nodes of a map read in one request, orders written in one."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Coroutine, Iterable, Mapping
from datetime import datetime, timezone
from typing import Any

from asyncua import Client, ua
from asyncua.ua.uaerrors import UaError, UaStatusCodeError

from heave_devices.adapt.links import words_of
from heave_devices.adapt.plc.polled import ANSWER_TIME, LinkLostError, RefusedError
from heave_devices.formats.number_kinds import packed
from heave_devices.formats.sample import Sample, TimeBase
from heave_devices.maps.link import Link

_CONNECT_TIME = 5.0
"""A session is there after this time, or not at all [s]."""
_KINDS = {
    **{"SByte": "int8", "Byte": "uint8", "Int16": "int16", "UInt16": "uint16", "Int32": "int32", "UInt32": "uint32"},
    **{"Int64": "int64", "UInt64": "uint64", "Float": "float32", "Double": "float64"},
}
"""Built-in types of OPC UA, part 6, table 1, that hold a number."""


class OpcUaExchange:
    """The nodes of one server at a `link`, without user's name and encryption: `fields` are read, `orders` written.

    A node is named by its identifier, such as ns=2;s=Winch.Payout.
    """

    def __init__(self, link: Link, fields: Iterable[str], orders: Iterable[str]) -> None:
        self._link = link
        self._fields, self._orders = list(dict.fromkeys(fields)), list(dict.fromkeys(orders))
        self._loop: asyncio.AbstractEventLoop | None = None
        self._client: Any = None
        self._ids: dict[str, Any] = {}
        self._types: dict[str, Any] = {}

    def open(self) -> None:
        """See Exchange."""
        logging.getLogger("asyncua").setLevel(logging.CRITICAL)  # what is wrong is said once, in the map's words
        self._loop = asyncio.new_event_loop()
        self._wait("connect", self._connect(), _CONNECT_TIME)

    async def _connect(self) -> None:
        self._ids = {name: _node_id(name) for name in (*self._fields, *self._orders)}
        self._client = Client(self._link.place, timeout=ANSWER_TIME)
        await self._client.connect()
        for name in self._orders:
            self._types[name] = await self._type_of(name)

    async def _type_of(self, name: str) -> Any:
        try:
            return await self._client.get_node(self._ids[name]).read_data_type_as_variant_type()
        except UaStatusCodeError as error:
            raise RefusedError(f"{name}: {words_of(error)}") from None

    def read(self) -> Sample:
        """See Exchange."""
        ids = [self._ids[name] for name in self._fields]
        found = self._wait("read", self._client.uaclient.read_attributes(ids, ua.AttributeIds.Value))
        values: dict[str, float] = {}
        words: dict[str, str] = {}
        invalid = set()
        stamps = []
        for name, data in zip(self._fields, found, strict=True):
            value = data.Value.Value if data.Value is not None else None
            if not data.StatusCode.is_good():
                if data.StatusCode.name.startswith(("BadNodeId", "BadAttributeId", "BadUserAccess", "BadNotReadable")):
                    raise RefusedError(f"read {name}: {data.StatusCode.name}: check the node in the map")
                invalid.add(name)
            elif isinstance(value, bool | int | float):
                values[name] = float(value)
            else:
                words[name] = str(value)
            if data.SourceTimestamp is not None:
                stamps.append(data.SourceTimestamp)
        time = _seconds(max(stamps)) if stamps else None
        return Sample("OPCUA", values, frozenset(invalid), time=time, time_base=TimeBase.UNIX, words=words)

    def write(self, values: Mapping[str, float]) -> None:
        """See Exchange."""
        data = [ua.DataValue(self._variant(name, value)) for name, value in values.items()]
        answers = self._wait("write", self._client.uaclient.write_attributes([self._ids[n] for n in values], data))
        for name, status in zip(values, answers, strict=True):
            if not status.is_good():
                raise RefusedError(f"write {name}: {status.name}: check the node and its access in the map")

    def _variant(self, name: str, value: float) -> Any:
        """Return a `value` as the type of a node has it. Raises ValueError where it does not fit."""
        kind = self._types[name].name
        if kind == "Boolean":
            return ua.Variant(bool(value), self._types[name])
        if kind not in _KINDS:
            raise ValueError(f"{name}: is of the type {kind}, which holds no number")
        packed(_KINDS[kind], value, name=name)  # which says where it does not fit
        return ua.Variant(float(value) if kind in ("Float", "Double") else round(value), self._types[name])

    def close(self) -> None:
        """See Exchange."""
        loop, client = self._loop, self._client
        self._loop = self._client = None
        if loop is None:
            return
        if client is not None:
            with contextlib.suppress(Exception):  # a session that is gone cannot be ended
                loop.run_until_complete(asyncio.wait_for(client.disconnect(), 1.0))
        for task in asyncio.all_tasks(loop):
            task.cancel()
        loop.run_until_complete(asyncio.sleep(0.0))
        loop.close()

    def _wait(self, what: str, work: Coroutine[Any, Any, Any], within: float = ANSWER_TIME) -> Any:
        """Return what `work` returns. Raises RefusedError and LinkLostError."""
        assert self._loop is not None
        try:
            return self._loop.run_until_complete(asyncio.wait_for(work, within))
        except asyncio.TimeoutError:
            raise LinkLostError(f"{what}: no answer: check address, port, cable and that the server runs") from None
        except UaStatusCodeError as error:
            raise LinkLostError(f"{what}: {words_of(error)}") from None
        except (UaError, OSError, asyncio.CancelledError) as error:
            raise LinkLostError(f"{what}: no connection: {words_of(error)}") from None


def _node_id(name: str) -> Any:
    try:
        return ua.NodeId.from_string(name)
    except (UaError, ValueError):
        raise RefusedError(f"{name} is no node identifier such as ns=2;s=Winch.Payout") from None


def _seconds(stamp: datetime) -> float:
    return (stamp if stamp.tzinfo else stamp.replace(tzinfo=timezone.utc)).timestamp()
