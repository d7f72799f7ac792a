"""The page of the core's layout: `python -m heave_core.page > docs/core.md`; a test keeps the two in step."""

from __future__ import annotations

import sys

from heave_core.layout import ENUMERATIONS, STRUCTURES
from heave_core.rows import Structure

HEAD = """# The core's layout

`heave_core` is the part of the controller's tick that is compiled: C++17 without a library, an allocation, an
exception, a clock or a text. One table, `heave_core.layout`, makes the C++ structures, the numpy types by which Python
reads and writes the same memory, and this page. The C++ header, with the unit and meaning of every field, is printed by
`python -m heave_core.layout`.

| part | file in `core/heave_core/src/` | what it does |
|---|---|---|
| envelope | `envelope.cpp` | bounds every order, takes over, brakes: see [the envelope](guide/controller/envelope.md) |
| ship | `ship.cpp` | motion reference unit, count of the drum, load cell, from raw readings |
| drum | `drum.cpp` | the nominal drum that is driven by what was sent |
| move | `move.cpp` | the move that an operator has requested |
| filter | `filter.cpp` | the Kalman filter over ticks: gates, streams, late readings |
| filter's model | `filter_model.cpp` | drag, a slack cable, the row of a reading |
| filter's steps | `filter_steps.cpp` | prediction, correction |
| pass | `pass.cpp` | a linear filter over a record in many versions at once, for the adviser's searches |
| servo | `servo.cpp` | a drum under the set-points it was sent: what its encoder should have read |
| drum watch | `drum_watch.cpp` | orders and encoder of the last seconds: is the drum off, is its encoder |
| winch watch | `winch_watch.cpp` | late commands, a silent winch, authority that is cut for a drum that is off |
| look | `look.cpp` | all motions at a tick: boom tip, drum, units with the winch locked and without readings |
| sense | `sense.cpp` | a tick of all that is known: readings, gates, filter, motions, in one call |
| sensor gate | `sensor_gate.cpp` | what one sensor shows alone: no number, a wrong stamp, a value that stands |
| noise | `noise.cpp` | noise and rate of a sensor, from its readings alone |
| steps | `steps.cpp` | jumps of a motion reference unit and of a depth sensor |
| encoder | `encoder.cpp` | the count of the drum against the way it was sent |
| terms | `terms.cpp` | a gated reading in the filter's terms, without the mean payout's share |
| watches | `watches.cpp` | consistency, tension over the waves, whether the boom tip is known |
| sea | `sea.cpp` | the sea that is seen beside that of the design |
| unit | `unit.cpp` | a unit below an outlet whose motion is known: quadratic drag, slack cable |
| guard | `guard.cpp` | whether compensation does harm: drum, swing, depth sensor, waves |
| demand | `demand.cpp` | what the sea asks of the winch, and the authority that leaves |
| statistics | `statistics.cpp` | running standard deviations and amplitudes |
| landing | `landing.cpp` | whether a lowered unit has landed, and a lifted one hangs again |
| trend | `trend.cpp` | the newest readings: mean, straight line |
| KPI window | `kpi.cpp` | statistics over the rolling window of the figures of merit |
| act | `act.cpp` | the acting half of a tick: command, mean payout, set-points, envelope, place of the drive |
| nominal load | `nominal_load.cpp` | the nominal unit under a locked drum, moved by the raw motion reference unit |
| load watch | `load_watch.cpp` | slack cable, high tension, rope, a winch at its limits |
| laws | `laws.cpp` | linear feedback, limits that are near, whether a plan keeps them without a correction |
| governor | `governor.cpp` | no command beyond what the winch can do |
| command | `command.cpp` | authority, the law, the mean payout's share, what the last minute of orders allows |
| tension | `tension.cpp` | constant tension, also by tension and drum alone |
| motion | `motion.cpp` | the mean payout and the loop's own answer to it |

The C interface is `interface.cpp`: `heave_core_layout` and `heave_core_size`, by which Python refuses a library with
another layout, a function for a tick of each part (`heave_core_sense`, `heave_core_filter`, `heave_core_guard`,
`heave_core_envelope`), and one for each jump of a state (`..._begin`, `..._continue_...`, `..._allow_...`). Python
calls them by ctypes, with the lock released. A copy of a state is its part at that tick.
"""


def _row(structure: Structure) -> str:
    return f"| `{structure.name}` | {len(structure.rows)} | {structure.meaning} |"


def page() -> str:
    """Return the page as Markdown."""
    names = ["## Numbers", "", "| what | names |", "|---|---|"]
    names += [f"| `{kind.__name__}` | {', '.join(f'{one.name} {int(one)}' for one in kind)} |" for kind in ENUMERATIONS]
    structures = ["## Structures", "", "| structure | fields | what it is |", "|---|---|---|", *map(_row, STRUCTURES)]
    return "\n\n".join([HEAD.rstrip(), "\n".join(names), "\n".join(structures)]) + "\n"


if __name__ == "__main__":
    sys.stdout.write(page())
