"""What the core holds, for numpy, for C++ and for the page: names, units, shapes and meanings, in a table by subject.

`python -m heave_core.layout` writes the C++ header, `python -m heave_core.page` the page of the documentation. The
tables import nothing but the standard library: the build runs this before anything is installed.

What a parameter fills, what changes in a tick, what comes in and what goes out are structures of their own, so that a
copy of the state is a core at that tick.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from enum import EnumMeta
from pathlib import Path

from heave_core import (
    envelope_table,
    filter_table,
    law_table,
    look_table,
    modes_table,
    proof_table,
    sense_table,
    watch_table,
)
from heave_core.rows import COUNTER, NUMBER, Size, Structure

TABLES = (
    envelope_table,
    filter_table,
    look_table,
    law_table,
    watch_table,
    sense_table,
    modes_table,
    proof_table,
)
"""By subject, in the order in which C++ needs them."""

_DEFINED = tuple(one for table in TABLES for one in vars(table).values())

STRUCTURES = tuple(dict.fromkeys(one for one in _DEFINED if isinstance(one, Structure)))
"""In the order in which the tables define them, which C++ needs."""

ENUMERATIONS = tuple(dict.fromkeys(one for one in _DEFINED if isinstance(one, EnumMeta) and one.__members__))
"""Names of numbers, and of bits."""

SIZES = {one.text: one for one in _DEFINED if isinstance(one, Size)}
"""Sizes of arrays."""

_C_TYPES = {NUMBER: "double", COUNTER: "int"}


def _struct(structure: Structure) -> str:
    """Return a structure in C++."""
    lines = [f"// {structure.meaning}", f"struct {structure.name} {{"]
    for row in structure.rows:
        kind = row.kind.name if isinstance(row.kind, Structure) else _C_TYPES[row.kind]
        size = "".join(f"[{getattr(n, 'text', n)}]" for n in row.shape)
        unit = f" [{row.unit}]" if row.unit else ""
        lines.append(f"    {kind} {row.name}{size};  // {row.meaning}{unit}")
    return "\n".join([*lines, "};"])


def _body(sizes: Mapping[str, int]) -> str:
    """Return the declarations, with these `sizes` of arrays."""
    named = ", ".join(f"{name} = {int(size)}" for name, size in sizes.items())
    held = ", ".join(f"sizeof({record.name})" for record in STRUCTURES)
    records = f"// As Python has them\nconstexpr long long STRUCTURE_SIZES[] = {{{held}}};"
    names = [
        f"enum {kind.__name__} {{ {', '.join(f'{one.name} = {int(one)}' for one in kind)} }};" for kind in ENUMERATIONS
    ]
    return "\n\n".join([f"enum {{ {named} }};", *names, *map(_struct, STRUCTURES), records])


def interface() -> tuple[tuple[str, str, tuple[str, ...]], ...]:
    """Return result, name and types of the arguments of each function in `src/interface.cpp`."""
    text = (Path(__file__).parent / "src" / "interface.cpp").read_text(encoding="utf-8")
    found = re.findall(r"^(\w[\w ]*) (heave_core_\w+)\(([^)]*)\)", text, re.MULTILINE)
    return tuple(
        (result, name, tuple(re.sub(r"\w+$", "", one.strip()).strip() for one in arguments.split(",") if one))
        for result, name, arguments in found
    )


def layout_number() -> int:
    """Return the number of this layout, which library and Python must share: 63 bits of the declarations' digest."""
    lines = [line.partition("//")[0].rstrip() for line in _body(SIZES).splitlines()]
    declared = "\n".join([*lines, *map(str, interface())])
    return int.from_bytes(hashlib.sha256(declared.encode()).digest()[:8], "big") >> 1


def header(**smaller: int) -> str:
    """Return the C++ header.

    `smaller` are sizes of arrays by name, for one controller without Python: what is the same is checked by `LAYOUT`.
    """
    return (
        "// Made by heave_core/layout.py from the tables beside it: change those.\n"
        "#pragma once\n\nnamespace heave {\n\n"
        f"constexpr long long LAYOUT = {layout_number()};\n\n{_body({**SIZES, **smaller})}\n\n}}  // namespace heave\n"
    )


if __name__ == "__main__":
    print(header(), end="")  # noqa: T201
