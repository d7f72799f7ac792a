"""The page of the core's layout: `python -m heave_core.page > docs/core.md`; a test keeps the two in step."""

from __future__ import annotations

import sys

from heave_core.layout import ENUMERATIONS, STRUCTURES
from heave_core.rows import Structure

HEAD = """# The core's layout

`heave_core` is the part of the controller's tick that is compiled: C++17 without a library, an allocation, an
exception, a clock or a text. One table, `heave_core.layout`, makes the C++ structures, the numpy types by which Python
reads and writes the same memory, and this page (`python -m heave_core.page`).

| part | file in `core/heave_core/src/` | what it does |
|---|---|---|
| envelope | `envelope.cpp` | bounds every order, takes over, brakes: see [the envelope](guide/controller/envelope.md) |
| ship | `ship.cpp` | motion reference unit, count of the drum, load cell, from raw readings |
| drum | `drum.cpp` | the nominal drum that is driven by what was sent |
| move | `move.cpp` | the move that an operator has requested |
| filter | `filter.cpp` | the Kalman filter over ticks: gates, streams, late readings |
| filter's model | `filter_model.cpp` | drag, a slack cable, the row of a reading |
| filter's steps | `filter_steps.cpp` | prediction, correction |
| laws | `laws.cpp` | linear feedback, limits that are near, whether a plan keeps them without a correction |
| governor | `governor.cpp` | no command beyond what the winch can do |
| command | `command.cpp` | authority, the law, the mean payout's share, what the last minute of orders allows |
| tension | `tension.cpp` | constant tension, also by tension and drum alone |
| motion | `motion.cpp` | the mean payout and the loop's own answer to it |

`interface.cpp` is its C interface. By `heave_core_layout` and `heave_core_size` Python refuses a library with another
layout; the others do what their names say, on structures that Python and C++ share. Python calls them by ctypes, with
the lock released. A copy of `State` is the envelope at that tick, one of `FilterState` the filter.
"""


def _table(structure: Structure) -> str:
    lines = [f"## {structure.name}", "", structure.meaning, "", "| field | unit | meaning |", "|---|---|---|"]
    for row in structure.rows:
        if row.name == "pad":
            continue
        size = "".join(f"[{n}]" for n in row.shape)
        meaning = f"{row.meaning} (`{row.kind.name}`)" if isinstance(row.kind, Structure) else row.meaning
        lines.append(f"| `{row.name}{size}` | {row.unit} | {meaning} |")
    return "\n".join(lines)


def page() -> str:
    """Return the page as Markdown."""
    names = ["## Numbers", "", "| what | names |", "|---|---|"]
    names += [f"| `{kind.__name__}` | {', '.join(f'{one.name} {int(one)}' for one in kind)} |" for kind in ENUMERATIONS]
    return "\n\n".join([HEAD.rstrip(), "\n".join(names), *map(_table, STRUCTURES)]) + "\n"


if __name__ == "__main__":
    sys.stdout.write(page())
