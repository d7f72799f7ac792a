"""Numbers that stand for "not available" by custom: one table for devices and for records.

By the kind of number: both ends of a signed whole number, all ones of an unsigned one, and what is no finite number.
0x8000, 0x7FFF, 0xFFFF and 0x80000000 are such ends. A map names a device's own by `invalid_values`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

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
