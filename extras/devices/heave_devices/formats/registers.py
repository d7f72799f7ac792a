"""Modbus registers by name: `TABLE:ADDRESS:KIND`, such as `input:4:int32`, and `holding:10.0` for one bit.

A number whose words come in another order than the map's says so: `input:4:int32:little`.

TABLE is one of the four of the MODBUS Application Protocol Specification V1.1b3, section 4.3: `coil`, `discrete` (one
bit), `input`, `holding` (16 bits). ADDRESS is that of the wire, from 0: what a manual calls 40001 is `holding:0`, and
30001 is `input:0`. A number of more than one register begins with the most significant word unless the map says
`word_order: little`; inside a word the first byte is the most significant one (section 4.2).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from heave_devices.formats.number_kinds import KINDS, packed, size_of, split_bit, unpacked

BIT_TABLES = ("coil", "discrete")
WRITABLE = ("coil", "holding")
LONGEST_READ = 120
"""Registers of one request; the specification allows 125 to be read and 123 to be written."""
_NAME = re.compile(
    r"(?P<table>coil|discrete|input|holding):(?P<address>\d{1,5})(:(?P<kind>\w+))?(:(?P<order>big|little))?"
)


@dataclass(frozen=True)
class Register:
    """One number among the registers of a PLC."""

    name: str  # as the map has it, without a bit
    table: str  # coil, discrete, input, holding
    address: int  # of its first register, from 0
    kind: str  # of number_kinds
    order: str = ""  # of its words, big or little; "": that of the map

    @property
    def count(self) -> int:
        """Registers, or bits, that it takes."""
        return 1 if self.table in BIT_TABLES else size_of(self.kind) // 2


def register_of(text: str) -> Register:
    """Return the register that a `text` names, with or without a bit. Raises ValueError where it names none."""
    name, bit = split_bit(text)
    found = _NAME.fullmatch(name)
    if found is None:
        raise ValueError(f"{text!r} is no register, such as input:4:int32, holding:10, holding:10.0 or coil:3")
    table, address, kind = found["table"], int(found["address"]), found["kind"] or "uint16"
    if kind not in KINDS or size_of(kind) < 2:
        raise ValueError(f"{text!r}: {kind} must be one of {', '.join(name for name in KINDS if size_of(name) > 1)}")
    register = Register(name, table, address, kind, found["order"] or "")
    if table in BIT_TABLES and (found["kind"] or found["order"] or bit is not None):
        raise ValueError(f"{text!r}: a {table} is one bit: leave out what follows its address")
    if bit is not None and (kind.startswith("float") or bit >= 16 * register.count):
        raise ValueError(f"{text!r}: {kind} has no bit {bit}")
    if address + register.count > 65_536:
        raise ValueError(f"{text!r}: addresses end at 65535")
    return register


@dataclass(frozen=True)
class Block:
    """Registers that one request reads or writes."""

    table: str  # Modbus table
    address: int  # of the first of them
    count: int  # how many
    registers: tuple[Register, ...]  # the numbers in them


def blocks_of(registers: Iterable[Register]) -> list[Block]:
    """Return the requests that cover `registers`, and none besides: a PLC may refuse one that it does not have."""
    blocks: list[Block] = []
    for register in sorted(set(registers), key=lambda found: (found.table, found.address, found.count)):
        last = blocks[-1] if blocks else None
        end = register.address + register.count
        if last is not None and last.table == register.table and register.address <= last.address + last.count:
            count = max(last.count, end - last.address)
            if count <= LONGEST_READ:
                blocks[-1] = Block(last.table, last.address, count, (*last.registers, register))
                continue
        blocks.append(Block(register.table, register.address, register.count, (register,)))
    return blocks


def values_in(block: Block, words: Sequence[int], word_order: str) -> dict[str, float]:
    """Return the numbers of a `block`, by name, that were read as `words`, in a `word_order`, big or little.

    Raises ValueError for too few.
    """
    if len(words) < block.count:
        raise ValueError(f"{len(words)} of {block.count} registers of {block.table}:{block.address} came")
    values = {}
    for register in block.registers:
        start = register.address - block.address
        own = words[start : start + register.count]
        if register.table in BIT_TABLES:
            values[register.name] = float(bool(own[0]))
            continue
        ordered = own if (register.order or word_order) == "big" else own[::-1]
        values[register.name] = unpacked(register.kind, b"".join(word.to_bytes(2, "big") for word in ordered))
    return values


def words_for(block: Block, values: Mapping[str, float], word_order: str) -> list[int]:
    """Return the words, or bits, of a `block` that hold `values`, in a `word_order`, big or little.

    Raises ValueError where one does not fit.
    """
    words = [0] * block.count
    for register in block.registers:
        start = register.address - block.address
        if register.table in BIT_TABLES:
            words[start] = int(values[register.name] != 0.0)
            continue
        data = packed(register.kind, values[register.name], name=register.name)
        own = [int.from_bytes(data[place : place + 2], "big") for place in range(0, len(data), 2)]
        words[start : start + register.count] = own if (register.order or word_order) == "big" else own[::-1]
    return words
