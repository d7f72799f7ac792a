"""Modbus/TCP by pymodbus: registers of a map read in few requests, orders written in as few."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from pymodbus.client import ModbusTcpClient
from pymodbus.exceptions import ModbusException

from heave_devices.adapt.links import words_of
from heave_devices.adapt.plc.polled import ANSWER_TIME, LinkLostError, RefusedError
from heave_devices.formats.registers import BIT_TABLES, Block, blocks_of, register_of, values_in, words_for
from heave_devices.formats.sample import Sample
from heave_devices.maps.link import Link

_EXCEPTIONS = {
    1: "illegal function: the PLC does not offer this table",
    2: "illegal data address: check table, address and unit of the map",
    3: "illegal data value",
    4: "server device failure",
    5: "acknowledge: the PLC is still at it",
    6: "server device busy",
    10: "gateway path unavailable: check unit",
    11: "gateway target did not respond: check unit",
}
"""Exception codes of the MODBUS Application Protocol Specification V1.1b3, section 7."""


class ModbusExchange:
    """The registers of one PLC behind a `link`: `fields` are read, `orders` written."""

    def __init__(self, link: Link, fields: Iterable[str], orders: Iterable[str]) -> None:
        self._link = link
        self._reads = blocks_of(map(register_of, fields))
        self._writes = blocks_of(map(register_of, orders))
        self._unit = {"device_id": link.unit}
        self._client: Any = None

    def open(self) -> None:
        """See Exchange."""
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # what is wrong is said once, in the map's words
        self._client = ModbusTcpClient(self._link.place, port=self._link.number, timeout=ANSWER_TIME, retries=0)
        if not self._client.connect():
            raise LinkLostError("no connection: check address, port, cable and that the PLC is on")

    def read(self) -> Sample:
        """See Exchange."""
        values: dict[str, float] = {}
        ask = self._client
        calls = {
            "coil": ask.read_coils,
            "discrete": ask.read_discrete_inputs,
            "input": ask.read_input_registers,
            "holding": ask.read_holding_registers,
        }
        for block in self._reads:
            request = partial(calls[block.table], block.address, count=block.count, **self._unit)
            answer = self._answer(block, "read", request)
            words = answer.bits if block.table in BIT_TABLES else answer.registers
            values |= values_in(block, words, self._link.word_order)
        return Sample("MODBUS", values)

    def write(self, values: Mapping[str, float]) -> None:
        """See Exchange."""
        for block in self._writes:
            words = words_for(block, values, self._link.word_order)
            call = self._client.write_coils if block.table == "coil" else self._client.write_registers
            given = [bool(word) for word in words] if block.table == "coil" else words
            self._answer(block, "write", partial(call, block.address, given, **self._unit))

    def close(self) -> None:
        """See Exchange."""
        if self._client is not None:
            self._client.close()
            self._client = None

    def _answer(self, block: Block, what: str, request: Callable[[], Any]) -> Any:
        """Return the PLC's answer to a request. Raises RefusedError for an exception, LinkLostError for none."""
        where = f"{what} {block.table}:{block.address}"
        where += f" to {block.table}:{block.address + block.count - 1}" if block.count > 1 else ""
        try:
            answer = request()
        except (ModbusException, OSError) as error:
            raise LinkLostError(f"{where}: no answer: {words_of(error)}") from None
        if answer.isError():
            code = int(getattr(answer, "exception_code", 0))
            raise RefusedError(f"{where}: exception {code}: {_EXCEPTIONS.get(code, 'unknown')}")
        return answer
