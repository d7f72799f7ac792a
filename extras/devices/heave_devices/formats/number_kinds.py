"""Numbers as bytes, as drives and PLCs exchange them: whole numbers of 8 to 64 bits, floats of 32 and 64, and bits.

Whole numbers are two's complement, floats IEEE 754; the first byte is the most significant one unless a map says
`little`. One bit of a whole number is named by its place behind a point: `status.0` is the least significant bit.

Some numbers stand for "not available" by custom: both ends of a signed whole number, all ones of an unsigned one, and
what is no finite number. 0x8000, 0x7FFF, 0xFFFF and 0x80000000 are such ends. A map names a device's own by
`invalid_values`.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Mapping

KINDS = {
    **{"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "int64": "q"},
    **{"uint64": "Q", "float32": "f", "float64": "d"},
}
"""Names of kinds, with the letter that `struct` knows them by."""
ORDERS_OF_BYTES = {"big": ">", "little": "<"}
_BIT = re.compile(r"(?P<name>.+)\.(?P<bit>\d{1,2})")


def split_bit(text: str) -> tuple[str, int | None]:
    """Return the name in a `text` such as `status.3`, and the bit; None where it names no bit.

    >>> split_bit("status.3"), split_bit("status")
    (('status', 3), ('status', None))
    """
    found = _BIT.fullmatch(text)
    return (text, None) if found is None else (found["name"], int(found["bit"]))


def size_of(kind: str) -> int:
    """Return the bytes of a `kind`."""
    return struct.calcsize(">" + KINDS[kind])


def packed(kind: str, value: float, order: str = "big", name: str = "") -> bytes:
    """Return a `value` as bytes of a `kind` in an `order`, big or little; a whole number is rounded.

    Raises ValueError, with the `name` of the field, where it does not fit.
    """
    letter = KINDS[kind]
    where = f"{name}: " if name else ""
    if not math.isfinite(value):
        raise ValueError(f"{where}{value} cannot be sent as {kind}")
    try:
        return struct.pack(ORDERS_OF_BYTES[order] + letter, value if letter in "fd" else round(value))
    except (struct.error, OverflowError):
        raise ValueError(f"{where}{value:.6g} does not fit {kind}: check unit and scale of the map") from None


def unpacked(kind: str, data: bytes, order: str = "big") -> float:
    """Return the number that `data` are as a `kind`, in an `order` of bytes, big or little."""
    return float(struct.unpack(ORDERS_OF_BYTES[order] + KINDS[kind], data)[0])


def with_words_swapped(kind: str, value: float) -> float:
    """Return what a `value` of a `kind` reads with its words of 16 bits in the other order."""
    data = packed(kind, value)
    return unpacked(kind, b"".join(data[at : at + 2] for at in reversed(range(0, len(data), 2))))


def wrap_of(kind: str) -> float:
    """Return the count after which one in a number of a `kind` begins at 0 again; infinity for floats."""
    return math.inf if kind.startswith("float") else float(1 << 8 * size_of(kind) - (not kind.startswith("uint")))


def wrapped(kind: str, count: int) -> int:
    """Return a `count` that goes on for ever as it is sent in a whole number of a `kind`: from 0 again."""
    return count % int(wrap_of(kind))


def with_bits(values: dict[str, float], name: str, bit: int | None, value: float) -> None:
    """Put a `value` into `values` under a `name`; of a `bit` that bit alone is set or cleared."""
    if bit is None:
        values[name] = value
        return
    held = int(values.get(name, 0))
    values[name] = float(held | 1 << bit if value else held & ~(1 << bit))


FILL_VALUES: Mapping[str, tuple[float, ...]] = {
    **{f"int{bits}": (float(-(1 << bits - 1)), float((1 << bits - 1) - 1)) for bits in (16, 32, 64)},
    **{f"uint{bits}": (float((1 << bits) - 1),) for bits in (16, 32, 64)},
    "float32": (),
    "float64": (),
}
"""By the kind of number, besides what is not finite; shorter numbers use their whole range."""
CUSTOMARY = frozenset(value for values in FILL_VALUES.values() for value in values)
"""Those of any kind, for a number whose kind is not known."""


def is_fill(value: float, kind: str = "") -> bool:
    """Return whether a `value`, in a number of a `kind`, stands for none; a `kind` of "" is not known.

    >>> is_fill(-32768.0, "int16"), is_fill(-32768.0, "int32"), is_fill(math.nan, "float32"), is_fill(65535.0)
    (True, False, True, True)
    """
    return not math.isfinite(value) or value in (FILL_VALUES.get(kind, ()) if kind else CUSTOMARY)
